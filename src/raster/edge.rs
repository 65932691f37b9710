//! Edge functions: exact coverage of pixel centres with the top-left rule.
//!
//! For a clockwise triangle (on a screen with y down) the edge a -> b has
//! E(p) = (b.x - a.x)(p.y - a.y) - (b.y - a.y)(p.x - a.x), in square grid units, above 0 on the inner side. A centre
//! on the edge (E = 0) is inside only for a top edge (horizontal, pointing right) or a left edge (pointing up): all
//! others subtract 1, so that "inside" is "E >= 0" throughout. Pixel centres are 256 units apart, so E's steps are
//! multiples of 256 and its low 8 bits never change sign: E >> 8 is kept, which makes a step the plain difference of
//! two snapped coordinates (|step| <= 2^24) and a whole 8x8 block fit in i32 once trivial cases are out.

use super::clip::{Snapped, UNITS, doubled_area};
use crate::fragment::BLOCK;

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
}

/// The covered pixels of the 8x8 block whose first pixel is (x, y): bit `8 * dy + dx`.
#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
#[must_use]
pub fn block_mask(edges: &[Edge; 3], x: u32, y: u32) -> u64 {
    let far = (BLOCK - 1) as i32;
    let mut corners = [0i32; 3];
    let mut cut = false;
    for (corner, edge) in corners.iter_mut().zip(edges) {
        let first = edge.at(x, y);
        let (step_x, step_y) = (far * edge.a, far * edge.b);
        if first + i64::from(step_x.max(0)) + i64::from(step_y.max(0)) < 0 {
            return 0;
        }
        if first + i64::from(step_x.min(0)) + i64::from(step_y.min(0)) < 0 {
            *corner = first as i32; // within ±7 * 2^25, or one of the tests above would have held
            cut = true;
        } else {
            *corner = i32::MAX; // wholly inside: no longer takes part
        }
    }
    if cut { partial_mask(edges, corners) } else { u64::MAX }
}

/// The mask of a block that at least one edge cuts; `i32::MAX` marks an edge that does not.
#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
fn partial_mask(edges: &[Edge; 3], corners: [i32; 3]) -> u64 {
    // An edge that does not cut the block is 0 everywhere, which is inside.
    let steps: [[i32; 3]; 3] = std::array::from_fn(|i| match corners[i] {
        i32::MAX => [0; 3],
        corner => [corner, edges[i].a, edges[i].b],
    });
    let first =
        steps.map(|[corner, a, _]| -> [i32; 8] { std::array::from_fn(|x| corner + a * x as i32) });
    // The sign of what lies outside of one of them.
    let mut values = [0i32; 64];
    for (y, row) in (0..).zip(values.chunks_exact_mut(8)) {
        let [p, q, r] = steps.map(|[.., b]| b * y);
        for (x, value) in row.iter_mut().enumerate() {
            *value = (first[0][x] + p) | (first[1][x] + q) | (first[2][x] + r);
        }
    }
    signs(&values)
}

/// The bits of the values that are not negative.
#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
fn signs(values: &[i32; 64]) -> u64 {
    let bytes: [u8; 64] = std::array::from_fn(|i| (values[i] >> 31) as u8 & 1);
    let mut outside = 0;
    for (y, row) in (0..).zip(bytes.as_chunks().0) {
        // Eight bytes of 0 or 1 become eight bits side by side.
        let bits = u64::from_le_bytes(*row).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        outside |= bits << (8 * y);
    }
    !outside
}
