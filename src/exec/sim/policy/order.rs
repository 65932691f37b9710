//! `order` and `reverse`: one invocation runs to its end, then the next. They differ in which one is next: the oldest,
//! as on a device that draws strictly in submission order, or the youngest resident.

use std::collections::VecDeque;

use super::Scheduler;
use crate::error::Result;

/// The oldest first. Slots fill in order of age, so a queue holds them by age.
#[derive(Debug, Default)]
pub(super) struct InOrder(VecDeque<u32>);

impl Scheduler for InOrder {
    fn admit(&mut self, slot: u32) {
        self.0.push_back(slot);
    }

    fn retire(&mut self, slot: u32) {
        debug_assert_eq!(self.0.front(), Some(&slot), "only the first one runs");
        self.0.pop_front();
    }

    fn next(&mut self) -> Result<u32> {
        Ok(self.0.front().copied().unwrap_or(u32::MAX))
    }
}

/// The youngest first. One that waits goes behind all others: it may wait for an older one, as at an ordered interlock.
#[derive(Debug, Default)]
pub(super) struct Reverse(VecDeque<u32>);

impl Scheduler for Reverse {
    fn admit(&mut self, slot: u32) {
        self.0.push_back(slot);
    }

    fn retire(&mut self, slot: u32) {
        debug_assert_eq!(self.0.back(), Some(&slot), "only the last one runs");
        self.0.pop_back();
    }

    fn waits(&mut self, slot: u32) {
        debug_assert_eq!(self.0.back(), Some(&slot), "only the last one runs");
        self.0.rotate_right(1);
    }

    fn next(&mut self) -> Result<u32> {
        Ok(self.0.back().copied().unwrap_or(u32::MAX))
    }
}
