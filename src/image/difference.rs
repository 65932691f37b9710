//! How two images of one size differ, in exact integers over all four channels.

use super::{Image, ramp};
use crate::error::{Error, Result};

/// The differences between two images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Difference {
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels that differ in any channel.
    pub differing: u64,
    /// The largest absolute difference of a channel, 0..=255.
    pub max: u8,
    /// Sums of absolute differences of R, G, B and A.
    pub sums: [u64; 4],
}

impl Difference {
    /// The mean absolute difference per channel value, 0..=255: an exact sum, divided once. 0 for empty images.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: u64 = self.sums.iter().sum();
        if self.pixels == 0 { 0.0 } else { sum as f64 / (4 * self.pixels) as f64 }
    }
}

/// Compare two images.
///
/// # Errors
/// Images of different sizes.
pub fn measure(a: &Image, b: &Image) -> Result<Difference> {
    same_size(a, b)?;
    let mut found = Difference { pixels: a.pixels.len() as u64, ..Difference::default() };
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        let apart = channels(*p, *q);
        found.differing += u64::from(apart != [0; 4]);
        found.max = found.max.max(largest(apart));
        for (sum, d) in found.sums.iter_mut().zip(apart) {
            *sum += u64::from(d);
        }
    }
    Ok(found)
}

/// An opaque picture of the largest channel difference of each pixel, coloured by [`ramp::color`].
///
/// # Errors
/// Images of different sizes.
pub fn heat_map(a: &Image, b: &Image) -> Result<Image> {
    same_size(a, b)?;
    let heat = |(p, q): (&[u8; 4], &[u8; 4])| {
        let [red, green, blue] = ramp::color(largest(channels(*p, *q)));
        [red, green, blue, 255]
    };
    let pixels = a.pixels.iter().zip(&b.pixels).map(heat).collect();
    Ok(Image { width: a.width, height: a.height, pixels })
}

fn channels(p: [u8; 4], q: [u8; 4]) -> [u8; 4] {
    std::array::from_fn(|c| p[c].abs_diff(q[c]))
}

fn largest(apart: [u8; 4]) -> u8 {
    apart.into_iter().fold(0, u8::max)
}

pub(super) fn same_size(a: &Image, b: &Image) -> Result<()> {
    if (a.width, a.height) == (b.width, b.height) {
        return Ok(());
    }
    let sizes = format!("{}x{} and {}x{}", a.width, a.height, b.width, b.height);
    Err(Error::new("images", format!("sizes {sizes} cannot be compared: both must be equal")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_images_do_not_differ() {
        let image = Image::filled(5, 3, [9, 8, 7, 6]);
        let expected = Difference { pixels: 15, ..Difference::default() };
        assert_eq!(measure(&image, &image).unwrap(), expected);
        assert_eq!(expected.mean().to_bits(), 0.0f64.to_bits());
    }

    #[test]
    fn one_bit_in_any_channel_of_any_pixel_is_seen() {
        let image = Image::filled(3, 2, [128; 4]);
        for pixel in 0..6 {
            for channel in 0..4 {
                let mut other = image.clone();
                other.pixels[pixel][channel] ^= 1;
                let mut sums = [0; 4];
                sums[channel] = 1;
                let expected = Difference { pixels: 6, differing: 1, max: 1, sums };
                assert_eq!(measure(&image, &other).unwrap(), expected);
                let heat = heat_map(&image, &other).unwrap();
                let hot = heat.pixels.iter().filter(|p| p[..3] != ramp::EQUAL).count();
                assert_eq!((hot, &heat.pixels[pixel][..3]), (1, &ramp::color(1)[..]));
            }
        }
    }

    #[test]
    fn sums_and_mean_are_exact() {
        let a = Image { width: 2, height: 1, pixels: vec![[0, 10, 255, 255], [1, 1, 1, 1]] };
        let b = Image { width: 2, height: 1, pixels: vec![[255, 7, 0, 255], [1, 1, 1, 0]] };
        let found = measure(&a, &b).unwrap();
        assert_eq!(found, measure(&b, &a).unwrap());
        assert_eq!(found, Difference { pixels: 2, differing: 2, max: 255, sums: [255, 3, 255, 1] });
        assert_eq!(found.mean().to_bits(), 64.25f64.to_bits());
        assert_eq!(heat_map(&a, &b).unwrap().pixels[0][..3], ramp::color(255));
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, tall) = (Image::filled(3, 2, [0; 4]), Image::filled(2, 3, [0; 4]));
        assert!(measure(&wide, &tall).is_err() && heat_map(&wide, &tall).is_err());
    }
}
