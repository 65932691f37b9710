//! Dual depth peeling (Bavoil, Myers, "Order independent transparency with dual depth peeling", 2008): a round finds
//! the nearest and the farthest fragment of those not peeled yet, so that half as many rounds are enough.
//!
//! As in `depth-peel`, and unlike as published, layers are keys of depth and data, and the fragments of a layer are
//! counted in the round after the one that found it. Where both ends meet, the layer in the middle counts as near.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Layout, Memory};
use crate::scheme::contract::Keeps;
use crate::scheme::parts::ends::Ends;
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
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
    title: "Dual depth peeling, two layers a round",
    paper: "Bavoil, Myers 2008",
    words: "10",
    needs: "64-bit atomic min and max, 32-bit atomic add, relaxed; a query whether any pixel goes on",
    wgsl: Some("64-bit atomicMin and atomicMax where there are; atomicAdd"),
    // All operations are there.
    source: include_str!("../parts/ends.rs"),
    ..super::peeled("depth-peel-dual", Keeps::All)
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

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { ends: Ends::new(layout, 1), variant: PhantomData }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.ends.clear(mem, pixel, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        self.ends.peel::<_, Self>(mem, 0, fragment, V::ONCE).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        self.ends.resolve(mem, pixel, 0, keys).await;
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        self.ends.again(mem, pixel, 0).await
    }
}
