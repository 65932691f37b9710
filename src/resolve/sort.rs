//! Sorting a pixel's keys into canonical order, front to back. Equal keys are identical fragments, so any correct sort
//! gives the same list.

/// Up to this length insertion sort is faster.
const INSERTION: usize = 20;

/// Up to this length the k+-buffer paper uses insertion sort, and shell sort above (section 3.2, Algorithm 3).
const PUBLISHED_INSERTION: usize = 16;

/// The gaps of shell sort (Ciura 2001); above, each is 2.25 times the one before.
const GAPS: [usize; 8] = [1, 4, 10, 23, 57, 132, 301, 701];

/// Which sort.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Sort {
    /// The fastest that we have: insertion sort up to 20, then the standard library's (`benches/sort.rs`).
    #[default]
    Fastest,
    /// As published: insertion sort up to 16, then shell sort.
    Published,
}

impl Sort {
    /// Sort ascending.
    #[inline]
    pub fn run(self, keys: &mut [u64]) {
        match self {
            Self::Fastest => canonical(keys),
            Self::Published if keys.len() <= PUBLISHED_INSERTION => insertion(keys),
            Self::Published => shell(keys),
        }
    }
}

fn shell(keys: &mut [u64]) {
    let mut gaps = GAPS.to_vec();
    while let Some(&last) = gaps.last()
        && last < keys.len()
    {
        gaps.push(last * 9 / 4);
    }
    for &gap in gaps.iter().rev() {
        for i in gap..keys.len() {
            let key = keys[i];
            let mut place = i;
            while place >= gap && keys[place - gap] > key {
                keys[place] = keys[place - gap];
                place -= gap;
            }
            keys[place] = key;
        }
    }
}

/// Sort ascending.
#[inline]
pub fn canonical(keys: &mut [u64]) {
    if keys.len() <= INSERTION { insertion(keys) } else { keys.sort_unstable() }
}

fn insertion(keys: &mut [u64]) {
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
            }
        }
    }
}
