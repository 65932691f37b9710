//! Memory models: what an operation may find.
//!
//! A model keeps the words of one state, encoded as a slice that equals another's exactly when the states do. The
//! explorer loads a state, performs one operation in one of its alternatives, and stores the state that follows.

use crate::memory::asked::Action;
use crate::memory::{Access, Order, Update};

/// How memory behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MemoryModel {
    /// Sequential consistency: an operation is a step, and all invocations see the same order of steps.
    Sequential,
    /// Release and acquire without load buffering: see `relaxed`.
    Relaxed(Profile),
}

/// How a shading language treats the memory orders that a scheme is written with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Profile {
    /// As written: the Vulkan memory model has release and acquire.
    Vulkan,
    /// GLSL: atomics are relaxed; acquire is a relaxed operation before a memory barrier, release one after it; images
    /// are `coherent`, so a plain access behaves as a relaxed one and is not reported as a race.
    Glsl,
    /// WGSL: every atomic is relaxed, whatever was written. A lock is outside of what the language guarantees.
    Wgsl,
}

impl MemoryModel {
    /// The name on the command line, without the profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sequential => "sc",
            Self::Relaxed(_) => "relaxed",
        }
    }

    /// The profile's name.
    #[must_use]
    pub fn profile(self) -> Option<&'static str> {
        match self {
            Self::Sequential => None,
            Self::Relaxed(profile) => Some(profile.name()),
        }
    }

    /// The text that a verdict under this model must contain.
    #[must_use]
    pub fn bound(self) -> &'static str {
        match self {
            Self::Sequential => "sequentially consistent",
            Self::Relaxed(_) => "relaxed, without load buffering",
        }
    }
}

impl std::fmt::Display for MemoryModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.profile() {
            None => f.write_str(self.name()),
            Some(profile) => write!(f, "{}/{profile}", self.name()),
        }
    }
}

impl Profile {
    /// All.
    pub const ALL: [Self; 3] = [Self::Vulkan, Self::Glsl, Self::Wgsl];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Vulkan => "vulkan",
            Self::Glsl => "glsl",
            Self::Wgsl => "wgsl",
        }
    }

    /// The order that remains, and whether a barrier stands before and after the operation.
    pub(in crate::explore) fn order(self, order: Order) -> (Order, Fences) {
        let (before, after) = match order {
            Order::Relaxed => (false, false),
            Order::Acquire => (false, true),
            Order::Release => (true, false),
            Order::AcqRel => (true, true),
        };
        match self {
            Self::Vulkan => (order, Fences::default()),
            Self::Glsl => (Order::Relaxed, Fences { before, after }),
            Self::Wgsl => (Order::Relaxed, Fences::default()),
        }
    }

    /// Whether a plain access that conflicts with an unordered one is a data race.
    pub(in crate::explore) fn has_races(self) -> bool {
        self != Self::Glsl
    }
}

/// Memory barriers around an operation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::explore) struct Fences {
    pub(in crate::explore) before: bool,
    pub(in crate::explore) after: bool,
}

/// Two unordered accesses, at least one of which is a write and at least one plain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::explore) struct Race {
    /// The earlier one's invocation.
    pub(in crate::explore) other: usize,
    /// The word.
    pub(in crate::explore) cell: u32,
    /// Whether the earlier access was a write.
    pub(in crate::explore) other_writes: bool,
    /// Whether the earlier access was plain.
    pub(in crate::explore) other_plain: bool,
}

/// A word's value in an initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::explore) enum Initial {
    /// As the clear pass left it.
    Written(u64),
    /// Any value: chosen when it is first read.
    Unwritten,
}

/// The words of one state under a memory model. Operations are on words that exist: what becomes of others is the
/// machine's.
pub(in crate::explore) trait Model: Send + Sync {
    /// The same words, to be worked on apart from these.
    fn copy(&self) -> Box<dyn Model>;

    /// Take up a state.
    fn load(&mut self, encoded: &[u32]);

    /// In how many ways the invocation's operation can go.
    fn alternatives(&mut self, invocation: usize, cell: u32, action: Action) -> usize;

    /// Perform it in one of these ways, and give the value that it reads, 0 for a write.
    fn perform(&mut self, invocation: usize, cell: u32, action: Action, alternative: usize) -> u64;

    /// The race that the last operation was part of.
    fn race(&self) -> Option<Race>;

    /// Whether the last operation put a value into its word's order that is less than the one before it, or more than
    /// the one behind it. Where writes are only ever appended, the values of the word tell that.
    fn descends(&self) -> bool {
        false
    }

    /// Whether there was no room for the last operation: it was not performed, and nothing follows from it.
    fn lost(&self) -> bool {
        false
    }

    /// Whether an operation was ever left out for lack of room: the exploration is then incomplete.
    fn full(&self) -> bool {
        false
    }

    /// Encode the state; `live` has a bit for every invocation that has not ended.
    fn store(&self, live: u32, into: &mut Vec<u32>);

    /// A barrier between passes: every invocation sees everything, and these words in addition; invocations that start
    /// now are new.
    fn barrier(&mut self, written: &std::collections::BTreeMap<u32, u64>);

    /// All values of a word that some invocation may still read, in the order in which memory has them; `None` for one
    /// that was never written.
    fn versions(&self, cell: u32) -> Vec<Option<u64>> {
        vec![self.settled(cell)]
    }

    /// The oldest of them that an invocation may still read.
    fn oldest(&self, _invocation: usize, _cell: u32) -> usize {
        0
    }

    /// Which of them the last operation read, and where it put one; `None` if each word has one value at a time.
    fn touched(&self) -> Option<Touched> {
        None
    }

    /// What a word holds once all invocations are ordered before the reader; `None` if it was never written.
    fn settled(&self, cell: u32) -> Option<u64>;
}

impl Clone for Box<dyn Model> {
    fn clone(&self) -> Self {
        self.copy()
    }
}

/// Which versions of its word an operation read and wrote.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::explore) struct Touched {
    /// The one that it read.
    pub(in crate::explore) read: Option<usize>,
    /// Where it put its own: those from there on go up by one.
    pub(in crate::explore) put: Option<usize>,
}

/// A value cut to a word's width.
pub(in crate::explore) fn cut(value: u64, bits: u32) -> u64 {
    if bits == 32 { value & 0xFFFF_FFFF } else { value }
}

/// The order of an access, if it is atomic.
pub(in crate::explore) fn order_of(action: Action) -> Option<Order> {
    match action {
        Action::Read(Access::Atomic(order))
        | Action::Write(_, Access::Atomic(order))
        | Action::Update(_, order) => Some(order),
        Action::Read(Access::Plain) | Action::Write(_, Access::Plain) => None,
    }
}

/// Whether an operation that read this value writes: a compare-exchange that fails does not.
pub(in crate::explore) fn writes(action: Action, read: u64) -> bool {
    match action {
        Action::Read(_) => false,
        Action::Update(Update::CompareExchange { expected, .. }, _) => expected == read,
        Action::Write(..) | Action::Update(..) => true,
    }
}
