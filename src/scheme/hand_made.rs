//! Memory made by hand: words of one pixel as a test sets them, for looking at invariants.

use super::{Config, Moment, Scheme};
use crate::memory::asked::Cells;
use crate::memory::{At, Kind, Layout, Snapshot, Space, Word};

/// A scheme, and words that nobody wrote unless they were set.
pub(super) struct HandMade<S> {
    pub(super) scheme: S,
    cells: Cells,
    values: Vec<Option<u64>>,
}

impl<S: Scheme> HandMade<S> {
    pub(super) fn new(k: Option<u32>, generated: u64) -> Self {
        Self::of(&Config { k, pixels: 1, generated, ..Config::default() })
    }

    pub(super) fn of(config: &Config) -> Self {
        let mut layout = Layout::default();
        let scheme = S::new(config, &mut layout);
        let cells = Cells::new(&layout, 1);
        Self { scheme, values: vec![None; cells.count() as usize], cells }
    }

    pub(super) fn set<P: Space, K: Kind, W: Word>(&mut self, at: At<P, K, W>, value: W) {
        self.values[self.cells.number(at) as usize] = Some(value.to_u64());
    }

    pub(super) fn check(&self, moment: Moment) -> Result<(), String> {
        let value = |cell: u32| self.values.get(cell as usize).copied().flatten();
        let words = Snapshot { cells: &self.cells, value: &value };
        self.scheme.invariant(&words, 0, moment)
    }
}
