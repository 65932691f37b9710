//! PNG files. The settings are fixed, so that equal images give equal bytes with one version of the encoder; across
//! versions, only the pixels are guaranteed.

use std::io::{BufRead, Seek};

use png::{
    BitDepth, ColorType, Compression, Decoder, Encoder, EncodingError, Filter, SrgbRenderingIntent,
    Transformations,
};

use super::Image;
use super::linear::Linear;

/// The bytes of a PNG file: 8 bits per channel, RGBA, marked as sRGB.
///
/// # Errors
/// An image of width or height 0, which PNG cannot hold.
pub fn encode(image: &Image) -> Result<Vec<u8>, EncodingError> {
    write([image.width, image.height], BitDepth::Eight, image.bytes())
}

/// The same with 16 bits per channel.
///
/// # Errors
/// A picture of width or height 0.
pub fn encode16(picture: &Linear) -> Result<Vec<u8>, EncodingError> {
    let words = picture.srgb16();
    let bytes: Vec<u8> = words.as_flattened().iter().flat_map(|word| word.to_be_bytes()).collect();
    write([picture.width, picture.height], BitDepth::Sixteen, &bytes)
}

fn write(
    [width, height]: [u32; 2],
    depth: BitDepth,
    data: &[u8],
) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Balanced);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    writer.finish()?;
    Ok(bytes)
}

/// The picture in a PNG file of up to 8 bits per channel, taken for sRGB; what has no opacity is opaque.
///
/// # Errors
/// What is wrong with it: no PNG, cut off, 16 bits per channel, or an edge above `most` pixels.
pub fn decode(file: impl BufRead + Seek, most: u32) -> Result<Image, String> {
    read(file, most, Transformations::EXPAND)
}

/// As [`decode`], but of 16 bits per channel, the upper 8 are taken.
///
/// # Errors
/// What is wrong with it: no PNG, cut off, or an edge above `most` pixels.
pub fn decode_any(file: impl BufRead + Seek, most: u32) -> Result<Image, String> {
    read(file, most, Transformations::EXPAND | Transformations::STRIP_16)
}

/// The picture in a PNG file of any depth, each channel as a part of 1, as it is stored; what has no opacity is opaque.
///
/// # Errors
/// As [`decode_any`].
pub fn decode_deep(
    file: impl BufRead + Seek,
    most: u32,
) -> Result<([u32; 2], Vec<[f64; 4]>), String> {
    let Raw { size, channels, deep, bytes } = raw(file, most, Transformations::EXPAND)?;
    let values: Vec<f64> = match deep {
        false => bytes.iter().map(|&byte| f64::from(byte) / 255.0).collect(),
        true => {
            let (words, _) = bytes.as_chunks();
            words.iter().map(|&word| f64::from(u16::from_be_bytes(word)) / 65_535.0).collect()
        }
    };
    Ok((size, values.chunks_exact(channels).map(|pixel| rgba(pixel, 1.0)).collect()))
}

fn read(file: impl BufRead + Seek, most: u32, how: Transformations) -> Result<Image, String> {
    let Raw { size: [width, height], channels, deep, bytes } = raw(file, most, how)?;
    if deep {
        return Err("has 16 bits per channel: must be 8 or fewer".to_owned());
    }
    let pixels = bytes.chunks_exact(channels).map(|pixel| rgba(pixel, 255)).collect();
    Ok(Image { width, height, pixels })
}

/// A pixel's gray or colour, and its opacity, if it has one.
pub(super) fn rgba<T: Copy + Default>(channels: &[T], opaque: T) -> [T; 4] {
    match *channels {
        [gray] => [gray, gray, gray, opaque],
        [gray, alpha] => [gray, gray, gray, alpha],
        [red, green, blue] => [red, green, blue, opaque],
        [red, green, blue, alpha, ..] => [red, green, blue, alpha],
        [] => [T::default(); 4],
    }
}

/// What a file holds.
struct Raw {
    size: [u32; 2],
    /// Of a pixel.
    channels: usize,
    /// 16 bits per channel, and not 8.
    deep: bool,
    bytes: Vec<u8>,
}

fn raw(file: impl BufRead + Seek, most: u32, how: Transformations) -> Result<Raw, String> {
    let broken = |error: png::DecodingError| format!("must be a PNG picture ({error})");
    let mut decoder = Decoder::new(file);
    decoder.set_transformations(how);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width, reader.info().height);
    if width > most || height > most {
        return Err(format!("is {width}x{height}, but each edge must be 1 to {most}"));
    }
    let deep = reader.output_color_type().1 != BitDepth::Eight;
    let mut bytes = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let frame = reader.next_frame(&mut bytes).map_err(broken)?;
    bytes.truncate(frame.buffer_size());
    Ok(Raw { size: [width, height], channels: frame.color_type.samples(), deep, bytes })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn read(bytes: &[u8]) -> Result<Image, String> {
        decode(Cursor::new(bytes), 64)
    }

    /// A picture of 2x1 pixels as another program would write it.
    fn foreign(color: ColorType, depth: BitDepth, data: &[u8], palette: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if !palette.is_empty() {
            encoder.set_palette(palette.to_vec());
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn pixels_survive_the_file() {
        let pixels = (0..=255u8).map(|i| [i, i.wrapping_mul(7), 255 - i, i ^ 0x5A]).collect();
        let image = Image { width: 32, height: 8, pixels };
        let bytes = encode(&image).unwrap();
        assert_eq!(read(&bytes).unwrap(), image);
        assert_eq!(encode(&image).unwrap(), bytes);
    }

    #[test]
    fn every_kind_of_picture_becomes_rgba() {
        use BitDepth::{Eight, One, Sixteen};
        use ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb};
        for (color, depth, data, palette, expected) in [
            (Rgb, Eight, &[1, 2, 3, 4, 5, 6][..], &[][..], [[1, 2, 3, 255], [4, 5, 6, 255]]),
            (Grayscale, Eight, &[7, 8], &[], [[7, 7, 7, 255], [8, 8, 8, 255]]),
            (Grayscale, One, &[0b0100_0000], &[], [[0, 0, 0, 255], [255; 4]]),
            (GrayscaleAlpha, Eight, &[7, 9, 8, 0], &[], [[7, 7, 7, 9], [8, 8, 8, 0]]),
            (Indexed, Eight, &[1, 0], &[1, 2, 3, 4, 5, 6], [[4, 5, 6, 255], [1, 2, 3, 255]]),
        ] {
            let image = read(&foreign(color, depth, data, palette)).unwrap();
            assert_eq!((image.width, image.height, &image.pixels[..]), (2, 1, &expected[..]));
        }
        let deep = foreign(Grayscale, Sixteen, &[1, 2, 3, 4], &[]);
        assert!(read(&deep).unwrap_err().contains("16 bits"));
        let upper = decode_any(Cursor::new(&deep), 64).unwrap();
        assert_eq!(upper.pixels, [[1, 1, 1, 255], [3, 3, 3, 255]]);
        let (size, whole) = decode_deep(Cursor::new(&deep), 64).unwrap();
        let parts = [258.0, 772.0].map(|word: f64| word / 65_535.0);
        assert_eq!((size, whole), ([2, 1], parts.map(|c| [c, c, c, 1.0]).to_vec()));
    }

    #[test]
    fn what_is_no_picture_is_an_error() {
        let whole = encode(&Image::filled(64, 1, [9; 4])).unwrap();
        assert!(read(&whole).is_ok());
        for end in [0, 4, 20, whole.len() / 2] {
            assert!(read(&whole[..end]).unwrap_err().contains("PNG"), "{end}");
        }
        let wide = encode(&Image::filled(65, 1, [9; 4])).unwrap();
        assert!(read(&wide).unwrap_err().contains("1 to 64"));
    }

    #[test]
    fn sixteen_bits_are_srgb_with_the_high_byte_first() {
        let pixels = vec![[0, 1, 14_027, u16::MAX], [u16::MAX, 0, 0, u16::MAX]];
        let picture = Linear { width: 2, height: 1, pixels };
        let bytes = encode16(&picture).unwrap();
        let mut reader = Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.output_color_type(), (ColorType::Rgba, BitDepth::Sixteen));
        assert!(reader.info().srgb.is_some());
        let mut data = [0; 16];
        reader.next_frame(&mut data).unwrap();
        let words: Vec<u16> =
            data.chunks_exact(2).map(|word| u16::from_be_bytes([word[0], word[1]])).collect();
        assert_eq!(words, *picture.srgb16().as_flattened());
        assert_eq!(data[2..4], [0, 13], "12.92 times 1, and not 13 times 256");
    }

    #[test]
    fn an_empty_image_is_an_error() {
        assert!(encode(&Image::filled(0, 4, [0; 4])).is_err());
    }
}
