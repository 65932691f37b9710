//! FLIP for pictures of low dynamic range: how much a viewer who flips between two pictures sees change, per pixel from
//! 0 (nothing) to 1 (black against white, about). Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020,
//! *FLIP: A Difference Evaluator for Alternating Images*; numbers in brackets are sections there.
//!
//! Colour (4.1): both pictures go from sRGB to an opponent space, YCxCz, where each channel is blurred as the eye blurs
//! it at a distance (4.1.1); back to linear RGB, clamped, and on to L\*a\*b\*, whose chroma shrinks where it is dark
//! (Hunt, 4.1.2). The distance is HyAB, |ΔL| + |(Δa, Δb)| (4.1.3), raised to 0.7 and mapped to 0..1, large ones
//! compressed (4.1.4). Features (4.2): edges and points of Y, by first and second derivatives of a Gaussian; what one
//! picture has and the other has not. Both together (4.3): colour^(1 - features).
//!
//! Distances are of the paper's viewer. Everything is f64 in the written order: the same bits everywhere. Opacity does not
//! count. Beyond the picture's edge, its outermost pixels go on.

use rayon::prelude::*;

use super::Image;
use crate::error::Result;
use crate::image::difference::same_size;
use crate::num::color::linear_of;

/// Pixels in a degree of the viewer's sight, about 67: a screen 0.7 m and 3,840 pixels wide, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 3_840.0 * (std::f64::consts::PI / 180.0);

/// Sensitivity to contrast (4.1.1, Table 1), as sums of Gaussians a sqrt(π/b) exp(-π² x² / b), x in degrees: (a, b) of
/// Y, Cx and Cz.
const SENSITIVITY: [&[(f64, f64)]; 3] =
    [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// The exponent of colour distances (4.1.4).
const COLOR_POWER: f64 = 0.7;

/// Below this share of the largest colour distance (4.1.4) ...
const KNEE: f64 = 0.4;

/// ... errors are linear up to this one.
const KNEE_ERROR: f64 = 0.95;

/// The width of the detectors of features, in degrees (4.2).
const FEATURE_WIDTH: f64 = 0.082;

/// Rows that one task takes at a time. No result depends on it.
const BAND: usize = 64;

/// The error of every pixel, row by row.
///
/// # Errors
/// Images of different sizes.
pub fn map(reference: &Image, test: &Image) -> Result<Vec<f64>> {
    same_size(reference, test)?;
    if reference.pixels.is_empty() {
        return Ok(Vec::new());
    }
    let eye = Eye::new(PIXELS_PER_DEGREE);
    let height = reference.height as usize;
    let starts: Vec<usize> = (0..height).step_by(BAND).collect();
    let band = |&start: &usize| {
        let rows = [start, (start + BAND).min(height)];
        let [a, b] = [reference, test].map(|image| eye.sees(image, rows));
        a.iter().zip(&b).map(|(a, b)| eye.error(a, b)).collect::<Vec<f64>>()
    };
    let bands: Vec<Vec<f64>> = starts.par_iter().map(band).collect();
    Ok(bands.concat())
}

/// The mean of a map, added row by row; 0 without pixels.
#[must_use]
pub fn mean(map: &[f64]) -> f64 {
    map.iter().sum::<f64>() / map.len().max(1) as f64
}

/// What the eye makes of a pixel.
struct Seen {
    /// L\*, and a\* and b\* by Hunt.
    color: [f64; 3],
    edge: f64,
    point: f64,
}

/// The kernels for a viewer, and the largest colour distance.
struct Eye {
    /// Of Y, Cx and Cz: a share and a Gaussian for each term.
    blurs: [Vec<(f64, Vec<f64>)>; 3],
    smooth: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
    largest: f64,
}

impl Eye {
    fn new(pixels_per_degree: f64) -> Self {
        let terms = || SENSITIVITY.into_iter().flatten();
        let widest = terms().map(|&(_, b)| b).fold(0.0, f64::max);
        let pi = std::f64::consts::PI;
        let reach = (3.0 * (widest / (2.0 * pi * pi)).sqrt() * pixels_per_degree).ceil();
        let blur = |terms: &[(f64, f64)]| {
            let term = |&(a, b): &(f64, f64)| {
                let gauss = kernel(reach, |x| {
                    let x = x / pixels_per_degree;
                    libm::exp(-(pi * pi) * (x * x) / b)
                });
                let sum: f64 = gauss.iter().sum();
                (a * (pi / b).sqrt() * (sum * sum), unit(&gauss))
            };
            let terms: Vec<_> = terms.iter().map(term).collect();
            let whole: f64 = terms.iter().map(|(share, _)| share).sum();
            terms.into_iter().map(|(share, gauss)| (share / whole, gauss)).collect()
        };
        let width = 0.5 * FEATURE_WIDTH * pixels_per_degree;
        let reach = (3.0 * width).ceil();
        let gauss = |x: f64| libm::exp(-(x * x) / (2.0 * width * width));
        let edge = kernel(reach, |x| -x * gauss(x));
        let point = kernel(reach, |x| (x * x / (width * width) - 1.0) * gauss(x));
        // Green against blue.
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| hunt(lab(xyz(rgb))));
        Self {
            blurs: SENSITIVITY.map(blur),
            smooth: unit(&kernel(reach, gauss)),
            edge: unit(&edge),
            point: unit(&point),
            largest: libm::pow(hyab(green, blue), COLOR_POWER),
        }
    }

    /// What it makes of the rows from `rows[0]` to before `rows[1]`.
    fn sees(&self, image: &Image, rows: [usize; 2]) -> Vec<Seen> {
        let around = self.blurs[0][0].1.len().max(self.smooth.len()) / 2;
        let [width, height] = [image.width as usize, image.height as usize];
        let first = rows[0].saturating_sub(around);
        let last = (rows[1] + around).min(height);
        let pixels = &image.pixels[first * width..last * width];
        let opponent: Vec<[f64; 3]> = pixels
            .iter()
            .map(|&[r, g, b, _]| opponent(xyz([linear_of(r), linear_of(g), linear_of(b)])))
            .collect();
        let plane = |channel: usize| Plane {
            width,
            first,
            values: opponent.iter().map(|color| color[channel]).collect(),
            rows,
        };
        let colors: [Vec<f64>; 3] = std::array::from_fn(|channel| {
            let plane = plane(channel);
            let mut sum = vec![0.0; width * (rows[1] - rows[0])];
            for (share, gauss) in &self.blurs[channel] {
                let term = plane.convolved(gauss, gauss);
                sum.iter_mut().zip(term).for_each(|(sum, value)| *sum += share * value);
            }
            sum
        });
        let mut luma = plane(0);
        luma.values.iter_mut().for_each(|y| *y = (*y + 16.0) / 116.0);
        let steepness = |kernel: &[f64]| {
            let [x, y] =
                [luma.convolved(kernel, &self.smooth), luma.convolved(&self.smooth, kernel)];
            x.into_iter().zip(y).map(|(x, y)| (x * x + y * y).sqrt()).collect::<Vec<f64>>()
        };
        let (edges, points) = (steepness(&self.edge), steepness(&self.point));
        (0..edges.len())
            .map(|i| {
                let rgb = rgb([colors[0][i], colors[1][i], colors[2][i]]);
                let color = hunt(lab(xyz(rgb.map(|c| c.clamp(0.0, 1.0)))));
                Seen { color, edge: edges[i], point: points[i] }
            })
            .collect()
    }

    /// The error between two pixels, 0..=1.
    fn error(&self, a: &Seen, b: &Seen) -> f64 {
        let distance = libm::pow(hyab(a.color, b.color), COLOR_POWER);
        let knee = KNEE * self.largest;
        let color = if distance < knee {
            distance * (KNEE_ERROR / knee)
        } else {
            KNEE_ERROR + (distance - knee) / (self.largest - knee) * (1.0 - KNEE_ERROR)
        };
        let feature = (a.edge - b.edge).abs().max((a.point - b.point).abs());
        let feature = (feature / std::f64::consts::SQRT_2).sqrt();
        libm::pow(color, 1.0 - feature).clamp(0.0, 1.0)
    }
}

/// `weight` at -reach..=reach.
fn kernel(reach: f64, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let reach = reach as i32;
    (-reach..=reach).map(|x| weight(f64::from(x))).collect()
}

/// Its positive weights scaled to a sum of 1, its negative ones to -1.
fn unit(kernel: &[f64]) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|&&w| w > 0.0).sum();
    let negative: f64 = kernel.iter().filter(|&&w| w < 0.0).sum();
    kernel.iter().map(|&w| if w < 0.0 { w / -negative } else { w / positive }).collect()
}

/// A channel of some rows of a picture.
struct Plane {
    width: usize,
    /// The row that `values` begins with.
    first: usize,
    values: Vec<f64>,
    /// The rows to compute; `values` reaches beyond them as far as kernels do, where the picture does.
    rows: [usize; 2],
}

impl Plane {
    /// By one kernel along rows and another along columns.
    fn convolved(&self, across: &[f64], down: &[f64]) -> Vec<f64> {
        let (width, reach) = (self.width, across.len() / 2);
        let mut wide = vec![0.0; width + 2 * reach];
        let mut lines = vec![0.0; self.values.len()];
        for (row, line) in self.values.chunks_exact(width).zip(lines.chunks_exact_mut(width)) {
            wide[..reach].fill(row[0]);
            wide[reach..reach + width].copy_from_slice(row);
            wide[reach + width..].fill(row[width - 1]);
            for (shift, &weight) in across.iter().enumerate() {
                add(line, weight, &wide[shift..shift + width]);
            }
        }
        let (reach, last) = (down.len() / 2, lines.len() / width - 1);
        let mut out = vec![0.0; width * (self.rows[1] - self.rows[0])];
        for (y, line) in (self.rows[0]..).zip(out.chunks_exact_mut(width)) {
            for (shift, &weight) in down.iter().enumerate() {
                let from = (y + shift).saturating_sub(reach).saturating_sub(self.first).min(last);
                add(line, weight, &lines[from * width..(from + 1) * width]);
            }
        }
        out
    }
}

fn add(line: &mut [f64], weight: f64, other: &[f64]) {
    line.iter_mut().zip(other).for_each(|(sum, value)| *sum += weight * value);
}

/// From linear sRGB to XYZ, with the paper's white.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// Its inverse.
const TO_RGB: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

/// XYZ of white, RGB (1, 1, 1).
const WHITE: [f64; 3] = [
    (10_135_552.0 + 8_788_810.0 + 4_435_075.0) / 24_577_794.0,
    1.0,
    (1_425_312.0 + 8_788_810.0 + 70_074_185.0) / 73_733_382.0,
];

fn times(matrix: &[[f64; 3]; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c]| (a * x + b * y) + c * z)
}

/// XYZ of linear RGB, each channel as a part of white.
fn xyz(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = times(&TO_XYZ, rgb);
    std::array::from_fn(|c| xyz[c] / WHITE[c])
}

/// YCxCz.
fn opponent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear RGB of YCxCz.
fn rgb([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let parts = [y + cx / 500.0, y, y - cz / 200.0];
    times(&TO_RGB, std::array::from_fn(|c| parts[c] * WHITE[c]))
}

/// L\*a\*b\*.
fn lab(xyz: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |part: f64| {
        if part > DELTA * DELTA * DELTA {
            libm::cbrt(part)
        } else {
            part / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = xyz.map(root);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Chroma as strong as it looks at that lightness.
fn hunt([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    [lightness, 0.01 * lightness * a, 0.01 * lightness * b]
}

fn hyab(p: [f64; 3], q: [f64; 3]) -> f64 {
    let [l, a, b]: [f64; 3] = std::array::from_fn(|c| p[c] - q[c]);
    l.abs() + (a * a + b * b).sqrt()
}
