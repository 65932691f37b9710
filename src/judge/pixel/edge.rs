//! Where edges pass, and what a pixel would look like if they passed on the other side of its centre.

use crate::judge::answer::{Answer, Entry};
use crate::report::expected::near_edges;

/// Up to so many primitives with edges near to a pixel, every combination of them is tried; of more, single ones, pairs,
/// and all.
const COMBINED: usize = 6;

/// Which primitives have an edge near to which pixels.
pub(in crate::judge) struct Near {
    /// Pixel and primitive, sorted.
    found: Vec<(u32, u32)>,
}

impl Near {
    /// Of the pixels that `of` names, up to `distance` pixels from an edge.
    pub(in crate::judge) fn new(
        answer: &Answer<'_>,
        distance: f64,
        of: impl Fn(usize) -> bool,
    ) -> Self {
        let mut found = Vec::new();
        near_edges(&answer.front, answer.scene.size, distance, |primitive, pixel| {
            if of(pixel) {
                found.push((pixel as u32, primitive));
            }
        });
        found.sort_unstable();
        found.dedup();
        Self { found }
    }

    /// The primitives near to a pixel.
    pub(in crate::judge) fn of(&self, pixel: usize) -> impl Iterator<Item = u32> + '_ {
        let start = self.found.partition_point(|&(p, _)| (p as usize) < pixel);
        self.found[start..].iter().take_while(move |(p, _)| *p as usize == pixel).map(|(_, i)| *i)
    }
}

/// The fragments that some primitives have at a pixel, or would have if they covered it.
pub(in crate::judge) fn fragments(
    answer: &Answer<'_>,
    pixel: usize,
    primitives: impl Iterator<Item = u32>,
) -> Vec<Entry> {
    let width = answer.scene.size[0] as usize;
    let [x, y] = [(pixel % width) as u32, (pixel / width) as u32];
    let format = answer.options.record().depth;
    let one = |index: u32| {
        let primitive = answer.front.primitive(index);
        let depth = format.encode(primitive.plane.code(primitive.plane.at(x, y)));
        let color = answer.front.surface(index).at(x, y);
        Entry { depth, color, triangle: primitive.triangle }
    };
    primitives.map(one).collect()
}

/// Call `look` with every list in which some of `edges` are there and not in `list`, or the other way round, until it
/// returns true. The first is `list` as it is.
pub(super) fn toggled(
    list: &[Entry],
    edges: &[Entry],
    mut look: impl FnMut(&[Entry]) -> bool,
) -> bool {
    let mut made = Vec::new();
    let mut with = |is_toggled: &dyn Fn(usize) -> bool| {
        made.clear();
        made.extend_from_slice(list);
        for (_, edge) in edges.iter().enumerate().filter(|(i, _)| is_toggled(*i)) {
            match made.iter().position(|entry| entry.triangle == edge.triangle) {
                Some(place) => {
                    made.remove(place);
                }
                None => {
                    let place = made.partition_point(|entry| entry < edge);
                    made.insert(place, *edge);
                }
            }
        }
        look(&made)
    };
    let n = edges.len();
    if n <= COMBINED {
        return (0..1_u32 << n).any(|set| with(&|i| set >> i & 1 == 1));
    }
    with(&|_| false)
        || (0..n).any(|one| with(&|i| i == one))
        || (0..n).any(|one| (one + 1..n).any(|other| with(&|i| i == one || i == other)))
        || with(&|_| true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_is_looked_at_once() {
        let entry = |depth| Entry { depth, color: 0, triangle: depth };
        let list = [entry(1), entry(3), entry(5)];
        let edges = [entry(2), entry(3)];
        let mut seen = Vec::new();
        let stopped = toggled(&list, &edges, |list| {
            seen.push(list.iter().map(|entry| entry.depth).collect::<Vec<_>>());
            false
        });
        assert!(!stopped);
        assert_eq!(seen, [vec![1, 3, 5], vec![1, 2, 3, 5], vec![1, 5], vec![1, 2, 5]]);
        let many: Vec<Entry> = (10..19).map(entry).collect();
        let mut count = 0;
        toggled(&list, &many, |_| {
            count += 1;
            false
        });
        assert_eq!(count, 1 + 9 + 36 + 1);
        assert!(toggled(&list, &many, |list| list.len() == 12));
    }
}
