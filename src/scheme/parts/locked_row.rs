//! A bounded row of records behind a pixel's spin lock, for methods that give each pixel a row of its own length
//! (k+-buffer paper, section 3): a max-array, or a max-heap, whose entry 0 is the farthest.
//!
//! The steps are those of the correct forms (`kplus_array`, `kplus_heap`): a cull test before the lock, the counter
//! raised only when its record is in place.

use super::lock::reach::Reach;
use super::lock::{FREE, SpinLock};
use super::slots::{Slots, entry};
use super::{max_array, max_heap};
use crate::fragment::{Fragment, pair_key};
use crate::memory::{At, Atomic, Memory, Order, Pixel};
use crate::scheme::Outcome;

/// A pixel's row.
#[derive(Clone, Copy, Debug)]
pub struct Row<S> {
    /// Its records.
    pub slots: S,
    /// How many there are, at least 1.
    pub k: u32,
    /// Whether they form a heap; otherwise an array.
    pub heap: bool,
    /// Guards them.
    pub lock: SpinLock,
    /// How many hold a fragment.
    pub counter: At<Pixel, Atomic, u32>,
}

/// Store a fragment in its pixel's row. Gives the key that has no room then, if there is one: the fragment's own, where k
/// nearer ones are there, or that of the record which it has displaced.
#[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
pub async fn insert<M: Memory, S: Slots, Caller>(
    mem: &M,
    row: Row<S>,
    fragment: Fragment,
) -> Option<u64> {
    let Row { slots, k, heap, lock, counter } = row;
    let new = fragment.key();
    let test = mem.block();
    if mem.load(counter, S::Reach::ACQUIRE).await == k
        && fragment.depth > S::Reach::load(mem, slots.depth(0), Order::Relaxed).await
    {
        return Some(new);
    }
    mem.merge(test).await;
    let _attempts = mem.block();
    let mark = mem.mark();
    loop {
        let attempt = mem.block();
        if lock.try_acquire(mem, fragment.pixel, S::Reach::ACQUIRE).await == FREE {
            let count = S::Reach::load(mem, counter, Order::Relaxed).await;
            let mut gone = None;
            if count < k {
                if heap {
                    max_heap::append::<_, _, Caller>(mem, slots, count, new).await;
                } else {
                    max_array::append::<_, _, Caller>(mem, slots, count, new).await;
                }
                S::Reach::store(mem, counter, count + 1, Order::Release).await;
            } else {
                let farthest = pair_key(entry(mem, slots, 0).await);
                gone = Some(new.max(farthest));
                if new < farthest && heap {
                    max_heap::replace::<_, _, Caller>(mem, slots, k, new).await;
                } else if new < farthest {
                    max_array::replace::<_, _, Caller>(mem, slots, k, new).await;
                }
            }
            S::Reach::release(mem, lock, fragment.pixel).await;
            return gone;
        }
        mem.merge(attempt).await;
        mem.spin(mark).await;
    }
}

/// What became of a fragment, by what [`insert`] gave for it.
#[inline]
#[must_use]
pub fn outcome(fragment: Fragment, gone: Option<u64>) -> Outcome {
    match gone {
        None => Outcome::Kept,
        Some(key) if key == fragment.key() => Outcome::Culled,
        Some(_) => Outcome::Evicted,
    }
}
