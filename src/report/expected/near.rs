//! Pixels near to an edge, and pixels whose fragments are near to each other.

use crate::num::depth::Format;
use crate::raster::FrontEnd;
use crate::raster::clip::{Snapped, UNITS};
use crate::resolve::Lists;

/// The pixels whose centre is at most `distance` pixels from an edge of a drawn triangle, as rows.
pub(super) fn edges(front: &FrontEnd, size: [u32; 2], distance: f64) -> Vec<[u32; 3]> {
    let mut near = vec![false; size[0] as usize * size[1] as usize];
    near_edges(front, size, distance, |_, pixel| near[pixel] = true);
    rows(&near, size[0])
}

/// Call `mark` with a primitive's index and a pixel, row by row, for every pixel whose centre is at most `distance`
/// pixels from an edge of that primitive: once for every such edge. `front` must have been made with
/// [`FrontEnd::outlined`].
pub fn near_edges(
    front: &FrontEnd,
    size: [u32; 2],
    distance: f64,
    mut mark: impl FnMut(u32, usize),
) {
    let units = (distance * f64::from(UNITS)) as i64;
    for primitive in front.indices() {
        let corners = front.outline(primitive).map_or(&[][..], |polygon| polygon.vertices());
        for (i, &from) in corners.iter().enumerate() {
            let edge = Edge::new(from, corners[(i + 1) % corners.len()]);
            edge.mark(units, size, |pixel| mark(primitive, pixel));
        }
    }
}

/// Pixels with two fragments, one after the other, whose depths are at most `distance` apart and whose data differ.
pub(super) fn ties(lists: &Lists, format: Format, distance: f64) -> Vec<[u32; 3]> {
    let depth = |key: u64| format.decode((key >> 32) as u32);
    let tied = |pair: &[u64]| {
        depth(pair[1]) - depth(pair[0]) <= distance && pair[0] as u32 != pair[1] as u32
    };
    let near: Vec<bool> = lists
        .offsets
        .windows(2)
        .map(|ends| lists.entries[ends[0] as usize..ends[1] as usize].windows(2).any(tied))
        .collect();
    rows(&near, lists.width)
}

/// Marked pixels as rows: y, the first x, and one past the last.
fn rows(marked: &[bool], width: u32) -> Vec<[u32; 3]> {
    let mut rows = Vec::new();
    for (y, row) in (0..).zip(marked.chunks(width as usize)) {
        let mut x = 0;
        for run in row.chunk_by(|a, b| a == b) {
            let past = x + run.len() as u32;
            if run[0] {
                rows.push([y, x, past]);
            }
            x = past;
        }
    }
    rows
}

/// An edge in units of the grid, from its upper end to its lower one.
struct Edge {
    from: [i64; 2],
    along: [i64; 2],
}

impl Edge {
    fn new(a: Snapped, b: Snapped) -> Self {
        let [a, b] = [a, b].map(|v| [i64::from(v.x), i64::from(v.y)]);
        let [from, to] = if a[1] <= b[1] { [a, b] } else { [b, a] };
        Self { from, along: [to[0] - from[0], to[1] - from[1]] }
    }

    /// Call `mark` for the pixels whose centre is at most `units` away.
    fn mark(&self, units: i64, [width, height]: [u32; 2], mut mark: impl FnMut(usize)) {
        let unit = i64::from(UNITS);
        // The first centre at or behind a coordinate, within an image's edge.
        let first =
            |v: i64, most: u32| (v - unit / 2 + unit - 1).div_euclid(unit).clamp(0, most.into());
        let past = |v: i64, most: u32| first(v + 1, most);
        let [(top, bottom), (x, dx)] =
            [(self.from[1], self.from[1] + self.along[1]), (self.from[0], self.along[0])];
        for row in first(top - units, height)..past(bottom + units, height) {
            let center = row * unit + unit / 2;
            // Where the edge is while it passes this row, and a little around.
            let at = |y: i64| match self.along[1] {
                0 => None,
                dy => Some(x + (dx * (y.clamp(top, bottom) - top)).div_euclid(dy)),
            };
            let ends = match (at(center - units), at(center + units)) {
                (Some(a), Some(b)) => [a.min(b), a.max(b)],
                _ => [x.min(x + dx), x.max(x + dx)],
            };
            for column in first(ends[0] - units - 1, width)..past(ends[1] + units + 1, width) {
                if self.is_near([column * unit + unit / 2, center], units) {
                    mark(row as usize * width as usize + column as usize);
                }
            }
        }
    }

    /// Whether a point is at most `units` away.
    fn is_near(&self, point: [i64; 2], units: i64) -> bool {
        let wide = |v: i64| i128::from(v);
        let [px, py] = [wide(point[0] - self.from[0]), wide(point[1] - self.from[1])];
        let [dx, dy] = self.along.map(wide);
        let (dot, square) = (px * dx + py * dy, dx * dx + dy * dy);
        let most = wide(units * units);
        if dot <= 0 {
            return px * px + py * py <= most;
        }
        if dot >= square {
            let [qx, qy] = [px - dx, py - dy];
            return qx * qx + qy * qy <= most;
        }
        let cross = px * dy - py * dx;
        cross * cross <= most * square
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::Random;

    /// The marked pixels are those that a look at every pixel finds.
    #[test]
    fn marks_are_those_of_a_full_search() {
        let mut random = Random::new(7, 1);
        let size = [24u32, 17];
        let mut found = 0;
        for _ in 0..3_000 {
            let mut place = || random.below(12_000) as i32 - 3_000;
            let [a, b] = [(place(), place()), (place(), place())].map(|(x, y)| Snapped {
                x,
                y: y / if x % 3 == 0 { 64 } else { 1 },
                z: 0,
            });
            let edge = Edge::new(a, b);
            for units in [0, 16, 100] {
                let mut near = vec![false; 24 * 17];
                edge.mark(units, size, |pixel| near[pixel] = true);
                for (i, &near) in near.iter().enumerate() {
                    let center = [i as i64 % 24, i as i64 / 24].map(|c| c * 256 + 128);
                    assert_eq!(near, edge.is_near(center, units), "{a:?} {b:?} {units} {center:?}");
                    found += usize::from(near);
                }
            }
        }
        assert!(found > 10_000, "{found}");
    }

    #[test]
    fn distances_are_to_the_edge_and_not_to_its_line() {
        let corner = |x, y| Snapped { x, y, z: 0 };
        let edge = Edge::new(corner(256, 256), corner(1_024, 256));
        for (point, units, near) in [
            ([600, 256], 0, true),
            ([600, 272], 16, true),
            ([600, 273], 16, false),
            ([240, 256], 16, true),
            ([239, 256], 16, false),
            ([1_040, 256], 16, true),
            ([1_036, 268], 16, false),
        ] {
            assert_eq!(edge.is_near(point, units), near, "{point:?}");
        }
    }

    #[test]
    fn ties_are_near_depths_of_two_colours() {
        let key = |depth: u32, data: u32| u64::from(depth) << 32 | u64::from(data);
        let step = (f64::from(u32::MAX) / 4_194_304.0) as u32;
        let pixels = [
            vec![key(5, 1), key(5, 2)],
            vec![key(5, 1), key(5, 1)],
            vec![key(0, 1), key(step, 2)],
            vec![key(0, 1), key(step + 2, 2)],
            vec![],
            vec![key(1, 1), key(1 << 30, 9), key((1 << 30) + 7, 8)],
        ];
        let mut lists = Lists { width: 3, height: 2, offsets: vec![0], entries: Vec::new() };
        for pixel in pixels {
            lists.entries.extend(pixel);
            lists.offsets.push(lists.entries.len() as u64);
        }
        let expected = vec![[0, 0, 1], [0, 2, 3], [1, 2, 3]];
        assert_eq!(ties(&lists, Format::D32, super::super::DEPTH_DISTANCE), expected);
        assert_eq!(rows(&[true, true, false, true], 2), [[0, 0, 2], [1, 1, 2]]);
    }
}
