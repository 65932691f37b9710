//! How far the words and colours of a twin may be from the simulator's: not at all, where both are integers. Where a
//! device's floats go into a sum, the bound counts the operations of the twin's file.
//!
//! The unit is 2^-23 of the value: a unit in the last place (ulp) of an f32 is at most that. By the standard, the
//! conversion of an integer, a sum, a product and a rounded constant are off by one unit at most (a constant by a half), a
//! quotient by 2.5. To multiply adds the errors of both factors; a sum of positive numbers has at most the larger error
//! of both.
//!
//! These bounds say when a device's sum counts as equal. Nothing that is kept or left out depends on them.

use super::shape::Shape;
use crate::exec::Method;
use crate::gpu::driver::failure::{Failure, Result};
use crate::scheme::{Config, Light};

/// A weighted sum of `wboit`, in units of itself.
///
/// Distance: 2.5 for the product with its step, 3.5 with the near plane, 6.5 for the quotient. A 200th: 9, its square
/// 19, its sixth power 59, the sum of three 61, the quotient 63.5 (the other weights have fewer). Opacity 2.5, times the
/// weight 67; colour 2.5, times that 70.5. The rest is for products of errors, and for the simulator's f64.
pub const WEIGHTED: u32 = 72;

/// A colour of `wboit`, at most 1, in units of 1: the errors of both sums, and what rounding to whole units does to the
/// sum of opacities, where a fragment adds 6.7e5 units at least: 1.5e-6 of it, 13 units, also twice.
pub const COLOR: u32 = 2 * WEIGHTED + 26;

/// The absorbance of `mbt` as a float, in units of itself: a conversion and a sum.
pub const ABSORBANCE: u32 = 2;

/// What each further power of u adds to that, besides [`STEEP`]. u is at most 1. The logarithm is off by 3 of itself,
/// where that is more than 2^-21: 6 of u. Its product with 2 / ln(far / near) adds 3, the difference 1. (Where rays are
/// parallel, it is 6 in all.) The product with u adds 1, and products of errors less than another.
pub const POWER: u32 = 12;

/// The part of it that the planes decide, over ln(far / near): the argument of the logarithm is off by 3.5 of itself,
/// which moves the logarithm by as much, and the logarithm by 2^-21, 4 units; and u is twice that.
pub const STEEP: f64 = 15.0;

/// Rounding a term to whole units, on both sides, and the table's absorbance.
const UNITS: u64 = 2;

/// With the far plane nearer than this many near planes, a logarithmic scale is too steep for f32.
const SMALLEST_RATIO: f64 = 1.001;

/// How far a 64-bit word may be from the simulator's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    /// Not at all.
    Same,
    /// So many units of its own value.
    OfItself(u32),
    /// So many units of the first word.
    OfFirst(u32),
    /// The twin does not compute it, or arrival decides it; the colour, which does not depend on that, shows whether it
    /// is right.
    Left,
}

/// How far a colour may be from the simulator's. Its transmittance has the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Color {
    /// Not at all.
    Same,
    /// So many units of 1.
    Within(u32),
    /// The twin does not compute it.
    Left,
}

/// How far what a twin gives may be from what the simulator gives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Of a pixel's first words; the others are the same.
    words: Vec<Word>,
    /// Of a pixel where arrival decides, the word that it does not decide.
    settled: Option<usize>,
    color: Color,
}

impl Bounds {
    /// Those of a method's twin.
    #[must_use]
    pub fn of(method: Method, config: &Config) -> Self {
        match method.name() {
            "wboit" => {
                let words = vec![Word::OfItself(WEIGHTED); 4];
                Self { words, settled: None, color: Color::Within(COLOR) }
            }
            "mbt" => {
                let moments = config.approximation.moments;
                let planes = config.distances.planes;
                let steep = STEEP / libm::log(planes.far / planes.near);
                let steep = if planes.parallel { 0 } else { libm::ceil(steep) as u32 };
                let power = |i| Word::OfFirst(ABSORBANCE + i * (POWER + steep));
                let mut words = vec![Word::Same];
                words.extend((1..=moments).map(power));
                // The reference, and the sums of the second pass.
                words.extend([Word::Left; 5]);
                Self { words, settled: None, color: Color::Left }
            }
            // The lock and the number of nodes, behind what is behind each of k nodes.
            "mlab" => {
                let settled = config.k.or(method.contract().default_k).map(|k| k as usize);
                Self { words: Vec::new(), settled, color: Color::Same }
            }
            // Four sums, the lock and the counter; then the k nearest, in any order.
            "hybrid" => {
                let k = config.k.or(method.contract().default_k).unwrap_or_default();
                let mut words = vec![Word::Same; 5];
                words.extend((0..k).map(|_| Word::Left));
                Self { words, settled: None, color: Color::Same }
            }
            _ => Self { words: Vec::new(), settled: None, color: Color::Same },
        }
    }

    /// What equality does not say.
    #[must_use]
    pub fn says(&self) -> &'static str {
        match self.color {
            Color::Same => "",
            Color::Within(_) => "its sums are floats, within a bound",
            Color::Left => "moments alone, within a bound",
        }
    }

    /// The first of a pixel's words that is too far from the simulator's, after `n` fragments.
    #[must_use]
    pub fn first_apart(&self, right: &[u64], found: &[u64], n: u64) -> Option<usize> {
        let first = right.first().copied().unwrap_or_default();
        let near = |i: usize| {
            let (Some(&right), Some(&found)) = (right.get(i), found.get(i)) else { return false };
            let (ulps, of) = match self.words.get(i).copied().unwrap_or(Word::Same) {
                Word::Same => return right == found,
                Word::Left => return true,
                Word::OfItself(ulps) => (ulps, right),
                Word::OfFirst(ulps) => (ulps, first),
            };
            let bound = (u128::from(of) * u128::from(ulps)) >> 23;
            let apart = found.wrapping_sub(right).cast_signed().unsigned_abs();
            u128::from(apart) <= bound + u128::from(UNITS * n)
        };
        (0..right.len().max(found.len())).find(|&i| !near(i))
    }

    /// Whether those of a pixel's words that arrival does not decide are the same.
    #[must_use]
    pub fn is_settled(&self, right: &[u64], found: &[u64]) -> bool {
        self.settled.is_none_or(|word| right.get(word) == found.get(word))
    }

    /// Whether a colour is near enough to the simulator's.
    #[must_use]
    pub fn is_near(&self, right: &Light, found: &Light) -> bool {
        let same = right.transmittance.to_bits() == found.transmittance.to_bits();
        match self.color {
            Color::Same => right == found,
            Color::Left => same,
            Color::Within(ulps) => {
                let most = f64::from(ulps) / f64::from(1 << 23);
                let mut channels = right.color.iter().zip(&found.color);
                same && channels.all(|(right, found)| (right - found).abs() <= most)
            }
        }
    }
}

/// Whether a colour may come from another arrival of the same `n` fragments: the same number of nodes, and a
/// transmittance that is within rounding. In either arrival there are two roundings for each fragment, by half a unit of
/// 16 bits at most.
#[must_use]
pub fn may_be_another_arrival(right: &Light, found: &Light, n: u64) -> bool {
    let apart = (right.transmittance - found.transmittance).abs() * 65_535.0;
    right.kept == found.kept && apart <= 2.0 * n as f64 + 0.5
}

/// Whether bounds hold for a method with this configuration.
///
/// # Errors
/// They do not.
pub fn can(shape: &Shape) -> Result<()> {
    let planes = shape.config.distances.planes;
    let problem = match shape.contract.name {
        "wboit" if planes.near < 0.0 => "no bound holds for distances behind the eye",
        "mbt" if !planes.parallel && planes.far < SMALLEST_RATIO * planes.near => {
            "no bound holds where the far plane is near the near plane"
        }
        _ => return Ok(()),
    };
    Err(Failure::Unsupported(problem.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue;

    #[test]
    fn bounds_are_as_wide_as_they_say() {
        let of = |name| Bounds::of(catalogue::method(name).expect("known"), &Config::default());
        let wboit = of("wboit");
        let right = [1 << 30, 0, 5, 1 << 40, 77];
        let with = |i: usize, word: u64| {
            let mut found = right;
            found[i] = word;
            wboit.first_apart(&right, &found, 3)
        };
        let most = 72 * (1 << 7) + 6;
        assert_eq!(with(0, right[0] + most), None);
        assert_eq!(with(0, right[0] + most + 1), Some(0));
        assert_eq!(with(0, right[0] - most - 1), Some(0));
        assert_eq!([with(1, 6), with(1, 7), with(4, 78)], [None, Some(1), Some(4)]);
        assert_eq!(wboit.first_apart(&right, &right[..4], 3), Some(4));
        let mlab = of("mlab");
        assert_eq!(mlab.first_apart(&right, &[1 << 30, 0, 6, 1 << 40, 77], 3), Some(2));
    }

    #[test]
    fn moments_are_in_units_of_the_first() {
        let mbt = Bounds::of(catalogue::method("mbt").expect("known"), &Config::default());
        let right = [1 << 40, (-5_i64).cast_unsigned(), 0, 0, 0, 1, 2, 3, 4, 5];
        let second = |word: i64| {
            let mut found = right;
            found[1] = word.cast_unsigned();
            mbt.first_apart(&right, &found, 1)
        };
        // Planes at 0.1 and 100: 15 / ln(1000) is 2.2.
        let most = 17 * (1 << 17) + 2;
        assert_eq!([second(most - 5), second(-5 - most)], [None, None]);
        assert_eq!([second(most - 4), second(-6 - most)], [Some(1), Some(1)]);
        let mut other = right;
        other[9] = 0;
        assert_eq!(mbt.first_apart(&right, &other, 1), None, "it has no second pass");
        other[0] += 1;
        assert_eq!(mbt.first_apart(&right, &other, 1), Some(0), "the absorbance is exact");
    }
}
