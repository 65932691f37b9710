//! Picture files as textures: PNG and JPEG, told apart by their first bytes.

use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::super::model::Unplaced;
use crate::image::{Image, png};

/// The longest edge of a picture, pixels.
const MAX_EDGE: u32 = 8192;

/// sRGB and opacity, 8 bits each: of deeper pictures, the upper ones.
pub(in crate::scene) fn decode(bytes: &[u8]) -> Unplaced<Image> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => png::decode_any(Cursor::new(bytes), MAX_EDGE),
        [0xFF, 0xD8, 0xFF, ..] => jpeg(bytes),
        [b'R', b'I', b'F', b'F', ..] => Err("is WebP; convert it to PNG".to_owned()),
        [0xAB, b'K', b'T', b'X', ..] => Err("is KTX; convert it to PNG".to_owned()),
        _ => Err("must be PNG or JPEG".to_owned()),
    }
}

fn jpeg(bytes: &[u8]) -> Unplaced<Image> {
    // Without the code for certain processors, so that all of them give the same bytes.
    let options = DecoderOptions::default()
        .set_use_unsafe(false)
        .set_max_width(MAX_EDGE as usize)
        .set_max_height(MAX_EDGE as usize)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    let broken = |_| "must be a whole JPEG picture".to_owned();
    let rgb = decoder.decode().map_err(broken)?;
    let (width, height) = decoder.dimensions().ok_or("must be a whole JPEG picture")?;
    let pixels: Vec<[u8; 4]> =
        rgb.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
    if pixels.is_empty() || pixels.len() != width * height {
        return Err("must be a whole JPEG picture".to_owned());
    }
    Ok(Image { width: width as u32, height: height as u32, pixels })
}
