//! Where bounded structures keep their records: depth and data words in a row, of a pixel or of the frame.

use std::future::Future;

use crate::fragment::{data_of, depth_of};
use crate::memory::{At, Atomic, Global, Memory, Order, Pixel, Plain, Space, Words, both};

/// A row of records.
pub trait Slots: Copy {
    /// The space of the words.
    type Space: Space;

    /// The depth word of record `i`.
    fn depth(self, i: u32) -> At<Self::Space, Atomic, u32>;

    /// The data word of record `i`.
    fn data(self, i: u32) -> At<Self::Space, Plain, u32>;
}

/// Records of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct OfPixel {
    /// Depth words.
    pub depth: Words<Pixel, Atomic, u32>,
    /// Data words.
    pub data: Words<Pixel, Plain, u32>,
    /// The pixel.
    pub pixel: u32,
}

/// Records of the frame, from `first` on.
#[derive(Clone, Copy, Debug)]
pub struct OfFrame {
    /// Depth words.
    pub depth: Words<Global, Atomic, u32>,
    /// Data words.
    pub data: Words<Global, Plain, u32>,
    /// Where the row begins.
    pub first: u64,
}

impl Slots for OfPixel {
    type Space = Pixel;

    #[inline(always)]
    fn depth(self, i: u32) -> At<Pixel, Atomic, u32> {
        self.depth.at(self.pixel, i)
    }

    #[inline(always)]
    fn data(self, i: u32) -> At<Pixel, Plain, u32> {
        self.data.at(self.pixel, i)
    }
}

impl Slots for OfFrame {
    type Space = Global;

    #[inline(always)]
    fn depth(self, i: u32) -> At<Global, Atomic, u32> {
        self.depth.at(self.first + u64::from(i))
    }

    #[inline(always)]
    fn data(self, i: u32) -> At<Global, Plain, u32> {
        self.data.at(self.first + u64::from(i))
    }
}

/// Depth and data word of a record.
#[inline(always)]
#[track_caller]
pub fn entry<M: Memory, S: Slots>(mem: &M, slots: S, i: u32) -> impl Future<Output = (u32, u32)> {
    both(mem.load(slots.depth(i), Order::Relaxed), mem.plain_load(slots.data(i)))
}

/// Write a record, its depth last.
#[inline(always)]
#[track_caller]
pub fn put<M: Memory, S: Slots>(
    mem: &M,
    slots: S,
    i: u32,
    key: u64,
) -> impl Future<Output = ((), ())> {
    both(
        mem.plain_store(slots.data(i), data_of(key)),
        mem.store(slots.depth(i), depth_of(key), Order::Relaxed),
    )
}
