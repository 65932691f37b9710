//! How much alike two images of one size look, as numbers in common use: PSNR and SSIM ([`super::flip`] is another).
//!
//! Opacity does not count. All is f64 in the written order: the same bits everywhere.

use rayon::prelude::*;

use super::Image;
use crate::error::Result;
use crate::image::difference::same_size;
use crate::num::color::linear_of;

/// What the paper on SSIM fixes.
#[derive(Clone, Copy)]
struct Window {
    /// Pixels on either side of its middle.
    reach: usize,
    /// The width of its Gaussian, in pixels.
    sigma: f64,
    /// (K1 L)² and (K2 L)², which keep quotients of flat windows finite.
    stable: [f64; 2],
    /// Shares of R, G and B.
    luma: [f64; 3],
}

const WANG: Window = Window {
    reach: 5,
    sigma: 1.5,
    stable: [(0.01 * 255.0) * (0.01 * 255.0), (0.03 * 255.0) * (0.03 * 255.0)],
    luma: [0.299, 0.587, 0.114],
};

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
    Ok(if a.pixels.is_empty() { 1.0 } else { ssim_by(WANG, a, b) })
}

fn ssim_by(window: Window, a: &Image, b: &Image) -> f64 {
    let Window { reach, stable, luma: [red, green, blue], .. } = window;
    let size = [a.width as usize, a.height as usize];
    let luma = |image: &Image| -> Vec<f64> {
        let of = |p: &[u8; 4]| {
            let [r, g, b, _] = p.map(f64::from);
            (red * r + green * g) + blue * b
        };
        image.pixels.iter().map(of).collect()
    };
    let (x, y) = (luma(a), luma(b));
    let product =
        |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x * y).collect() };
    let blur = |values: &[f64]| window.blurred(values, size);
    let (mean_x, mean_y) = (blur(&x), blur(&y));
    let (xx, yy, xy) = (blur(&product(&x, &x)), blur(&product(&y, &y)), blur(&product(&x, &y)));
    // The middles of windows.
    let whole = |edge: usize| if edge > 2 * reach { reach..edge - reach } else { 0..edge };
    let [columns, rows] = size.map(whole);
    let count = columns.len() * rows.len();
    let mut sum = 0.0;
    for i in rows.flat_map(|y| columns.clone().map(move |x| y * size[0] + x)) {
        let (mx, my) = (mean_x[i], mean_y[i]);
        let (vx, vy, cov) = (xx[i] - mx * mx, yy[i] - my * my, xy[i] - mx * my);
        let light = (2.0 * mx * my + stable[0]) / ((mx * mx + my * my) + stable[0]);
        let structure = (2.0 * cov + stable[1]) / ((vx + vy) + stable[1]);
        sum += light * structure;
    }
    sum / count as f64
}

impl Window {
    /// The weighted mean around every pixel: rows first, then columns.
    fn blurred(&self, values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
        let Self { reach, sigma, .. } = *self;
        let weight = |distance: usize| {
            let d = distance as f64;
            libm::exp(-(d * d) / (2.0 * sigma * sigma))
        };
        let weights: Vec<f64> = (0..=reach).map(weight).collect();
        let along =
            |values: &[f64], edge: usize, at: &dyn Fn(usize, usize) -> usize, line: usize| {
                let mean = |place: usize| {
                    let (mut sum, mut whole) = (0.0, 0.0);
                    for other in place.saturating_sub(reach)..(place + reach + 1).min(edge) {
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
}

#[cfg(test)]
mod tests {
    use super::super::ledger::cases;
    use super::*;

    /// How far we may be from scikit-image, which computes in double precision too, in another order.
    const BOUND: f64 = 1e-9;

    #[test]
    fn as_others_measure() {
        for case in cases() {
            let [a, b] = &case.pictures;
            for (found, expected) in [
                (psnr(a, b).unwrap().unwrap(), case.psnr),
                (psnr_linear(a, b).unwrap().unwrap(), case.psnr_linear),
                (ssim(a, b).unwrap(), case.ssim),
            ] {
                assert!((found - expected).abs() < BOUND, "{found} {expected}");
            }
        }
    }

    /// With any of these, [`as_others_measure`] fails.
    #[test]
    fn a_fault_in_any_part_is_seen() {
        let [c1, c2] = WANG.stable;
        for (fault, window) in [
            ("7 x 7 pixels", Window { reach: 3, ..WANG }),
            ("another sigma", Window { sigma: 1.4, ..WANG }),
            ("constants for 0..1", Window { stable: WANG.stable.map(|c| c / 65_025.0), ..WANG }),
            ("constants swapped", Window { stable: [c2, c1], ..WANG }),
            ("luma of HDTV", Window { luma: [0.2126, 0.7152, 0.0722], ..WANG }),
        ] {
            let seen = |case: &super::super::ledger::Case| {
                (ssim_by(window, &case.pictures[0], &case.pictures[1]) - case.ssim).abs() > BOUND
            };
            assert!(cases().iter().any(seen), "{fault}");
        }
        let [case, ..] = &cases()[..] else { panic!("no cases") };
        assert!((case.psnr - case.psnr_linear).abs() > BOUND, "a missing gamma");
        let [a, b] = &case.pictures;
        let [mut a, mut b] = [a.clone(), b.clone()];
        a.pixels.iter_mut().chain(&mut b.pixels).for_each(|pixel| pixel[2] = pixel[1]);
        let without_blue = psnr(&a, &b).unwrap().unwrap();
        assert!((without_blue - case.psnr).abs() > BOUND, "a channel too few");
    }

    /// Windows that are cut at the edge do not count, unless there are no others.
    #[test]
    fn only_whole_windows_count() {
        let a = Image::filled(31, 31, [60, 60, 60, 255]);
        let mut b = a.clone();
        b.pixels[15 * 31 + 15] = [90, 90, 90, 255];
        let around = |edge: u32| {
            let cut = |image: &Image| {
                let from = (31 - edge) / 2;
                let places = (0..edge).flat_map(|y| (0..edge).map(move |x| (from + x, from + y)));
                let pixels = places.map(|(x, y)| image.pixel(x, y)).collect();
                Image { width: edge, height: edge, pixels }
            };
            1.0 - ssim(&cut(&a), &cut(&b)).unwrap()
        };
        // 21 x 21 whole windows hold the dot or not; a smaller picture has the same windows around it.
        assert!((around(31) * 21.0 * 21.0 - around(21) * 11.0 * 11.0).abs() < 1e-9);
        assert!(around(11) > 0.0 && around(9) > 0.0, "one whole window, and none");
    }

    fn ramp(step: u8) -> Image {
        let of = |i: usize| [(i % 24 * 7) as u8 + step, (i / 24 * 9) as u8, 90, 255];
        Image { width: 24, height: 20, pixels: (0..480).map(of).collect() }
    }

    #[test]
    fn equal_images_are_wholly_alike() {
        assert_eq!(psnr(&ramp(0), &ramp(0)).unwrap(), None);
        assert_eq!(psnr_linear(&ramp(0), &ramp(0)).unwrap(), None);
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

    /// Black against white: a mean square of 1, so 0 dB.
    #[test]
    fn black_against_white_is_0() {
        let [black, white] = [[0, 0, 0, 255], [255; 4]].map(|color| Image::filled(13, 12, color));
        assert_eq!(psnr(&black, &white).unwrap(), Some(0.0));
        assert_eq!(psnr_linear(&black, &white).unwrap(), Some(0.0));
        let expected = WANG.stable[0] / (65_025.0 + WANG.stable[0]);
        assert!((ssim(&black, &white).unwrap() - expected).abs() < 1e-9);
    }

    /// Two flat images differ in light alone.
    #[test]
    fn flat_images_have_a_closed_form() {
        let (a, b) = (Image::filled(30, 14, [100; 4]), Image::filled(30, 14, [110; 4]));
        let expected = (2.0 * 100.0 * 110.0 + WANG.stable[0])
            / (100.0 * 100.0 + 110.0 * 110.0 + WANG.stable[0]);
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
