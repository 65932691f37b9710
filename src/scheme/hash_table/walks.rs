//! Walks of a block's fragments, side by side, for a worker that stores blocks at once
//! ([`Scheme::store_block`](crate::scheme::Scheme::store_block)).
//!
//! A pixel's fragments all walk the same cells, so most steps pass by a record of the same pixel, or push it one age
//! on. And neighbours look at neighbouring cells. So a block walks age by age: of every pixel, one record is on its way,
//! and all are compared with the cells of that age, eight of which lie side by side. A record that is displaced at its
//! own age is of the same pixel, and takes its turn; one of another age is a *stray*, of a pixel elsewhere. When the
//! block has done, its strays walk. They look at their next cells first, which is many loads at a time: a cell is a
//! random place of a large table, and an atomic update lets no later load begin.
//!
//! What was seen may be older than what is there, since other workers walk on the same table. Cells only grow, so that
//! a record that was not larger then is not larger now.
//!
//! The cells do not depend on the order of walks: records propose themselves along their walks, and a cell keeps the
//! largest (Gale, Shapley, "College admissions and the stability of marriage", 1962). Nor do the largest ages, unless a
//! record is dropped for its age.

use super::table::{Place, Table};
use crate::memory::{OwnedBlock, Word};
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::{Outcome, Outcomes};

/// A table, and what its records look like.
pub(super) struct Walks<'a, W> {
    pub(super) table: &'a Table<W>,
    pub(super) block: &'a OwnedBlock<'a>,
    /// The bit of a record at which its age begins, up to its highest.
    pub(super) age_bit: u32,
    /// Whether a record that is already there is not kept a second time.
    pub(super) once: bool,
}

/// A record on its way to another block's pixel.
struct Stray<W> {
    /// The record, without its age.
    own: u64,
    place: Place,
    age: u32,
    /// The cell where it is, and what was seen there.
    cell: Place,
    seen: W,
    /// The bit of the fragment that displaced it.
    bit: u32,
}

/// What became of a record at a cell.
enum Step {
    /// It is there, and nothing was.
    Stays,
    /// It is there, and displaced a record.
    Displaces { own: u64, age: u32 },
    /// It was there already.
    Alike,
    /// What is there is larger.
    Passes,
}

impl<W: Word> Walks<'_, W> {
    /// Walk with a batch's fragments; `record` gives that of the one at a bit, without an age, from the lowest bit on.
    pub(super) fn go(
        &self,
        batch: &Batch,
        mut record: impl FnMut(u32) -> u64,
        outcomes: &mut Outcomes,
    ) {
        let table = self.table;
        let corner = table.place(batch.first());
        let mut own = [0; 64];
        bits(batch.mask()).for_each(|bit| own[bit as usize & 63] = record(bit));
        let mut left = batch.mask();
        let mut strays = Vec::new();
        for age in 1..=table.ages() {
            let mut inserted = false;
            let seen = self.compare(corner, age, left, &own);
            for bit in bits(seen) {
                let record = self.record(own[bit as usize & 63], age);
                let cell = table.cell(place(corner, bit), age);
                match self.step(cell, record, W::default()) {
                    Step::Stays => left &= !(1 << bit),
                    Step::Displaces { own: next, age: theirs } if theirs == age => {
                        own[bit as usize & 63] = next;
                    }
                    Step::Displaces { own, age } => {
                        left &= !(1 << bit);
                        let place = table.origin(cell, age);
                        strays.push(Stray { own, place, age, cell, seen: W::default(), bit });
                    }
                    Step::Alike => {
                        left &= !(1 << bit);
                        outcomes.set(bit, Outcome::Duplicate);
                        continue;
                    }
                    Step::Passes => continue,
                }
                inserted = true;
            }
            if inserted {
                let _ = self.block.max(table.largest(corner), age);
            }
            if left == 0 {
                break;
            }
        }
        bits(left).for_each(|bit| outcomes.set(bit, Outcome::Age));
        self.stray(strays, outcomes);
    }

    /// Which of the records at these bits are not smaller than what is in their cells.
    fn compare(&self, corner: Place, age: u32, left: u64, own: &[u64; 64]) -> u64 {
        let table = self.table;
        let mut found = 0;
        for (own, y) in own.as_chunks::<8>().0.iter().zip(0..) {
            let row = left >> (8 * y) & 0xFF;
            if row == 0 {
                continue;
            }
            let first = place(corner, 8 * y);
            let run = table.row(first, age, 8).and_then(|at| self.block.run(table.cells(), at, 8));
            let seen: [W; 8] = run.and_then(|run| run.values()).unwrap_or_else(|| {
                // The table's edge is in between, or behind.
                std::array::from_fn(|x| {
                    let cell = table.cell(place(first, x as u32), age);
                    self.block.value(table.word(cell)).unwrap_or_default()
                })
            });
            // All eight, whatever is asked: there is nothing to guess.
            for x in 0..8 {
                let larger = u64::from(seen[x] <= self.record(own[x], age));
                found |= (larger << x & row) << (8 * y);
            }
        }
        found
    }

    /// Strays walk to their ends.
    fn stray(&self, mut strays: Vec<Stray<W>>, outcomes: &mut Outcomes) {
        let table = self.table;
        while !strays.is_empty() {
            strays.retain_mut(|stray| {
                stray.age += 1;
                if stray.age > table.ages() {
                    outcomes.set(stray.bit, Outcome::Age);
                    return false;
                }
                stray.cell = table.cell(stray.place, stray.age);
                stray.seen = self.block.value(table.word(stray.cell)).unwrap_or_default();
                true
            });
            strays.retain_mut(|stray| {
                let record = self.record(stray.own, stray.age);
                let step = self.step(stray.cell, record, stray.seen);
                if matches!(step, Step::Stays | Step::Displaces { .. }) {
                    let _ = self.block.max(table.largest(stray.place), stray.age);
                }
                match step {
                    Step::Displaces { own, age } => {
                        (stray.own, stray.age) = (own, age);
                        stray.place = table.origin(stray.cell, age);
                    }
                    Step::Alike => outcomes.set(stray.bit, Outcome::Duplicate),
                    Step::Stays | Step::Passes => {}
                }
                matches!(step, Step::Displaces { .. } | Step::Passes)
            });
        }
    }

    /// Take a record to a cell in which `seen` was.
    #[inline]
    fn step(&self, cell: Place, record: W, seen: W) -> Step {
        let mut old = seen;
        if old < record {
            old = self.block.max(self.table.word(cell), record).unwrap_or_default();
        }
        if old > record || old == record && !self.once {
            return Step::Passes;
        }
        if old == record {
            return Step::Alike;
        }
        if old == W::default() {
            return Step::Stays;
        }
        let old = old.to_u64();
        let age = old >> self.age_bit;
        Step::Displaces { own: old ^ age << self.age_bit, age: age as u32 }
    }

    #[inline(always)]
    fn record(&self, own: u64, age: u32) -> W {
        W::from_u64(own | u64::from(age) << self.age_bit)
    }
}

/// The place of a block's pixel.
#[inline(always)]
fn place([x, y]: Place, bit: u32) -> Place {
    [x + bit % 8, y + bit / 8]
}
