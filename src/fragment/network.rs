//! Sorting short lists of keys without branches: by networks (Batcher, "Sorting networks and their applications", AFIPS
//! 1968, the odd-even merge sort), and a merge of two such lists. What is missing to the size of a network counts as
//! farther than any fragment.

/// Up to this length.
pub(super) const MOST: usize = 32;

/// Behind every fragment: no depth word has all bits set.
const BEHIND: u64 = u64::MAX;

macro_rules! network {
    ($(#[$doc:meta])* $name:ident, $n:literal: $($i:literal $j:literal),* $(,)?) => {
        $(#[$doc])*
        #[inline]
        fn $name(v: &mut [u64; $n]) {
            $(
                let (a, b) = (v[$i], v[$j]);
                // No `if`: of that, the compiler may make a branch.
                (v[$i], v[$j]) = (a.min(b), a.max(b));
            )*
        }
    };
}

network! {
    /// 5 exchanges.
    of_4, 4:
        0 1, 2 3, 0 2, 1 3, 1 2,
}

network! {
    /// 19 exchanges.
    of_8, 8:
        0 1, 2 3, 4 5, 6 7, 0 2, 1 3, 4 6, 5 7, 1 2, 5 6, 0 4, 1 5, 2 6, 3 7, 2 4, 3 5, 1 2, 3 4,
        5 6,
}

network! {
    /// 63 exchanges.
    of_16, 16:
        0 1, 2 3, 4 5, 6 7, 8 9, 10 11, 12 13, 14 15, 0 2, 1 3, 4 6, 5 7, 8 10, 9 11, 12 14,
        13 15, 1 2, 5 6, 9 10, 13 14, 0 4, 1 5, 2 6, 3 7, 8 12, 9 13, 10 14, 11 15, 2 4, 3 5,
        10 12, 11 13, 1 2, 3 4, 5 6, 9 10, 11 12, 13 14, 0 8, 1 9, 2 10, 3 11, 4 12, 5 13, 6 14,
        7 15, 4 8, 5 9, 6 10, 7 11, 2 4, 3 5, 6 8, 7 9, 10 12, 11 13, 1 2, 3 4, 5 6, 7 8, 9 10,
        11 12, 13 14,
}

/// Sort at most [`MOST`] keys ascending; longer lists stay as they are.
#[inline]
pub(super) fn sort(keys: &mut [u64]) {
    match keys.len() {
        0 | 1 => {}
        2..=4 => padded(keys, of_4),
        5..=8 => padded(keys, of_8),
        9..=16 => padded(keys, of_16),
        17..=MOST => halves(keys),
        _ => {}
    }
}

#[inline]
fn padded<const N: usize>(keys: &mut [u64], network: impl Fn(&mut [u64; N])) {
    if let Ok(all) = <&mut [u64; N]>::try_from(&mut *keys) {
        return network(all);
    }
    let mut all = std::array::from_fn(|i| keys.get(i).copied().unwrap_or(BEHIND));
    network(&mut all);
    for (i, &key) in all.iter().enumerate() {
        if let Some(place) = keys.get_mut(i) {
            *place = key;
        }
    }
}

/// The first 16 and the rest, each by a network, then merged.
fn halves(keys: &mut [u64]) {
    let mut parts = [[BEHIND; 17]; 2];
    for (part, keys) in parts.iter_mut().zip(keys.chunks(16)) {
        let mut all = [BEHIND; 16];
        all[..keys.len()].copy_from_slice(keys);
        of_16(&mut all);
        part[..16].copy_from_slice(&all);
    }
    let [mut i, mut j] = [0; 2];
    for key in keys {
        // Neither goes beyond its end, behind which lies nothing nearer; the remainder only spares the check.
        let (a, b) = (parts[0][i % 17], parts[1][j % 17]);
        *key = a.min(b);
        i += usize::from(a <= b);
        j += usize::from(a > b);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A network that sorts all lists of zeroes and ones sorts all lists (Knuth, "The Art of Computer Programming",
    /// volume 3, 5.3.4, theorem Z).
    fn sorts_zeroes_and_ones<const N: usize>(network: impl Fn(&mut [u64; N])) -> bool {
        (0..1_u64 << N).all(|bits| {
            let mut list: [u64; N] = std::array::from_fn(|i| bits >> i & 1);
            network(&mut list);
            list.is_sorted()
        })
    }

    #[test]
    fn every_network_sorts() {
        assert!(sorts_zeroes_and_ones(of_4));
        assert!(sorts_zeroes_and_ones(of_8));
        assert!(sorts_zeroes_and_ones(of_16));
    }

    network! {
        /// One exchange is missing.
        incomplete, 4: 0 1, 2 3, 0 2, 1 3
    }

    #[test]
    fn a_network_that_does_not_sort_is_seen() {
        assert!(!sorts_zeroes_and_ones(incomplete));
    }

    proptest! {
        #[test]
        fn as_the_standard_library(mut keys in prop::collection::vec(0u64..40, 0..=MOST)) {
            let mut sorted = keys.clone();
            sorted.sort_unstable();
            sort(&mut keys);
            prop_assert_eq!(keys, sorted);
        }
    }
}
