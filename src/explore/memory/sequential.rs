//! Sequential consistency: words are plain values.

use super::model::{Initial, Model, Race, cut};
use crate::memory::Numbering;
use crate::memory::asked::Action;

/// The words of one state: each cell's value in one or two u32, then a bit per cell, set while it has been neither
/// written nor read.
#[derive(Clone)]
pub(super) struct Sequential {
    words: Vec<u32>,
    /// Where a cell's value begins, and its width.
    places: Vec<(u32, u32)>,
    /// Where the bits of unwritten cells begin.
    unwritten: usize,
    candidates: Vec<u64>,
}

impl Sequential {
    pub(super) fn new(cells: &Numbering, initial: &[Initial], candidates: &[u64]) -> Self {
        let mut places = Vec::new();
        let mut words = Vec::new();
        for cell in 0..initial.len() as u32 {
            let bits = cells.address(cell).bits;
            places.push((words.len() as u32, bits));
            words.resize(words.len() + bits as usize / 32, 0);
        }
        let unwritten = words.len();
        words.resize(unwritten + initial.len().div_ceil(32), 0);
        let mut model = Self { words, places, unwritten, candidates: candidates.to_vec() };
        for (cell, value) in initial.iter().enumerate() {
            match value {
                Initial::Written(value) => model.set(cell as u32, *value),
                Initial::Unwritten => model.words[unwritten + cell / 32] |= 1 << (cell % 32),
            }
        }
        model
    }

    #[inline]
    fn is_unwritten(&self, cell: u32) -> bool {
        self.words[self.unwritten + cell as usize / 32] & (1 << (cell % 32)) != 0
    }

    #[inline]
    fn get(&self, cell: u32) -> u64 {
        let (at, bits) = self.places[cell as usize];
        let low = u64::from(self.words[at as usize]);
        if bits == 32 { low } else { low | u64::from(self.words[at as usize + 1]) << 32 }
    }

    #[inline]
    fn set(&mut self, cell: u32, value: u64) {
        let (at, bits) = self.places[cell as usize];
        self.words[at as usize] = value as u32;
        if bits == 64 {
            self.words[at as usize + 1] = (value >> 32) as u32;
        }
        self.words[self.unwritten + cell as usize / 32] &= !(1 << (cell % 32));
    }
}

impl Model for Sequential {
    fn copy(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }

    #[inline]
    fn load(&mut self, encoded: &[u32]) {
        self.words.copy_from_slice(encoded);
    }

    #[inline]
    fn alternatives(&mut self, _: usize, cell: u32, action: Action) -> usize {
        let reads = !matches!(action, Action::Write(..));
        if reads && self.is_unwritten(cell) { self.candidates.len() } else { 1 }
    }

    #[inline]
    fn perform(&mut self, _: usize, cell: u32, action: Action, alternative: usize) -> u64 {
        let bits = self.places[cell as usize].1;
        let old = match action {
            Action::Write(value, _) => {
                self.set(cell, value);
                return 0;
            }
            _ if self.is_unwritten(cell) => cut(self.candidates[alternative], bits),
            _ => self.get(cell),
        };
        let new = match action {
            Action::Update(update, _) => cut(update.apply(old), bits),
            _ => old,
        };
        self.set(cell, new);
        old
    }

    fn race(&self) -> Option<Race> {
        None
    }

    #[inline]
    fn store(&self, _: u32, into: &mut Vec<u32>) {
        into.extend_from_slice(&self.words);
    }

    fn barrier(&mut self, written: &std::collections::BTreeMap<u32, u64>) {
        written.iter().for_each(|(&cell, &value)| self.set(cell, value));
    }

    fn settled(&self, cell: u32) -> Option<u64> {
        let known = (cell as usize) < self.places.len() && !self.is_unwritten(cell);
        known.then(|| self.get(cell))
    }
}
