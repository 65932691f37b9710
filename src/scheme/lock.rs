//! The spin lock that k+-buffers share: one word per pixel, 0 when free (k+-buffer paper, Algorithm 1).
//!
//! It is used as published, with the critical section *inside* the loop, so that a lane that wins can leave while the
//! others of its warp try again:
//!
//! ```text
//! let mark = mem.mark();
//! loop {
//!     if lock.try_acquire(mem, pixel).await == FREE { ...; lock.release(mem, pixel, order).await; return }
//!     mem.spin(mark).await
//! }
//! ```
//!
//! Taking it is an acquire exchange. Releasing it takes an order, since that is where published shaders differ: the
//! correct one is `Release`.

use std::future::Future;

use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};

/// What a try returns when it got the lock.
pub const FREE: u32 = 0;

/// One lock per pixel.
#[derive(Clone, Copy, Debug)]
pub struct SpinLock(Words<Pixel, Atomic, u32>);

impl SpinLock {
    /// Declare the word.
    #[must_use]
    pub fn new(layout: &mut Layout) -> Self {
        Self(layout.lock())
    }

    /// Free it, in the clear pass.
    #[inline(always)]
    #[track_caller]
    pub fn clear<M: Memory>(self, mem: &M, pixel: u32) -> impl Future<Output = ()> + Unpin {
        mem.store(self.0.at(pixel, 0), FREE, Order::Relaxed)
    }

    /// Try once; [`FREE`] if the caller now holds it.
    #[inline(always)]
    #[track_caller]
    pub fn try_acquire<M: Memory>(self, mem: &M, pixel: u32) -> impl Future<Output = u32> + Unpin {
        mem.exchange(self.0.at(pixel, 0), 1, Order::Acquire)
    }

    /// Give it back.
    #[inline(always)]
    #[track_caller]
    pub fn release<M: Memory>(
        self,
        mem: &M,
        pixel: u32,
        order: Order,
    ) -> impl Future<Output = ()> + Unpin {
        mem.store(self.0.at(pixel, 0), FREE, order)
    }
}
