//! Depth peeling (Everitt, "Interactive order-independent transparency", 2001): front to back, one layer a round. A
//! round finds the nearest fragment behind the layer peeled last.
//!
//! What the correct form does differently from the published one (kept as `depth-peel@published`): layers are keys of
//! depth and data, so that equal depths are layers of their own, and the round after the one that found a layer counts
//! how many fragments it has, so that identical ones all survive. Peeling ends after k fragments, and so is the k
//! nearest for any k.
//!
//! The published form keeps one fragment of every depth; which one is left open there, and is the smallest here.

use std::iter::repeat_n;
use std::marker::PhantomData;

use crate::fragment::{Fragment, depth_of, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Form, Keeps, Overflow};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// No layer: the key of no fragment. Where peeling goes on from here, it has ended.
const NONE: u64 = key(EMPTY, u32::MAX);

/// The correct form, another, or a fault.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether the fragments of a layer are counted, and emitted in the round after.
    const COUNTED: bool = true;
    /// Whether only what lies strictly behind the last layer is peeled.
    const STRICT: bool = true;
    /// The first key that is peeled.
    const FIRST: u64 = 0;

    /// Where peeling goes on behind a layer.
    #[must_use]
    fn behind(layer: u64) -> u64 {
        layer + 1
    }
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// Depths alone are compared.
#[derive(Debug)]
pub enum Published {}

/// What equals the last layer is peeled again: a test with `<=` for `<`.
#[derive(Debug)]
pub enum NotStrict {}

/// The first round peels as if there were a layer at depth 0 already.
#[derive(Debug)]
pub enum BehindNearPlane {}

/// The method.
#[derive(Debug)]
pub struct DepthPeel<V = Correct> {
    k: u32,
    /// The smallest key that is not peeled yet; behind the first round, the last layer's plus 1.
    from: Words<Pixel, Plain, u64>,
    /// Fragments still to be emitted.
    left: Words<Pixel, Plain, u32>,
    /// The layer that this round finds.
    nearest: Words<Pixel, Atomic, u64>,
    /// Fragments of the last layer.
    count: Words<Pixel, Atomic, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "Depth peeling, one layer a round",
    paper: "Everitt 2001",
    words: "6",
    overflow: Overflow::Never("what lies behind the k nearest is not peeled"),
    needs: "64-bit atomic min, 32-bit atomic add, relaxed; a query whether any pixel goes on",
    wgsl: Some("64-bit atomicMin where there is one; atomicAdd"),
    source: include_str!("depth_peel.rs"),
    ..super::peeled("depth-peel", Keeps::Nearest)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Published {
    const CONTRACT: Contract = Contract {
        name: "depth-peel@published",
        title: "Depth peeling by depth alone: of equal depths, one layer",
        form: Form::Published,
        published_words: Some("2"),
        keeps: Keeps::Layers,
        exact_when: "no two fragments of a pixel have the same depth",
        ties: "the one with the smaller data word stays, the others are lost",
        ..CONTRACT
    };
    const COUNTED: bool = false;

    fn behind(layer: u64) -> u64 {
        key(depth_of(layer) + 1, 0)
    }
}

impl Variant for NotStrict {
    const CONTRACT: Contract = CONTRACT.fault(
        "depth-peel@not-strict",
        "Fault not-strict: the last layer is peeled again, and takes the place of all behind it",
        "no pixel has more than one layer",
    );
    const STRICT: bool = false;
}

impl Variant for BehindNearPlane {
    const CONTRACT: Contract = CONTRACT.fault(
        "depth-peel@near-plane",
        "Fault near-plane: the first layer must lie strictly behind depth 0",
        "nothing lies on the near plane",
    );
    const FIRST: u64 = key(1, 0);
}

impl<V: Variant> Scheme for DepthPeel<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            k: config.k.unwrap_or(8),
            from: layout.named("from").pixel(1),
            left: layout.named("left").pixel(1),
            nearest: layout.named("nearest").pixel(1),
            count: layout.named("count").pixel(1),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.plain_store(self.from.at(pixel, 0), V::FIRST).await;
        mem.plain_store(self.left.at(pixel, 0), self.k).await;
        mem.store(self.nearest.at(pixel, 0), NONE, Order::Relaxed).await;
        mem.store(self.count.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let from = mem.plain_load(self.from.at(fragment.pixel, 0)).await;
        let of_last = fragment.key() + 1 == from;
        if V::COUNTED && of_last {
            mem.add(self.count.at(fragment.pixel, 0), 1, Order::Relaxed).await;
        }
        let peeled = fragment.key() >= from || (of_last && !V::STRICT);
        if peeled {
            mem.min(self.nearest.at(fragment.pixel, 0), fragment.key(), Order::Relaxed).await;
        }
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        let left = mem.plain_load(self.left.at(pixel, 0)).await;
        let nearest = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        let count = mem.load(self.count.at(pixel, 0), Order::Relaxed).await;
        let (layer, times) = if V::COUNTED {
            (from.wrapping_sub(1), count.min(left))
        } else {
            (nearest, u32::from(nearest != NONE))
        };
        keys.extend(repeat_n(layer, times as usize));
        let ends = times == left || nearest == NONE;
        let behind = if ends { NONE } else { V::behind(nearest) };
        mem.plain_store(self.from.at(pixel, 0), behind).await;
        mem.plain_store(self.left.at(pixel, 0), left - times).await;
        mem.store(self.nearest.at(pixel, 0), NONE, Order::Relaxed).await;
        mem.store(self.count.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        mem.plain_load(self.from.at(pixel, 0)).await != NONE
    }
}
