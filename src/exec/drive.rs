//! The one place where ready futures are polled.
//!
//! On native and exclusive memory every operation is ready at once, so one poll runs an invocation to its end and the
//! compiler removes the machinery, *if* the poll is inlined. It is inlined when a (scheme, memory) pair is polled in a
//! single place: here, for executors, tests and benchmarks alike. A scheme inside of another one is polled on a memory
//! of another type, [`Inside`](crate::memory::Inside). A part of a scheme that holds an array is polled by the memory
//! itself ([`Memory::part`]).
//!
//! Executors see a scheme through [`Pipeline`], in batches: they are compiled once for all schemes.

use std::ops::Range;

pub use crate::memory::complete;
use crate::memory::{Memory, Order};
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::{Held, HeldKind, Holds, Outcomes, Readback, Scheme};

/// Where the lists of pixels end that lie one after another.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    /// In entries, for each pixel.
    pub entries: Vec<u32>,
    /// Fragments that resolve merged into others, of all pixels so far; empty if none ever is.
    pub merged: Vec<u32>,
}

impl Ends {
    /// Another pixel, after which so many entries are held.
    #[inline]
    pub fn push<H: Holds>(&mut self, held: &H) {
        self.entries.push(held.entries() as u32);
        if H::KIND == HeldKind::Records {
            self.merged.push(held.merged());
        }
    }
}

/// A scheme on one kind of memory, without its type.
pub trait Pipeline<M>: Sync {
    /// Clear the frame's own words.
    fn clear_frame(&self, mem: &M);
    /// Clear a range of pixels.
    fn clear(&self, mem: &M, pixels: Range<u32>);
    /// Run an earlier geometry pass for fragments, one after another.
    fn prepare(&self, mem: &M, pass: usize, batch: &Batch);
    /// Whether an earlier geometry pass does nothing but count fragments. If so, run it for the pixels from `first` on,
    /// which have so many; of none, it only tells.
    fn count(&self, mem: &M, pass: usize, first: u32, counts: &[u32]) -> bool {
        let _ = (mem, pass, first, counts);
        false
    }
    /// Run a full-screen pass for a range of pixels.
    fn screen(&self, mem: &M, pass: usize, pixels: Range<u32>);
    /// Run a part of a pass over the frame's words.
    fn frame(&self, mem: &M, pass: usize, indices: Range<u32>);
    /// How many invocations such a pass has.
    fn invocations(&self, pass: usize) -> u32;
    /// Store fragments one after another, or at once where the scheme knows how ([`Scheme::store_block`]).
    fn store(&self, mem: &M, batch: &Batch, outcomes: &mut Outcomes);
    /// How many batches of the block at `first` are stored at once, one block after another; 0 if a tile stores in the
    /// order of primitives ([`Scheme::together`]).
    fn together(&self, mem: &M, first: u32) -> usize {
        let _ = (mem, first);
        0
    }
    /// Store that many of them, or fewer: at once, or one after another.
    fn store_together(&self, mem: &M, batches: &[Batch], outcomes: &mut [Outcomes]) {
        let _ = (mem, batches, outcomes);
    }
    /// Add what these pixels hold to `held`, one after another, and to `ends` where each ends there: in lists, by
    /// entries. Returns whether any of them needs another round.
    fn resolve_all(
        &self,
        mem: &M,
        pixels: Range<u32>,
        held: &mut Held,
        ends: Option<&mut Ends>,
    ) -> bool;
    /// Add what a pixel holds to `held`. Returns whether it needs another round.
    fn resolve(&self, mem: &M, pixel: u32, held: &mut Held) -> bool {
        self.resolve_all(mem, pixel..pixel + 1, held, None)
    }
    /// What is read back after the frame.
    fn readback(&self) -> Option<Readback>;
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

    fn count(&self, mem: &M, pass: usize, first: u32, counts: &[u32]) -> bool {
        let Some(words) = self.counts(pass) else { return false };
        for (pixel, &count) in (first..).zip(counts) {
            complete(mem.add(words.at(pixel, 0), count, Order::Relaxed));
        }
        true
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

    fn store(&self, mem: &M, batch: &Batch, outcomes: &mut Outcomes) {
        outcomes.reset();
        let block = mem.owned_block(batch.first());
        if block.is_some_and(|block| self.store_block(&block, batch, outcomes)) {
            return;
        }
        for bit in bits(batch.mask()) {
            outcomes.set(bit, complete(Scheme::store(self, mem, batch.get(bit))));
        }
    }

    fn together(&self, mem: &M, first: u32) -> usize {
        mem.owned_block(first).map_or(0, |_| Scheme::together(self))
    }

    fn store_together(&self, mem: &M, batches: &[Batch], outcomes: &mut [Outcomes]) {
        outcomes.iter_mut().for_each(Outcomes::reset);
        let block = batches.first().and_then(|batch| mem.owned_block(batch.first()));
        if block.is_some_and(|block| Scheme::store_together(self, &block, batches, outcomes)) {
            return;
        }
        for (batch, outcomes) in batches.iter().zip(outcomes) {
            Pipeline::store(self, mem, batch, outcomes);
        }
    }

    fn resolve_all(
        &self,
        mem: &M,
        pixels: Range<u32>,
        held: &mut Held,
        mut ends: Option<&mut Ends>,
    ) -> bool {
        let mut again = false;
        let holds = S::Holds::of(held);
        for pixel in pixels {
            // The only call, so that it is part of this loop and its state stays in registers.
            complete(Scheme::resolve(self, mem, pixel, holds));
            if let Some(ends) = &mut ends {
                ends.push(holds);
            }
            again |= S::CONTRACT.program.repeats && complete(Scheme::again(self, mem, pixel));
        }
        again
    }

    fn readback(&self) -> Option<Readback> {
        Scheme::readback(self)
    }
}
