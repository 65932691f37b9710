//! A method with an operation that no litmus pixel reaches: a check that does not report it would claim too much.

use fragloom::fragment::{Fragment, key};
use fragloom::memory::{Atomic, Layout, Memory, Order, Pixel, Words};
use fragloom::num::depth::EMPTY;
use fragloom::scheme::contract::{Keeps, Overflow};
use fragloom::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// Keeps the smallest key, in one 64-bit word.
pub(crate) struct Unreached {
    nearest: Words<Pixel, Atomic, u64>,
}

impl Scheme for Unreached {
    const CONTRACT: Contract = Contract {
        title: "Z-buffer in one word, with an operation too many",
        words: "2",
        ties: "canonical",
        overflow: Overflow::Drops("the farther one is dropped"),
        needs: "64-bit atomic minimum",
        max_k: 1,
        ..Contract::new("unreached", Keeps::One)
    };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { nearest: layout.pixel(1) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.nearest.at(pixel, 0), u64::MAX, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let nearest = self.nearest.at(fragment.pixel, 0);
        if fragment.depth == 12_345 {
            mem.exchange(nearest, key(0, 0), Order::Relaxed).await;
        }
        let before = mem.min(nearest, fragment.key(), Order::Relaxed).await;
        match before > fragment.key() {
            true if before == u64::MAX => Outcome::Kept,
            true => Outcome::Evicted,
            false => Outcome::Culled,
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let nearest = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        if nearest >> 32 != u64::from(EMPTY) {
            keys.push(nearest);
        }
    }
}
