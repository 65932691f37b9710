//! k+-buffer with exact memory (Vasilakis, Fudos 2014, section 3.3, Algorithm 3; K+B-SB): a bounded count, a prefix
//! sum, and per pixel a max-array or a max-heap in a contiguous range of min(f, k) records.
//!
//! A pixel with more than k fragments has a heap if k > 16, and an array otherwise, as published.
//!
//! What differs from Algorithm 3 (`kplus-sb@published`), and why:
//! * The published count tests the counter and then adds: several invocations pass the test together, and the counter
//!   overshoots k (claim C6). And a count bounded at k cannot tell f = k from f > k, on which the choice depends. Here
//!   a compare-exchange counts to min(f, k + 1), and min(f, k) records are allocated. The published form is clamped
//!   where it allocates, so that its records stay within the array.
//! * Insertion is that of the correct forms ([`locked_row`]).
//!
//! The range's start carries the choice in its lowest bit ([`Ranges`]), so that a pixel has three words besides its
//! records: counter, semaphore, start.

use std::marker::PhantomData;

use crate::fragment::{Fragment, pair_key};
use crate::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Plain, Snapshot, Words};
use crate::scheme::contract::{Form, Keeps};
use crate::scheme::parts::lock::reach::{Reach, Updated, updated};
use crate::scheme::parts::lock::{self, SpinLock};
use crate::scheme::parts::locked_row::{self, Row};
use crate::scheme::parts::ranges::{self, Ranges};
use crate::scheme::parts::slots::{OfFrame, settled};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// Up to this k, an array is faster than a heap (section 3.2).
pub const ARRAY_UP_TO: u32 = 16;

/// The correct form, or another.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How the lock's holder reaches a pixel's records.
    type Reach: Reach;
    /// Whether the count is bounded by compare-exchange, and goes up to k + 1.
    const EXACT_COUNT: bool = true;
    /// Up to which k an array is used.
    const ARRAY_UP_TO: u32 = ARRAY_UP_TO;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// The count of Algorithm 3.
#[derive(Debug)]
pub enum Published {}

/// A heap whatever k, so that small instances reach it.
#[derive(Debug)]
pub enum Heap {}

/// The method.
#[derive(Debug)]
pub struct KPlusSb<V: Variant = Correct> {
    k: u32,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    ranges: Ranges,
    depth: Words<Global, Atomic, u32>,
    data: Words<Global, <V::Reach as Reach>::Kind, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "k+-buffer in exact contiguous ranges, array or heap per pixel",
    section: "3.3, Algorithm 3 (K+B-SB)",
    paper: "Vasilakis, Fudos 2014",
    words: "3",
    wgsl: lock::WGSL,
    needs: "acquire and release on a 32-bit word; forward progress of the lock's holder; two geometry passes that \
            generate the same fragments",
    ..ranges::counted("kplus-sb", Keeps::Nearest)
};

/// What the form needs whose accesses are updates.
const MENDED_NEEDS: &str = "32-bit atomic updates, relaxed; no load buffering; forward progress of the lock's holder; \
                            two geometry passes that generate the same fragments";

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
    type Reach = Plain;
}

impl Variant for Published {
    const CONTRACT: Contract = Contract {
        name: "kplus-sb@published",
        title: "k+-buffer in contiguous ranges, counted as in Algorithm 3",
        form: Form::Published,
        ..CONTRACT
    };
    const EXACT_COUNT: bool = false;
    type Reach = Plain;
}

impl Variant for Heap {
    const CONTRACT: Contract = Contract {
        name: "kplus-sb@heap",
        title: "k+-buffer in exact contiguous ranges, a heap in every full pixel",
        ..CONTRACT
    };
    const ARRAY_UP_TO: u32 = 0;
    type Reach = Plain;
}

impl Variant for Atomic {
    const CONTRACT: Contract = CONTRACT
        .mended("kplus-sb@atomic", "k+-buffer in exact contiguous ranges, all records atomic");
    type Reach = Self;
}

impl Variant for Updated {
    const CONTRACT: Contract = Contract {
        needs: MENDED_NEEDS,
        ..updated(
            CONTRACT,
            "kplus-sb@rmw",
            "k+-buffer in exact contiguous ranges, all accesses updates",
        )
    };
    type Reach = Self;
}

impl<V: Variant> Scheme for KPlusSb<V> {
    const CONTRACT: Contract = Contract { source: include_str!("kplus_sb.rs"), ..V::CONTRACT };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            k: config.k.unwrap_or(8),
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            ranges: Ranges::new(config, layout),
            depth: layout.named("depth").global(config.bounded),
            data: layout.named("data").global(config.bounded),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.ranges.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    /// The count pass.
    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let counter = self.counter.at(fragment.pixel, 0);
        if V::EXACT_COUNT {
            let _attempts = mem.block();
            let mark = mem.mark();
            loop {
                let attempt = mem.block();
                let count = mem.load(counter, Order::Relaxed).await;
                if count > self.k {
                    return;
                }
                let found = mem.compare_exchange(counter, count, count + 1, Order::Relaxed).await;
                if found == count {
                    return;
                }
                mem.merge(attempt).await;
                mem.spin(mark).await;
            }
        } else {
            let test = mem.block();
            if mem.load(counter, Order::Relaxed).await < self.k {
                mem.add(counter, 1, Order::Relaxed).await;
            }
            mem.merge(test).await;
        }
    }

    /// The referencing pass.
    async fn screen<M: Memory>(&self, mem: &M, _: usize, pixel: u32) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        if count > 0 {
            let crowded = if V::EXACT_COUNT { count > self.k } else { count >= self.k };
            self.ranges.refer(mem, pixel, count.min(self.k), crowded).await;
            mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
        }
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.ranges.invocations(pass)
    }

    async fn frame<M: Memory>(&self, mem: &M, pass: usize, index: u32) {
        self.ranges.sum(mem, pass, index).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (slots, crowded) = mem.part(self.slots::<_, Self>(mem, fragment.pixel)).await;
        let heap = crowded && self.k > V::ARRAY_UP_TO;
        let counter = self.counter.at(fragment.pixel, 0);
        let row = Row { slots, k: self.k, heap, lock: self.lock, counter };
        let gone = mem.part(locked_row::insert::<_, _, Self>(mem, row, fragment)).await;
        locked_row::outcome(fragment, gone)
    }

    /// A count that allocates more than min(f, k) records is not exact memory.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, _: Moment) -> Result<(), String> {
        let most = if V::EXACT_COUNT { self.k + 1 } else { self.k };
        match words.get(self.counter.at(pixel, 0)) {
            Some(count) if count > most => {
                Err(format!("the count is bounded by {most}, and overshoots to {count}"))
            }
            _ => Ok(()),
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        if count > 0 {
            let (slots, _) = mem.part(self.slots::<_, ()>(mem, pixel)).await;
            for i in 0..count {
                keys.push(pair_key(settled(mem, slots, i).await));
            }
        }
    }
}

impl<V: Variant> KPlusSb<V> {
    /// A pixel's records, and whether it has more than k fragments.
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    async fn slots<M: Memory, Caller>(&self, mem: &M, pixel: u32) -> (OfFrame<V::Reach>, bool) {
        let (first, crowded) = self.ranges.start::<_, (Self, Caller)>(mem, pixel).await;
        (OfFrame { depth: self.depth, data: self.data, first }, crowded)
    }
}
