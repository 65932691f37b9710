//! Contiguous ranges: where each pixel's records begin in one array (S-buffer: Vasilakis, Fudos 2012; the referencing
//! pass of Algorithm 3 of the k+-buffer paper).
//!
//! A geometry pass has counted the fragments of every pixel. Then follows a parallel prefix sum over non-empty pixels,
//! in three steps with a radix of 64:
//!
//! ```text
//! per pixel       offset = atomicAdd(sum of its block of 8x8 pixels, count)
//! per 64 blocks   their sums become starts; their total is the group's sum
//! once            the groups' sums become starts
//! ```
//!
//! A range begins at group + block + offset. Neighbouring pixels are neighbours in memory, as in the paper's square
//! tiling. Offsets within a block depend on the order of arrival; which records a pixel holds does not.

use crate::memory::{
    Atomic, Global, Layout, Memory, Order, OwnedBlock, Pixel, Plain, Snapshot, Words,
};
use crate::scheme::contract::Demand;
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keeps};

/// Pixels of a block, and blocks of a group.
const RADIX: u32 = 64;

/// Number of the counting pass in a program that begins with [`PASSES`]'s first.
pub const COUNT: usize = 0;
/// Number of the full-screen pass.
pub const REFER: usize = 1;
/// Number of the pass over blocks.
pub const BLOCKS: usize = 2;
/// Number of the pass over groups.
pub const GROUPS: usize = 3;

/// Count, sum up, store.
pub const PASSES: &[Pass] = &[
    Pass::new("count", PassKind::Prepare, Barrier::Pixel),
    Pass::new("refer", PassKind::Screen, Barrier::Pixel),
    Pass::new("sum blocks", PassKind::Frame, Barrier::Frame),
    Pass::new("sum groups", PassKind::Frame, Barrier::Frame),
    Pass::store(Barrier::Frame),
];

/// What methods that count first, and then store into ranges, have in common.
#[must_use]
pub const fn counted(name: &'static str, keeps: Keeps) -> Contract {
    Contract {
        program: Program::of(PASSES),
        frame_words: "2S + G + H",
        needs: "32-bit atomic add, relaxed; two geometry passes that generate the same fragments",
        wgsl: Some("storage buffers; atomicAdd"),
        demand: Demand::Bounded,
        ..Contract::new(name, keeps)
    }
}

/// The words of the sums.
#[derive(Clone, Copy, Debug)]
pub struct Ranges {
    offset: Words<Pixel, Plain, u32>,
    blocks: Words<Global, Atomic, u32>,
    groups: Words<Global, Plain, u32>,
}

impl Ranges {
    /// Declare a word for every pixel, block and group.
    #[must_use]
    pub fn new(config: &Config, layout: &mut Layout) -> Self {
        let blocks = config.pixels.div_ceil(RADIX);
        Self {
            offset: layout.named("offset").pixel(1),
            blocks: layout.named("blocks").global(u64::from(blocks)),
            groups: layout.named("groups").global(u64::from(blocks.div_ceil(RADIX))),
        }
    }

    /// Zero the blocks' sums.
    pub async fn clear_frame<M: Memory>(self, mem: &M) {
        for block in 0..self.blocks.count() {
            mem.store(self.blocks.at(block), 0, Order::Relaxed).await;
        }
    }

    /// The full-screen pass's part for a pixel with `count` records, at least one. `flag` comes back with the start.
    pub async fn refer<M: Memory>(self, mem: &M, pixel: u32, count: u32, flag: bool) {
        let block = self.blocks.at(u64::from(pixel / RADIX));
        let offset = mem.add(block, count, Order::Relaxed).await;
        mem.plain_store(self.offset.at(pixel, 0), offset << 1 | u32::from(flag)).await;
    }

    /// Invocations of a pass over the frame's words.
    #[must_use]
    pub fn invocations(self, pass: usize) -> u32 {
        if pass == BLOCKS { self.groups.count() as u32 } else { 1 }
    }

    /// An invocation of the passes over the frame's words.
    pub async fn sum<M: Memory>(self, mem: &M, pass: usize, index: u32) {
        let mut start = 0u32;
        if pass == BLOCKS {
            let first = u64::from(index) * u64::from(RADIX);
            for block in first..self.blocks.count().min(first + u64::from(RADIX)) {
                let sum = mem.load(self.blocks.at(block), Order::Relaxed).await;
                mem.store(self.blocks.at(block), start, Order::Relaxed).await;
                start = start.wrapping_add(sum);
            }
            mem.plain_store(self.groups.at(u64::from(index)), start).await;
        } else {
            for group in 0..self.groups.count() {
                let sum = mem.plain_load(self.groups.at(group)).await;
                mem.plain_store(self.groups.at(group), start).await;
                start = start.wrapping_add(sum);
            }
        }
    }

    /// Where a pixel's records begin, and its flag. Only for pixels that have records.
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub async fn start<M: Memory, Caller>(self, mem: &M, pixel: u32) -> (u64, bool) {
        let offset = mem.plain_load(self.offset.at(pixel, 0)).await;
        let block = mem.load(self.blocks.at(u64::from(pixel / RADIX)), Order::Relaxed).await;
        let group = self.groups.at(u64::from(pixel / (RADIX * RADIX)));
        let group = mem.plain_load(group).await;
        (u64::from(group) + u64::from(block) + u64::from(offset >> 1), offset & 1 == 1)
    }

    /// Where the records of a block's pixels begin, the first of which is `pixel`, by bits: [`Self::start`] of each.
    #[must_use]
    pub fn starts<'a>(
        self,
        block: &OwnedBlock<'a>,
        pixel: u32,
    ) -> Option<impl Fn(u32) -> u64 + use<'a>> {
        let own = block.value(self.blocks.at(u64::from(pixel / RADIX)))?;
        let group = block.value(self.groups.at(u64::from(pixel / (RADIX * RADIX))))?;
        let (offsets, base) = (block.rows(self.offset)?, u64::from(own) + u64::from(group));
        Some(move |bit| base + u64::from(offsets.first(bit).get() >> 1))
    }

    /// Write a pixel's start where its offset was, so that the store pass needs not add it up for every fragment. Only
    /// for pixels that have records, once, in a pass of its own.
    pub async fn place<M: Memory>(self, mem: &M, pixel: u32) {
        let (start, flag) = self.start::<_, Self>(mem, pixel).await;
        mem.plain_store(self.offset.at(pixel, 0), (start as u32) << 1 | u32::from(flag)).await;
    }

    /// Where a pixel's records begin, and its flag, after [`Self::place`].
    #[inline(always)]
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub async fn placed<M: Memory, Caller>(self, mem: &M, pixel: u32) -> (u64, bool) {
        let place = mem.plain_load(self.offset.at(pixel, 0)).await;
        (u64::from(place >> 1), place & 1 == 1)
    }

    /// The same, for an invariant; `None` while nothing was written.
    #[must_use]
    pub fn seen(self, words: &Snapshot<'_>, pixel: u32) -> Option<u64> {
        words.get(self.offset.at(pixel, 0)).map(|place| u64::from(place >> 1))
    }
}
