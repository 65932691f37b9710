//! The Z-buffer: the nearest fragment only, by one 64-bit atomic minimum on (depth, data), which also settles ties in
//! canonical order. Hardware does the same with its depth test.

use std::marker::PhantomData;

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, OwnedBlock, Pixel, Words};
use crate::num::depth::{EMPTY, FARTHEST};
use crate::num::lanes::wide;
use crate::raster::Batch;
use crate::scheme::contract::Keeps;
use crate::scheme::{Config, Contract, Keys, Outcome, Outcomes, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// What the clear pass writes; every fragment that counts is nearer.
    const CLEARED: u64 = key(EMPTY, u32::MAX);
    /// Whether the nearer key is written by one atomic operation.
    const ATOMIC_MIN: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M18: cleared to the far plane, as to depth 1.0 with a strict test: what lies there is not nearer, and is culled.
/// With 0 for the data word, no fragment of that plane has a smaller key.
#[derive(Debug)]
pub enum ClearedToFarPlane {}

/// A load, a comparison and a store: another invocation may have written a nearer key in between.
#[derive(Debug)]
pub enum LoadStore {}

/// A block of fewer fragments is stored one by one, which is as fast.
const FEW: u32 = 12;

/// From an unsigned number to a signed one of the same order.
const SIGN: u64 = 1 << 63;

/// Depth in the upper half of one word per pixel, data in the lower.
#[derive(Debug)]
pub struct ZBuffer<V = Correct> {
    nearest: Words<Pixel, Atomic, u64>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "Nearest fragment only",
    paper: "Catmull 1974",
    section: "k+-buffer paper, 3.4 (k = 1)",
    words: "2",
    exact_when: "always (k = 1)",
    ties: "canonical: the smaller data word stays",
    needs: "64-bit atomic min, relaxed",
    wgsl: Some("the device's depth test, or 64-bit atomicMin where there is one"),
    source: include_str!("z_buffer.rs"),
    ..Contract::new("z-buffer", Keeps::One)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for ClearedToFarPlane {
    const CONTRACT: Contract = Contract {
        dependence: CONTRACT.dependence,
        ..CONTRACT.fault(
            "z-buffer@M18",
            "Fault M18: cleared to depth 1.0, so that the far plane is culled",
            "nothing lies on the far plane, or depths are not stored as 32-bit codes",
        )
    };
    const CLEARED: u64 = key(FARTHEST, 0);
}

impl Variant for LoadStore {
    const CONTRACT: Contract = CONTRACT.fault(
        "z-buffer@load-store",
        "Fault load-store: a load, a comparison and a store instead of an atomic minimum",
        "no two invocations of a pixel overlap",
    );
    const ATOMIC_MIN: bool = false;
}

#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
fn all_bits(all: bool) -> u64 {
    u64::from(all).wrapping_neg()
}

impl<V: Variant> Scheme for ZBuffer<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { nearest: layout.named("nearest").pixel(1), variant: PhantomData }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.nearest.at(pixel, 0), V::CLEARED, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let nearest = self.nearest.at(fragment.pixel, 0);
        let old = if V::ATOMIC_MIN {
            mem.min(nearest, fragment.key(), Order::Relaxed).await
        } else {
            let old = mem.load(nearest, Order::Relaxed).await;
            if fragment.key() < old {
                mem.store(nearest, fragment.key(), Order::Relaxed).await;
            }
            old
        };
        if fragment.key() >= old {
            Outcome::Culled
        } else if old == V::CLEARED {
            Outcome::Kept
        } else {
            Outcome::Evicted
        }
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        let (mask, depths, data) = (batch.mask(), batch.depths(), batch.data());
        if mask.count_ones() < FEW {
            return false;
        }
        let Some(nearest) = block.pixels(self.nearest) else { return false };
        let [nearer, evicted] = wide(
            #[inline(always)]
            || {
                let [mut all, mut evicted] = [0; 2];
                for bit in 0..64 {
                    let old = nearest[bit].get();
                    // What is not there is farther than any fragment.
                    let absent = (mask >> bit & 1).wrapping_sub(1);
                    let own = key(depths[bit], data[bit]) | absent;
                    // Whether it is nearer, in all bits. Vectors compare signed numbers only, and a choice between two
                    // values would become a masked store, which is slow.
                    let nearer = all_bits((own ^ SIGN).cast_signed() < (old ^ SIGN).cast_signed());
                    nearest[bit].set(old ^ (old ^ own) & nearer);
                    all |= nearer & 1 << bit;
                    evicted |= nearer & 1 << bit & all_bits(old != V::CLEARED);
                }
                [all, evicted]
            },
        );
        let culled = mask & !nearer;
        outcomes.assign([(culled, Outcome::Culled), (evicted, Outcome::Evicted)]);
        true
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let nearest = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        if nearest < V::CLEARED {
            keys.push(nearest);
        }
    }
}
