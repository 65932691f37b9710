//! PNG files. The settings are fixed, so that equal images give equal bytes with one version of the encoder; across
//! versions, only the pixels are guaranteed.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, SrgbRenderingIntent};

use super::Image;

/// The bytes of a PNG file: 8 bits per channel, RGBA, marked as sRGB.
///
/// # Errors
/// An image of width or height 0, which PNG cannot hold.
pub fn encode(image: &Image) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, image.width, image.height);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Balanced);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image.bytes())?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(bytes: &[u8]) -> Image {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut buffer).unwrap();
        let pixels = buffer.as_chunks::<4>().0.to_vec();
        Image { width: info.width, height: info.height, pixels }
    }

    #[test]
    fn pixels_survive_the_file() {
        let pixels = (0..=255u8).map(|i| [i, i.wrapping_mul(7), 255 - i, i ^ 0x5A]).collect();
        let image = Image { width: 32, height: 8, pixels };
        let bytes = encode(&image).unwrap();
        assert_eq!(decode(&bytes), image);
        assert_eq!(encode(&image).unwrap(), bytes);
    }

    #[test]
    fn an_empty_image_is_an_error() {
        assert!(encode(&Image::filled(0, 4, [0; 4])).is_err());
    }
}
