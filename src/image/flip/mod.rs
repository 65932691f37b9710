//! FLIP for pictures of low dynamic range: how much a viewer who flips between two pictures sees change, per pixel from
//! 0 (nothing) to 1 (green against blue). Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020, *FLIP: A
//! Difference Evaluator for Alternating Images*.
//!
//! * Colour. Both pictures go from sRGB to an opponent space, `YCxCz`, where each channel is blurred as the eye blurs it at
//!   a distance (contrast sensitivity); back to linear RGB, clamped to 0..1, and on to L\*a\*b\*, with chroma scaled by
//!   0.01 L\* (Hunt effect). The distance is `HyAB`, |ΔL| + |(Δa, Δb)|, raised to 0.7. With m that of green and blue, the
//!   error rises in a line from 0 to 0.95 at 0.4 m, and in another to 1 at m.
//! * Features. Of (Y + 16) / 116, edges are the lengths of its first derivatives, points of its second ones, both by
//!   derivatives of one Gaussian whose positive and negative weights sum up to 1 each. The error is the larger of the
//!   differences of both, divided by √2, to the power of 0.5.
//! * Together: colour^(1 - features).
//!
//! Distances are of the paper's viewer. Everything is f64 in the written order: the same bits everywhere. Opacity does not
//! count. Beyond the picture's edge, its outermost pixels go on.

mod color;
mod plane;

use rayon::prelude::*;

use self::color::{hunt, hyab, lab, opponent, rgb, xyz};
use self::plane::{Plane, kernel, unit};
use super::Image;
use crate::error::Result;
use crate::image::difference::same_size;
use crate::num::color::linear_of;

/// Pixels in a degree of the viewer's sight, about 67: a screen 0.7 m and 3,840 pixels wide, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 3_840.0 * (std::f64::consts::PI / 180.0);

/// What the paper fixes.
#[derive(Clone, Copy)]
struct Model {
    pixels_per_degree: f64,
    /// Sensitivity to contrast, as sums of Gaussians a sqrt(π/b) exp(-π² x² / b), x in degrees: (a, b) of
    /// Y, Cx and Cz.
    sensitivity: [&'static [(f64, f64)]; 3],
    /// The light of an sRGB byte.
    light: fn(u8) -> f64,
    /// Chroma by lightness.
    chroma: fn([f64; 3]) -> [f64; 3],
    /// The exponent of colour distances.
    power: f64,
    /// Below this share of the largest colour distance, errors are linear up to this one.
    knee: [f64; 2],
    /// The width of the detectors of features, in degrees.
    feature_width: f64,
}

const PAPER: Model = Model {
    pixels_per_degree: PIXELS_PER_DEGREE,
    sensitivity: [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]],
    light: linear_of,
    chroma: hunt,
    power: 0.7,
    knee: [0.4, 0.95],
    feature_width: 0.082,
};

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
    Ok(map_by(&PAPER, reference, test))
}

fn map_by(model: &Model, reference: &Image, test: &Image) -> Vec<f64> {
    let eye = Eye::new(*model);
    let height = reference.height as usize;
    let starts: Vec<usize> = (0..height).step_by(BAND).collect();
    let band = |&start: &usize| {
        let rows = [start, (start + BAND).min(height)];
        let [a, b] = [reference, test].map(|image| eye.sees(image, rows));
        a.iter().zip(&b).map(|(a, b)| eye.error(a, b)).collect::<Vec<f64>>()
    };
    let bands: Vec<Vec<f64>> = starts.par_iter().map(band).collect();
    bands.concat()
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

/// A model's kernels, and the largest colour distance.
struct Eye {
    model: Model,
    /// Of Y, Cx and Cz: a share and a Gaussian for each term.
    blurs: [Vec<(f64, Vec<f64>)>; 3],
    smooth: Vec<f64>,
    edge: Vec<f64>,
    point: Vec<f64>,
    largest: f64,
}

impl Eye {
    fn new(model: Model) -> Self {
        let pixels_per_degree = model.pixels_per_degree;
        let terms = || model.sensitivity.into_iter().flatten();
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
        let width = 0.5 * model.feature_width * pixels_per_degree;
        let reach = (3.0 * width).ceil();
        let gauss = |x: f64| libm::exp(-(x * x) / (2.0 * width * width));
        let edge = kernel(reach, |x| -x * gauss(x));
        let point = kernel(reach, |x| (x * x / (width * width) - 1.0) * gauss(x));
        // Green against blue.
        let [green, blue] =
            [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| (model.chroma)(lab(xyz(rgb))));
        Self {
            model,
            blurs: model.sensitivity.map(blur),
            smooth: unit(&kernel(reach, gauss)),
            edge: unit(&edge),
            point: unit(&point),
            largest: libm::pow(hyab(green, blue), model.power),
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
            .map(|&[r, g, b, _]| opponent(xyz([r, g, b].map(self.model.light))))
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
                let color = (self.model.chroma)(lab(xyz(rgb.map(|c| c.clamp(0.0, 1.0)))));
                Seen { color, edge: edges[i], point: points[i] }
            })
            .collect()
    }

    /// The error between two pixels, 0..=1.
    fn error(&self, a: &Seen, b: &Seen) -> f64 {
        let distance = libm::pow(hyab(a.color, b.color), self.model.power);
        let [share, level] = self.model.knee;
        let knee = share * self.largest;
        let color = if distance < knee {
            distance * (level / knee)
        } else {
            level + (distance - knee) / (self.largest - knee) * (1.0 - level)
        };
        let feature = (a.edge - b.edge).abs().max((a.point - b.point).abs());
        let feature = (feature / std::f64::consts::SQRT_2).sqrt();
        libm::pow(color, 1.0 - feature).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::ledger::cases;
    use super::*;

    /// How far we are from flip-evaluator, which computes in single precision: 7.4e-7 at most where it was tried.
    const BOUND: f64 = 2e-6;

    fn flat(color: [u8; 4]) -> Image {
        Image::filled(40, 30, color)
    }

    fn mean_by(model: &Model, [reference, test]: &[Image; 2]) -> f64 {
        mean(&map_by(model, reference, test))
    }

    #[test]
    fn as_others_measure() {
        for case in cases() {
            let found = mean_by(&PAPER, &case.pictures);
            assert!((found - case.flip).abs() < BOUND, "{found} {}", case.flip);
        }
    }

    /// Each part of the model counts: with one of them wrong, [`as_others_measure`] fails.
    #[test]
    fn a_fault_in_any_part_is_seen() {
        let linear = |byte: u8| f64::from(byte) / 255.0;
        let [y, cx, cz] = PAPER.sensitivity;
        for (fault, model) in [
            ("no gamma", Model { light: linear, ..PAPER }),
            ("no Hunt effect", Model { chroma: |lab| lab, ..PAPER }),
            ("another distance", Model { pixels_per_degree: 67.0, ..PAPER }),
            ("colour not raised", Model { power: 1.0, ..PAPER }),
            ("no compression", Model { knee: [0.4, 0.4], ..PAPER }),
            ("wide features", Model { feature_width: 0.09, ..PAPER }),
            ("Y and Cx swapped", Model { sensitivity: [cx, y, cz], ..PAPER }),
            ("one term of Cz", Model { sensitivity: [y, cx, &cz[..1]], ..PAPER }),
        ] {
            let seen = cases()
                .iter()
                .any(|case| (mean_by(&model, &case.pictures) - case.flip).abs() > 10.0 * BOUND);
            assert!(seen, "{fault}");
        }
    }

    /// The kernels of features, and each of the steps that put an error together.
    #[test]
    fn a_fault_in_the_kernels_is_seen() {
        let case = &cases()[0];
        let [a, b] = &case.pictures;
        let rows = [0, a.height as usize];
        type Spoil = fn(&mut Eye);
        let by = |spoil: Spoil| {
            let mut eye = Eye::new(PAPER);
            spoil(&mut eye);
            let [a, b] = [eye.sees(a, rows), eye.sees(b, rows)];
            mean(&a.iter().zip(&b).map(|(a, b)| eye.error(a, b)).collect::<Vec<_>>())
        };
        assert!((by(|_| ()) - case.flip).abs() < BOUND);
        let faults: [(&str, Spoil); 5] = [
            ("no edges", |eye| eye.edge.fill(0.0)),
            ("no points", |eye| eye.point.fill(0.0)),
            ("a shifted edge", |eye| eye.edge.rotate_left(1)),
            ("a cut Gaussian", |eye| eye.smooth[0] = 0.0),
            ("no blur of Cz", |eye| eye.blurs[2].iter_mut().for_each(|(_, w)| w.rotate_left(1))),
        ];
        for (fault, spoil) in faults {
            assert!((by(spoil) - case.flip).abs() > 10.0 * BOUND, "{fault}");
        }
    }

    #[test]
    fn black_against_white_is_the_most_lightness_can_differ() {
        let map = map(&flat([0, 0, 0, 255]), &flat([255; 4])).unwrap();
        let knee = 0.4 * Eye::new(PAPER).largest;
        let distance = libm::pow(100.0, 0.7);
        let expected = 0.95 + (distance - knee) / (1.5 * knee) * 0.05;
        assert!(map.iter().all(|error| (error - expected).abs() < 1e-6), "{} {expected}", map[0]);
        assert!((mean(&map) - map[0]).abs() < 1e-12);
    }

    #[test]
    fn green_against_blue_is_1() {
        let map = map(&flat([0, 255, 0, 255]), &flat([0, 0, 255, 255])).unwrap();
        assert!(map.iter().all(|error| (error - 1.0).abs() < 1e-6), "{}", map[0]);
    }

    /// A dot is seen from afar as far as the blur reaches, and no farther.
    #[test]
    fn one_pixel_shows_in_its_surroundings() {
        let paper = Image::filled(64, 48, [128, 128, 128, 255]);
        let mut dot = paper.clone();
        dot.pixels[24 * 64 + 32] = [255, 0, 0, 255];
        let map = map(&paper, &dot).unwrap();
        let at = |x: usize, y: usize| map[y * 64 + x];
        assert!((0..map.len()).all(|i| map[i] <= at(32, 24)), "the dot is worst");
        assert!(at(32, 24) > 0.1 && at(33, 24) > 0.0 && at(32, 21) > 0.0);
        let reach = Eye::new(PAPER).blurs[2][0].1.len() / 2;
        assert_eq!([at(32 + reach + 1, 24), at(32, 24 + reach + 1)], [0.0, 0.0]);
        assert!((at(32 + 3, 24) - at(32 - 3, 24)).abs() < 1e-12, "as far to the left");
    }

    #[test]
    fn opacity_does_not_count_and_sizes_must_agree() {
        assert_eq!(mean(&map(&flat([9, 8, 7, 255]), &flat([9, 8, 7, 0])).unwrap()), 0.0);
        assert!(map(&flat([0; 4]), &Image::filled(30, 40, [0; 4])).is_err());
        let none = Image::filled(0, 5, [0; 4]);
        assert_eq!(mean(&map(&none, &none).unwrap()), 0.0);
    }

    /// The same picture, however many bands it is cut into: rows of a tall one are those of its parts.
    #[test]
    fn bands_do_not_show() {
        let case = &cases()[0];
        let [a, b] = &case.pictures;
        let eye = Eye::new(PAPER);
        let height = a.height as usize;
        let whole = [a, b].map(|image| eye.sees(image, [0, height]));
        let whole = whole[0].iter().zip(&whole[1]).map(|(a, b)| eye.error(a, b).to_bits());
        let map = map(a, b).unwrap();
        assert!(height > BAND && whole.eq(map.iter().map(|error| error.to_bits())));
    }

    fn pictures() -> impl Strategy<Value = [Image; 2]> {
        let pixels = || prop::collection::vec(any::<[u8; 3]>(), 70);
        let image = |pixels: Vec<[u8; 3]>| Image {
            width: 10,
            height: 7,
            pixels: pixels.into_iter().map(|[r, g, b]| [r, g, b, 255]).collect(),
        };
        [pixels(), pixels()].prop_map(move |both| both.map(image))
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(32) })]

        #[test]
        fn it_is_symmetric_within_0_and_1_and_0_for_equals([a, b] in pictures()) {
            let (there, back) = (map(&a, &b).unwrap(), map(&b, &a).unwrap());
            prop_assert!(there.iter().all(|error| (0.0..=1.0).contains(error)));
            let bits = |map: &[f64]| map.iter().map(|error| error.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&there), bits(&back));
            prop_assert_eq!(mean(&there) == 0.0, a == b);
            prop_assert!(map(&a, &a).unwrap().iter().all(|&error| error == 0.0));
        }

        #[test]
        fn one_step_of_one_channel_is_seen([a, _] in pictures(), pixel in 0_usize..70, channel in 0_usize..3) {
            let mut b = a.clone();
            b.pixels[pixel][channel] ^= 1;
            prop_assert!(mean(&map(&a, &b).unwrap()) > 0.0);
        }
    }
}
