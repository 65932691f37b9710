//! The max-array of K+B-Array (k+-buffer paper, section 3.2): the farthest record is at entry 0, the others anywhere.
//! The order of writes is that of the correct form (see `kplus_array`, which has it in its own body).

use super::lock::reach::Reach;
use super::slots::{Slots, entry, put};
use crate::fragment::{depth_of, key, pair_key};
use crate::memory::{Memory, Order};

/// Add a record to an array of `count`.
#[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
pub async fn append<M: Memory, S: Slots, Caller>(mem: &M, slots: S, count: u32, new: u64) {
    let mut last = new;
    if count > 0 {
        let farthest = pair_key(entry(mem, slots, 0).await);
        if last > farthest {
            put(mem, slots, 0, last).await;
            last = farthest;
        }
    }
    put(mem, slots, count, last).await;
}

/// Put a record in the place of the farthest of `count`: the new farthest is found before anything is written.
#[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
pub async fn replace<M: Memory, S: Slots, Caller>(mem: &M, slots: S, count: u32, new: u64) {
    let (mut place, mut farthest) = (0, new);
    for i in 1..count {
        // The data word decides only among equal depths, and is read only then.
        let depth = S::Reach::load(mem, slots.depth(i), Order::Relaxed).await;
        if depth >= depth_of(farthest) {
            let data = S::Reach::read(mem, slots.data(i)).await;
            if key(depth, data) > farthest {
                (place, farthest) = (i, key(depth, data));
            }
        }
    }
    if place != 0 {
        put(mem, slots, place, new).await;
    }
    put(mem, slots, 0, farthest).await;
}
