//! The reference rasterizer: written to be verified by reading, not to be fast. No tiles, no blocks, no increments, no
//! 64-bit tricks.
//!
//! A triangle covers a pixel centre that lies strictly inside, or on a top or left edge. A polygon covers what its
//! fan covers with the sign of the whole. Depth is the plane of the largest vertex triple with coefficients rounded
//! to 24 fraction bits, evaluated without wrapping.

use super::clip::{Polygon, Snapped, UNITS, doubled_area};
use super::plane::coefficients;

/// The depth code of the fragment that `polygon` has at pixel (x, y), if any.
#[must_use]
pub fn fragment(polygon: &Polygon, x: u32, y: u32) -> Option<u32> {
    let center = [x, y].map(|v| i128::from(v) * i128::from(UNITS) + i128::from(UNITS / 2));
    let sum: i64 =
        polygon.fan().map(|t| i64::from(covers(t, center)) * doubled_area(t).signum()).sum();
    let triple = largest_triple(polygon)?;
    (sum * polygon.doubled_area().signum() > 0).then(|| depth(polygon, triple, x, y))
}

/// Whether a triangle covers a point in grid units; one of zero area covers nothing.
fn covers(triangle: [Snapped; 3], [px, py]: [i128; 2]) -> bool {
    let [a, b, c] =
        if doubled_area(triangle) < 0 { [triangle[0], triangle[2], triangle[1]] } else { triangle };
    let inside = |from: Snapped, to: Snapped| {
        let (dx, dy) =
            (i128::from(to.x) - i128::from(from.x), i128::from(to.y) - i128::from(from.y));
        let side = dx * (py - i128::from(from.y)) - dy * (px - i128::from(from.x));
        let (top, left) = (dy == 0 && dx > 0, dy < 0);
        side > 0 || (side == 0 && (top || left))
    };
    doubled_area(triangle) != 0 && inside(a, b) && inside(b, c) && inside(c, a)
}

fn largest_triple(polygon: &Polygon) -> Option<[Snapped; 3]> {
    let v = polygon.vertices();
    let n = v.len();
    let triples =
        (0..n).flat_map(|i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| [i, j, k])));
    let mut best: Option<[Snapped; 3]> = None;
    for triple in triples.map(|t| t.map(|i| v[i])) {
        if doubled_area(triple).abs() > best.map_or(0, |b| doubled_area(b).abs()) {
            best = Some(triple);
        }
    }
    best
}

fn depth(polygon: &Polygon, [v0, v1, v2]: [Snapped; 3], x: u32, y: u32) -> u32 {
    let [a, b, c] = coefficients(v0, v1, v2);
    let z = (a * i128::from(x) + b * i128::from(y) + c + (1 << 23)) >> 24;
    let depths = polygon.vertices().iter().map(|v| i128::from(v.z));
    let (min, max) = (depths.clone().min().unwrap_or(0), depths.max().unwrap_or(0));
    z.clamp(min, max) as u32
}
