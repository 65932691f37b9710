//! Pools, and indices that are taken ahead from them.
//!
//! Every invocation of a frame adds 1 to a pool's counter, so threads wait for each other at that one word. A worker
//! that knows how many fragments it will store takes as many indices by one addition, and hands them out itself, as
//! shader compilers do for a warp.
//!
//! That is sound: an addition of m is m additions of 1 in a row, the counter is relaxed and orders nothing, and an index
//! is nothing but a name. An invocation gets one that no other has, as it does from the counter. So it is the plain
//! program that the explorer checks. What is left over when a fragment needs no index is not handed out any more. No
//! index is beyond a pool because of that: a pool with room for every fragment has room for one index each, taken or
//! left over. A pool that is too small has not, so nothing is taken ahead from it.

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
    next: Cell<u32>,
    left: Cell<u32>,
}

impl Ahead {
    pub(super) fn none(pool: Pool) -> Self {
        Self { pool, next: Cell::new(0), left: Cell::new(0) }
    }

    /// The pool that they are of.
    #[must_use]
    pub fn pool(&self) -> Pool {
        self.pool
    }

    /// Hand out these from now on, instead of those that are left.
    #[inline]
    pub fn set(&self, first: u32, count: u32) {
        self.next.set(first);
        self.left.set(count);
    }

    /// The first of so many, if there are so many left.
    #[inline(always)]
    pub(in crate::memory) fn first(&self, count: u32) -> Option<u32> {
        (self.left.get() >= count).then(|| self.next.get())
    }

    /// Leave so many out, of those that are left.
    #[inline(always)]
    pub(in crate::memory) fn skip(&self, count: u32) {
        self.left.set(self.left.get() - count);
        self.next.set(self.next.get().wrapping_add(count));
    }

    /// The next one, if there is one.
    #[inline(always)]
    pub(in crate::memory) fn next(&self) -> Option<u32> {
        self.left.set(self.left.get().checked_sub(1)?);
        Some(self.next.replace(self.next.get().wrapping_add(1)))
    }
}
