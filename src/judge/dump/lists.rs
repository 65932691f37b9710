//! One pixel's list against the exact one.

use crate::judge::class::Class;

/// A fragment: depth word and data word.
pub(super) type Pair = (u32, u32);

/// Whether a dumped fragment may be an exact one.
type Fits<'a> = &'a dyn Fn(Pair, Pair) -> bool;

/// What is the same.
pub(super) struct Same<'a> {
    /// Whether two depth words are nearly the same depth.
    pub(super) is_near: &'a dyn Fn(u32, u32) -> bool,
    /// Whether two data words are the same but for rounding.
    pub(super) is_alike: &'a dyn Fn(u32, u32) -> bool,
    /// Whether an edge is so near that a triangle with this fragment may be there or not.
    pub(super) is_edge: &'a dyn Fn(Pair) -> bool,
}

/// What became of a fragment, of the exact list or of the dumped one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fate {
    pub(super) class: Class,
    /// Its place in the exact list, or if it is not one of that, in the dumped list.
    pub(super) index: u32,
    /// It is one of the exact list.
    pub(super) is_exact: bool,
    /// With another depth: by how many codes.
    pub(super) codes: u64,
}

/// How a dumped list, in its order, differs from the exact one: what became of each fragment, of the dumped list and of
/// those that are not in it.
pub(super) fn compare(exact: &[Pair], dumped: &[Pair], same: &Same<'_>) -> Vec<Fate> {
    let mut fates: Vec<Option<Fate>> = vec![None; dumped.len()];
    let mut taken = vec![false; exact.len()];
    // By dumped fragment: which exact one it is.
    let mut is: Vec<Option<usize>> = vec![None; dumped.len()];
    let rounds: [(Class, Fits<'_>); 5] = [
        (Class::Equal, &|a, b| a == b),
        (Class::Rounding, &|a, b| (same.is_near)(a.0, b.0) && (same.is_alike)(a.1, b.1)),
        (Class::Depth, &|a, b| a.1 == b.1),
        (Class::Depth, &|a, b| (same.is_alike)(a.1, b.1)),
        (Class::Data, &|a, b| (same.is_near)(a.0, b.0)),
    ];
    for (class, fits) in rounds {
        for (place, &fragment) in
            dumped.iter().enumerate().filter(|&(i, _)| fates[i].is_none()).collect::<Vec<_>>()
        {
            // A copy of what is there already is no fragment with another depth.
            let copy = class == Class::Depth
                && exact.iter().enumerate().any(|(i, &e)| taken[i] && e == fragment);
            let free = (0..exact.len()).filter(|&i| !copy && !taken[i] && fits(exact[i], fragment));
            let Some(index) = free.min_by_key(|&i| exact[i].0.abs_diff(fragment.0)) else {
                continue;
            };
            taken[index] = true;
            is[place] = Some(index);
            let codes = u64::from(exact[index].0.abs_diff(fragment.0));
            fates[place] = Some(Fate { class, index: index as u32, is_exact: true, codes });
        }
    }
    let mut found: Vec<Fate> = Vec::with_capacity(dumped.len());
    for (place, (fate, &fragment)) in fates.into_iter().zip(dumped).enumerate() {
        found.push(fate.unwrap_or_else(|| {
            let twice = (0..exact.len()).find(|&i| {
                taken[i]
                    && (same.is_near)(exact[i].0, fragment.0)
                    && (same.is_alike)(exact[i].1, fragment.1)
            });
            match twice {
                Some(index) => {
                    Fate { class: Class::Duplicated, index: index as u32, is_exact: true, codes: 0 }
                }
                None => {
                    let edge = (same.is_edge)(fragment);
                    let class = if edge { Class::Edge } else { Class::Extra };
                    Fate { class, index: place as u32, is_exact: false, codes: 0 }
                }
            }
        }));
    }
    disorder(exact, &is, same, &mut found);
    for (index, &fragment) in exact.iter().enumerate().filter(|&(i, _)| !taken[i]) {
        let class = if (same.is_edge)(fragment) { Class::Edge } else { Class::Missing };
        found.push(Fate { class, index: index as u32, is_exact: true, codes: 0 });
    }
    found
}

/// Fragments that come after one that should be behind them.
fn disorder(exact: &[Pair], is: &[Option<usize>], same: &Same<'_>, found: &mut [Fate]) {
    let mut farthest: Option<usize> = None;
    for (place, own) in is.iter().enumerate() {
        let Some(own) = *own else { continue };
        match farthest {
            Some(before) if own < before => {
                if found[place].class.is_right() {
                    let near = (same.is_near)(exact[own].0, exact[before].0);
                    found[place].class = if near { Class::Tie } else { Class::Order };
                }
            }
            _ => farthest = Some(own),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn classes(exact: &[Pair], dumped: &[Pair]) -> Vec<Class> {
        let same = Same {
            is_near: &|a, b| a.abs_diff(b) <= 2,
            is_alike: &|a, b| a == b,
            is_edge: &|(_, data)| data == 99,
        };
        compare(exact, dumped, &same).into_iter().map(|fate| fate.class).collect()
    }

    #[test]
    fn every_difference_is_named() {
        use Class::{Data, Depth, Duplicated, Edge, Equal, Extra, Missing, Order, Rounding, Tie};
        let exact = [(10, 1), (20, 2), (21, 3), (40, 4)];
        for (dumped, expected) in [
            (&exact[..], &[Equal; 4][..]),
            (&[(10, 1), (20, 2), (40, 4)], &[Equal, Equal, Equal, Missing]),
            (&[(10, 1), (20, 2), (21, 3), (30, 7), (40, 4)], &[Equal, Equal, Equal, Extra, Equal]),
            (
                &[(10, 1), (10, 1), (20, 2), (21, 3), (40, 4)],
                &[Equal, Duplicated, Equal, Equal, Equal],
            ),
            (&[(11, 1), (20, 2), (21, 3), (40, 4)], &[Rounding, Equal, Equal, Equal]),
            (&[(10, 1), (20, 2), (21, 3), (49, 4)], &[Equal, Equal, Equal, Depth]),
            (&[(10, 1), (20, 2), (21, 3), (40, 9)], &[Equal, Equal, Equal, Data]),
            (&[(10, 1), (21, 3), (20, 2), (40, 4)], &[Equal, Equal, Tie, Equal]),
            (&[(40, 4), (10, 1), (20, 2), (21, 3)], &[Equal, Order, Order, Order]),
            (&[(10, 1), (20, 2), (21, 3), (30, 99), (40, 4)], &[Equal, Equal, Equal, Edge, Equal]),
            (&[], &[Missing; 4]),
        ] {
            assert_eq!(classes(&exact, dumped), expected, "{dumped:?}");
        }
        assert_eq!(classes(&[(5, 99)], &[]), [Edge]);
        assert_eq!(classes(&[(5, 1), (5, 1)], &[(5, 1)]), [Equal, Missing], "equal ones all count");
    }
}
