//! What a search is given, and what it gives: when to stop, what it found, and why it has not seen everything.

use std::collections::{BTreeMap, BTreeSet};

use super::property::Property;
use crate::explore::program::schedule::Schedule;
use crate::scheme::Held;

/// When to stop.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// States per instance.
    pub states: usize,
    /// Whether the user has cancelled.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl std::fmt::Debug for Limits<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} states", self.states)
    }
}

/// Why a search is not complete.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// There are more states than the limit, of so many bytes each.
    States {
        /// The limit.
        limit: usize,
        /// Bytes of a state, with what a search keeps of it.
        bytes: usize,
    },
    /// The user has cancelled.
    Cancelled,
    /// An invocation has not ended after so many operations, the last one here.
    Endless {
        /// File, line and column.
        site: String,
        /// Operations.
        operations: usize,
    },
    /// The scheme's code panics: what would follow was not explored.
    Panics,
    /// A word, or the rounds of a program, had no room.
    Full,
}

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::States { limit, bytes } => {
                let more = (limit * 4 * bytes).div_ceil(1 << 20);
                write!(
                    f,
                    "there are more than {limit} states: raise --max-states (four times as many take up to {more} MiB \
                     for an instance and four times as long), or lower -n"
                )
            }
            Self::Cancelled => f.write_str("interrupted"),
            Self::Endless { site, operations } => write!(
                f,
                "{site}: an invocation has not ended after {operations} operations, the last one here. No option \
                 raises this bound: a loop that waits for others must say so, with `mem.mark()` before it and \
                 `mem.spin(mark).await` before it tries again; any other loop must end"
            ),
            Self::Panics => f.write_str("the scheme's code panics, and what would follow is not explored"),
            Self::Full => f.write_str(
                "a word had too many writes that can still be read, or a program too many rounds; no option raises \
                 this bound: lower -n",
            ),
        }
    }
}

/// A violation, and the first schedule that shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// What went wrong.
    pub message: String,
    /// The moves up to where it shows.
    pub schedule: Schedule,
}

/// The result of exploring an instance.
#[derive(Clone, Debug)]
pub struct Explored {
    /// Every state was visited.
    pub complete: bool,
    /// Why not, if not.
    pub stopped: Option<Stopped>,
    /// Distinct states.
    pub states: usize,
    /// Moves from them.
    pub transitions: usize,
    /// Bytes of the states and moves that it kept, but for the hash table's.
    pub bytes: usize,
    /// Complete interleavings, a repeated state not counted again; `None` if there are cycles, or above 2^127.
    pub executions: Option<u128>,
    /// Some invocation can repeat itself: there is a cycle, possibly of one step.
    pub cyclic: bool,
    /// Every final result, with a shortest schedule to it.
    pub outcomes: BTreeMap<Vec<Held>, Schedule>,
    /// The first violation of each property.
    pub violations: BTreeMap<Property, Found>,
    /// Operations and blocks reached: file, line, column.
    pub sites: BTreeSet<(&'static str, u32, u32)>,
    /// Waits outside of any block.
    pub bare_waits: usize,
    /// Comparisons of waits with the marks they go back to.
    pub claims: usize,
}

impl Explored {
    /// What is left of a search if the scheme's code panics outside of its invocations: where it is made, or where it
    /// says what it expects.
    pub(in crate::explore) fn panicked(message: String) -> Self {
        let found = Found { message, schedule: Vec::new() };
        Self {
            complete: false,
            stopped: Some(Stopped::Panics),
            states: 0,
            transitions: 0,
            bytes: 0,
            executions: None,
            cyclic: false,
            outcomes: BTreeMap::new(),
            violations: BTreeMap::from([(Property::Panics, found)]),
            sites: BTreeSet::new(),
            bare_waits: 0,
            claims: 0,
        }
    }
}
