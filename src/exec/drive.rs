//! The one place where ready futures are polled.
//!
//! On native and exclusive memory every operation is ready at once, so one poll runs an invocation to its end and the
//! compiler removes the machinery, *if* the poll is inlined. It is inlined when a (scheme, memory) pair is polled in a
//! single place: here, for executors, tests and benchmarks alike. A scheme inside of another one is polled on a memory
//! of another type, [`Inside`](crate::memory::Inside).
//!
//! Executors see a scheme through [`Pipeline`], in batches: they are compiled once for all schemes.

use std::future::Future;
use std::ops::Range;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::memory::Memory;
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::{Held, Holds, Outcome, Readback, Scheme};

/// Outcomes of a batch, at the bits of its fragments.
pub type Outcomes = [Outcome; 64];

/// A scheme on one kind of memory, without its type.
pub trait Pipeline<M>: Sync {
    /// Clear the frame's own words.
    fn clear_frame(&self, mem: &M);
    /// Clear a range of pixels.
    fn clear(&self, mem: &M, pixels: Range<u32>);
    /// Run an earlier geometry pass for fragments, one after another.
    fn prepare(&self, mem: &M, pass: usize, batch: &Batch);
    /// Run a full-screen pass for a range of pixels.
    fn screen(&self, mem: &M, pass: usize, pixels: Range<u32>);
    /// Run a part of a pass over the frame's words.
    fn frame(&self, mem: &M, pass: usize, indices: Range<u32>);
    /// How many invocations such a pass has.
    fn invocations(&self, pass: usize) -> u32;
    /// Store fragments one after another. Gives the bits of those whose outcome is not [`Outcome::Kept`].
    fn store(&self, mem: &M, batch: &Batch, outcomes: &mut Outcomes) -> u64;
    /// Add what a pixel holds to `held`. Returns whether it needs another round.
    fn resolve(&self, mem: &M, pixel: u32, held: &mut Held) -> bool;
    /// What is read back after the frame.
    fn readback(&self) -> Option<Readback>;
}

/// The result of a future that never waits.
///
/// # Panics
/// If it waits, that is, if it runs on a memory whose operations are not ready.
#[allow(clippy::inline_always, reason = "see the module's text")]
#[inline(always)]
pub fn complete<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => panic!("an operation of this memory is not ready"),
    }
}

impl<S: Scheme, M: Memory> Pipeline<M> for S {
    fn clear_frame(&self, mem: &M) {
        complete(Scheme::clear_frame(self, mem));
    }

    fn clear(&self, mem: &M, pixels: Range<u32>) {
        for pixel in pixels {
            complete(Scheme::clear(self, mem, pixel));
        }
    }

    fn prepare(&self, mem: &M, pass: usize, batch: &Batch) {
        for fragment in batch.iter() {
            complete(Scheme::prepare(self, mem, pass, fragment));
        }
    }

    fn screen(&self, mem: &M, pass: usize, pixels: Range<u32>) {
        for pixel in pixels {
            complete(Scheme::screen(self, mem, pass, pixel));
        }
    }

    fn frame(&self, mem: &M, pass: usize, indices: Range<u32>) {
        for index in indices {
            complete(Scheme::frame(self, mem, pass, index));
        }
    }

    fn invocations(&self, pass: usize) -> u32 {
        Scheme::invocations(self, pass)
    }

    fn store(&self, mem: &M, batch: &Batch, outcomes: &mut Outcomes) -> u64 {
        let mut gone = 0;
        for bit in bits(batch.mask()) {
            let outcome = complete(Scheme::store(self, mem, batch.get(bit)));
            outcomes[bit as usize & 63] = outcome;
            gone |= u64::from(outcome != Outcome::Kept) << bit;
        }
        gone
    }

    fn resolve(&self, mem: &M, pixel: u32, held: &mut Held) -> bool {
        complete(Scheme::resolve(self, mem, pixel, S::Holds::of(held)));
        S::CONTRACT.program.repeats && complete(Scheme::again(self, mem, pixel))
    }

    fn readback(&self) -> Option<Readback> {
        Scheme::readback(self)
    }
}
