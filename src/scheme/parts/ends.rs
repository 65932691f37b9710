//! Runs of keys peeled from both ends: what dual depth peeling and peeling by buckets share.

use std::iter::repeat_n;

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::depth::EMPTY;
use crate::scheme::Keys;

/// No layer: the key of no fragment.
const NONE: u64 = key(EMPTY, u32::MAX);

/// Runs of keys that are peeled from both ends, so many for every pixel.
#[derive(Debug)]
pub struct Ends {
    /// The smallest key that is not peeled yet; behind the first round, the last near layer's plus 1.
    from: Words<Pixel, Plain, u64>,
    /// The last far layer: what is nearer is not peeled yet.
    to: Words<Pixel, Plain, u64>,
    /// The layers that this round finds.
    nearest: Words<Pixel, Atomic, u64>,
    farthest: Words<Pixel, Atomic, u64>,
    /// Fragments of the last near layer, and of the last far one.
    near_count: Words<Pixel, Atomic, u32>,
    far_count: Words<Pixel, Atomic, u32>,
}

impl Ends {
    /// Declare `runs` for every pixel.
    #[must_use]
    pub fn new(layout: &mut Layout, runs: u64) -> Self {
        Self {
            from: layout.named("from").pixel(runs),
            to: layout.named("to").pixel(runs),
            nearest: layout.named("nearest").pixel(runs),
            farthest: layout.named("farthest").pixel(runs),
            near_count: layout.named("near_count").pixel(runs),
            far_count: layout.named("far_count").pixel(runs),
        }
    }

    /// Nothing is peeled.
    pub async fn clear<M: Memory>(&self, mem: &M, pixel: u32, run: u32) {
        mem.plain_store(self.from.at(pixel, run), 0).await;
        mem.plain_store(self.to.at(pixel, run), NONE).await;
        self.forget(mem, pixel, run).await;
    }

    /// A fragment's part in a round. If not `once`, a layer that is both the last near and the last far one counts
    /// twice.
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub async fn peel<M: Memory, Caller>(&self, mem: &M, run: u32, fragment: Fragment, once: bool) {
        let (pixel, key) = (fragment.pixel, fragment.key());
        let from = mem.plain_load(self.from.at(pixel, run)).await;
        let to = mem.plain_load(self.to.at(pixel, run)).await;
        let is_near = key + 1 == from;
        if from <= key && key < to {
            mem.min(self.nearest.at(pixel, run), key, Order::Relaxed).await;
            mem.max(self.farthest.at(pixel, run), key, Order::Relaxed).await;
        }
        if is_near {
            mem.add(self.near_count.at(pixel, run), 1, Order::Relaxed).await;
        }
        if key == to && !(is_near && once) {
            mem.add(self.far_count.at(pixel, run), 1, Order::Relaxed).await;
        }
    }

    /// Emit the last layers, and go on to those that the round found.
    pub async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, run: u32, keys: &mut Keys) {
        let from = mem.plain_load(self.from.at(pixel, run)).await;
        let to = mem.plain_load(self.to.at(pixel, run)).await;
        let near_count = mem.load(self.near_count.at(pixel, run), Order::Relaxed).await;
        let far_count = mem.load(self.far_count.at(pixel, run), Order::Relaxed).await;
        keys.extend(repeat_n(from.wrapping_sub(1), near_count as usize));
        keys.extend(repeat_n(to, far_count as usize));
        let nearest = mem.load(self.nearest.at(pixel, run), Order::Relaxed).await;
        let farthest = mem.load(self.farthest.at(pixel, run), Order::Relaxed).await;
        let ends = nearest == NONE;
        let (from, to) = if ends { (NONE, NONE) } else { (nearest + 1, farthest) };
        mem.plain_store(self.from.at(pixel, run), from).await;
        mem.plain_store(self.to.at(pixel, run), to).await;
        self.forget(mem, pixel, run).await;
    }

    /// Whether there is a layer to be counted in the next round.
    pub async fn again<M: Memory>(&self, mem: &M, pixel: u32, run: u32) -> bool {
        mem.plain_load(self.from.at(pixel, run)).await != NONE
    }

    /// No layer is found yet.
    async fn forget<M: Memory>(&self, mem: &M, pixel: u32, run: u32) {
        mem.store(self.nearest.at(pixel, run), NONE, Order::Relaxed).await;
        mem.store(self.farthest.at(pixel, run), 0, Order::Relaxed).await;
        mem.store(self.near_count.at(pixel, run), 0, Order::Relaxed).await;
        mem.store(self.far_count.at(pixel, run), 0, Order::Relaxed).await;
    }
}
