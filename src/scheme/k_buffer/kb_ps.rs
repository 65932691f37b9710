//! k-buffer with pixel synchronisation (Salvi, "Advances in real-time rendering: pixel synchronization", 2013; KB-PS):
//! Bavoil's k-buffer inside an ordered interlock, so that its read-modify-write is one step.
//!
//! Entries are sorted front to back; an insertion shifts what is farther and lets the last one fall out. WGSL has no
//! interlock.

use crate::scheme::contract::{Extra, Keeps};
use std::marker::PhantomData;

use crate::fragment::{Fragment, data_of, depth_of, key};
use crate::memory::{Layout, Memory, Pixel, Plain, Words};
use crate::num::depth::EMPTY;
use crate::scheme::parts::interlock::Interlock;
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether a fragment stays inside until its entries are written.
    const STAYS: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// The interlock is left before the entries are written back.
#[derive(Debug)]
pub enum LeavesEarly {}

/// The method.
#[derive(Debug)]
pub struct KbPixelSync<V = Correct> {
    k: u32,
    interlock: Interlock,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
    variant: PhantomData<V>,
}

/// Registers for entries.
const MAX_K: usize = 64;

const CONTRACT: Contract = Contract {
    title: "k-buffer in an ordered interlock",
    paper: "Salvi 2013",
    section: "k+-buffer paper, 2 and 3.1 (KB-PS)",
    words: "2k",
    published_words: Some("2k"),
    needs: "the ordered interlock; invocations of a pixel are started in order",
    max_k: MAX_K as u32,
    source: include_str!("kb_ps.rs"),
    extra: Extra::Rank,
    ..Contract::new("kb-ps", Keeps::Nearest)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for LeavesEarly {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-ps@leaves-early",
        "Fault leaves-early: the interlock is left before the entries are written",
        "no two invocations of a pixel overlap",
    );
    const STAYS: bool = false;
}

impl<V: Variant> Scheme for KbPixelSync<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            interlock: Interlock::new(layout),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.interlock.clear(mem, pixel).await;
        for i in 0..self.k {
            mem.plain_store(self.depth.at(pixel, i), EMPTY).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let _turns = mem.block();
        let mark = mem.mark();
        loop {
            let turn = mem.block();
            if self.interlock.turn(mem, fragment).await == fragment.extra {
                if !V::STAYS {
                    self.interlock.leave(mem, fragment).await;
                }
                let mut carried = fragment.key();
                for i in 0..self.k {
                    let depth = mem.plain_load(self.depth.at(pixel, i)).await;
                    let entry = key(depth, mem.plain_load(self.data.at(pixel, i)).await);
                    // An empty entry's data word may be anything.
                    if depth == EMPTY || carried < entry {
                        mem.plain_store(self.depth.at(pixel, i), depth_of(carried)).await;
                        mem.plain_store(self.data.at(pixel, i), data_of(carried)).await;
                        carried = entry;
                    }
                    if depth == EMPTY {
                        break;
                    }
                }
                if V::STAYS {
                    self.interlock.leave(mem, fragment).await;
                }
                return if depth_of(carried) == EMPTY {
                    Outcome::Kept
                } else if carried == fragment.key() {
                    Outcome::Culled
                } else {
                    Outcome::Evicted
                };
            }
            mem.merge(turn).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..self.k {
            let depth = mem.plain_load(self.depth.at(pixel, i)).await;
            if depth == EMPTY {
                return;
            }
            keys.push(key(depth, mem.plain_load(self.data.at(pixel, i)).await));
        }
    }
}
