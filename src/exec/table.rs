//! A hash table as the application reads it back after a frame: how full it is, and how old its records are.

use crate::memory::arena::Shared;
use crate::memory::sim::Sim;
use crate::memory::{Atomic, Global, Word, Words};
use crate::scheme::{Cells, Readback};

/// A table that a frame has left. To read it back is no part of the frame: it may have hundreds of MiB.
#[derive(Debug)]
pub enum Left {
    /// In the frame's words.
    There(Readback, Shared),
    /// It was read back.
    Read(TableWords),
}

/// A table's contents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableWords {
    /// Cells across and down.
    pub size: [u32; 2],
    /// The bit of a cell at which its age begins.
    pub age_bit: u32,
    /// Cells, row by row; 0 is empty.
    pub cells: Vec<u64>,
}

/// Memory whose words can be read back.
pub trait Source {
    /// All values of a run of the frame's words.
    fn copy<W: Word>(&self, words: Words<Global, Atomic, W>) -> Vec<u64>;
}

impl Source for Shared {
    fn copy<W: Word>(&self, words: Words<Global, Atomic, W>) -> Vec<u64> {
        Self::copy(self, words)
    }
}

impl<O: crate::memory::Observer> Source for Sim<O> {
    fn copy<W: Word>(&self, words: Words<Global, Atomic, W>) -> Vec<u64> {
        Self::copy(self, words)
    }
}

impl TableWords {
    /// Read it back.
    #[must_use]
    pub fn new(readback: &Readback, from: &impl Source) -> Self {
        let cells = match readback.cells {
            Cells::Words32(words) => from.copy(words),
            Cells::Words64(words) => from.copy(words),
        };
        Self { size: readback.size, age_bit: readback.age_bit, cells }
    }

    /// Number of records by age, from 0, which no record has.
    #[must_use]
    pub fn ages(&self) -> Vec<u64> {
        let mut ages = Vec::new();
        for &cell in self.cells.iter().filter(|&&cell| cell != 0) {
            let age = (cell >> self.age_bit) as usize;
            if ages.len() <= age {
                ages.resize(age + 1, 0);
            }
            ages[age] += 1;
        }
        ages
    }
}
