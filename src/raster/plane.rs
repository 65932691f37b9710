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

use super::batch::{Lanes, bits};
use super::clip::{Polygon, Snapped, UNITS, doubled_area};
use crate::fragment::BLOCK;
use crate::num::lanes::wide;

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
    /// The plane of a polygon; `None` if all its vertices lie on one line.
    #[must_use]
    pub fn new(polygon: &Polygon) -> Option<Self> {
        let [v0, v1, v2] = carrier(polygon)?;
        let [a, b, c] = coefficients(v0, v1, v2);
        let depths = || polygon.vertices().iter().map(|v| v.z);
        let (min, max) = (depths().min()?, depths().max()?);
        Some(Self { a: a as i64, b: b as i64, c: c as i64, min, max })
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
            wide(
                #[inline(always)]
                || self.narrow(origin, codes),
            );
        }
    }

    /// All codes of a block, in 32 bits. Each coefficient is split into whole codes, modulo 2^32, and its fraction;
    /// up to 15 fractions fit a word.
    #[allow(clippy::inline_always, reason = "see `lanes`")]
    #[inline(always)]
    fn narrow(&self, origin: i64, codes: &mut Lanes) {
        let split = |v: i64| ((v >> FRACTION) as u32, v as u32 & ((1 << FRACTION) - 1));
        let [(whole, part), a, b] = [origin, self.a, self.b].map(split);
        let times = |(whole, part): (u32, u32), n: u32| (whole.wrapping_mul(n), part * n);
        let columns: [(u32, u32); 8] = std::array::from_fn(|n| times(a, n as u32));
        let range = (self.max - self.min) as i32;
        for (row, n) in codes.chunks_exact_mut(8).zip(0..) {
            let down = times(b, n);
            let whole = whole.wrapping_add(down.0).wrapping_sub(self.min);
            let part = part + down.1;
            for (code, across) in row.iter_mut().zip(columns) {
                let carried = (part + across.1) >> FRACTION;
                let above = whole.wrapping_add(across.0).wrapping_add(carried) as i32;
                *code = above.clamp(0, range) as u32 + self.min;
            }
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

/// The vertex triple of largest area, the first on a tie.
fn carrier(polygon: &Polygon) -> Option<[Snapped; 3]> {
    let v = polygon.vertices();
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
