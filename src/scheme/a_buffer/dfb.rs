//! Dynamic fragment buffer (Maule, Comba, Torchelsen, Bastos, "Memory-efficient order-independent transparency with
//! dynamic fragment buffer", 2012; DFB): count, prefix sum, store into exact ranges; resolve sorts.
//!
//! It differs from the S-buffer in how a fragment finds its place: the counter is not zeroed, but counted down again,
//! so that the store pass fills a range from its end and the counters are zero when it is full. A pixel's fragments are
//! sorted in a local array of 1,024 records; what a pixel has beyond is dropped by arrival.

use std::ops::Range;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Global, Layout, Memory, Order, OwnedBlock, Pixel, Plain, Words};
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::contract::{Keeps, Overflow};
use crate::scheme::parts::ranges::{self, Ranges};
use crate::scheme::{Config, Contract, Keys, Outcome, Outcomes, Scheme};

/// Records that resolve can sort.
const MOST: u32 = 1_024;

/// The method.
#[derive(Debug)]
pub struct DynamicFragmentBuffer {
    /// Fragments counted; then, fragments still to come.
    counter: Words<Pixel, Atomic, u32>,
    /// Records of the pixel, for resolve.
    length: Words<Pixel, Plain, u32>,
    ranges: Ranges,
    records: Words<Global, Plain, u64>,
}

impl Scheme for DynamicFragmentBuffer {
    const CONTRACT: Contract = Contract {
        title: "dynamic fragment buffer: count, prefix sum, store, sort",
        paper: "Maule, Comba, Torchelsen, Bastos 2012",
        section: "fragment merging paper, 5 (DFB)",
        words: "3",
        exact_when: "f(p) <= 1024",
        overflow: Overflow::Drops("beyond 1024 at a pixel, drop by arrival, counted"),
        source: include_str!("dfb.rs"),
        ..ranges::counted("dfb", Keeps::All)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            counter: layout.named("counter").pixel(1),
            length: layout.named("length").pixel(1),
            ranges: Ranges::new(config, layout),
            records: layout.named("records").global(config.bounded),
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.ranges.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
        mem.plain_store(self.length.at(pixel, 0), 0).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        mem.add(self.counter.at(fragment.pixel, 0), 1, Order::Relaxed).await;
    }

    fn counts(&self, _: usize) -> Option<Words<Pixel, Atomic, u32>> {
        Some(self.counter)
    }

    async fn screen<M: Memory>(&self, mem: &M, _: usize, pixel: u32) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        if count > 0 {
            self.ranges.refer(mem, pixel, count, false).await;
            mem.plain_store(self.length.at(pixel, 0), count).await;
        }
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.ranges.invocations(pass)
    }

    async fn frame<M: Memory>(&self, mem: &M, pass: usize, index: u32) {
        self.ranges.sum(mem, pass, index).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        match self.place::<_, Self>(mem, fragment.pixel).await {
            Ok(record) => {
                mem.plain_store(self.records.at(record), fragment.key()).await;
                Outcome::Kept
            }
            Err(outcome) => outcome,
        }
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        let (starts, counters) =
            (self.ranges.starts(block, batch.first()), block.rows(self.counter));
        let (Some(start), Some(counters), Some(lengths), Some(records)) =
            (starts, counters, block.rows(self.length), block.all(self.records))
        else {
            return false;
        };
        let [mut overflow, mut pool] = [0; 2];
        for bit in bits(batch.mask()) {
            let counter = counters.first(bit);
            let left = counter.replace(counter.get().wrapping_sub(1));
            // As in `place`.
            if lengths.first(bit).get().wrapping_sub(left) >= MOST {
                overflow |= 1 << bit;
                continue;
            }
            let record = start(bit) + u64::from(left.wrapping_sub(1));
            let stored = records.write(record, batch.get(bit).key());
            pool |= u64::from(!stored) << bit;
        }
        outcomes.assign([(overflow, Outcome::Overflow), (pool, Outcome::Pool)]);
        true
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for record in self.range::<_, Self>(mem, pixel).await {
            keys.push(mem.plain_load(self.records.at(record)).await);
        }
    }
}

impl DynamicFragmentBuffer {
    /// Where a fragment of a pixel is stored; or why it is not.
    #[inline(always)]
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub(in crate::scheme) async fn place<M: Memory, Caller>(
        &self,
        mem: &M,
        pixel: u32,
    ) -> Result<u64, Outcome> {
        let left = mem.add(self.counter.at(pixel, 0), 1u32.wrapping_neg(), Order::Relaxed).await;
        // The last to arrive find the local array full: the range is filled from its end.
        let index = left.wrapping_sub(1);
        let length = mem.plain_load(self.length.at(pixel, 0)).await;
        let place = length.wrapping_sub(left);
        if place >= MOST {
            return Err(Outcome::Overflow);
        }
        let (start, _) = self.ranges.start::<_, Caller>(mem, pixel).await;
        let record = start + u64::from(index);
        if record < self.records.count() { Ok(record) } else { Err(Outcome::Pool) }
    }

    /// The records of a pixel.
    #[inline(always)]
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub(in crate::scheme) async fn range<M: Memory, Caller>(
        &self,
        mem: &M,
        pixel: u32,
    ) -> Range<u64> {
        let length = mem.plain_load(self.length.at(pixel, 0)).await;
        if length == 0 {
            return 0..0;
        }
        let (start, _) = self.ranges.start::<_, (Caller,)>(mem, pixel).await;
        let end = start + u64::from(length);
        let begin = end.saturating_sub(u64::from(MOST)).max(start);
        begin..end.min(self.records.count())
    }

    /// The words of the records: keys.
    pub(in crate::scheme) fn records(&self) -> Words<Global, Plain, u64> {
        self.records
    }
}
