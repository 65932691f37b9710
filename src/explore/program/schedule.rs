//! Schedules of litmus pixels: which invocation moves, and which of the possible values the move reads.

use serde::{Deserialize, Serialize};

/// One step of one invocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Move {
    /// The invocation, in the order of the litmus pixel's tasks.
    pub invocation: u8,
    /// Which of the values that it may read; 0 under sequential consistency, unless the word was never written. For an
    /// access outside of a buffer, 0 drops it, and the others are those of the buffer's last word, one higher.
    pub alternative: u16,
}

/// The moves of a run, from its beginning.
pub type Schedule = Vec<Move>;

/// How often a schedule switches from one invocation to another although it could have continued with the first.
#[must_use]
pub fn switches(schedule: &[Move]) -> usize {
    schedule.windows(2).filter(|pair| pair[0].invocation != pair[1].invocation).count()
}
