//! Pictures of other programs: PNG of any depth, OpenEXR, and NumPy's arrays.

use std::io::Cursor;

use super::linear::exr;
use super::{Image, png};
use crate::num::color::{byte, linear, srgb, word16};
use crate::num::npy::Array;

/// What the numbers of a picture stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Space {
    /// Encoded as sRGB.
    Srgb,
    /// Linear light.
    Linear,
}

/// What the opacity of a picture says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Opacity {
    /// Nothing: colours are as they are seen.
    Ignored,
    /// Colours are not multiplied by it.
    Straight,
    /// Colours are multiplied by it, in their own space.
    Premultiplied,
}

/// A picture as a file has it, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Foreign {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Row by row: red, green, blue and opacity; full is 1. Finite.
    pub pixels: Vec<[f64; 4]>,
    /// What the format says of its colours.
    pub space: Space,
    /// What the format says of its opacity.
    pub opacity: Opacity,
}

impl Foreign {
    /// The picture in the bytes of a file; the first of them tell the format.
    ///
    /// * PNG of any depth: sRGB, straight.
    /// * OpenEXR: linear, premultiplied.
    /// * `.npy`: as [`Foreign::of_array`].
    ///
    /// # Errors
    /// What is wrong with it: another format, a number that is not finite, or an edge above `most` pixels.
    pub fn parse(bytes: &[u8], most: u32) -> Result<Self, String> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => {
                let (size, pixels) = png::decode_deep(Cursor::new(bytes), most)?;
                Ok(Self { size, pixels, space: Space::Srgb, opacity: Opacity::Straight })
            }
            [0x76, 0x2F, 0x31, 0x01, ..] => {
                let (size, pixels) = exr::decode(bytes, most)?;
                let opacity = Opacity::Premultiplied;
                Self { size, pixels, space: Space::Linear, opacity }.finite()
            }
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Self::of_array(&Array::of(bytes)?, most),
            _ => Err("must be PNG, OpenEXR, .npy or .npz".to_owned()),
        }
    }

    /// An array of rows x columns, or rows x columns x 1 to 4 channels (gray, gray and opacity, RGB, RGBA), straight.
    /// Whole numbers of 8 or 16 bits are sRGB; floating-point numbers are linear light, 1 being full.
    ///
    /// # Errors
    /// Another shape or type, a number that is not finite, or an edge above `most` pixels.
    pub fn of_array(array: &Array<'_>, most: u32) -> Result<Self, String> {
        let (full, space) = match array.element {
            "u1" => (255.0, Space::Srgb),
            "u2" => (65_535.0, Space::Srgb),
            "f2" | "f4" | "f8" => (1.0, Space::Linear),
            other => {
                return Err(format!("descr: {other:?} must be one of u1, u2, f2, f4, f8"));
            }
        };
        let (height, width, channels) = match array.shape[..] {
            [height, width] => (height, width, 1),
            [height, width, channels @ 1..=4] => (height, width, channels),
            _ => {
                let shape = &array.shape;
                return Err(format!(
                    "shape: {shape:?} must be (rows, columns) or (rows, columns, 1 to 4 channels)"
                ));
            }
        };
        let most = u64::from(most);
        if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
            return Err(format!("is {width}x{height}, but each edge must be 1 to {most}"));
        }
        let size = [width as usize, height as usize, channels as usize];
        let values: Vec<f64> = array.reals()?.into_iter().map(|value| value / full).collect();
        let at = |x: usize, y: usize, c: usize| match array.fortran {
            true => values[y + size[1] * (x + size[0] * c)],
            false => values[c + size[2] * (x + size[0] * y)],
        };
        let pixel = |x, y| {
            let channels: Vec<f64> = (0..size[2]).map(|c| at(x, y, c)).collect();
            png::rgba(&channels, 1.0)
        };
        let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let pixels = places.map(|(x, y)| pixel(x, y)).collect();
        let size = [width as u32, height as u32];
        Self { size, pixels, space, opacity: Opacity::Straight }.finite()
    }

    /// Check that all numbers are.
    fn finite(self) -> Result<Self, String> {
        let broken = |pixel: &[f64; 4]| pixel.iter().any(|c| !c.is_finite());
        let Some(place) = self.pixels.iter().position(broken) else { return Ok(self) };
        let (x, y) = (place % self.size[0] as usize, place / self.size[0] as usize);
        let value = self.pixels[place].iter().find(|c| !c.is_finite()).unwrap_or(&f64::NAN);
        Err(format!("pixel {x},{y}: {value} must be a finite number"))
    }

    /// Whether some pixel is not opaque.
    #[must_use]
    pub fn is_transparent(&self) -> bool {
        self.pixels.iter().any(|pixel| pixel[3] < 1.0)
    }

    /// What is seen of it over a background of linear light, in 8 bits of sRGB, opaque. Where it is transparent, light
    /// is mixed in linear space.
    #[must_use]
    pub fn seen(&self, background: [f32; 3]) -> Image {
        let color = |pixel: &[f64; 4]| {
            let alpha = pixel[3].clamp(0.0, 1.0);
            let opaque = alpha >= 1.0 || self.opacity == Opacity::Ignored;
            let channel = |c: usize| {
                let value = pixel[c].clamp(0.0, 1.0);
                match (self.space, opaque) {
                    (Space::Srgb, true) => byte(value as f32),
                    (Space::Linear, true) => light(value),
                    _ => {
                        light(self.through(value, alpha) + (1.0 - alpha) * f64::from(background[c]))
                    }
                }
            };
            [channel(0), channel(1), channel(2), 255]
        };
        let pixels = self.pixels.iter().map(color).collect();
        Image { width: self.size[0], height: self.size[1], pixels }
    }

    /// The light that a channel adds to what is behind it.
    fn through(&self, value: f64, alpha: f64) -> f64 {
        match (self.space, self.opacity) {
            (Space::Linear, Opacity::Premultiplied) => value,
            (Space::Linear, _) => value * alpha,
            (Space::Srgb, Opacity::Premultiplied) if alpha > 0.0 => {
                linear((value / alpha).min(1.0)) * alpha
            }
            (Space::Srgb, _) => linear(value) * alpha,
        }
    }
}

/// The byte of a linear channel.
fn light(value: f64) -> u8 {
    srgb(word16(value as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::linear::Linear;

    fn npy(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let text =
            format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}}}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        [&bytes, text.as_bytes(), data].concat()
    }

    fn read(bytes: &[u8]) -> Image {
        Foreign::parse(bytes, 64).unwrap().seen([1.0, 0.0, 0.0])
    }

    #[test]
    fn every_format_gives_the_same_picture() {
        let pixels = vec![[0, 14_027, 65_535, 65_535], [32_768, 1_000, 9, 65_535]];
        let picture = Linear { width: 1, height: 2, pixels };
        let expected = picture.srgb8();
        let floats: Vec<u8> =
            (0..2).flat_map(|y| picture.parts(0, y)).flat_map(f32::to_le_bytes).collect();
        let bytes: Vec<u8> = expected.pixels.as_flattened().to_vec();
        let columns: Vec<u8> = (0..4).flat_map(|c| [bytes[c], bytes[4 + c]]).collect();
        for file in [
            png::encode(&expected).unwrap(),
            png::encode16(&picture).unwrap(),
            exr::encode(&picture).unwrap(),
            npy("<f4", "False", "(2, 1, 4)", &floats),
            npy("|u1", "False", "(2, 1, 4)", &bytes),
            npy("|u1", "True", "(2, 1, 4)", &columns),
        ] {
            assert_eq!(read(&file), expected);
        }
        let gray = read(&npy("|u1", "False", "(1, 2)", &[7, 9]));
        assert_eq!((gray.width, gray.pixels), (2, vec![[7, 7, 7, 255], [9, 9, 9, 255]]));
    }

    /// Half covered by white, over red.
    #[test]
    fn what_is_transparent_is_seen_over_the_background() {
        let half = [1.0, 1.0, 1.0, 0.5];
        let seen = |pixel, space, opacity| {
            let picture = Foreign { size: [1, 1], pixels: vec![pixel], space, opacity };
            assert!(picture.is_transparent());
            picture.seen([1.0, 0.0, 0.0]).pixels[0]
        };
        use Opacity::{Ignored, Premultiplied, Straight};
        let right = [255, 188, 188, 255];
        assert_eq!(seen(half, Space::Linear, Straight), right);
        assert_eq!(seen(half, Space::Srgb, Straight), right);
        assert_eq!(seen([0.5; 4], Space::Linear, Premultiplied), right);
        assert_eq!(seen([0.5; 4], Space::Srgb, Premultiplied), right);
        assert_eq!(seen(half, Space::Srgb, Ignored), [255; 4]);
        assert_eq!(seen([0.0; 4], Space::Srgb, Premultiplied), [255, 0, 0, 255]);
    }

    #[test]
    fn what_is_wrong_is_told() {
        let error = |bytes: &[u8]| Foreign::parse(bytes, 64).unwrap_err();
        assert!(error(b"P6 1 1").contains("PNG, OpenEXR"));
        let nan = [0.5_f32, f32::NAN].map(f32::to_le_bytes).concat();
        assert!(error(&npy("<f4", "False", "(1, 2)", &nan)).contains("pixel 1,0: NaN"));
        assert!(error(&npy("<f4", "False", "(2,)", &[0; 8])).starts_with("shape"));
        assert!(error(&npy("<u4", "False", "(1, 2)", &[0; 8])).starts_with("descr"));
        assert!(error(&npy("|u1", "False", "(65, 1)", &[0; 65])).contains("1 to 64"));
        assert!(error(&npy("|u1", "False", "(0, 1)", &[])).contains("1 to 64"));
        assert!(error(&npy("|u1", "False", "(2, 2, 3)", &[0; 7])).starts_with("data"));
        let infinite = Linear { width: 1, height: 1, pixels: vec![[0; 4]] };
        let mut bytes = exr::encode(&infinite).unwrap();
        assert!(Foreign::parse(&bytes, 64).is_ok());
        bytes.truncate(bytes.len() - 1);
        assert!(Foreign::parse(&bytes, 64).is_err());
    }
}
