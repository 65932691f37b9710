//! HA-buffer (Lefebvre, Hornus, Lasram, "HA-Buffer: Coherent hashing for single-pass A-buffer", INRIA RR-8282, 2013).
//!
//! All fragments of a frame are in one hash table. A fragment walks its pixel's cells, age by age, and an atomic
//! maximum puts its record where that is larger than what is there. Records have the age in their upper bits, so that
//! the older wins (Robin Hood); then the depth, reversed, so that of two fragments of one pixel the nearer wins. A
//! displaced record walks on, carried by the invocation that displaced it, and may be of another pixel: the cell and
//! the age identify the pixel (see [`super::table`]). So an invocation may end with another pixel's fragment, and the
//! accounting of drops holds for the frame.
//!
//! Two properties make it work (section 4.1.2), and checks test both after every step: cells only grow; and Proposition
//! A: where a record of pixel p is found at age a, every cell of p's walk before holds at least what that record would
//! be there. So the ages of a pixel's fragments grow with depth, and a walk ends at the first cell whose record is
//! younger than the walk.
//!
//! The result does not depend on any schedule: it is the stable matching of fragments and cells, which is unique.
//!
//! Deviations. Resolve takes every age up to the largest (the paper's listing subtracts 1 from it *and* stops before:
//! as published, it never sees the last fragment). Two records that are wholly alike are one: the published rule
//! ("duplicate") drops the second, and counts it here; `ha64-multiset` keeps it. `ha32` has no data word, so that its
//! fragments are alike where their depths are.

pub mod faults;

use std::marker::PhantomData;

use super::table::{Place, Table};
use super::walks::Walks;
use crate::fragment::{Data, Fragment, data_of, depth_of, key};
use crate::memory::{Event, Layout, Memory, Order, OwnedBlock, Snapshot, Word};
use crate::num::depth::Format;
use crate::raster::Batch;
use crate::scheme::contract::{Alike, Form, Keeps, Overflow};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Cells, Config, Contract, Keys, Moment, Outcome, Outcomes, Readback, Scheme};

/// The largest depth of 24 bits.
const FAR: u32 = 0xFF_FFFF;

/// Of how many primitives a block's fragments walk together: what the first-level cache has room for.
const TOGETHER: usize = 32;

/// The pass that clears the table.
pub(super) const CLEAR: Pass = Pass::new("clear table", PassKind::Frame, Barrier::Frame);

/// Clear, then store; resolve begins when all records are in.
pub(super) const PROGRAM: Program = Program {
    passes: &[CLEAR, Pass::store(Barrier::Frame)],
    before_resolve: Barrier::Frame,
    repeats: false,
};

/// What a cell holds: age, reversed depth and, if there is room, data; from the upper bits to the lower. 0 is empty.
pub trait Record: Send + Sync + 'static {
    /// A cell.
    type Word: Word;
    /// The bit at which the age begins.
    const AGE_BIT: u32;
    /// The table's cells, without their type.
    fn cells(table: &Table<Self::Word>) -> Cells;
    /// The record of a fragment's key at an age.
    fn pack(age: u32, key: u64) -> Self::Word;
    /// Its age.
    fn age(record: Self::Word) -> u32;
    /// Its fragment's key.
    fn key(record: Self::Word) -> u64;
}

/// Age 8 | depth 24 | data 32.
#[derive(Debug)]
pub enum Bits64 {}

/// Age 8 | depth 24.
#[derive(Debug)]
pub enum Bits32 {}

impl Record for Bits64 {
    type Word = u64;

    const AGE_BIT: u32 = 56;

    fn cells(table: &Table<u64>) -> Cells {
        Cells::Words64(table.cells())
    }

    #[inline(always)]
    fn pack(age: u32, key: u64) -> u64 {
        let upper = age << 24 | FAR.wrapping_sub(depth_of(key));
        u64::from(upper) << 32 | u64::from(data_of(key))
    }

    #[inline(always)]
    fn age(record: u64) -> u32 {
        (record >> 56) as u32
    }

    #[inline(always)]
    fn key(record: u64) -> u64 {
        key(FAR - (depth_of(record) & FAR), data_of(record))
    }
}

impl Record for Bits32 {
    type Word = u32;

    const AGE_BIT: u32 = 24;

    fn cells(table: &Table<u32>) -> Cells {
        Cells::Words32(table.cells())
    }

    #[inline(always)]
    fn pack(age: u32, key: u64) -> u32 {
        age << 24 | FAR.wrapping_sub(depth_of(key))
    }

    #[inline(always)]
    fn age(record: u32) -> u32 {
        record >> 24
    }

    #[inline(always)]
    fn key(record: u32) -> u64 {
        key(FAR - (record & FAR), 0)
    }
}

/// A form of the method, or a fault in it.
pub trait Variant<R>: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether a record that is already there is kept a second time.
    const MULTISET: bool = false;
    /// Whether resolve goes up to the largest age.
    const LAST_AGE: bool = true;
    /// Whether an age beyond the largest is refused.
    const LIMITED: bool = true;
    /// Whether a displaced record is inserted again.
    const REINSERTS: bool = true;
    /// Whether the largest age of the block is updated.
    const TELLS_AGE: bool = true;
    /// Whether the pixel of an evicted record follows from the record's own age, or from that of the evicting one.
    const OWN_OFFSET: bool = true;
    /// Whether the cell is updated by one atomic operation.
    const ATOMIC: bool = true;
    /// Whether the table is as large as the screen on each axis.
    const COVERS: bool = true;
    /// Whether depth stands above data, so that it is compared first.
    const BY_DEPTH: bool = true;
}

/// As published, except that resolve loses nothing.
#[derive(Debug)]
pub enum Correct {}

/// As listed: resolve never sees the largest age of a block.
#[derive(Debug)]
pub enum Published {}

/// Records that are alike are all kept.
#[derive(Debug)]
pub enum Multiset {}

/// The method.
#[derive(Debug)]
pub struct HaBuffer<R: Record, V = Correct> {
    table: Table<R::Word>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "HA-buffer: all fragments in one hash table, sorted as they are inserted",
    paper: "Lefebvre, Hornus, Lasram 2013",
    section: "HA-buffer paper, 4.1",
    program: PROGRAM,
    exact_when: "no age limit is met, depths have 24 bits, and no two fragments of a pixel are alike",
    depth_format: Some(Format::D24),
    depth_bits: 24,
    source: include_str!("ha.rs"),
    alike: Alike::Once,
    overflow: Overflow::Settled(super::OVERFLOW),
    ties: super::TIES,
    ..super::hashed("ha64", Keeps::All)
};

const CONTRACT_32: Contract = Contract {
    name: "ha32",
    title: "HA-buffer of depths alone: layered depth images, voxels",
    section: "HA-buffer paper, 4.1.3 (32 bits version)",
    frame_words: "C + B",
    exact_when: "no age limit is met, and the depths of a pixel are distinct in 24 bits",
    data: Some(Data::Nothing),
    needs: "32-bit atomic maximum, relaxed",
    wgsl: Some("storage buffers; atomicMax"),
    ..CONTRACT
};

impl Variant<Bits64> for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant<Bits32> for Correct {
    const CONTRACT: Contract = CONTRACT_32;
}

impl Variant<Bits64> for Multiset {
    const CONTRACT: Contract = Contract {
        name: "ha64-multiset",
        title: "HA-buffer that keeps fragments that are wholly alike",
        exact_when: "no age limit is met, and depths have 24 bits",
        ties: "canonical after resolve",
        alike: Alike::Each,
        ..CONTRACT
    };
    const MULTISET: bool = true;
}

impl Variant<Bits64> for Published {
    const CONTRACT: Contract = Contract {
        name: "ha64@published",
        title: "HA-buffer with the traversal as listed: the largest age of a block is never looked at",
        section: "HA-buffer paper, 4.1.4 (listing)",
        form: Form::Published,
        keeps: Keeps::Some,
        exact_when: "never: the last fragment of a block's longest walk is lost",
        ..CONTRACT
    };
    const LAST_AGE: bool = false;
}

impl<R: Record, V: Variant<R>> HaBuffer<R, V> {
    /// Its table.
    #[inline(always)]
    pub(super) fn table(&self) -> &Table<R::Word> {
        &self.table
    }

    #[inline(always)]
    fn pack(age: u32, key: u64) -> R::Word {
        if V::BY_DEPTH {
            return R::pack(age, key);
        }
        let depth = u64::from(FAR - (depth_of(key) & FAR));
        R::Word::from_u64(u64::from(age) << 56 | u64::from(data_of(key)) << 24 | depth)
    }

    #[inline(always)]
    fn key(record: R::Word) -> u64 {
        if V::BY_DEPTH {
            return R::key(record);
        }
        let record = record.to_u64();
        key(FAR - (record as u32 & FAR), (record >> 24) as u32)
    }

    /// Proposition A for the record that a pixel has at an age.
    fn proposition(
        &self,
        words: &Snapshot<'_>,
        place: Place,
        age: u32,
        key: u64,
    ) -> Result<(), String> {
        for before in 1..age {
            let found = words.get(self.table.word(self.table.cell(place, before)));
            if found.is_some_and(|found| found < R::pack(before, key)) {
                let depth = depth_of(key);
                return Err(format!(
                    "Proposition A: depth {depth:x} is at age {age}, and smaller is at {before}"
                ));
            }
        }
        Ok(())
    }
}

impl<R: Record, V: Variant<R>> Scheme for HaBuffer<R, V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let table =
            if V::COVERS { Table::new(config, layout) } else { Table::narrow(config, layout) };
        Self { table, variant: PhantomData }
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
        let empty = R::Word::default();
        let (mut place, mut age, mut own) = (table.place(fragment.pixel), 1, fragment.key());
        let _walk = mem.block();
        loop {
            let step = mem.block();
            mem.here(&[place[0].into(), place[1].into(), age.into(), own]);
            let last = if V::LIMITED { table.ages() } else { 2 * table.ages() };
            if age > last {
                return Outcome::Age;
            }
            // A field of as many bits as the largest age has begins again at 0, which is no age at all.
            let field = if V::LIMITED { age } else { age & table.ages() };
            let (record, cell) = (Self::pack(field, own), table.cell_beyond(place, age));
            let word = table.word(cell);
            mem.note(Event::Probe);
            let old = if V::ATOMIC {
                mem.max(word, record, Order::Relaxed).await
            } else {
                let old = mem.load(word, Order::Relaxed).await;
                if old < record {
                    mem.store(word, record, Order::Relaxed).await;
                }
                old
            };
            if old == record && !V::MULTISET {
                return Outcome::Duplicate;
            }
            let inserted = mem.block();
            if old < record {
                if V::TELLS_AGE {
                    mem.max(table.largest(place), age, Order::Relaxed).await;
                }
                if old == empty || !V::REINSERTS {
                    return Outcome::Kept;
                }
                mem.note(Event::Eviction);
                let theirs = R::age(old);
                place = table.origin(cell, if V::OWN_OFFSET { theirs } else { age });
                (age, own) = (theirs, Self::key(old));
            }
            mem.merge(inserted).await;
            age += 1;
            mem.merge(step).await;
        }
    }

    fn together(&self) -> usize {
        if self.table.covers_screen() { TOGETHER } else { 0 }
    }

    fn store_together(
        &self,
        block: &OwnedBlock<'_>,
        batches: &[Batch],
        outcomes: &mut [Outcomes],
    ) -> bool {
        let walks = Walks { table: &self.table, block, age_bit: R::AGE_BIT, once: !V::MULTISET };
        let record = |batch: &Batch, bit| R::pack(0, batch.get(bit).key()).to_u64();
        walks.go(batches, record, outcomes);
        true
    }

    /// At any time, Proposition A; in the end, nothing is beyond the largest age, and the list is sorted.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let table = &self.table;
        let place = table.place(pixel);
        let mut last = 0;
        for age in 1..=table.ages() {
            let record = words.get(table.word(table.cell(place, age))).unwrap_or_default();
            if R::age(record) != age {
                continue;
            }
            self.proposition(words, place, age, Self::key(record))?;
            let largest = words.get(table.largest(place)).unwrap_or_default();
            if moment == Moment::Quiet && largest < age {
                return Err(format!("a record is at age {age}, and the largest is {largest}"));
            }
            let depth = depth_of(Self::key(record));
            if depth < last {
                return Err(format!("depth {depth:x} at age {age} comes after {last:x}"));
            }
            last = depth;
        }
        Ok(())
    }

    fn owner(&self, bits: u32, word: u64, value: u64) -> Option<u32> {
        let table = &self.table;
        let index = table.cells().index_of(word).filter(|_| bits == R::Word::BITS)?;
        let age = R::age(R::Word::from_u64(value));
        let known = (1..=table.ages()).contains(&age);
        known.then(|| table.pixel(table.origin(table.place_of(index), age)))
    }

    fn readback(&self) -> Option<Readback> {
        let (size, cells) = (self.table.size(), R::cells(&self.table));
        Some(Readback { size, age_bit: R::AGE_BIT, cells })
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        if !self.table.is_seen(pixel) {
            return;
        }
        let table = &self.table;
        let place = table.place(pixel);
        let largest = mem.load(table.largest(place), Order::Relaxed).await;
        let last = if V::LAST_AGE { largest } else { largest.saturating_sub(1) };
        for age in 1..=last.min(table.ages()) {
            let record = mem.load(table.word(table.cell(place, age)), Order::Relaxed).await;
            if R::age(record) == age {
                keys.push(Self::key(record));
            }
            if R::age(record) < age {
                return;
            }
        }
    }
}
