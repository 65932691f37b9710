//! How far a picture is from a reference: every measure in one table row.

use super::{Image, difference, flip, similarity};
use crate::error::Result;

/// The threshold of [`Metrics::beyond`] unless another is given: what rounding may explain is left out.
pub const THRESHOLD: u8 = 1;

/// How far a picture is from a reference, by the names that `--json` uses. R, G, B and A count for differences; R, G and
/// B for the other measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Metrics {
    /// [`similarity::psnr`]: decibels, over sRGB bytes. None if equal.
    pub psnr: Option<f64>,
    /// [`similarity::psnr_linear`]: decibels, over linear RGB. None if equal.
    pub psnr_linear: Option<f64>,
    /// [`similarity::ssim`]: 1 if equal.
    pub ssim: f64,
    /// The mean of [`flip::map`]: 0 if equal, at most 1.
    pub flip: f64,
    /// The largest difference of a channel, 0..=255 sRGB steps.
    pub max_difference: u8,
    /// The mean difference of a channel, 0..=255 sRGB steps.
    pub mean_difference: f64,
    /// Pixels with any difference.
    pub pixels_different: u64,
    /// sRGB steps, 0..=255.
    pub threshold: u8,
    /// Pixels with a channel that differs by more than `threshold`.
    pub pixels_beyond: u64,
    /// Their share of all pixels, 0..=100 per cent.
    pub beyond: f64,
    /// Column and row of the first pixel, row by row, that differs by `max_difference`; none if equal.
    pub worst_pixel: Option<[u32; 2]>,
}

impl Metrics {
    /// Measure `test` against `reference`.
    ///
    /// # Errors
    /// Images of different sizes.
    pub fn measure(reference: &Image, test: &Image, threshold: u8) -> Result<Self> {
        let found = difference::measure(reference, test, threshold)?;
        let equal = Self { ssim: 1.0, threshold, ..Self::default() };
        if found.differing == 0 {
            return Ok(equal);
        }
        Ok(Self {
            psnr: similarity::psnr(reference, test)?,
            psnr_linear: similarity::psnr_linear(reference, test)?,
            ssim: similarity::ssim(reference, test)?,
            flip: flip::mean(&flip::map(reference, test)?),
            max_difference: found.max,
            mean_difference: found.mean(),
            pixels_different: found.differing,
            pixels_beyond: found.beyond,
            beyond: 100.0 * found.beyond as f64 / found.pixels as f64,
            worst_pixel: found.worst,
            ..equal
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn equal_pictures() {
        let image = Image::filled(3, 2, [9, 8, 7, 6]);
        let expected = Metrics { ssim: 1.0, threshold: 4, ..Metrics::default() };
        assert_eq!(Metrics::measure(&image, &image, 4).unwrap(), expected);
        assert!(Metrics::measure(&image, &Image::filled(2, 3, [0; 4]), 4).is_err());
    }

    #[test]
    fn one_pixel_of_many() {
        let image = Image::filled(20, 20, [100, 100, 100, 255]);
        let mut other = image.clone();
        other.pixels[7 * 20 + 3][1] = 106;
        let found = Metrics::measure(&image, &other, 5).unwrap();
        assert_eq!((found.max_difference, found.pixels_different, found.pixels_beyond), (6, 1, 1));
        assert_eq!((found.worst_pixel, found.beyond), (Some([3, 7]), 0.25));
        assert_eq!(found.mean_difference.to_bits(), (6.0 / 1_600.0_f64).to_bits());
        let expected = 10.0 * libm::log10(65_025.0 * 1_200.0 / 36.0);
        assert!((found.psnr.unwrap() - expected).abs() < 1e-9);
        assert!(found.ssim < 1.0 && found.flip > 0.0);
        assert_eq!(Metrics::measure(&image, &other, 6).unwrap().beyond, 0.0);
    }

    /// Opacity alone is a difference, but nothing that PSNR, SSIM or FLIP see.
    #[test]
    fn opacity_counts_for_differences() {
        let [a, b] = [[5, 5, 5, 255], [5, 5, 5, 250]].map(|color| Image::filled(12, 11, color));
        let found = Metrics::measure(&a, &b, 1).unwrap();
        assert_eq!((found.max_difference, found.pixels_different), (5, 132));
        assert_eq!((found.psnr, found.psnr_linear, found.ssim, found.flip), (None, None, 1.0, 0.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

        /// Every measure is the same in both directions, and says "equal" of equal pictures alone.
        #[test]
        fn symmetric_and_equal_only_if_equal(
            pixels in prop::collection::vec(any::<[u8; 3]>(), 36),
            change in prop::option::of((0_usize..36, 0_usize..3, 1_u8..=255)),
        ) {
            let pixels = pixels.into_iter().map(|[r, g, b]| [r, g, b, 255]).collect();
            let a = Image { width: 9, height: 4, pixels };
            let mut b = a.clone();
            if let Some((pixel, channel, step)) = change {
                b.pixels[pixel][channel] = b.pixels[pixel][channel].wrapping_add(step);
            }
            let found = Metrics::measure(&a, &b, 0).unwrap();
            prop_assert_eq!(found, Metrics::measure(&b, &a, 0).unwrap());
            let equal = a == b;
            prop_assert_eq!(found.psnr.is_none(), equal);
            prop_assert_eq!(found.psnr_linear.is_none(), equal);
            prop_assert_eq!(found.flip == 0.0, equal);
            prop_assert_eq!(found.ssim == 1.0, equal);
            prop_assert_eq!(found.worst_pixel.is_none(), equal);
            prop_assert_eq!(found.max_difference == 0, equal);
            if let Some(place) = found.worst_pixel {
                let (pixel, ..) = change.unwrap();
                prop_assert_eq!(place, [pixel as u32 % 9, pixel as u32 / 9]);
            }
        }
    }
}
