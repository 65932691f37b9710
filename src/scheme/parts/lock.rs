//! The spin lock that k+-buffers share: one word per pixel, 0 when free (k+-buffer paper, Algorithm 1).
//!
//! It is used as published, with the critical section *inside* the loop, so that a lane that wins can leave while the
//! others of its warp try again:
//!
//! ```text
//! let mark = mem.mark();
//! loop {
//!     if lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
//!         ...;
//!         lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
//!         return
//!     }
//!     mem.spin(mark).await
//! }
//! ```
//!
//! Each use says how it is taken and released, since that is where published shaders differ: the correct ways are an
//! acquire exchange, and a release store of 0.

pub mod reach;

use std::future::Future;

use crate::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Snapshot, Words};

/// What a method with a lock needs.
pub const NEEDS: &str =
    "acquire and release on a 32-bit word; forward progress of the lock's holder";

/// How WGSL can express it.
pub const WGSL: Option<&str> =
    Some("storage buffers; a lock is outside WGSL's guarantees (relaxed atomics only)");

/// What a try returns when it got the lock.
pub const FREE: u32 = 0;

/// What a holder leaves in the word.
const TAKEN: u32 = 1;

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
    pub fn try_acquire<M: Memory>(
        self,
        mem: &M,
        pixel: u32,
        order: Order,
    ) -> impl Future<Output = u32> + Unpin {
        mem.exchange(self.0.at(pixel, 0), TAKEN, order)
    }

    /// Release it by a write.
    #[inline(always)]
    #[track_caller]
    pub fn release<M: Memory>(
        self,
        mem: &M,
        pixel: u32,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        mem.write(self.0.at(pixel, 0), FREE, access)
    }

    /// Release it by an exchange, as shaders without an atomic store do. Gives the old value.
    #[inline(always)]
    #[track_caller]
    pub fn exchange_free<M: Memory>(
        self,
        mem: &M,
        pixel: u32,
        order: Order,
    ) -> impl Future<Output = u32> + Unpin {
        mem.exchange(self.0.at(pixel, 0), FREE, order)
    }

    /// Whether an invocation holds it; `None` if the word was never written.
    ///
    /// # Errors
    /// The word holds a value that is neither free nor taken.
    pub fn is_held(self, words: &Snapshot<'_>, pixel: u32) -> Result<Option<bool>, String> {
        match words.get(self.0.at(pixel, 0)) {
            None => Ok(None),
            Some(FREE) => Ok(Some(false)),
            Some(TAKEN) => Ok(Some(true)),
            Some(other) => Err(format!("the lock holds {other}")),
        }
    }

    /// The word itself, for memories made by hand.
    #[cfg(test)]
    pub(in crate::scheme) fn word(self, pixel: u32) -> crate::memory::At<Pixel, Atomic, u32> {
        self.0.at(pixel, 0)
    }
}
