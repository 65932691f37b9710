//! Pools, and indices that are taken ahead from them.
//!
//! Every invocation of a frame adds 1 to a pool's counter, so threads wait for each other at that one word. A worker
//! that knows how many fragments it will store takes as many indices by one addition, and hands them out itself, as
//! shader compilers do for a warp.
//!
//! That is sound: an addition of m is m additions of 1 in a row, the counter is relaxed and orders nothing, and an
//! index is nothing but a name. An invocation gets one that no other has, as it does from the counter, and
//! invocations may come to the counter in any order. So it is the plain program that the explorer checks. What is
//! left over when a fragment needs no index is not handed out any more. No index is beyond a pool because of that: a
//! pool with room for every fragment has room for one index each, taken or left over. A pool that is too small has
//! not, so nothing is taken ahead from it.

use std::cell::Cell;

use super::{At, Atomic, Global, Words};

/// A pool of the frame: a counter whose value is the next free index.
#[derive(Clone, Copy, Debug)]
pub struct Pool {
    pub(super) counter: Words<Global, Atomic, u32>,
    /// Which one of the layout's pools.
    pub(super) number: u32,
}

impl Pool {
    /// The counter.
    #[inline(always)]
    #[must_use]
    pub fn counter(self) -> At<Global, Atomic, u32> {
        self.counter.at(0)
    }

    /// This pool's part of what a worker has.
    #[inline(always)]
    pub(in crate::memory) fn of(self, ahead: &[Ahead]) -> Option<&Ahead> {
        ahead.get(self.number as usize)
    }
}

/// Indices of one pool that a worker hands out itself.
#[derive(Debug)]
pub struct Ahead {
    pool: Pool,
    first: Cell<u32>,
    count: Cell<u32>,
    /// How many of them stand in whole pages, whose indices are turned.
    turned: Cell<u32>,
    taken: Cell<u32>,
}

/// Indices of a page: so many keys of 8 bytes are as far apart as words that share a place in a first-level cache.
const PAGE: u32 = 512;

impl Ahead {
    pub(super) fn none(pool: Pool) -> Self {
        let [first, count, turned, taken] = [0; 4].map(Cell::new);
        Self { pool, first, count, turned, taken }
    }

    /// The pool that they are of.
    #[must_use]
    pub fn pool(&self) -> Pool {
        self.pool
    }

    /// Hand out these from now on, instead of those that are left.
    #[inline]
    pub fn set(&self, first: u32, count: u32) {
        self.first.set(first);
        self.count.set(count);
        self.turned.set(0);
        self.taken.set(0);
    }

    /// Hand out these from now on, in an order that spreads what was stored as many steps apart as a tile has pixels:
    /// the nodes of one list on a scene of layers. In their own order, the caches would have one place for them. It is
    /// for pools that have room for all: if one has not, the order decides which fragments find none.
    pub fn spread(&self, first: u32, count: u32) {
        self.set(first, count);
        self.turned.set(count - count % PAGE);
    }

    /// The next one, if there is one.
    #[inline(always)]
    pub(in crate::memory) fn next(&self) -> Option<u32> {
        let i = self.taken.get();
        if i >= self.count.get() {
            return None;
        }
        self.taken.set(i + 1);
        let place = if i < self.turned.get() { turn(i) } else { i };
        Some(self.first.get().wrapping_add(place))
    }
}

/// Each page begins 16 indices further into itself than the one before it, and 16 more than the one eight before it.
#[inline(always)]
fn turn(i: u32) -> u32 {
    let page = i / PAGE;
    page * PAGE + (i + 16 * (page + page / 8)) % PAGE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(ahead: &Ahead) -> Vec<u32> {
        std::iter::from_fn(|| ahead.next()).collect()
    }

    fn ahead() -> Ahead {
        let mut layout = super::super::Layout::default();
        let _ = layout.pool();
        layout.ahead().pop().expect("a pool")
    }

    /// Each index is handed out once, whatever the range.
    #[test]
    fn spread_indices_are_those_of_the_range() {
        let ahead = ahead();
        for (first, count) in [(0, 0), (7, 1), (100, 511), (0, 512), (3, 513), (9, 70_000)] {
            ahead.spread(first, count);
            let mut all = taken(&ahead);
            all.sort_unstable();
            assert_eq!(all, (first..first + count).collect::<Vec<_>>());
            ahead.set(first, count);
            assert_eq!(taken(&ahead), (first..first + count).collect::<Vec<_>>());
        }
    }

    /// Keys of 8 bytes, 4,096 stores apart, are in different lines of a first-level cache of 4 KiB a way.
    #[test]
    fn what_is_as_far_apart_as_a_tile_has_pixels_shares_no_place() {
        let ahead = ahead();
        ahead.spread(0, 4_096 * 16);
        let all = taken(&ahead);
        for pixel in [0, 1, 1_000, 4_095] {
            let mut lines: Vec<u32> =
                (0..16).map(|layer| all[pixel + layer * 4_096] * 8 % 4_096 / 64).collect();
            lines.sort_unstable();
            lines.dedup();
            assert_eq!(lines.len(), 16, "{lines:?}");
        }
    }
}
