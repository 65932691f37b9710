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
    /// Pixels with a channel that differs by more than a given threshold.
    pub beyond: u64,
    /// Column and row of the first pixel, row by row, with a channel that differs by `max`; none if the images are equal.
    pub worst: Option<[u32; 2]>,
}

impl Difference {
    /// The mean absolute difference per channel value, 0..=255: an exact sum, divided once. 0 for empty images.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: u64 = self.sums.iter().sum();
        if self.pixels == 0 { 0.0 } else { sum as f64 / (4 * self.pixels) as f64 }
    }
}

/// Compare two images. `threshold` is for [`Difference::beyond`], in sRGB steps.
///
/// # Errors
/// Images of different sizes.
pub fn measure(a: &Image, b: &Image, threshold: u8) -> Result<Difference> {
    same_size(a, b)?;
    let mut found = Difference { pixels: a.pixels.len() as u64, ..Difference::default() };
    let places = (0..a.height).flat_map(|y| (0..a.width).map(move |x| [x, y]));
    for (place, (p, q)) in places.zip(a.pixels.iter().zip(&b.pixels)) {
        let apart = channels(*p, *q);
        let most = largest(apart);
        found.differing += u64::from(most > 0);
        found.beyond += u64::from(most > threshold);
        if most > found.max {
            (found.max, found.worst) = (most, Some(place));
        }
        for (sum, d) in found.sums.iter_mut().zip(apart) {
            *sum += u64::from(d);
        }
    }
    Ok(found)
}

/// The largest channel difference of each pixel, row by row.
///
/// # Errors
/// Images of different sizes.
pub fn map(a: &Image, b: &Image) -> Result<Vec<u8>> {
    same_size(a, b)?;
    Ok(a.pixels.iter().zip(&b.pixels).map(|(p, q)| largest(channels(*p, *q))).collect())
}

/// An opaque picture of [`map()`], coloured by [`ramp::color`].
///
/// # Errors
/// Images of different sizes.
pub fn heat_map(a: &Image, b: &Image) -> Result<Image> {
    let heat = |difference| {
        let [red, green, blue] = ramp::color(difference);
        [red, green, blue, 255]
    };
    let pixels = map(a, b)?.into_iter().map(heat).collect();
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
        assert_eq!(measure(&image, &image, 0).unwrap(), expected);
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
                let worst = Some([pixel as u32 % 3, pixel as u32 / 3]);
                let (pixels, differing, max, beyond) = (6, 1, 1, 1);
                let expected = Difference { pixels, differing, max, sums, beyond, worst };
                assert_eq!(measure(&image, &other, 0).unwrap(), expected);
                assert_eq!(
                    measure(&image, &other, 1).unwrap(),
                    Difference { beyond: 0, ..expected }
                );
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
        let found = measure(&a, &b, 1).unwrap();
        assert_eq!(found, measure(&b, &a, 1).unwrap());
        let (sums, worst) = ([255, 3, 255, 1], Some([0, 0]));
        let expected = Difference { pixels: 2, differing: 2, max: 255, sums, beyond: 1, worst };
        assert_eq!(found, expected);
        assert_eq!(found.mean().to_bits(), 64.25f64.to_bits());
        assert_eq!(heat_map(&a, &b).unwrap().pixels[0][..3], ramp::color(255));
    }

    /// Of two equally bad pixels, the one in the row above counts, though its column is larger.
    #[test]
    fn the_worst_pixel_is_the_first_in_row_order() {
        let a = Image::filled(4, 3, [100; 4]);
        let mut b = a.clone();
        for ([x, y], step) in [([1, 0], 8), ([3, 1], 9), ([0, 2], 9)] {
            b.pixels[y * 4 + x][2] += step;
        }
        let found = measure(&a, &b, 8).unwrap();
        assert_eq!(
            (found.worst, found.max, found.beyond, found.differing),
            (Some([3, 1]), 9, 2, 3)
        );
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, tall) = (Image::filled(3, 2, [0; 4]), Image::filled(2, 3, [0; 4]));
        assert!(measure(&wide, &tall, 0).is_err() && heat_map(&wide, &tall).is_err());
    }
}
