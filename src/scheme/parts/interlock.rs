//! The ordered interlock: of one pixel's fragments, one at a time is inside, in API order (Intel's pixel
//! synchronisation, Salvi 2013; `ARB_fragment_shader_interlock`; raster-order views).
//!
//! On a device the hardware grants it. Here the executor numbers each pixel's fragments in API order, and a word per
//! pixel says which fragment's turn it is; that word stands for the hardware and is not the method's. It is used like a
//! lock, with the critical section inside the loop:
//!
//! ```text
//! let mark = mem.mark();
//! loop {
//!     if interlock.turn(mem, fragment).await == fragment.extra {
//!         ...;
//!         interlock.leave(mem, fragment).await;
//!         return
//!     }
//!     mem.spin(mark).await
//! }
//! ```
//!
//! What one fragment wrote inside is visible to the next one inside, as those extensions promise. Fixed-function
//! blending and stencil tests are ordered in the same way.

use std::future::Future;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};

/// One turn per pixel.
#[derive(Clone, Copy, Debug)]
pub struct Interlock(Words<Pixel, Atomic, u32>);

impl Interlock {
    /// Declare the word.
    #[must_use]
    pub fn new(layout: &mut Layout) -> Self {
        Self(layout.interlock())
    }

    /// Let the first fragment enter, in the clear pass.
    #[inline(always)]
    #[track_caller]
    pub fn clear<M: Memory>(self, mem: &M, pixel: u32) -> impl Future<Output = ()> + Unpin {
        mem.store(self.0.at(pixel, 0), 0, Order::Relaxed)
    }

    /// The rank of the fragment that may enter; the caller may, if it equals its fragment's rank.
    #[inline(always)]
    #[track_caller]
    pub fn turn<M: Memory>(self, mem: &M, fragment: Fragment) -> impl Future<Output = u32> + Unpin {
        mem.load(self.0.at(fragment.pixel, 0), Order::Acquire)
    }

    /// Let the next fragment enter.
    #[inline(always)]
    #[track_caller]
    pub fn leave<M: Memory>(self, mem: &M, fragment: Fragment) -> impl Future<Output = ()> + Unpin {
        mem.store(self.0.at(fragment.pixel, 0), fragment.extra + 1, Order::Release)
    }
}
