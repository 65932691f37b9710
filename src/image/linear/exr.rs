//! OpenEXR files. For writing, the settings are fixed, so that equal pictures give equal bytes with one version of the encoder;
//! across versions, only the pixels are guaranteed.

use std::io::Cursor;

use exr::error::Error;
use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, SpecificChannels,
    WritableImage, read,
};

use super::Linear;

/// The bytes of an OpenEXR file: channels R, G, B and A as 32-bit floating point, linear, colours multiplied by opacity
/// as the format asks; all light is 1.
///
/// # Errors
/// A picture of width or height 0.
pub fn encode(picture: &Linear) -> Result<Vec<u8>, Error> {
    let size = (picture.width as usize, picture.height as usize);
    // The encoder divides by both.
    if size.0 == 0 || size.1 == 0 {
        return Err(Error::Invalid("a picture without pixels".into()));
    }
    let pixel = |at: exr::math::Vec2<usize>| {
        let [r, g, b, a] = picture.parts(at.x() as u32, at.y() as u32);
        (r, g, b, a)
    };
    let channels = SpecificChannels::rgba(pixel);
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// The picture in an OpenEXR file: its first layer with channels R, G and B, and A where there is one, as they are
/// stored.
///
/// # Errors
/// What is wrong with it: no OpenEXR, cut off, without those channels, or an edge above `most` pixels.
pub fn decode(bytes: &[u8], most: u32) -> Result<([u32; 2], Vec<[f64; 4]>), String> {
    let broken = |error: Error| format!("must be an OpenEXR picture with R, G and B ({error})");
    // The size is checked before anything of it is allocated.
    let meta =
        exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &meta.headers {
        let [width, height] = [header.layer_size.width(), header.layer_size.height()];
        if width > most as usize || height > most as usize {
            return Err(format!("is {width}x{height}, but each edge must be 1 to {most}"));
        }
    }
    let reader = read().no_deep_data().largest_resolution_level().rgba_channels(
        |size, _| (size.width(), vec![[0.0_f64; 4]; size.width() * size.height()]),
        |(width, pixels), at, (r, g, b, a): (f32, f32, f32, f32)| {
            pixels[at.y() * *width + at.x()] = [r, g, b, a].map(f64::from);
        },
    );
    let reader = reader.first_valid_layer().all_attributes().non_parallel();
    let layer = reader.from_buffered(Cursor::new(bytes)).map_err(broken)?.layer_data;
    let size = [layer.size.width() as u32, layer.size.height() as u32];
    Ok((size, layer.channel_data.pixels.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_survive_the_file() {
        let pixels = (0..32_u16 * 20).map(|i| [i, 100 * i, 65_535 - i, 9 * i]).collect();
        let picture = Linear { width: 32, height: 20, pixels };
        let bytes = encode(&picture).unwrap();
        assert_eq!(encode(&picture).unwrap(), bytes);
        let (size, pixels) = decode(&bytes, 32).unwrap();
        assert_eq!(size, [32, 20]);
        let places = (0..20).flat_map(|y| (0..32).map(move |x| (x, y)));
        let parts = places.map(|(x, y)| picture.parts(x, y).map(f64::from));
        assert_eq!(pixels, parts.collect::<Vec<_>>());
        assert!(decode(&bytes, 31).unwrap_err().contains("32x20"));
        for end in [0, 4, 40, bytes.len() / 2] {
            assert!(decode(&bytes[..end], 32).unwrap_err().contains("OpenEXR"), "{end}");
        }
    }

    #[test]
    fn an_empty_picture_is_an_error() {
        for (width, height) in [(0, 1), (1, 0)] {
            assert!(encode(&Linear { width, height, pixels: Vec::new() }).is_err());
        }
    }
}
