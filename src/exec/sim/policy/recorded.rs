//! `recorded`: a schedule that was recorded before, step by step.

use super::Scheduler;
use crate::error::{Error, Result};
use crate::exec::sim::schedule::Reader;

/// Follows the recording, which also brings the number of slots and how they are refilled.
#[derive(Debug)]
pub(super) struct Recorded(Reader);

impl Recorded {
    pub(super) fn new(reader: Reader) -> Self {
        Self(reader)
    }
}

impl Scheduler for Recorded {
    fn admit(&mut self, _: u32) {}

    fn retire(&mut self, _: u32) {}

    fn next(&mut self) -> Result<u32> {
        self.0.next_step()
    }

    fn group(&self) -> usize {
        self.0.group
    }

    fn resident(&self, _: usize) -> usize {
        self.0.resident
    }

    fn finish(&mut self) -> Result<()> {
        if self.0.is_done() {
            return Ok(());
        }
        Err(Error::new("--schedule recorded", "the schedule goes on after the run has ended"))
    }
}
