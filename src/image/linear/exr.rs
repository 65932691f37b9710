//! OpenEXR files. The settings are fixed, so that equal pictures give equal bytes with one version of the encoder;
//! across versions, only the pixels are guaranteed.

use std::io::Cursor;

use exr::error::Error;
use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage};

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

#[cfg(test)]
mod tests {
    use exr::prelude::{ReadChannels, ReadLayers, read};

    use super::*;

    #[test]
    fn pixels_survive_the_file() {
        let pixels = (0..32_u16 * 20).map(|i| [i, 100 * i, 65_535 - i, 9 * i]).collect();
        let picture = Linear { width: 32, height: 20, pixels };
        let bytes = encode(&picture).unwrap();
        assert_eq!(encode(&picture).unwrap(), bytes);
        let reader = read().no_deep_data().largest_resolution_level().rgba_channels(
            |size, _| vec![[0.0_f32; 4]; size.width() * size.height()],
            |pixels, at, (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[at.y() * 32 + at.x()] = [r, g, b, a];
            },
        );
        let image =
            reader.first_valid_layer().all_attributes().from_buffered(Cursor::new(bytes)).unwrap();
        let places = (0..20).flat_map(|y| (0..32).map(move |x| (x, y)));
        let expected: Vec<[f32; 4]> = places.map(|(x, y)| picture.parts(x, y)).collect();
        assert_eq!(image.layer_data.channel_data.pixels, expected);
    }

    #[test]
    fn an_empty_picture_is_an_error() {
        for (width, height) in [(0, 1), (1, 0)] {
            assert!(encode(&Linear { width, height, pixels: Vec::new() }).is_err());
        }
    }
}
