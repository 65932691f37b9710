//! Where bounded structures keep their records: depth and data words in a row, of a pixel or of the frame.

use std::future::Future;

use super::lock::reach::Reach;
use crate::fragment::{data_of, depth_of};
use crate::memory::{At, Atomic, Global, Memory, Order, Pixel, Plain, Space, Words, both};

/// A row of records.
pub trait Slots: Copy {
    /// The space of the words.
    type Space: Space;

    /// How the lock's holder reaches them.
    type Reach: Reach;

    /// The depth word of record `i`.
    fn depth(self, i: u32) -> At<Self::Space, Atomic, u32>;

    /// The data word of record `i`.
    fn data(self, i: u32) -> At<Self::Space, <Self::Reach as Reach>::Kind, u32>;
}

/// Records of a pixel.
#[derive(Debug)]
pub struct OfPixel<R: Reach = Plain> {
    /// Depth words.
    pub depth: Words<Pixel, Atomic, u32>,
    /// Data words.
    pub data: Words<Pixel, R::Kind, u32>,
    /// The pixel.
    pub pixel: u32,
}

/// Records of the frame, from `first` on.
#[derive(Debug)]
pub struct OfFrame<R: Reach = Plain> {
    /// Depth words.
    pub depth: Words<Global, Atomic, u32>,
    /// Data words.
    pub data: Words<Global, R::Kind, u32>,
    /// Where the row begins.
    pub first: u64,
}

impl<R: Reach> Clone for OfPixel<R> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Reach> Copy for OfPixel<R> {}

impl<R: Reach> Clone for OfFrame<R> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Reach> Copy for OfFrame<R> {}

impl<R: Reach> Slots for OfPixel<R> {
    type Space = Pixel;
    type Reach = R;

    #[inline(always)]
    fn depth(self, i: u32) -> At<Pixel, Atomic, u32> {
        self.depth.at(self.pixel, i)
    }

    #[inline(always)]
    fn data(self, i: u32) -> At<Pixel, R::Kind, u32> {
        self.data.at(self.pixel, i)
    }
}

impl<R: Reach> Slots for OfFrame<R> {
    type Space = Global;
    type Reach = R;

    #[inline(always)]
    fn depth(self, i: u32) -> At<Global, Atomic, u32> {
        self.depth.at(self.first + u64::from(i))
    }

    #[inline(always)]
    fn data(self, i: u32) -> At<Global, R::Kind, u32> {
        self.data.at(self.first + u64::from(i))
    }
}

/// Depth and data word of a record, for the lock's holder.
#[inline(always)]
#[track_caller]
pub fn entry<M: Memory, S: Slots>(mem: &M, slots: S, i: u32) -> impl Future<Output = (u32, u32)> {
    both(S::Reach::load(mem, slots.depth(i), Order::Relaxed), S::Reach::read(mem, slots.data(i)))
}

/// The same after a barrier.
#[inline(always)]
#[track_caller]
pub fn settled<M: Memory, S: Slots>(mem: &M, slots: S, i: u32) -> impl Future<Output = (u32, u32)> {
    both(mem.load(slots.depth(i), Order::Relaxed), mem.read(slots.data(i), S::Reach::SETTLED))
}

/// Write a record, its depth last.
#[inline(always)]
#[track_caller]
pub fn put<M: Memory, S: Slots>(mem: &M, slots: S, i: u32, key: u64) -> impl Future {
    both(
        S::Reach::write(mem, slots.data(i), data_of(key)),
        S::Reach::store(mem, slots.depth(i), depth_of(key), Order::Relaxed),
    )
}
