//! `round-robin`: every resident invocation performs one operation in turn, by age of its slot's last admission.

use std::collections::VecDeque;

use super::Scheduler;
use crate::error::Result;

/// A ring of slots; the last one has just moved.
#[derive(Debug, Default)]
pub(super) struct RoundRobin {
    ring: VecDeque<u32>,
}

impl Scheduler for RoundRobin {
    fn admit(&mut self, slot: u32) {
        self.ring.push_back(slot);
    }

    fn retire(&mut self, slot: u32) {
        debug_assert_eq!(
            self.ring.back(),
            Some(&slot),
            "only the slot that has just moved can end"
        );
        self.ring.pop_back();
    }

    fn next(&mut self) -> Result<u32> {
        self.ring.rotate_left(usize::from(!self.ring.is_empty()));
        Ok(self.ring.back().copied().unwrap_or(u32::MAX))
    }
}
