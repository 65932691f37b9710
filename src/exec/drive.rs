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
use crate::scheme::{Held, HeldKind, Holds, Outcome, Readback, Scheme};

/// The outcomes of a batch, a byte for each fragment at its bit.
#[derive(Clone, Debug)]
pub struct Outcomes {
    codes: [u8; 64],
}

impl Default for Outcomes {
    fn default() -> Self {
        Self { codes: [Outcome::Kept as u8; 64] }
    }
}

impl Outcomes {
    /// For another batch, of fragments at these bits. What is not set is kept.
    #[inline]
    pub fn reset(&mut self, mask: u64) {
        if mask != u64::MAX {
            *self = Self::default();
        }
    }

    /// What became of the fragment at a bit.
    #[inline]
    pub fn set(&mut self, bit: u32, outcome: Outcome) {
        self.codes[bit as usize & 63] = outcome as u8;
    }

    /// The bits of the fragments that were not kept.
    #[inline]
    #[must_use]
    pub fn gone(&self) -> u64 {
        const LOW: u64 = 0x7F7F_7F7F_7F7F_7F7F;
        let mut gone = 0;
        for (i, bytes) in self.codes.as_chunks().0.iter().enumerate() {
            let bytes = u64::from_le_bytes(*bytes);
            // The upper bit of every byte that is not 0, then these eight side by side.
            let upper = (((bytes & LOW) + LOW) | bytes) & !LOW;
            gone |= ((upper >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i);
        }
        gone
    }

    /// The code of the first one's.
    #[must_use]
    pub fn first(&self) -> u32 {
        self.codes[0].into()
    }

    /// How many have this outcome, of at most 64; those at bits that are not set count as kept.
    #[inline]
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u64 {
        u64::from(self.codes.iter().map(|&code| u8::from(code == outcome as u8)).sum::<u8>())
    }
}

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
    /// Store fragments one after another.
    fn store(&self, mem: &M, batch: &Batch, outcomes: &mut Outcomes);
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
        outcomes.reset(batch.mask());
        for bit in bits(batch.mask()) {
            outcomes.set(bit, complete(Scheme::store(self, mem, batch.get(bit))));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_are_counted_and_found_by_their_bits() {
        let all = [
            Outcome::Kept,
            Outcome::Culled,
            Outcome::Evicted,
            Outcome::Overflow,
            Outcome::Pool,
            Outcome::Duplicate,
            Outcome::Age,
            Outcome::Merged,
        ];
        let mut outcomes = Outcomes::default();
        for round in 0..8 {
            outcomes.reset(u64::MAX);
            let of = |bit: u32| all[((bit * bit + round) % 11 % 8) as usize];
            (0..64).for_each(|bit| outcomes.set(bit, of(bit)));
            for outcome in all {
                let count = (0..64).filter(|&bit| of(bit) == outcome).count();
                assert_eq!(outcomes.count(outcome), count as u64, "{outcome:?}");
            }
            let gone: u64 =
                (0..64).filter(|&bit| of(bit) != Outcome::Kept).map(|bit| 1 << bit).sum();
            assert_eq!(outcomes.gone(), gone);
        }
        outcomes.reset(5);
        assert_eq!(
            (outcomes.gone(), outcomes.count(Outcome::Kept)),
            (0, 64),
            "nothing is left over"
        );
    }
}
