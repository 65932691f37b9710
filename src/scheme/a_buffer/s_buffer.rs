//! S-buffer (Vasilakis, Fudos, "S-buffer: sparsity-aware multi-fragment rendering", 2012; SB): count, sum up, store
//! into exact contiguous ranges.
//!
//! A first geometry pass counts every pixel's fragments; [`ranges`] turns counts into starts; a second one stores, with
//! the pixel's counter, zeroed again, as its index. The array holds as many records as the scene has fragments.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Global, Layout, Memory, Order, OwnedBlock, Pixel, Plain, Words};
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::contract::{Keeps, Overflow};
use crate::scheme::parts::ranges::{self, Ranges};
use crate::scheme::program::{Barrier, Pass, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Outcomes, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether the counting pass adds by one atomic operation.
    const ATOMIC_COUNT: bool = true;
    /// Whether the first record beyond the array is refused.
    const BOUNDED: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// The counting pass adds by a load and a store: ranges come out too small, and overlap.
#[derive(Debug)]
pub enum PlainCount {}

/// M17: nothing stands between the sums and the store pass.
#[derive(Debug)]
pub enum NoBarrier {}

/// M14: the bound test lets one record too many through.
#[derive(Debug)]
pub enum OneTooMany {}

/// The method.
#[derive(Debug)]
pub struct SBuffer<V = Correct> {
    counter: Words<Pixel, Atomic, u32>,
    ranges: Ranges,
    records: Words<Global, Plain, u64>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "A-buffer in exact contiguous ranges: count, prefix sum, store",
    paper: "Vasilakis, Fudos 2012",
    section: "k+-buffer paper, 2 and 3.3 (SB)",
    words: "2",
    overflow: Overflow::Drops("drop, counted"),
    source: include_str!("s_buffer.rs"),
    ..ranges::counted("s-buffer", Keeps::All)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for PlainCount {
    const CONTRACT: Contract = CONTRACT.fault(
        "s-buffer@plain-count",
        "Fault plain-count: fragments are counted by a load and a store",
        "no two invocations of a pixel overlap",
    );
    const ATOMIC_COUNT: bool = false;
}

/// The passes, with a barrier missing.
const UNGUARDED: &[Pass] = &[
    ranges::PASSES[ranges::COUNT],
    ranges::PASSES[ranges::REFER],
    ranges::PASSES[ranges::BLOCKS],
    ranges::PASSES[ranges::GROUPS],
    Pass::store(Barrier::Missing),
];

impl Variant for NoBarrier {
    const CONTRACT: Contract = Contract {
        program: Program::of(UNGUARDED),
        ..CONTRACT.fault(
            "s-buffer@M17",
            "Fault M17: no barrier between the sums and the store pass",
            "no store begins before the sums are there",
        )
    };
}

impl Variant for OneTooMany {
    const CONTRACT: Contract = Contract {
        dependence: CONTRACT.dependence,
        ..CONTRACT.fault(
            "s-buffer@M14",
            "Fault M14: the bound test lets one record too many through",
            CONTRACT.exact_when,
        )
    };
    const BOUNDED: bool = false;
}

impl<V: Variant> Scheme for SBuffer<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            counter: layout.named("counter").pixel(1),
            ranges: Ranges::new(config, layout),
            records: layout.named("records").global(config.bounded),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.ranges.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let counter = self.counter.at(fragment.pixel, 0);
        if V::ATOMIC_COUNT {
            mem.add(counter, 1, Order::Relaxed).await;
        } else {
            let count = mem.load(counter, Order::Relaxed).await;
            mem.store(counter, count + 1, Order::Relaxed).await;
        }
    }

    fn counts(&self, _: usize) -> Option<Words<Pixel, Atomic, u32>> {
        V::ATOMIC_COUNT.then_some(self.counter)
    }

    async fn screen<M: Memory>(&self, mem: &M, _: usize, pixel: u32) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        if count > 0 {
            self.ranges.refer(mem, pixel, count, false).await;
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
        let index = mem.add(self.counter.at(fragment.pixel, 0), 1, Order::Relaxed).await;
        let (start, _) = self.ranges.start::<_, Self>(mem, fragment.pixel).await;
        let record = start + u64::from(index);
        let last = if V::BOUNDED { self.records.count() } else { self.records.count() + 1 };
        if record >= last {
            return Outcome::Pool;
        }
        mem.plain_store(self.records.at(record), fragment.key()).await;
        Outcome::Kept
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        if !V::BOUNDED {
            return false;
        }
        let starts = self.ranges.starts(block, batch.first());
        let (Some(start), Some(counters), Some(records)) =
            (starts, block.rows(self.counter), block.all(self.records))
        else {
            return false;
        };
        let mut pool = 0;
        for bit in bits(batch.mask()) {
            let counter = counters.first(bit);
            let index = counter.replace(counter.get().wrapping_add(1));
            let stored = records.write(start(bit) + u64::from(index), batch.get(bit).key());
            pool |= u64::from(!stored) << bit;
        }
        outcomes.assign([(pool, Outcome::Pool)]);
        true
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        if count > 0 {
            let (start, _) = self.ranges.start::<_, ()>(mem, pixel).await;
            let end = (start + u64::from(count)).min(self.records.count());
            for record in start..end {
                keys.push(mem.plain_load(self.records.at(record)).await);
            }
        }
    }
}
