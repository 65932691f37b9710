//! How much alike two images of one size look, as numbers in common use: PSNR and SSIM ([`super::flip`] is another).
//!
//! Opacity does not count. All is f64 in the written order: the same bits everywhere.

use rayon::prelude::*;

use super::Image;
use crate::error::Result;
use crate::image::difference::same_size;
use crate::num::color::linear_of;

/// Pixels on either side of a window's middle.
const REACH: usize = 5;

/// The width of its Gaussian, in pixels.
const SIGMA: f64 = 1.5;

/// (K1 L)² and (K2 L)², which keep quotients of flat windows finite.
const STABLE: [f64; 2] = [(0.01 * 255.0) * (0.01 * 255.0), (0.03 * 255.0) * (0.03 * 255.0)];

/// The peak signal-to-noise ratio over R, G and B as sRGB bytes, in decibels: 10 log10(255² / mean squared difference). `None` if the
/// images are equal.
///
/// # Errors
/// Images of different sizes.
pub fn psnr(a: &Image, b: &Image) -> Result<Option<f64>> {
    same_size(a, b)?;
    let square = |(p, q): (&[u8; 4], &[u8; 4])| -> u64 {
        (0..3).map(|c| u64::from(p[c].abs_diff(q[c])) * u64::from(p[c].abs_diff(q[c]))).sum()
    };
    let sum: u64 = a.pixels.iter().zip(&b.pixels).map(square).sum();
    let mean = sum as f64 / (3 * a.pixels.len().max(1)) as f64;
    Ok((sum > 0).then(|| 10.0 * libm::log10(255.0 * 255.0 / mean)))
}

/// The same over linear R, G and B, as parts of white: 10 log10(1 / mean squared difference). Differences in the dark
/// count less than with bytes. `None` if the images are equal.
///
/// # Errors
/// Images of different sizes.
pub fn psnr_linear(a: &Image, b: &Image) -> Result<Option<f64>> {
    same_size(a, b)?;
    let mut sum = 0.0;
    for (p, q) in a.pixels.iter().zip(&b.pixels) {
        for c in 0..3 {
            let apart = linear_of(p[c]) - linear_of(q[c]);
            sum += apart * apart;
        }
    }
    let mean = sum / (3 * a.pixels.len().max(1)) as f64;
    Ok((sum > 0.0).then(|| 10.0 * libm::log10(1.0 / mean)))
}

/// The mean structural similarity of luma, at most 1, which is equal (Wang, Bovik, Sheikh, Simoncelli 2004: a Gaussian
/// window of 11 x 11 pixels and sigma 1.5, K1 = 0.01, K2 = 0.03), over the windows that lie within the picture. Where
/// none does, since an edge is shorter than 11 pixels, windows are cut at both ends of it and their weights made up to 1.
/// Luma is 0.299 R + 0.587 G + 0.114 B, of sRGB bytes.
///
/// # Errors
/// Images of different sizes.
pub fn ssim(a: &Image, b: &Image) -> Result<f64> {
    same_size(a, b)?;
    if a.pixels.is_empty() {
        return Ok(1.0);
    }
    let size = [a.width as usize, a.height as usize];
    let luma = |image: &Image| -> Vec<f64> {
        let of = |p: &[u8; 4]| {
            let [r, g, b, _] = p.map(f64::from);
            (0.299 * r + 0.587 * g) + 0.114 * b
        };
        image.pixels.iter().map(of).collect()
    };
    let (x, y) = (luma(a), luma(b));
    let product =
        |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x * y).collect() };
    let blur = |values: &[f64]| blurred(values, size);
    let (mean_x, mean_y) = (blur(&x), blur(&y));
    let (xx, yy, xy) = (blur(&product(&x, &x)), blur(&product(&y, &y)), blur(&product(&x, &y)));
    // The middles of windows.
    let whole = |edge: usize| if edge > 2 * REACH { REACH..edge - REACH } else { 0..edge };
    let [columns, rows] = size.map(whole);
    let count = columns.len() * rows.len();
    let mut sum = 0.0;
    for i in rows.flat_map(|y| columns.clone().map(move |x| y * size[0] + x)) {
        let (mx, my) = (mean_x[i], mean_y[i]);
        let (vx, vy, cov) = (xx[i] - mx * mx, yy[i] - my * my, xy[i] - mx * my);
        let light = (2.0 * mx * my + STABLE[0]) / ((mx * mx + my * my) + STABLE[0]);
        let structure = (2.0 * cov + STABLE[1]) / ((vx + vy) + STABLE[1]);
        sum += light * structure;
    }
    Ok(sum / count as f64)
}

/// The weighted mean around every pixel: rows first, then columns.
fn blurred(values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
    let weights: [f64; REACH + 1] = std::array::from_fn(|distance| {
        let d = distance as f64;
        libm::exp(-(d * d) / (2.0 * SIGMA * SIGMA))
    });
    let along = |values: &[f64], edge: usize, at: &dyn Fn(usize, usize) -> usize, line: usize| {
        let mean = |place: usize| {
            let (mut sum, mut whole) = (0.0, 0.0);
            for other in place.saturating_sub(REACH)..(place + REACH + 1).min(edge) {
                let weight = weights[place.abs_diff(other)];
                sum += weight * values[at(line, other)];
                whole += weight;
            }
            sum / whole
        };
        (0..edge).map(mean).collect::<Vec<f64>>()
    };
    let row = |y| along(values, width, &|line, place| line * width + place, y);
    let rows: Vec<Vec<f64>> = (0..height).into_par_iter().map(row).collect();
    let rows = rows.concat();
    let column = |x| along(&rows, height, &|line, place| place * width + line, x);
    let columns: Vec<Vec<f64>> = (0..width).into_par_iter().map(column).collect();
    (0..width * height).map(|i| columns[i % width][i / width]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(step: u8) -> Image {
        let of = |i: usize| [(i % 24 * 7) as u8 + step, (i / 24 * 9) as u8, 90, 255];
        Image { width: 24, height: 20, pixels: (0..480).map(of).collect() }
    }

    #[test]
    fn equal_images_are_wholly_alike() {
        assert_eq!(psnr(&ramp(0), &ramp(0)).unwrap(), None);
        assert!((ssim(&ramp(0), &ramp(0)).unwrap() - 1.0).abs() < 1e-12);
        assert!(ssim(&ramp(0), &Image::filled(1, 1, [0; 4])).is_err());
        assert!(psnr(&ramp(0), &Image::filled(1, 1, [0; 4])).is_err());
    }

    /// One channel of three is off by one everywhere: a mean square of a third.
    #[test]
    fn a_known_ratio() {
        let found = psnr(&ramp(0), &ramp(1)).unwrap().unwrap();
        assert!((found - 10.0 * libm::log10(255.0 * 255.0 * 3.0)).abs() < 1e-12, "{found}");
    }

    /// Two flat images differ in light alone.
    #[test]
    fn flat_images_have_a_closed_form() {
        let (a, b) = (Image::filled(30, 14, [100; 4]), Image::filled(30, 14, [110; 4]));
        let expected =
            (2.0 * 100.0 * 110.0 + STABLE[0]) / (100.0 * 100.0 + 110.0 * 110.0 + STABLE[0]);
        assert!((ssim(&a, &b).unwrap() - expected).abs() < 1e-9);
    }

    #[test]
    fn structure_counts_more_than_light() {
        let mut noisy = ramp(0);
        for (i, pixel) in noisy.pixels.iter_mut().enumerate() {
            pixel[0] = pixel[0].saturating_add(if i % 2 == 0 { 20 } else { 0 });
        }
        let (lighter, noisy) =
            (ssim(&ramp(0), &ramp(10)).unwrap(), ssim(&ramp(0), &noisy).unwrap());
        assert!(noisy < lighter && lighter < 1.0, "{noisy} {lighter}");
    }
}
