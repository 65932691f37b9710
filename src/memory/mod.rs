//! The shader's view of memory.
//!
//! A scheme is an `async fn` generic over [`Memory`]; each access to shared memory is one `.await`. What an access *is*
//! depends on the memory: a std atomic ([`native`]), a plain cell of a tile that one worker owns ([`exclusive`]), or
//! one step of a simulated device that chooses which invocation goes next ([`sim`]). The memory for loom is in the
//! tests.
//!
//! The operations are WGSL's atomics plus what WGSL lacks: memory orderings, and GLSL's plain store to an atomic word
//! (the papers' unlock). A word is declared atomic or plain, 32 or 64 bits, and belongs to a pixel or to the frame
//! ([`layout`]); all of that is in its type, so that a plain word cannot be exchanged and the choice of storage costs
//! nothing at run time.
//!
//! Ready operations return [`std::future::Ready`], never an `async` block: only then does the compiler remove the
//! machinery (`benches/async_overhead.rs` guards that).

pub mod arena;
pub mod asked;
mod both;
pub mod count;
mod each;
pub mod exclusive;
mod inside;
pub mod layout;
pub mod native;
mod perform;
pub mod probe;
pub mod reuse;
pub mod sim;
pub mod word;

use std::future::Future;

pub use both::{Both, both, complete};
pub use count::{Counters, Observer};
pub use each::{Each, each};
pub use exclusive::block::OwnedBlock;
pub use inside::Inside;
pub use layout::{
    Address, Ahead, At, Atomic, Declared, Global, Growing, Input, InputAt, Inputs, Kind, Layout,
    Numbering, Per, Pixel, Plain, Pool, Snapshot, Space, Words,
};
pub use perform::perform;
pub use word::Word;

/// How an atomic operation is ordered against others, as in C++ and Rust (there is no sequentially consistent one:
/// neither Vulkan nor WGSL has it).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Order {
    /// Atomic, and nothing else.
    Relaxed,
    /// What the writer did before its release is visible after this read.
    Acquire,
    /// What was done before this write is visible to an acquire that reads it.
    Release,
    /// Both, for a read-modify-write.
    AcqRel,
}

/// How a read or write reaches its word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// Not atomic: a data race if another invocation conflicts.
    Plain,
    /// Atomic, with an order.
    Atomic(Order),
}

/// A read-modify-write; each returns the old value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Update<W> {
    /// Write the value.
    Exchange(W),
    /// Write `new` if the old value is `expected`. Strong: it does not fail otherwise.
    CompareExchange {
        /// What must be there.
        expected: W,
        /// What is then written.
        new: W,
    },
    /// Add, wrapping.
    Add(W),
    /// Bitwise and.
    And(W),
    /// Bitwise or.
    Or(W),
    /// The smaller of both, unsigned.
    Min(W),
    /// The larger of both, unsigned.
    Max(W),
}

impl<W: Word> Update<W> {
    /// The same update of words of another width.
    #[inline(always)]
    #[must_use]
    pub fn map<V: Word>(self, word: impl Fn(W) -> V) -> Update<V> {
        match self {
            Self::Exchange(v) => Update::Exchange(word(v)),
            Self::CompareExchange { expected, new } => {
                Update::CompareExchange { expected: word(expected), new: word(new) }
            }
            Self::Add(v) => Update::Add(word(v)),
            Self::And(v) => Update::And(word(v)),
            Self::Or(v) => Update::Or(word(v)),
            Self::Min(v) => Update::Min(word(v)),
            Self::Max(v) => Update::Max(word(v)),
        }
    }

    /// What the word holds afterwards.
    #[inline(always)]
    #[must_use]
    pub fn apply(self, old: W) -> W {
        match self {
            Self::Exchange(new) => new,
            Self::CompareExchange { expected, new } => {
                if old == expected {
                    new
                } else {
                    old
                }
            }
            Self::Add(v) => old.wrapping_add(v),
            Self::And(v) => old.and(v),
            Self::Or(v) => old.or(v),
            Self::Min(v) => old.min(v),
            Self::Max(v) => old.max(v),
        }
    }

    /// Whether an exchange failed: it found its own value (a lock already taken), or a compare-exchange found another.
    #[inline(always)]
    #[must_use]
    pub fn failed(self, old: W) -> bool {
        match self {
            Self::Exchange(new) => old == new,
            Self::CompareExchange { expected, .. } => old != expected,
            _ => false,
        }
    }
}

/// What an invocation is doing, for counters only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// It looks at a cell of a hash table.
    Probe,
    /// It has pushed a record out of its cell.
    Eviction,
    /// It has read a word of an input.
    Input,
}

/// A place in an invocation that a wait goes back to: see [`Memory::mark`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark(pub u32);

/// An open block: see [`Memory::block`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block(pub u32);

/// Shared memory, as a shader invocation sees it. An implementation has four operations; a scheme uses the named ones
/// below them.
///
/// An access outside of a memory's words, which only a faulty scheme makes, does what robust buffer access does
/// (Vulkan's `robustBufferAccess`): a read gives 0, a write has no effect, an update gives 0 and has no effect. The
/// memory counts it. Checks also try that it hits the buffer's last word, to which other devices clamp it.
#[allow(clippy::inline_always, reason = "the cost of a scheme is the cost of these operations")]
pub trait Memory {
    /// Read a word.
    #[track_caller]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin;

    /// Write a word.
    #[track_caller]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin;

    /// Read, modify and write a word in one atomic operation; the old value.
    #[track_caller]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin;

    /// Read a word of an input. It is not an operation: no invocation writes an input, so the order of reads cannot be
    /// observed.
    #[track_caller]
    fn input(&self, at: InputAt) -> u32;

    /// Say that this invocation waits for another one and is about to try again from `mark`.
    ///
    /// It claims that what follows is what followed the mark: nothing was carried over, no attempt was counted. Search
    /// relies on that to end, and checks it.
    #[track_caller]
    fn spin(&self, mark: Mark) -> impl Future<Output = ()> + Unpin;

    /// The place before an attempt that may have to be repeated.
    #[inline(always)]
    fn mark(&self) -> Mark {
        Mark(0)
    }

    /// Say that from here on this invocation depends on these values and on nothing else that it has seen. Not an
    /// operation.
    ///
    /// Like [`Memory::spin`], this is a claim. Search treats two invocations of one task as the same if they stand at
    /// the same place with the same values, and checks the claim. Good for loops whose iterations carry little over.
    #[inline(always)]
    #[track_caller]
    fn here(&self, live: &[u64]) {
        let _ = live;
    }

    /// Count an event; not an operation.
    #[inline(always)]
    fn note(&self, event: Event) {
        let _ = event;
    }

    /// Open a block: a loop or a branch with operations in it, after which the lanes of a warp come together again
    /// ([`Memory::merge`], the merge instruction of SPIR-V). A scheme gets a verdict on SIMT reconvergence if every
    /// loop and branch with operations is a block. Only a return, or a break that leaves an outer block at that block's
    /// merge, may leave a block without its merge.
    #[inline(always)]
    #[track_caller]
    fn block(&self) -> Block {
        Block(0)
    }

    /// Where a block ends.
    #[inline(always)]
    #[track_caller]
    fn merge(&self, block: Block) -> impl Future<Output = ()> + Unpin {
        let _ = block;
        std::future::ready(())
    }

    /// Run a part of an invocation that holds an array or a record across operations. Not an operation.
    ///
    /// Where operations are ready, the part runs at once, as a function of its own: what it holds is on the stack, or in
    /// registers, and not in the invocation's state, all of which would have to be memory for its sake.
    #[inline(always)]
    fn part<F: Future>(&self, part: F) -> impl Future<Output = F::Output> {
        part
    }

    /// Take a pool's next index: `atomicAdd` of 1 (or GLSL's `atomicCounterIncrement`). A memory that knows which
    /// indices its invocations will need may hand them out itself ([`layout::pool`]).
    #[inline(always)]
    #[track_caller]
    fn take(&self, pool: Pool) -> impl Future<Output = u32> + Unpin {
        self.update(pool.counter(), Update::Add(1), Order::Relaxed)
    }

    /// The words of the 64 pixels from `first` on, if this memory's worker owns them and nobody watches its operations:
    /// for [`Scheme::store_block`](crate::scheme::Scheme::store_block). Not an operation.
    #[inline(always)]
    fn owned_block(&self, first: u32) -> Option<OwnedBlock<'_>> {
        let _ = first;
        None
    }

    /// `atomicLoad`
    #[inline(always)]
    #[track_caller]
    fn load<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.read(at, Access::Atomic(order))
    }

    /// `atomicStore`
    #[inline(always)]
    #[track_caller]
    fn store<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = ()> + Unpin {
        self.write(at, value, Access::Atomic(order))
    }

    /// Read a plain word.
    #[inline(always)]
    #[track_caller]
    fn plain_load<S: Space, W: Word>(
        &self,
        at: At<S, Plain, W>,
    ) -> impl Future<Output = W> + Unpin {
        self.read(at, Access::Plain)
    }

    /// Write a plain word.
    #[inline(always)]
    #[track_caller]
    fn plain_store<S: Space, W: Word>(
        &self,
        at: At<S, Plain, W>,
        value: W,
    ) -> impl Future<Output = ()> + Unpin {
        self.write(at, value, Access::Plain)
    }

    /// GLSL's `imageStore` to a word that others access atomically: not atomic, not ordered.
    #[inline(always)]
    #[track_caller]
    fn plain_store_to_atomic<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
    ) -> impl Future<Output = ()> + Unpin {
        self.write(at, value, Access::Plain)
    }

    /// `atomicExchange`; the old value.
    #[inline(always)]
    #[track_caller]
    fn exchange<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::Exchange(value), order)
    }

    /// `atomicCompareExchange`, strong; the old value, which is `expected` if and only if `new` was written.
    #[inline(always)]
    #[track_caller]
    fn compare_exchange<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        expected: W,
        new: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::CompareExchange { expected, new }, order)
    }

    /// `atomicAdd`, wrapping; the old value.
    #[inline(always)]
    #[track_caller]
    fn add<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::Add(value), order)
    }

    /// `atomicAnd`; the old value.
    #[inline(always)]
    #[track_caller]
    fn and<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::And(value), order)
    }

    /// `atomicOr`; the old value.
    #[inline(always)]
    #[track_caller]
    fn or<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::Or(value), order)
    }

    /// `atomicMin`, unsigned; the old value.
    #[inline(always)]
    #[track_caller]
    fn min<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::Min(value), order)
    }

    /// `atomicMax`, unsigned; the old value.
    #[inline(always)]
    #[track_caller]
    fn max<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.update(at, Update::Max(value), order)
    }
}
