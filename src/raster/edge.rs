//! Edge functions: exact coverage of pixel centres with the top-left rule.
//!
//! For a clockwise triangle (on a screen with y down) the edge a -> b has
//! E(p) = (b.x - a.x)(p.y - a.y) - (b.y - a.y)(p.x - a.x), in square grid units, above 0 on the inner side. A centre
//! on the edge (E = 0) is inside only for a top edge (horizontal, pointing right) or a left edge (pointing up): all
//! others subtract 1, so that "inside" is "E >= 0" throughout. Pixel centres are 256 units apart, so E's steps are
//! multiples of 256 and its low 8 bits never change sign: E >> 8 is kept, which makes a step the plain difference of
//! two snapped coordinates (|step| <= 2^24). Over 8x8 places E then changes by less than 2^28, so that i32 is enough for
//! where it changes its sign.

use pulp::Simd;

use super::clip::{Snapped, UNITS, doubled_area};
use crate::fragment::BLOCK;
use crate::num::lanes::negative;

/// E >> 8 at the centre of pixel (x, y) is `c + a * x + b * y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Edge {
    c: i64,
    a: i32,
    b: i32,
}

/// The three edges of a triangle of non-zero area, turned clockwise first.
#[inline]
#[must_use]
pub fn edges(triangle: [Snapped; 3]) -> [Edge; 3] {
    let [v0, mut v1, mut v2] = triangle;
    if doubled_area(triangle) < 0 {
        std::mem::swap(&mut v1, &mut v2);
    }
    [Edge::new(v0, v1), Edge::new(v1, v2), Edge::new(v2, v0)]
}

impl Edge {
    #[inline]
    fn new(from: Snapped, to: Snapped) -> Self {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let top_left = dy < 0 || (dy == 0 && dx > 0);
        let half = i64::from(UNITS / 2);
        let at_origin = i64::from(dx) * (half - i64::from(from.y))
            - i64::from(dy) * (half - i64::from(from.x))
            - i64::from(!top_left);
        Self { c: at_origin >> UNITS.ilog2(), a: -dy, b: dx }
    }

    #[inline]
    fn at(&self, x: u32, y: u32) -> i64 {
        self.c + i64::from(self.a) * i64::from(x) + i64::from(self.b) * i64::from(y)
    }

    /// From the first pixel of a block to where E is least, and to where it is largest.
    #[inline]
    fn across(&self) -> (i64, i64) {
        let far = (BLOCK - 1) as i32;
        let (x, y) = (far * self.a, far * self.b);
        ((x.min(0) + y.min(0)).into(), (x.max(0) + y.max(0)).into())
    }
}

/// The covered pixels of the 8x8 block whose first pixel is (x, y): bit `8 * dy + dx`.
#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
#[must_use]
pub fn block_mask<S: Simd>(simd: S, edges: &[Edge; 3], x: u32, y: u32) -> u64 {
    let firsts = edges.map(|edge| edge.at(x, y));
    let mut least = [0; 3];
    for ((least, edge), first) in least.iter_mut().zip(edges).zip(firsts) {
        *least = first + edge.across().0;
    }
    if least[0] | least[1] | least[2] >= 0 { u64::MAX } else { inside(simd, edges, firsts) }
}

/// Which of 8x8 blocks may have covered pixels, by the corner that lies farthest inside of each edge: bit
/// `8 * row + column`. The first pixel of the first block is (x, y).
///
/// From block to block E moves by 8 steps, so that E >> 3 moves by one, exactly.
#[allow(clippy::inline_always, reason = "as above")]
#[inline(always)]
#[must_use]
pub fn touched<S: Simd>(simd: S, edges: &[Edge; 3], x: u32, y: u32) -> u64 {
    inside(simd, edges, edges.map(|edge| (edge.at(x, y) + edge.across().1) >> BLOCK.ilog2()))
}

/// Which of 8x8 places lie inside of all edges, if E is `firsts` at the first of them, and they are a step apart: bit
/// `8 * dy + dx`.
#[allow(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn inside<S: Simd>(simd: S, edges: &[Edge; 3], firsts: [i64; 3]) -> u64 {
    // Farther away than all steps together, every place is on the side of the first.
    const FAR: i64 = 1 << 29;
    let row = |i: usize| -> [i32; 8] {
        let first = firsts[i].clamp(-FAR, FAR) as i32;
        std::array::from_fn(|x| first + edges[i].a * x as i32)
    };
    let [mut p, mut q, mut r] = [row(0), row(1), row(2)];
    let mut outside = 0;
    for y in 0..8 {
        // The sign of what lies outside of one of them.
        let values = std::array::from_fn(|x| p[x] | q[x] | r[x]);
        outside |= u64::from(negative(simd, values)) << (8 * y);
        for x in 0..8 {
            (p[x], q[x], r[x]) = (p[x] + edges[0].b, q[x] + edges[1].b, r[x] + edges[2].b);
        }
    }
    !outside
}
