//! Walks of a block's fragments, side by side, for a worker that stores blocks at once
//! ([`Scheme::store_together`](crate::scheme::Scheme::store_together)).
//!
//! A block walks age by age: of every pixel, one record is on its way, and all are compared with the cells of that age,
//! eight of which lie side by side, since neighbours look at neighbouring cells. A pixel's largest record goes first,
//! and the next one begins at the age after it: at all ages up to there, it would have found something larger. So a
//! pixel takes as many steps as its last record is old, and not the sum of all its ages.
//!
//! A record that is displaced at its own age is of the same pixel, and waits for its turn; one of another age is a
//! *stray*, of a pixel elsewhere. When the block has done, its strays walk. They look at their next cells first, which
//! is many loads at a time: a cell is a random place of a large table, and an atomic update lets no later load begin.
//!
//! What was seen may be older than what is there, since other workers walk on the same table. Cells only grow, so that
//! a record that was not larger then is not larger now.
//!
//! The cells do not depend on the order of walks: records propose themselves along their walks, and a cell keeps the
//! largest (Gale, Shapley, "College admissions and the stability of marriage", 1962). Nor do the largest ages, unless a
//! record is dropped for its age.

use super::table::{Place, Table};
use crate::fragment::sort::Sort;
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

/// The records of a block that have not begun to walk, pixel by pixel, the largest last.
struct Waiting {
    own: Vec<u64>,
    /// Most of a pixel.
    most: usize,
    /// Behind each pixel's last one.
    ends: [usize; 64],
}

impl Waiting {
    fn new(batches: &[Batch], mut record: impl FnMut(&Batch, u32) -> u64) -> Self {
        let most = batches.len();
        let mut own = vec![0; 64 * most];
        let mut ends = std::array::from_fn(|bit| bit * most);
        for batch in batches {
            for bit in bits(batch.mask()) {
                let end = &mut ends[bit as usize & 63];
                own[*end] = record(batch, bit);
                *end += 1;
            }
        }
        ends.iter().zip(0..).for_each(|(&end, bit)| Sort::Fastest.keys(&mut own[bit * most..end]));
        Self { own, most, ends }
    }

    /// A pixel's largest.
    #[inline]
    fn take(&mut self, bit: u32) -> Option<u64> {
        let end = &mut self.ends[bit as usize & 63];
        if *end == (bit as usize & 63) * self.most {
            return None;
        }
        *end -= 1;
        Some(self.own[*end])
    }

    /// One more, where one was taken before.
    fn put(&mut self, bit: u32, record: u64) {
        let end = &mut self.ends[bit as usize & 63];
        let begin = (bit as usize & 63) * self.most;
        let mut place = *end;
        while place > begin && self.own[place - 1] > record {
            self.own[place] = self.own[place - 1];
            place -= 1;
        }
        self.own[place] = record;
        *end += 1;
    }
}

/// What became of fragments: of those at a bit, each batch's in turn, since it does not matter which.
struct Gone<'a> {
    batches: &'a [Batch],
    outcomes: &'a mut [Outcomes],
    /// How many batches have had their turn at each bit.
    turns: [usize; 64],
}

impl Gone<'_> {
    fn set(&mut self, bit: u32, outcome: Outcome) {
        let turn = &mut self.turns[bit as usize & 63];
        while self.batches.get(*turn).is_some_and(|batch| batch.mask() >> bit & 1 == 0) {
            *turn += 1;
        }
        if let Some(outcomes) = self.outcomes.get_mut(*turn) {
            outcomes.set(bit, outcome);
        }
        *turn += 1;
    }
}

impl<W: Word> Walks<'_, W> {
    /// Walk with the fragments of a block's batches; `record` gives that of the one at a bit, without an age, batch by
    /// batch, from the lowest bit on.
    pub(super) fn go(
        &self,
        batches: &[Batch],
        record: impl FnMut(&Batch, u32) -> u64,
        outcomes: &mut [Outcomes],
    ) {
        let Some(first) = batches.first() else { return };
        let table = self.table;
        let corner = table.place(first.first());
        let mut gone = Gone { batches, outcomes, turns: [0; 64] };
        let mut waiting = Waiting::new(batches, record);
        let mut own = [0; 64];
        let mut left = 0;
        for bit in 0..64 {
            if let Some(record) = waiting.take(bit) {
                own[bit as usize] = record;
                left |= 1 << bit;
            }
        }
        let mut strays = Vec::new();
        for age in 1..=table.ages() {
            let mut inserted = false;
            for bit in bits(self.compare(corner, age, left, &own)) {
                let own = &mut own[bit as usize & 63];
                let cell = table.cell(place(corner, bit), age);
                let step = self.step(cell, self.record(*own, age), W::default());
                inserted |= matches!(step, Step::Stays | Step::Displaces { .. });
                match step {
                    Step::Passes => continue,
                    Step::Stays => {}
                    Step::Alike => gone.set(bit, Outcome::Duplicate),
                    Step::Displaces { own, age: theirs } if theirs == age => waiting.put(bit, own),
                    Step::Displaces { own, age } => {
                        let place = table.origin(cell, age);
                        strays.push(Stray { own, place, age, cell, seen: W::default(), bit });
                    }
                }
                let mut next = waiting.take(bit);
                // The next one would walk past its like.
                while self.once && next == Some(*own) {
                    gone.set(bit, Outcome::Duplicate);
                    next = waiting.take(bit);
                }
                match next {
                    Some(next) => *own = next,
                    None => left &= !(1 << bit),
                }
            }
            if inserted {
                let _ = self.block.max(table.largest(corner), age);
            }
            if left == 0 {
                break;
            }
        }
        for bit in bits(left) {
            gone.set(bit, Outcome::Age);
            while waiting.take(bit).is_some() {
                gone.set(bit, Outcome::Age);
            }
        }
        self.stray(strays, &mut gone);
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
    fn stray(&self, mut strays: Vec<Stray<W>>, gone: &mut Gone<'_>) {
        let table = self.table;
        while !strays.is_empty() {
            strays.retain_mut(|stray| {
                stray.age += 1;
                if stray.age > table.ages() {
                    gone.set(stray.bit, Outcome::Age);
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
                    Step::Alike => gone.set(stray.bit, Outcome::Duplicate),
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
