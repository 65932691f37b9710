//! Exact integer depth: one plane equation per primitive.
//!
//! z(x, y) = (a x + b y + c + 2^23) >> 24 at the centre of pixel (x, y), clamped to the primitive's own depth range.
//! The coefficients are the exact rational plane through three snapped vertices, each rounded once (halves up) to
//! 24 fraction bits in i128, and kept modulo 2^64: sums wrap, and what wraps cancels, since the true value at a
//! covered pixel fits easily. The error against the rational plane is at most 0.5 for the final rounding plus
//! (16,384 + 16,384 + 1) / 2^25 < 0.001 for the coefficients.
//!
//! A clipped polygon takes the plane of its *carrier*, the vertex triple of largest area: every point of the polygon
//! then has barycentric coordinates within ±1 on it, so that extrapolation cannot overflow.

use pulp::{Simd, WithSimd};

use super::batch::{Lanes, bits};
use super::clip::{Snapped, UNITS, doubled_area};
use crate::fragment::BLOCK;
use crate::num::lanes::explicit;

/// Fraction bits of the coefficients.
const FRACTION: u32 = 24;

/// Half a code.
const HALF: i64 = 1 << (FRACTION - 1);

/// Depth ranges below this are walked in 32 bits: on a polygon, values lie within once the range before it and twice
/// the range behind its nearest vertex, which then fits an i32.
const NARROW: u32 = 1 << 30;

/// With fewer pixels than this, one after another is faster than all 64 at once.
const FEW: u32 = 6;

/// The depth plane of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct DepthPlane {
    a: i64,
    b: i64,
    c: i64,
    min: u32,
    max: u32,
}

impl DepthPlane {
    /// The plane of a convex polygon; `None` if all its vertices lie on one line.
    #[must_use]
    pub fn new(vertices: &[Snapped]) -> Option<Self> {
        let (mut plane, carrier) = Self::begin(vertices)?;
        plane.finish(carrier);
        Some(plane)
    }

    /// Its depth range, and its carrier.
    #[allow(clippy::inline_always, reason = "three vertices, known to be three, take no loop")]
    #[inline(always)]
    pub(super) fn begin(vertices: &[Snapped]) -> Option<(Self, [Snapped; 3])> {
        let carrier = carrier(vertices)?;
        let depths = || vertices.iter().map(|v| v.z);
        let (min, max) = (depths().min()?, depths().max()?);
        Some((Self { min, max, ..Self::default() }, carrier))
    }

    /// Its coefficients.
    #[inline]
    pub(super) fn finish(&mut self, [v0, v1, v2]: [Snapped; 3]) {
        [self.a, self.b, self.c] = match quick([v0, v1, v2]) {
            Some(coefficients) => coefficients,
            None => coefficients(v0, v1, v2).map(|v| v as i64),
        };
    }

    /// For a shader that evaluates the same plane: slope to the right, slope down, and the value at pixel (0, 0),
    /// modulo 2^64, each as its lower and its upper half; then the smallest and the largest code.
    #[must_use]
    pub fn words(&self) -> [u32; 8] {
        let [a, b, c] = [self.a, self.b, self.c].map(|v| [v as u32, (v >> 32) as u32]);
        [a[0], a[1], b[0], b[1], c[0], c[1], self.min, self.max]
    }

    /// The wrapped value at a pixel, before rounding: for walking a block by `step_x` and `step_y`.
    #[inline]
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> i64 {
        let ax = self.a.wrapping_mul(i64::from(x));
        let by = self.b.wrapping_mul(i64::from(y));
        self.c.wrapping_add(ax).wrapping_add(by)
    }

    /// The wrapped value `dx` pixels right and `dy` down of `origin`.
    #[inline]
    #[must_use]
    pub fn step(&self, origin: i64, dx: u32, dy: u32) -> i64 {
        origin
            .wrapping_add(self.a.wrapping_mul(i64::from(dx)))
            .wrapping_add(self.b.wrapping_mul(i64::from(dy)))
    }

    /// The depth codes of a block whose first pixel is (x, y), at the bits of `mask`; the other lanes hold anything.
    #[inline]
    pub fn codes(&self, [x, y]: [u32; 2], mask: u64, codes: &mut Lanes) {
        if self.max - self.min >= NARROW || mask.count_ones() < FEW {
            let origin = self.at(x, y);
            for bit in bits(mask) {
                codes[bit as usize] = self.code(self.step(origin, bit % BLOCK, bit / BLOCK));
            }
        } else {
            let origin = self.at(x, y).wrapping_add(HALF);
            explicit(Narrow { plane: self, origin, codes });
        }
    }

    /// The depth code of a wrapped value.
    #[inline]
    #[must_use]
    pub fn code(&self, value: i64) -> u32 {
        let rounded = value.wrapping_add(HALF) >> FRACTION;
        rounded.clamp(i64::from(self.min), i64::from(self.max)) as u32
    }
}

/// All codes of a block, in 32 bits. Each coefficient is split into whole codes, modulo 2^32, and its fraction; up to
/// 15 fractions fit a word. The vectors are named, since the compiler would lay them across the rows.
struct Narrow<'a> {
    plane: &'a DepthPlane,
    /// At the block's first pixel, with half a code.
    origin: i64,
    codes: &'a mut Lanes,
}

impl WithSimd for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plane: &DepthPlane { a, b, min, max, .. }, origin, codes } = self;
        let split = |v: i64| ((v >> FRACTION) as i32, v as u32 & ((1 << FRACTION) - 1));
        let [origin, a, b] = [origin, a, b].map(split);
        let (near, range) = (min.cast_signed(), (max - min).cast_signed());
        let first = origin.0.wrapping_sub(near);
        let mut whole: [i32; 8] =
            std::array::from_fn(|x| first.wrapping_add(a.0.wrapping_mul(x as i32)));
        let mut part: [u32; 8] = std::array::from_fn(|x| origin.1 + a.1 * x as u32);
        let [zero, near, range, down] = [0, near, range, b.0].map(|v| simd.splat_i32s(v));
        let [fraction, down_part] = [FRACTION, b.1].map(|v| simd.splat_u32s(v));
        let whole = S::as_mut_simd_i32s(&mut whole).0;
        let part = S::as_mut_simd_u32s(&mut part).0;
        for row in S::as_mut_simd_u32s(codes).0.chunks_exact_mut(whole.len()) {
            for ((code, whole), part) in row.iter_mut().zip(&mut *whole).zip(&mut *part) {
                let carried = simd.wrapping_dyn_shr_u32s(*part, fraction);
                let above = simd.add_i32s(*whole, simd.transmute_i32s_u32s(carried));
                let within = simd.min_i32s(simd.max_i32s(above, zero), range);
                *code = simd.transmute_u32s_i32s(simd.add_i32s(within, near));
                *whole = simd.add_i32s(*whole, down);
                *part = simd.add_u32s(*part, down_part);
            }
        }
    }
}

/// The vertex triple of largest area, the first on a tie.
#[allow(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn carrier(v: &[Snapped]) -> Option<[Snapped; 3]> {
    if let &[a, b, c] = v {
        return (doubled_area([a, b, c]) != 0).then_some([a, b, c]);
    }
    let mut best = None;
    let mut largest = 0;
    for i in 0..v.len() {
        for j in i + 1..v.len() {
            for k in j + 1..v.len() {
                let triple = [v[i], v[j], v[k]];
                let area = doubled_area(triple).abs();
                if area > largest {
                    (best, largest) = (Some(triple), area);
                }
            }
        }
    }
    best
}

/// [`coefficients`] modulo 2^64, by products of 64 bits and one division in f64; `None` where these are too narrow,
/// as for triangles of more than 8,192 square pixels.
#[allow(clippy::inline_always, reason = "so that triangles overlap in a loop")]
#[inline(always)]
fn quick([v0, v1, v2]: [Snapped; 3]) -> Option<[i64; 3]> {
    let area = doubled_area([v0, v1, v2]);
    let divisor = Divisor::new(area.abs())?;
    let of = |v: Snapped| [v.x.into(), v.y.into(), v.z.into()];
    let [origin, one, two]: [[i64; 3]; 3] = [v0, v1, v2].map(of);
    let [x1, y1, z1]: [i64; 3] = std::array::from_fn(|i| one[i] - origin[i]);
    let [x2, y2, z2]: [i64; 3] = std::array::from_fn(|i| two[i] - origin[i]);
    // Depths have 32 bits and coordinates 25: products have 58.
    let sign = area.signum();
    let slopes = [sign * (z1 * y2 - z2 * y1), sign * (z2 * x1 - z1 * x2)];
    if slopes.iter().any(|slope| slope.abs() >= divisor.limit) {
        return None;
    }
    // Whole slopes per unit, and what is left, below 2^30.
    let [(a, left_a), (b, left_b)] = slopes.map(|slope| divisor.divide(slope));
    let wide = UNITS.ilog2() + FRACTION;
    let slope = |whole: i64, left: i64| (whole << wide).wrapping_add(divisor.round(left << wide));
    // At the centre of pixel (0, 0), at most 2^24 units away: z0 + a x + b y, whole parts and what is left apart.
    let half = i64::from(UNITS / 2);
    let (x, y) = (half - origin[0], half - origin[1]);
    let (carried, left) = divisor.divide(left_a * x + left_b * y);
    let whole = (a.wrapping_mul(x)).wrapping_add(b.wrapping_mul(y));
    let whole = whole.wrapping_add(origin[2] + carried);
    let c = (whole << FRACTION).wrapping_add(divisor.round(left << FRACTION));
    Some([slope(a, left_a), slope(b, left_b), c])
}

/// Divides by an integer below 2^30 by its inverse in f64. That is off by less than 2^-51 of the quotient; below 2^50
/// this is less than a half, so that one step puts it right.
#[derive(Clone, Copy)]
struct Divisor {
    value: i64,
    inverse: f64,
    /// What is divided must be less, without its sign: quotients stay below 2^50.
    limit: i64,
}

impl Divisor {
    #[inline]
    fn new(value: i64) -> Option<Self> {
        let fits = (1..1 << 30).contains(&value);
        let limit = value.saturating_mul(1 << 50);
        fits.then(|| Self { value, inverse: 1.0 / value as f64, limit })
    }

    /// n / d towards minus infinity, and what is left, 0 to d - 1.
    #[inline]
    fn divide(self, n: i64) -> (i64, i64) {
        let estimate = n as f64 * self.inverse;
        // At or one below the integer that is nearest from below.
        let quotient = estimate as i64 - i64::from(estimate < 0.0);
        let left = n - quotient * self.value;
        // The estimate may be on the wrong side of an integer.
        let step = i64::from(left >= self.value) - i64::from(left < 0);
        (quotient + step, left - step * self.value)
    }

    /// n / d to the nearest integer, halves up; n >= 0.
    #[inline]
    fn round(self, n: i64) -> i64 {
        let (quotient, left) = self.divide(n);
        quotient + i64::from(2 * left >= self.value)
    }
}

/// Slopes per pixel and the value at the centre of pixel (0, 0), with 24 fraction bits, each rounded once.
/// Magnitudes: slopes below 2^58 * 2^32, the constant below 2^85 * 2^24: within i128.
pub(super) fn coefficients(v0: Snapped, v1: Snapped, v2: Snapped) -> [i128; 3] {
    let area = i128::from(doubled_area([v0, v1, v2]));
    let sign = area.signum();
    let (x1, y1, z1) = (long(v1.x) - long(v0.x), long(v1.y) - long(v0.y), long(v1.z) - long(v0.z));
    let (x2, y2, z2) = (long(v2.x) - long(v0.x), long(v2.y) - long(v0.y), long(v2.z) - long(v0.z));
    let slope_x = sign * (z1 * y2 - z2 * y1);
    let slope_y = sign * (z2 * x1 - z1 * x2);
    let half = long(UNITS / 2);
    let area = area.abs();
    let origin = long(v0.z) * area + slope_x * (half - long(v0.x)) + slope_y * (half - long(v0.y));
    let unit = long(UNITS);
    [slope_x * unit, slope_y * unit, origin].map(|n| divide_rounding(n << FRACTION, area))
}

fn long(v: impl Into<i128>) -> i128 {
    v.into()
}

/// n / d rounded to the nearest integer, halves up; d > 0.
fn divide_rounding(n: i128, d: i128) -> i128 {
    // One division, of magnitudes, rounded towards minus infinity.
    let (n, d) = (2 * n + d, (2 * d).unsigned_abs());
    let size = n.unsigned_abs();
    if n >= 0 { (size / d) as i128 } else { -(size.div_ceil(d) as i128) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::num::depth::FARTHEST;
    use crate::raster::clip::GUARD_BAND;

    /// Triangles of all sizes and slopes anywhere in the guard band: at most `2^reach` units across and `2^depth` codes
    /// deep.
    fn triangle() -> impl Strategy<Value = [Snapped; 3]> {
        let limit = GUARD_BAND * UNITS;
        let at = (-limit..=limit, -limit..=limit, 0..=FARTHEST);
        let by = (any::<i64>(), any::<i64>(), any::<i64>());
        (at, by, by, 0..25u32, 0..33u32).prop_map(move |((x, y, z), p, q, reach, depth)| {
            let near = |v: i32, by: i64| {
                let by = by % (1 << reach);
                (i64::from(v) + by).clamp((-limit).into(), limit.into()) as i32
            };
            let deep = |by: i64| {
                let by = by % (1 << depth);
                (i64::from(z) + by).clamp(0, FARTHEST.into()) as u32
            };
            let at = |(dx, dy, dz)| Snapped { x: near(x, dx), y: near(y, dy), z: deep(dz) };
            [Snapped { x, y, z }, at(p), at(q)]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn quick_coefficients_are_the_exact_ones(triangle in triangle()) {
            let area = doubled_area(triangle);
            if area == 0 {
                return Ok(());
            }
            let [v0, v1, v2] = triangle;
            let exact = coefficients(v0, v1, v2).map(|v| v as i64);
            match quick(triangle) {
                Some(quick) => prop_assert_eq!(quick, exact),
                // Less than half of the depth range per unit: no common triangle is steeper.
                None => prop_assert!(area.abs() >= 1 << 30 || area.abs() < 1 << 12),
            }
        }
    }

    /// Quotients that f64 cannot tell from the integers beside them.
    #[test]
    fn quotients_are_exact_next_to_integers() {
        for value in [1, 2, 3, 7, (1 << 29) + 1, (1 << 30) - 1] {
            let divisor = Divisor::new(value).unwrap();
            for quotient in [0, 1, 2, (1 << 32) - 1, (1 << 33) - 1] {
                for n in [quotient * value - 1, quotient * value, quotient * value + 1] {
                    for n in [n, -n] {
                        let expected = (n.div_euclid(value), n.rem_euclid(value));
                        assert_eq!(divisor.divide(n), expected, "{n} / {value}");
                    }
                }
            }
            // Halves go up.
            let half = value / 2;
            assert_eq!(divisor.round(half), i64::from(2 * half >= value), "{half} / {value}");
        }
        assert!(Divisor::new(0).is_none() && Divisor::new(1 << 30).is_none());
    }
}
