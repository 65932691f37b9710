//! How far a picture is from a reference: every measure in one table row.

use super::difference::{self, Difference};
use super::{Image, flip, similarity};
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
        Self::with(&found, reference, test, threshold)
    }

    /// The same, where the difference is known.
    ///
    /// # Errors
    /// Images of different sizes.
    pub fn with(
        found: &Difference,
        reference: &Image,
        test: &Image,
        threshold: u8,
    ) -> Result<Self> {
        let equal = Self { ssim: 1.0, threshold, ..Self::default() };
        difference::same_size(reference, test)?;
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
