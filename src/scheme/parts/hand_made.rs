//! Memory made by hand: words of one pixel as a test sets them, for looking at invariants.

use crate::memory::{Address, At, Kind, Layout, Numbering, Snapshot, Space, Word};
use crate::scheme::{Config, Moment, Scheme};

/// A scheme, and words that were never written unless a test set them.
pub(in crate::scheme) struct HandMade<S> {
    pub(in crate::scheme) scheme: S,
    numbering: Numbering,
    values: Vec<Option<u64>>,
}

impl<S: Scheme> HandMade<S> {
    pub(in crate::scheme) fn new(k: Option<u32>, generated: u64) -> Self {
        Self::of(&Config { k, pixels: 1, generated, ..Config::default() })
    }

    pub(in crate::scheme) fn of(config: &Config) -> Self {
        let mut layout = Layout::default();
        let scheme = S::new(config, &mut layout);
        let numbering = Numbering::new(&layout, 1);
        Self { scheme, values: vec![None; numbering.count() as usize], numbering }
    }

    pub(in crate::scheme) fn set<P: Space, K: Kind, W: Word>(&mut self, at: At<P, K, W>, value: W) {
        self.values[self.numbering.number(at.address()) as usize] = Some(value.to_u64());
    }

    pub(in crate::scheme) fn check(&self, moment: Moment) -> Result<(), String> {
        let value = |address: Address| {
            self.values.get(self.numbering.number(address) as usize).copied().flatten()
        };
        self.scheme.invariant(&Snapshot { value: &value }, 0, moment)
    }
}
