//! The max-heap of K+B-Heap (k+-buffer paper, section 3.2, Algorithm 2): children of i are 2i + 1 and 2i + 2, the
//! farthest record is at the root.
//!
//! Algorithm 2 writes the new record first and then swaps it up or down, so that for a while the root holds a record
//! nearer than the true farthest, and others are culled against it without the lock. Here a *hole* moves instead:
//! records make room for the new one, which is written once, where it belongs. The root then goes from the old farthest
//! to the new one in one write, and no reader ever sees a root nearer than the true farthest.

use super::slots::{Slots, entry, put};
use crate::fragment::pair_key;
use crate::memory::Memory;

/// Add a record to a heap of `count` (up-heap).
#[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
pub async fn append<M: Memory, S: Slots, Caller>(mem: &M, slots: S, count: u32, key: u64) {
    let mut hole = count;
    while hole > 0 {
        let parent = (hole - 1) / 2;
        let above = pair_key(entry(mem, slots, parent).await);
        if above >= key {
            break;
        }
        put(mem, slots, hole, above).await;
        hole = parent;
    }
    put(mem, slots, hole, key).await;
}

/// Put a record in the place of the farthest of `count` (down-heap).
#[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
pub async fn replace<M: Memory, S: Slots, Caller>(mem: &M, slots: S, count: u32, key: u64) {
    let mut hole = 0;
    loop {
        let left = 2 * hole + 1;
        if left >= count {
            break;
        }
        let (mut child, mut largest) = (left, pair_key(entry(mem, slots, left).await));
        if left + 1 < count {
            let right = pair_key(entry(mem, slots, left + 1).await);
            if right > largest {
                (child, largest) = (left + 1, right);
            }
        }
        if key >= largest {
            break;
        }
        put(mem, slots, hole, largest).await;
        hole = child;
    }
    put(mem, slots, hole, key).await;
}

/// How records are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// Whole keys.
    Key,
    /// Depths alone, as published.
    Depth,
}

impl By {
    /// What is compared of a record.
    #[must_use]
    pub fn of(self, key: u64) -> u64 {
        match self {
            Self::Key => key,
            Self::Depth => key >> 32,
        }
    }
}

/// As Algorithm 2 has it: the new record is swapped with its parent.
pub async fn append_by_swaps<M: Memory, S: Slots>(mem: &M, slots: S, count: u32, key: u64, by: By) {
    let mut place = count;
    put(mem, slots, place, key).await;
    while place > 0 {
        let parent = (place - 1) / 2;
        let above = pair_key(entry(mem, slots, parent).await);
        if by.of(key) <= by.of(above) {
            break;
        }
        put(mem, slots, place, above).await;
        put(mem, slots, parent, key).await;
        place = parent;
    }
}

/// As Algorithm 2 has it: the new record replaces the root, and is swapped with its farther child.
pub async fn replace_by_swaps<M: Memory, S: Slots>(
    mem: &M,
    slots: S,
    count: u32,
    key: u64,
    by: By,
) {
    let mut place = 0;
    put(mem, slots, place, key).await;
    loop {
        let left = 2 * place + 1;
        if left >= count {
            break;
        }
        let (mut child, mut largest) = (left, pair_key(entry(mem, slots, left).await));
        if left + 1 < count {
            let right = pair_key(entry(mem, slots, left + 1).await);
            if by.of(right) > by.of(largest) {
                (child, largest) = (left + 1, right);
            }
        }
        if by.of(key) >= by.of(largest) {
            break;
        }
        put(mem, slots, place, largest).await;
        put(mem, slots, child, key).await;
        place = child;
    }
}
