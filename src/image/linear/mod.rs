//! Pictures in 16 bits of linear light, with opacity, and their files.

pub mod exr;
pub mod pfm;

use super::Image;
use crate::num::color::{srgb, srgb16};

/// All light, and full opacity.
const ALL: u16 = u16::MAX;

/// A picture of linear light, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Linear {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width * height` pixels, row by row: the red, green and blue light that a pixel adds (colours multiplied by
    /// opacity), and its opacity, 0 to 65,535.
    pub pixels: Vec<[u16; 4]>,
}

impl Linear {
    /// In sRGB of 8 bits, colours not multiplied by opacity.
    #[must_use]
    pub fn srgb8(&self) -> Image {
        let pixel = |&pixel: &[u16; 4]| {
            let [r, g, b, opacity] = straight(pixel);
            [srgb(r), srgb(g), srgb(b), ((u32::from(opacity) + 128) / 257) as u8]
        };
        let pixels = self.pixels.iter().map(pixel).collect();
        Image { width: self.width, height: self.height, pixels }
    }

    /// The pixels in sRGB of 16 bits, colours not multiplied by opacity.
    #[must_use]
    pub fn srgb16(&self) -> Vec<[u16; 4]> {
        let pixel = |&pixel: &[u16; 4]| {
            let [r, g, b, opacity] = straight(pixel);
            [srgb16(r), srgb16(g), srgb16(b), opacity]
        };
        self.pixels.iter().map(pixel).collect()
    }

    /// The pixel at column `x` of row `y`, both inside the picture, each channel as a part of 1.
    #[must_use]
    pub fn parts(&self, x: u32, y: u32) -> [f32; 4] {
        let pixel = self.pixels[y as usize * self.width as usize + x as usize];
        pixel.map(|channel| f32::from(channel) / f32::from(ALL))
    }
}

/// Colours divided by their opacity, to the nearest integer, halves up, and at most all light. Where there is no
/// opacity, there is no colour.
fn straight([r, g, b, opacity]: [u16; 4]) -> [u16; 4] {
    let whole = u32::from(opacity);
    let divided = |light: u16| match whole {
        0 => 0,
        _ => ((u32::from(light) * u32::from(ALL) + whole / 2) / whole).min(ALL.into()) as u16,
    };
    [divided(r), divided(g), divided(b), opacity]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(pixel: [u16; 4]) -> Linear {
        Linear { width: 1, height: 1, pixels: vec![pixel] }
    }

    #[test]
    fn opaque_pixels_are_encoded_as_they_are() {
        for c in 0..=ALL {
            let picture = one([c, c / 2, 0, ALL]);
            assert_eq!(picture.srgb8().pixels, [[srgb(c), srgb(c / 2), 0, 255]]);
            assert_eq!(picture.srgb16(), [[srgb16(c), srgb16(c / 2), 0, ALL]]);
        }
    }

    #[test]
    fn colours_are_divided_by_opacity() {
        assert_eq!(straight([257, 128, 0, 257]), [ALL, 32_640, 0, 257]);
        assert_eq!(straight([2, 1, 9, 3]), [43_690, 21_845, ALL, 3], "more light than opacity");
        assert_eq!(straight([9, 0, 1, 0]), [0; 4]);
        assert_eq!(straight([ALL; 4]), [ALL; 4]);
        let opacity = |opacity| one([0, 0, 0, opacity]).srgb8().pixels[0][3];
        assert_eq!([0, 128, 129, 385, 386, ALL].map(opacity), [0, 0, 1, 1, 2, 255]);
    }

    #[test]
    fn parts_are_single_precision() {
        let picture = Linear { width: 1, height: 2, pixels: vec![[0; 4], [ALL, 1, 32_768, 0]] };
        assert_eq!(picture.parts(0, 1), [1.0, 1.0 / 65_535.0, 32_768.0 / 65_535.0, 0.0]);
        let back = |c: u16| (one([c; 4]).parts(0, 0)[0] * 65_535.0).round() as u16;
        assert!((0..=ALL).all(|c| back(c) == c));
    }
}
