//! Coherent hashing with explicit keys (García, Lefebvre, Hornus, Lasram 2011, as the HA-buffer paper describes it in
//! section 2.5.1), for fragments: what the HA-buffer is measured against.
//!
//! A record is age 8 | key 24 | data 32, from the upper bits to the lower. The key is the pixel, and takes the place of
//! the depth; so the data word is the number of a node, which holds the fragment. All fragments of a pixel have its
//! key, and stand anywhere on its walk. A displaced record is identified by its key, not by its age, so that a table
//! may also be smaller than the screen. Lists come out unsorted.
//!
//! The listing in the paper keeps the *inserting* record's data when it goes on with the evicted key; that is
//! `hash-coherent@published`.

use std::marker::PhantomData;

use super::ha::PROGRAM;
use super::table::Table;
use super::walks::Walks;
use crate::fragment::Fragment;
use crate::memory::{
    Event, Global, Layout, Memory, Order, OwnedBlock, Plain, Pool, Snapshot, Words,
};
use crate::raster::Batch;
use crate::scheme::contract::{Dependence, Form, Keeps};
use crate::scheme::{Cells, Config, Contract, Keys, Moment, Outcome, Outcomes, Readback, Scheme};

/// Bits of a key: more pixels than that are refused.
pub const KEY_BITS: u32 = 24;

/// A form of the method.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether an evicted key takes its data with it.
    const OWN_DATA: bool = true;
}

/// Every key keeps its data.
#[derive(Debug)]
pub enum Correct {}

/// As listed.
#[derive(Debug)]
pub enum Published {}

/// The method.
#[derive(Debug)]
pub struct HashCoherent<V = Correct> {
    table: Table<u64>,
    pool: Pool,
    nodes: Words<Global, Plain, u64>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "Coherent hashing with explicit keys, and lists to be sorted",
    paper: "García, Lefebvre, Hornus, Lasram 2011",
    section: "HA-buffer paper, 2.5.1",
    program: PROGRAM,
    frame_words: "2C + B + 2F + 1",
    exact_when: "no age limit is met",
    needs: "64-bit atomic maximum, 32-bit atomic add, relaxed",
    wgsl: Some("storage buffers; atomicAdd, 64-bit atomicMax (not in the standard)"),
    max_pixels: 1 << KEY_BITS,
    source: include_str!("hash_coherent.rs"),
    ..super::hashed("hash-coherent", Keeps::All)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Published {
    const CONTRACT: Contract = Contract {
        name: "hash-coherent@published",
        title: "Coherent hashing as listed: an evicted key goes on with the other's data",
        form: Form::Published,
        keeps: Keeps::Some,
        exact_when: "no record is displaced",
        dependence: Dependence::ArrivalAndInterleaving,
        ..CONTRACT
    };
    const OWN_DATA: bool = false;
}

const fn pack(age: u32, pixel: u32, node: u32) -> u64 {
    (((age << KEY_BITS) | pixel) as u64) << 32 | node as u64
}

const fn age(record: u64) -> u32 {
    (record >> 56) as u32
}

const fn key(record: u64) -> u32 {
    (record >> 32) as u32 & ((1 << KEY_BITS) - 1)
}

impl<V: Variant> Scheme for HashCoherent<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            table: Table::new(config, layout),
            pool: layout.named("pool").pool(),
            nodes: layout.named("nodes").global(config.generated),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        mem.store(self.pool.counter(), 0, Order::Relaxed).await;
    }

    async fn clear<M: Memory>(&self, _mem: &M, _pixel: u32) {}

    fn invocations(&self, _pass: usize) -> u32 {
        self.table.clearing()
    }

    async fn frame<M: Memory>(&self, mem: &M, _pass: usize, index: u32) {
        self.table.clear(mem, index).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let table = &self.table;
        let mut node = mem.take(self.pool).await;
        if u64::from(node) >= self.nodes.count() {
            return Outcome::Pool;
        }
        mem.plain_store(self.nodes.at(node.into()), fragment.key()).await;
        let (mut pixel, mut at) = (fragment.pixel, 0);
        let _walk = mem.block();
        loop {
            let step = mem.block();
            mem.here(&[pixel.into(), at.into(), node.into()]);
            at += 1;
            if at > table.ages() {
                return Outcome::Age;
            }
            let place = table.place(pixel);
            let (record, cell) = (pack(at, pixel, node), table.cell(place, at));
            mem.note(Event::Probe);
            let old = mem.max(table.word(cell), record, Order::Relaxed).await;
            let inserted = mem.block();
            if old < record {
                mem.max(table.largest(place), at, Order::Relaxed).await;
                if old == 0 {
                    return Outcome::Kept;
                }
                mem.note(Event::Eviction);
                (pixel, at) = (key(old), age(old));
                if V::OWN_DATA {
                    node = old as u32;
                }
            }
            mem.merge(inserted).await;
            mem.merge(step).await;
        }
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        let count = batch.mask().count_ones();
        if !V::OWN_DATA || !self.table.covers_screen() {
            return false;
        }
        let Some(first) = block.next(self.pool, count) else { return false };
        let Some(nodes) = block.run(self.nodes, first.into(), count.into()) else { return false };
        block.take(self.pool, count);
        nodes.writers().zip(batch.iter()).for_each(|(node, fragment)| node(fragment.key()));
        let walks = Walks { table: &self.table, block, age_bit: 56, once: false };
        let mut nodes = first..;
        let own =
            |batch: &Batch, bit| pack(0, batch.first() + bit, nodes.next().unwrap_or_default());
        walks.go(std::slice::from_ref(batch), own, std::slice::from_mut(outcomes));
        true
    }

    /// In the end, no record is beyond the largest age of its block.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let place = self.table.place(pixel);
        for at in 1..=self.table.ages() {
            let record = words.get(self.table.word(self.table.cell(place, at))).unwrap_or_default();
            let largest = words.get(self.table.largest(place)).unwrap_or_default();
            let own = age(record) == at && key(record) == pixel;
            if own && moment == Moment::Quiet && largest < at {
                return Err(format!("a record is at age {at}, and the largest is {largest}"));
            }
        }
        Ok(())
    }

    fn readback(&self) -> Option<Readback> {
        let cells = Cells::Words64(self.table.cells());
        Some(Readback { size: self.table.size(), age_bit: 56, cells })
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        if !self.table.is_seen(pixel) {
            return;
        }
        let place = self.table.place(pixel);
        let largest = mem.load(self.table.largest(place), Order::Relaxed).await;
        for at in 1..=largest.min(self.table.ages()) {
            let cell = self.table.word(self.table.cell(place, at));
            let record = mem.load(cell, Order::Relaxed).await;
            if age(record) == at && key(record) == pixel {
                keys.push(mem.plain_load(self.nodes.at(u64::from(record as u32))).await);
            }
            if age(record) < at {
                return;
            }
        }
    }
}
