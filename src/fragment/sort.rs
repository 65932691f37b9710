//! Sorting a pixel's keys into canonical order, front to back. Equal keys are identical fragments, so any correct sort
//! gives the same list.

use super::{merge_exchange, network, places};

/// Up to this length insertion sort is faster.
const INSERTION: usize = 20;

/// Up to this length the k+-buffer paper uses insertion sort, and shell sort above (section 3.2, Algorithm 3).
const PUBLISHED_INSERTION: usize = 16;

/// The gaps of shell sort (Ciura 2001); above, each is 2.25 times the one before.
const GAPS: [usize; 8] = [1, 4, 10, 23, 57, 132, 301, 701];

/// Which sort.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Sort {
    /// The fastest that we have (`benches/sort.rs`): for keys, networks up to 32, or, of many lists, eight side by side
    /// from 17 to 128; for other entries, insertion sort up to 20; then the standard library's.
    #[default]
    Fastest,
    /// As published: insertion sort up to 16, then shell sort.
    Published,
}

impl Sort {
    /// Sort keys ascending.
    #[inline]
    pub fn keys(self, keys: &mut [u64]) {
        match self {
            Self::Fastest if keys.len() <= network::MOST => network::sort(keys),
            Self::Fastest => keys.sort_unstable(),
            Self::Published => published(keys, || ()),
        }
    }

    /// Sort lists of keys that lie one after another, each ascending; `ends` says where they end.
    pub fn lists(self, keys: &mut [u64], ends: &[u32]) {
        match self {
            Self::Fastest => merge_exchange::sort(keys, ends),
            Self::Published => places(ends).for_each(|list| published(&mut keys[list], || ())),
        }
    }

    /// Sort ascending.
    #[inline]
    pub fn run<T: Ord + Copy>(self, keys: &mut [T]) {
        match self {
            Self::Fastest => canonical(keys),
            Self::Published => published(keys, || ()),
        }
    }
}

/// Sort ascending as published, and tell of every comparison and every move.
#[inline]
pub fn published<T: Ord + Copy>(list: &mut [T], mut operation: impl FnMut()) {
    if list.len() <= PUBLISHED_INSERTION {
        return insert_by(1, list, &mut operation);
    }
    let mut gaps = GAPS.to_vec();
    while let Some(&last) = gaps.last()
        && last < list.len()
    {
        gaps.push(last * 9 / 4);
    }
    gaps.iter().rev().for_each(|&gap| insert_by(gap, list, &mut operation));
}

/// Insertion sort of the elements that lie a gap apart.
#[inline]
fn insert_by<T: Ord + Copy>(gap: usize, list: &mut [T], operation: &mut impl FnMut()) {
    for i in gap..list.len() {
        let (own, mut place) = (list[i], i);
        while place >= gap {
            operation();
            if list[place - gap] <= own {
                break;
            }
            list[place] = list[place - gap];
            operation();
            place -= gap;
        }
        list[place] = own;
        operation();
    }
}

/// Sort ascending.
#[inline]
pub fn canonical<T: Ord + Copy>(keys: &mut [T]) {
    if keys.len() <= INSERTION { insertion(keys) } else { keys.sort_unstable() }
}

fn insertion<T: Ord + Copy>(keys: &mut [T]) {
    for i in 1..keys.len() {
        let key = keys[i];
        let mut place = i;
        while place > 0 && keys[place - 1] > key {
            keys[place] = keys[place - 1];
            place -= 1;
        }
        keys[place] = key;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::Random;

    #[test]
    fn sorts_like_the_standard_library() {
        let mut random = Random::new(3, 0);
        for len in (0..80).chain([500, 3_000]) {
            let keys: Vec<u64> = (0..len).map(|_| random.below(40)).collect();
            let mut expected = keys.clone();
            expected.sort();
            for sort in [Sort::Fastest, Sort::Published] {
                let mut sorted = keys.clone();
                sort.run(&mut sorted);
                assert_eq!(sorted, expected, "{sort:?}");
                sorted.copy_from_slice(&keys);
                sort.keys(&mut sorted);
                assert_eq!(sorted, expected, "{sort:?}, keys");
                let (first, second) = keys.split_at(keys.len() / 3);
                let mut parts = [first, second].map(<[u64]>::to_vec);
                parts.iter_mut().for_each(|part| part.sort());
                sorted.copy_from_slice(&keys);
                sort.lists(&mut sorted, &[first.len() as u32, keys.len() as u32]);
                assert_eq!(sorted, parts.concat(), "{sort:?}, lists");
            }
        }
    }

    #[test]
    fn operations_of_the_published_sort_are_counted() {
        let count = |list: &mut [u32]| {
            let mut operations = 0;
            published(list, || operations += 1);
            operations
        };
        assert_eq!(count(&mut [1, 2, 3]), 4, "two comparisons, two moves back");
        assert_eq!(count(&mut [2, 1]), 3, "one comparison, two moves");
    }
}
