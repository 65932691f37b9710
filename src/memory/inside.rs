//! The same memory under another type, for a scheme inside of another one.
//!
//! An `async fn` that is called from two places on one memory is one future, polled in two places. The compiler then
//! makes one function of it, with its state in memory, and every caller becomes slower: `kplus-heap` took more than
//! twice as long. On this memory, the futures of a scheme inside of another scheme have a type of their own. A shared
//! step that runs for every fragment takes its caller's type as a parameter instead, for the same reason.

use std::future::Future;
use std::marker::PhantomData;

use bytemuck::TransparentWrapper;

use super::{
    Access, At, Atomic, Block, Event, InputAt, Kind, Mark, Memory, Order, Pool, Space, Update, Word,
};

/// A memory, inside of scheme `S`. It is only ever seen through the reference to the memory: if a future held one of its
/// own, and a reference to that, its whole state would have to be memory.
#[derive(Debug, TransparentWrapper)]
#[transparent(M)]
#[repr(transparent)]
pub struct Inside<M, S> {
    mem: M,
    scheme: PhantomData<fn(S)>,
}

impl<M, S> Inside<M, S> {
    /// The memory that a scheme hands on.
    #[allow(clippy::inline_always, reason = "see `Memory`")]
    #[inline(always)]
    #[must_use]
    pub fn of(mem: &M) -> &Self {
        Self::wrap_ref(mem)
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<M: Memory, T> Memory for Inside<M, T> {
    #[inline(always)]
    #[track_caller]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        self.mem.read(at, access)
    }

    #[inline(always)]
    #[track_caller]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        self.mem.write(at, value, access)
    }

    #[inline(always)]
    #[track_caller]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        self.mem.update(at, update, order)
    }

    #[inline(always)]
    #[track_caller]
    fn input(&self, at: InputAt) -> u32 {
        self.mem.input(at)
    }

    #[inline(always)]
    #[track_caller]
    fn spin(&self, mark: Mark) -> impl Future<Output = ()> + Unpin {
        self.mem.spin(mark)
    }

    #[inline(always)]
    fn mark(&self) -> Mark {
        self.mem.mark()
    }

    #[inline(always)]
    #[track_caller]
    fn here(&self, live: &[u64]) {
        self.mem.here(live);
    }

    #[inline(always)]
    fn note(&self, event: Event) {
        self.mem.note(event);
    }

    #[inline(always)]
    #[track_caller]
    fn block(&self) -> Block {
        self.mem.block()
    }

    #[inline(always)]
    #[track_caller]
    fn merge(&self, block: Block) -> impl Future<Output = ()> + Unpin {
        self.mem.merge(block)
    }

    #[inline(always)]
    fn part<F: Future>(&self, part: F) -> impl Future<Output = F::Output> {
        self.mem.part(part)
    }

    #[inline(always)]
    #[track_caller]
    fn take(&self, pool: Pool) -> impl Future<Output = u32> + Unpin {
        self.mem.take(pool)
    }
}
