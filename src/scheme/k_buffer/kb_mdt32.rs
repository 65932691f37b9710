//! Multi depth test with 32-bit atomics (Liu, Huang, Liu, Wu 2010; in OpenGL: Maule, Comba, Torchelsen, Bastos 2013;
//! KB-MDT): two geometry passes.
//!
//! The first lowers k depth words by atomic minima, each passing on what it gives up; the second lets every fragment
//! look for its depth among them, and write its data there. Two things follow, and both are its published faults:
//! * A depth must fit an atomic integer, so depths are converted (24 bits here, as a depth buffer has them): fragments
//!   closer than that become one depth.
//! * The second pass knows a fragment by its depth alone. Of several with the same depth, each writes into every entry
//!   that matches; the last one stands for all.

use std::marker::PhantomData;

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};
use crate::num::depth::{EMPTY, Format};
use crate::scheme::contract::{Accounting, Dependence, Form, Keeps};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// The published form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;

    /// A fragment's depth in the first pass.
    #[must_use]
    fn first_depth(fragment: Fragment) -> u32 {
        fragment.depth
    }
}

/// As published.
#[derive(Debug)]
pub enum Published {}

/// M16: the first pass has another formula for depth, which rounds the last bit otherwise.
#[derive(Debug)]
pub enum TwoFormulas {}

/// The method.
#[derive(Debug)]
pub struct KbMdt32<V = Published> {
    k: u32,
    depth: Words<Pixel, Atomic, u32>,
    data: Words<Pixel, Atomic, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "k-buffer by 32-bit atomic minima, data in a second pass",
    paper: "Liu, Huang, Liu, Wu 2010; Maule, Comba, Torchelsen, Bastos 2013",
    section: "k+-buffer paper, 2 (KB-MDT)",
    form: Form::Published,
    program: Program::of(&[
        Pass::new("depths", PassKind::Prepare, Barrier::Pixel),
        Pass::store(Barrier::Pixel),
    ]),
    words: "2k",
    published_words: Some("2k"),
    exact_when: "no two fragments of a pixel have the same 24-bit depth",
    ties: "one of equal depth stands for all: whichever writes last",
    needs: "32-bit atomic minimum, relaxed",
    wgsl: Some("storage buffers; atomicMin"),
    depth_format: Some(Format::D24),
    source: include_str!("kb_mdt32.rs"),
    accounting: Accounting::Judged,
    dependence: Dependence::Ties,
    ..Contract::new("kb-mdt32", Keeps::Nearest)
};

impl Variant for Published {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for TwoFormulas {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-mdt32@M16",
        "Fault M16: depth computed by two formulas in two passes",
        "both formulas agree",
    );

    fn first_depth(fragment: Fragment) -> u32 {
        fragment.depth | 1
    }
}

impl<V: Variant> Scheme for KbMdt32<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.k {
            mem.store(self.depth.at(pixel, i), EMPTY, Order::Relaxed).await;
        }
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let mut carried = V::first_depth(fragment);
        for i in 0..self.k {
            let old = mem.min(self.depth.at(fragment.pixel, i), carried, Order::Relaxed).await;
            carried = carried.max(old);
            if carried == EMPTY {
                return;
            }
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let mut outcome = Outcome::Culled;
        for i in 0..self.k {
            let depth = mem.load(self.depth.at(fragment.pixel, i), Order::Relaxed).await;
            if depth > fragment.depth {
                break;
            }
            if depth == fragment.depth {
                mem.store(self.data.at(fragment.pixel, i), fragment.data, Order::Relaxed).await;
                outcome = Outcome::Kept;
            }
        }
        outcome
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..self.k {
            let depth = mem.load(self.depth.at(pixel, i), Order::Relaxed).await;
            if depth == EMPTY {
                return;
            }
            keys.push(key(depth, mem.load(self.data.at(pixel, i), Order::Relaxed).await));
        }
    }
}
