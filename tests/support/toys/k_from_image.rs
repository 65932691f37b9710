//! A method with an input: the nearest k fragments of each pixel, where an image says k. Records are kept in order by
//! atomic minima, as `kb-mdt64` does.

use fragloom::fragment::Fragment;
use fragloom::memory::{Atomic, Declared, Input, Layout, Memory, Order, Per, Pixel, Update, Words};
use fragloom::scheme::contract::Form;
use fragloom::scheme::{Config, Contract, Keeps, Keys, Outcome, Scheme};

/// The largest k of an image.
const MOST: u32 = 8;

/// An entry that holds nothing.
const EMPTY: u64 = u64::MAX;

/// The method; without `ATOMIC`, an entry is lowered by a load and a store.
pub(crate) struct KFromImage<const ATOMIC: bool> {
    entries: Words<Pixel, Atomic, u64>,
    k: Input,
}

impl<const ATOMIC: bool> Scheme for KFromImage<ATOMIC> {
    const CONTRACT: Contract = Contract {
        words: "16",
        source: include_str!("k_from_image.rs"),
        form: if ATOMIC { Form::Correct } else { Form::Mutation },
        ..Contract::new(
            if ATOMIC { "k-from-image" } else { "k-from-image@load-store" },
            Keeps::NearestBy("k"),
        )
    };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        let k = Declared { name: "k", per: Per::Pixel, default: 2, tried: &[0, 1, 3] };
        Self { entries: layout.pixel(MOST.into()), k: layout.input(k) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..MOST {
            mem.store(self.entries.at(pixel, i), EMPTY, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let mut carried = fragment.key();
        for i in 0..mem.input(self.k.at(fragment.pixel)).min(MOST) {
            let entry = self.entries.at(fragment.pixel, i);
            let old = if ATOMIC {
                mem.update(entry, Update::Min(carried), Order::Relaxed).await
            } else {
                let old = mem.load(entry, Order::Relaxed).await;
                mem.store(entry, old.min(carried), Order::Relaxed).await;
                old
            };
            carried = carried.max(old);
            if carried == EMPTY {
                return Outcome::Kept;
            }
        }
        if carried == fragment.key() { Outcome::Culled } else { Outcome::Evicted }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..MOST {
            let entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
            if entry == EMPTY {
                return;
            }
            keys.push(entry);
        }
    }
}
