//! Multi depth test with 64-bit atomics (Liu, Huang, Liu, Wu 2010; KB-MDT as it would be with them): k entries, each
//! lowered by an atomic minimum on the whole record; what an entry gives up goes on to the next one.
//!
//! Every minimum keeps the multiset of what entries hold and invocations carry, so nothing is lost or doubled whatever
//! the interleaving, and in the end the entries are the k smallest in order.

use crate::scheme::contract::Keeps;
use std::marker::PhantomData;

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Snapshot, Words};
use crate::num::depth::FARTHEST;
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether an entry is lowered by one atomic operation.
    const ATOMIC: bool = true;
    /// What an empty entry holds: farther than any record.
    const EMPTY: u64 = u64::MAX;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// An entry is lowered by a load and a store.
#[derive(Debug)]
pub enum LoadStore {}

/// M18: an empty entry is a record on the far plane.
#[derive(Debug)]
pub enum ClearedToFarPlane {}

/// The method.
#[derive(Debug)]
pub struct KbMdt64<V = Correct> {
    k: u32,
    entries: Words<Pixel, Atomic, u64>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "k-buffer by 64-bit atomic minima",
    paper: "Liu, Huang, Liu, Wu 2010",
    section: "k+-buffer paper, 2 (KB-MDT, single pass)",
    words: "2k",
    published_words: Some("2k"),
    needs: "64-bit atomic minimum, relaxed",
    wgsl: Some("storage buffers; 64-bit atomicMin (not in the standard)"),
    source: include_str!("kb_mdt64.rs"),
    ..Contract::new("kb-mdt64", Keeps::Nearest)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for LoadStore {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-mdt64@load-store",
        "Fault load-store: an entry is lowered by a load and a store",
        "no two invocations of a pixel overlap",
    );
    const ATOMIC: bool = false;
}

impl Variant for ClearedToFarPlane {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-mdt64@M18",
        "Fault M18: entries are cleared to the far plane, which rejects what lies on it",
        "no fragment lies on the far plane",
    );
    const EMPTY: u64 = key(FARTHEST, 0);
}

impl<V: Variant> Scheme for KbMdt64<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self { k, entries: layout.named("entries").pixel(u64::from(k)), variant: PhantomData }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.k {
            mem.store(self.entries.at(pixel, i), V::EMPTY, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let mut carried = fragment.key();
        for i in 0..self.k {
            let entry = self.entries.at(fragment.pixel, i);
            let old = if V::ATOMIC {
                mem.min(entry, carried, Order::Relaxed).await
            } else {
                let old = mem.load(entry, Order::Relaxed).await;
                mem.store(entry, old.min(carried), Order::Relaxed).await;
                old
            };
            carried = carried.max(old);
            if carried == V::EMPTY {
                return Outcome::Kept;
            }
        }
        if carried == fragment.key() { Outcome::Culled } else { Outcome::Evicted }
    }

    /// In the end, entries are sorted front to back.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        if moment == Moment::Always {
            return Ok(());
        }
        let mut last = 0;
        for i in 0..self.k {
            let Some(entry) = words.get(self.entries.at(pixel, i)) else { continue };
            if entry < last {
                return Err(format!("entry {i} is nearer than one in front of it"));
            }
            last = entry;
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..self.k {
            let entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
            if entry == V::EMPTY {
                return;
            }
            keys.push(entry);
        }
    }
}
