//! Dual depth peeling (Bavoil, Myers, "Order independent transparency with dual depth peeling", 2008): a round finds the
//! nearest and the farthest fragment of those not peeled yet, so that half the rounds do.
//!
//! As in `depth-peel`, and unlike as published, layers are keys of depth and data, and the fragments of a layer are
//! counted in the round after the one that found it. Where both ends meet, the layer in the middle counts as near.

use std::iter::repeat_n;
use std::marker::PhantomData;

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Barrier, Pass, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

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
            from: layout.pixel(runs),
            to: layout.pixel(runs),
            nearest: layout.pixel(runs),
            farthest: layout.pixel(runs),
            near_count: layout.pixel(runs),
            far_count: layout.pixel(runs),
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
    pub async fn peel<M: Memory>(&self, mem: &M, run: u32, fragment: Fragment, once: bool) {
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

/// The correct form, or a fault in it.
pub trait Variant: Sync {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether the layer in the middle counts once.
    const ONCE: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// The layer in the middle is emitted as the nearest and as the farthest.
#[derive(Debug)]
pub enum MiddleTwice {}

/// The method.
#[derive(Debug)]
pub struct DualPeel<V = Correct> {
    ends: Ends,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    name: "depth-peel-dual",
    title: "Dual depth peeling, two layers a round",
    paper: "Bavoil, Myers 2008",
    section: "k+-buffer paper, 2",
    program: Program::repeated(&[Pass::store(Barrier::Pixel)]),
    words: "10",
    judged: true,
    needs: "64-bit atomic min and max, 32-bit atomic add, relaxed; a query whether any pixel goes on",
    wgsl: Some("64-bit atomicMin and atomicMax where there are; atomicAdd"),
    source: include_str!("depth_peel_dual.rs"),
    ..Contract::BASE_ALL
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for MiddleTwice {
    const CONTRACT: Contract = CONTRACT.fault(
        "depth-peel-dual@middle-twice",
        "Fault middle-twice: where both ends meet, the layer is emitted twice",
        "the number of layers is even",
    );
    const ONCE: bool = false;
}

impl<V: Variant> Scheme for DualPeel<V> {
    const CONTRACT: Contract = V::CONTRACT;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { ends: Ends::new(layout, 1), variant: PhantomData }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.ends.clear(mem, pixel, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        self.ends.peel(mem, 0, fragment, V::ONCE).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        self.ends.resolve(mem, pixel, 0, keys).await;
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        self.ends.again(mem, pixel, 0).await
    }
}
