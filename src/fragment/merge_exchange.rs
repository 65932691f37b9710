//! Sorting the lists of eight pixels side by side: an exchange compares the entries of one place with those of another,
//! of all eight lists at once, in lanes. Which places are exchanged, and when, depends on the longest list alone: the
//! merge exchange of Batcher (Knuth, "The Art of Computer Programming", volume 3, 5.2.2, algorithm M), which is for
//! lists of any length. What a list is shorter than the longest counts as farther than any fragment; so lists of one
//! length, or nearly, go together.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::{network, places};
use crate::num::lanes::explicit;

/// How many lists.
const LISTS: usize = 8;

/// Lists of up to this length are sorted one by one, which is as fast.
const SHORT: usize = 16;

/// The longest list that is sorted beside others: 8 KiB in all.
const MOST: usize = 128;

/// From a key to a signed number of the same order, and back: not every machine compares unsigned lanes.
const SIGN: u64 = 1 << 63;

/// Behind every fragment: no depth word has all bits set.
const BEHIND: i64 = i64::MAX;

/// Sort lists that lie one after another, each ascending; `ends` says where they end.
pub(super) fn sort(keys: &mut [u64], ends: &[u32]) {
    let mut middling = Vec::new();
    for list in places(ends) {
        match list.len() {
            0 | 1 => {}
            2..=SHORT => network::sort(&mut keys[list]),
            _ if list.len() <= MOST => middling.push(list),
            _ => keys[list].sort_unstable(),
        }
    }
    explicit(Lists { keys, all: by_length(&middling) });
}

/// The same lists, the shortest first.
fn by_length(lists: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut begins = [0; MOST + 2];
    lists.iter().for_each(|list| begins[list.len() + 1] += 1);
    (1..begins.len()).for_each(|length| begins[length] += begins[length - 1]);
    let mut all = vec![0..0; lists.len()];
    for list in lists {
        all[begins[list.len()]] = list.clone();
        begins[list.len()] += 1;
    }
    all
}

/// Lists of at most [`MOST`] keys, by length.
struct Lists<'a> {
    keys: &'a mut [u64],
    all: Vec<Range<usize>>,
}

impl WithSimd for Lists<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { keys, all } = self;
        // Row by row, the entries of one place.
        let mut rows = [BEHIND; LISTS * MOST];
        for lists in all.chunks(LISTS) {
            let most = lists.last().map_or(0, Range::len);
            let rows = &mut rows[..LISTS * most];
            for (lane, places) in lists.iter().enumerate() {
                let (own, rest) = rows.as_chunks_mut::<LISTS>().0.split_at_mut(places.len());
                for (row, key) in own.iter_mut().zip(&keys[places.clone()]) {
                    row[lane] = (key ^ SIGN) as i64;
                }
                rest.iter_mut().for_each(|row| row[lane] = BEHIND);
            }
            exchange_all(simd, S::as_mut_simd_i64s(rows).0, most);
            for (lane, places) in lists.iter().enumerate() {
                let rows = rows.as_chunks::<LISTS>().0;
                for (key, row) in keys[places.clone()].iter_mut().zip(rows) {
                    *key = row[lane] as u64 ^ SIGN;
                }
            }
        }
    }
}

/// Algorithm M, of Knuth's names `p`, `q`, `r` and `d`, on so many rows.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for these vectors")]
#[inline(always)]
fn exchange_all<S: Simd>(simd: S, rows: &mut [S::i64s], count: usize) {
    let top = count.next_power_of_two() / 2;
    let mut p = top;
    while p > 0 {
        let (mut q, mut r, mut d) = (top, 0, p);
        loop {
            // All places i below count - d of which the bits in p are those of r.
            let mut block = r;
            while block < count - d {
                let size = p.min(count - d - block);
                exchange(simd, rows, block, block + d, size);
                block += 2 * p;
            }
            if q == p {
                break;
            }
            (d, q, r) = (q - p, q / 2, p);
        }
        p /= 2;
    }
}

/// The rows from `near` on, with as many from `far` on, which is at least so many behind.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for these vectors")]
#[inline(always)]
fn exchange<S: Simd>(simd: S, rows: &mut [S::i64s], near: usize, far: usize, size: usize) {
    let vectors = LISTS / S::I64_LANES;
    let places = near * vectors..(far + size) * vectors;
    let (front, behind) = rows[places].split_at_mut((far - near) * vectors);
    for (near, far) in front.iter_mut().zip(behind).take(size * vectors) {
        let swapped = simd.less_than_i64s(*far, *near);
        // By exclusive or: of a choice between the two, the compiler makes a masked store, which is slow.
        let both = simd.xor_i64s(*near, *far);
        let change = simd.select_i64s(swapped, both, simd.splat_i64s(0));
        (*near, *far) = (simd.xor_i64s(*near, change), simd.xor_i64s(*far, change));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A network that sorts all lists of zeroes and ones sorts all lists (Knuth, volume 3, 5.3.4, theorem Z).
    #[test]
    fn zeroes_and_ones_are_sorted_at_every_length() {
        for length in 0..=16_usize {
            let lists: Vec<Vec<u64>> = (0..1_u64 << length)
                .map(|bits| (0..length).map(|place| bits >> place & 1).collect())
                .collect();
            let mut keys = lists.concat();
            let all = (0..lists.len()).map(|i| i * length..(i + 1) * length).collect();
            explicit(Lists { keys: &mut keys, all });
            for (sorted, list) in keys.chunks(length.max(1)).zip(&lists) {
                let ones: u64 = list.iter().sum();
                let expected =
                    (0..length as u64).map(|place| u64::from(place + ones >= length as u64));
                assert!(sorted.iter().copied().eq(expected), "{list:?} {sorted:?}");
            }
        }
    }

    /// Lists of many lengths, some of them longer than what is sorted side by side.
    fn lists() -> impl Strategy<Value = Vec<Vec<u64>>> {
        let most = prop_oneof![Just(MOST), Just(MOST + 1)];
        let lengths = prop_oneof![0..4_usize, 12..40_usize, 0..MOST + 9, most];
        let keys = prop_oneof![0..9_u64, any::<u64>(), Just(u64::MAX), Just(SIGN), Just(SIGN - 1)];
        let list = lengths.prop_flat_map(move |n| prop::collection::vec(keys.clone(), n));
        prop::collection::vec(list, 0..30)
    }

    proptest! {
        #[test]
        fn as_the_standard_library(lists in lists()) {
            let mut end = 0;
            let ends: Vec<u32> = lists.iter().map(|list| { end += list.len() as u32; end }).collect();
            let mut keys = lists.concat();
            sort(&mut keys, &ends);
            let sorted = lists.into_iter().flat_map(|mut list| { list.sort_unstable(); list });
            prop_assert_eq!(keys, sorted.collect::<Vec<u64>>());
        }
    }
}
