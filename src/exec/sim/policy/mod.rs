//! Policies: which invocation performs the next operation. One file each.

mod any;
mod named;
mod order;
mod pct;
mod random;
mod recorded;
mod round_robin;
mod warp;

use crate::error::Result;

pub(super) use any::Any;
pub use named::Policy;

/// Decides the schedule. It is notified as slots fill and empty; `next` is called only while one is filled.
pub trait Scheduler {
    /// The slot took a new invocation, younger than all before.
    fn admit(&mut self, slot: u32);

    /// The slot's invocation ended.
    fn retire(&mut self, slot: u32);

    /// The slot's invocation is about to repeat an attempt: it waits for another one.
    fn waits(&mut self, slot: u32) {
        let _ = slot;
    }

    /// The slot that goes next.
    ///
    /// # Errors
    /// Only a recorded schedule can fail: at its end.
    fn next(&mut self) -> Result<u32>;

    /// The slot that will probably follow: with this hint, the device brings its invocation into the cache.
    fn hint(&self) -> Option<u32> {
        None
    }

    /// Slots that are refilled together, once all of them are empty.
    fn group(&self) -> usize {
        1
    }

    /// How many slots there are, given how many were requested.
    fn resident(&self, asked: usize) -> usize {
        asked.next_multiple_of(self.group())
    }

    /// The run is over.
    ///
    /// # Errors
    /// A recorded schedule that is not at its end.
    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// How the simulated device is set up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scheduling {
    /// Which invocation goes next.
    pub policy: Policy,
    /// Seed of `Policy::Random` and `Policy::Pct`.
    pub seed: u64,
    /// Invocations in flight, at least 1; a recorded schedule has its own number.
    pub resident: usize,
    /// Record the schedule.
    pub record: bool,
    /// What a schedule belongs to (`schedule::fingerprint`).
    pub fingerprint: u64,
    /// A storage pixel whose fragments and steps are to be reported.
    pub watch: Option<u32>,
    /// Check memory after every step of the store pass.
    pub check: bool,
}

/// The most lanes a warp has.
pub const MAX_WARP: u32 = 1_024;

/// The policy that the settings name.
///
/// # Errors
/// A warp of no or too many lanes, or a schedule that cannot be read.
pub fn make(scheduling: &Scheduling) -> Result<Box<dyn Scheduler>> {
    Ok(Box::new(Any::new(scheduling)?))
}
