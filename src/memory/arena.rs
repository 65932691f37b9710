//! Storage for one space of a layout: records of words, zeroed at creation. The system hands out zeroed pages on first
//! touch, so a large pool costs only the part that is used. Accesses beyond the end have no effect, and are counted.

use std::cell::Cell;
use std::sync::atomic::{AtomicU32, AtomicU64};

use rayon::prelude::*;

use super::layout::{At, Sizes};
use super::word::{Atomics, Cells};
use super::{Access, Atomic, Global, Kind, Order, Pixel, Space, Update, Word, Words};

/// What an access outside of the words reads.
const NOTHING: u64 = 0;

/// Words that many threads share. Plain words are relaxed atomics too, as safe Rust requires; on the machines at hand
/// they compile to the same instructions.
#[derive(Debug)]
pub struct Shared {
    words32: Box<[AtomicU32]>,
    words64: Box<[AtomicU64]>,
    stride: Sizes,
    outside: AtomicU64,
}

/// Words that one thread owns.
#[derive(Debug)]
pub struct Owned {
    words32: Box<[Cell<u32>]>,
    words64: Box<[Cell<u64>]>,
    stride: Sizes,
    outside: Cell<u64>,
}

/// A handle's view of shared words. A handle holds its views by value, so that the compiler knows that their addresses
/// and sizes do not change between operations.
#[derive(Clone, Copy, Debug)]
pub(super) struct SharedView<'a> {
    words: Atomics<'a>,
    stride: Sizes,
    outside: &'a AtomicU64,
}

/// The same for owned words.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnedView<'a> {
    words: Cells<'a>,
    stride: Sizes,
    outside: &'a Cell<u64>,
}

/// Some of the words of each of a block's pixels.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, W: Word> {
    /// From the first pixel's first of them to the last one's last.
    all: &'a [Cell<W>],
    /// From a pixel's to the next one's.
    stride: usize,
    /// How many a pixel has.
    count: usize,
}

impl<'a, W: Word> Rows<'a, W> {
    /// Those of the pixel at a bit.
    ///
    /// # Panics
    /// If a block has no such bit.
    #[inline]
    #[must_use]
    pub fn of(&self, bit: u32) -> &'a [Cell<W>] {
        let first = bit as usize * self.stride;
        &self.all[first..first + self.count]
    }

    /// The first of those of the pixel at a bit.
    ///
    /// # Panics
    /// If a block has no such bit, or a pixel none of them.
    #[inline]
    #[must_use]
    pub fn first(&self, bit: u32) -> &'a Cell<W> {
        &self.all[bit as usize * self.stride]
    }

    /// The only word that each of the pixels has of this width.
    #[inline]
    pub(super) fn single(&self) -> Option<&'a [Cell<W>; 64]> {
        if (self.stride, self.count) == (1, 1) { self.all.first_chunk() } else { None }
    }
}

/// The operations of every arena; each completes at once.
pub(super) trait Arena {
    fn read<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, access: Access) -> W;
    fn write<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, value: W, access: Access);
    fn update<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, u: Update<W>, order: Order) -> W;
}

/// Index of an address in the arena's array.
#[allow(clippy::inline_always, reason = "see `Memory`")]
#[inline(always)]
fn index<S: Space, K: Kind, W: Word>(stride: &Sizes, at: At<S, K, W>) -> usize {
    if S::GLOBAL {
        return at.word as usize;
    }
    let record = if W::BITS == 64 { stride.words64 } else { stride.words32 };
    at.pixel as usize * record as usize + at.word as usize
}

fn total(sizes: Sizes, records: usize) -> [usize; 2] {
    [sizes.words32 as usize * records, sizes.words64 as usize * records]
}

impl Shared {
    /// `records` records of the given sizes, all zero.
    #[must_use]
    pub fn new(sizes: Sizes, records: usize) -> Self {
        let [n32, n64] = total(sizes, records);
        Self {
            words32: bytemuck::allocation::zeroed_slice_box(n32),
            words64: bytemuck::allocation::zeroed_slice_box(n64),
            stride: sizes,
            outside: Default::default(),
        }
    }
}

impl Shared {
    /// Whether it is so many records of the given sizes.
    pub(super) fn has(&self, sizes: Sizes, records: usize) -> bool {
        [self.words32.len(), self.words64.len()] == total(sizes, records) && self.stride == sizes
    }

    /// The same words, no access outside of which was counted yet.
    pub(super) fn again(self) -> Self {
        Self { outside: Default::default(), ..self }
    }

    /// All values of a run of the frame's words, by all threads of the pool: a hash table may have hundreds of MiB.
    #[must_use]
    pub fn copy<W: Word>(&self, words: Words<Global, Atomic, W>) -> Vec<u64> {
        let read = |i: usize| {
            self.view().read(words.at(i as u64), Access::Atomic(Order::Relaxed)).to_u64()
        };
        (0..words.count() as usize).into_par_iter().map(read).collect()
    }

    /// All words, of 32 and of 64 bits, record after record.
    #[must_use]
    pub fn all(&self) -> (Vec<u32>, Vec<u64>) {
        let order = std::sync::atomic::Ordering::Relaxed;
        let narrow = self.words32.iter().map(|word| word.load(order)).collect();
        (narrow, self.words64.iter().map(|word| word.load(order)).collect())
    }

    /// Accesses so far that went outside of the words.
    #[must_use]
    pub fn outside(&self) -> u64 {
        self.outside.load(std::sync::atomic::Ordering::Relaxed)
    }

    pub(super) fn view(&self) -> SharedView<'_> {
        let words = (&*self.words32, &*self.words64);
        SharedView { words, stride: self.stride, outside: &self.outside }
    }
}

impl Owned {
    /// Whether it is so many records of the given sizes.
    pub(super) fn has(&self, sizes: Sizes, records: usize) -> bool {
        [self.words32.len(), self.words64.len()] == total(sizes, records) && self.stride == sizes
    }

    /// The same words, no access outside of which was counted yet.
    pub(super) fn again(self) -> Self {
        Self { outside: Default::default(), ..self }
    }

    /// Accesses so far that went outside of the words.
    #[must_use]
    pub fn outside(&self) -> u64 {
        self.outside.get()
    }

    /// Count an access outside of the words.
    #[cold]
    pub(super) fn miss(&self) {
        self.outside.set(self.outside.get() + 1);
    }

    pub(super) fn view(&self) -> OwnedView<'_> {
        let words = (&*self.words32, &*self.words64);
        OwnedView { words, stride: self.stride, outside: &self.outside }
    }

    /// `records` records of the given sizes, all zero.
    #[must_use]
    pub fn new(sizes: Sizes, records: usize) -> Self {
        let [n32, n64] = total(sizes, records);
        Self {
            words32: bytemuck::allocation::zeroed_slice_box(n32),
            words64: bytemuck::allocation::zeroed_slice_box(n64),
            stride: sizes,
            outside: Default::default(),
        }
    }

    /// Records of the given sizes that have these words, of 32 and of 64 bits. Missing ones are zero.
    #[must_use]
    pub fn of(sizes: Sizes, records: usize, words: (&[u32], &[u64])) -> Self {
        let own = Self::new(sizes, records);
        own.words32.iter().zip(words.0).for_each(|(cell, &word)| cell.set(word));
        own.words64.iter().zip(words.1).for_each(|(cell, &word)| cell.set(word));
        own
    }

    /// All words, of 32 and of 64 bits, record after record.
    #[must_use]
    pub fn all(&self) -> (Vec<u32>, Vec<u64>) {
        let narrow = self.words32.iter().map(Cell::get).collect();
        (narrow, self.words64.iter().map(Cell::get).collect())
    }

    /// The index of a word of this arena's space in [`Self::words`]; a faulty scheme's may be beyond the end.
    #[allow(clippy::inline_always, reason = "see `Memory`")]
    #[inline(always)]
    pub(super) fn index<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>) -> usize {
        index(&self.stride, at)
    }

    /// A word's value, by its record and its place in the record; `None` if there is none.
    pub(super) fn value(&self, record: u32, bits: u32, word: u64) -> Option<u64> {
        let at = |stride: u64| (u64::from(record) * stride + word) as usize;
        match bits {
            64 => self.words64.get(at(self.stride.words64)).map(Cell::get),
            _ => self.words32.get(at(self.stride.words32)).map(|word| u64::from(word.get())),
        }
    }

    /// All words of a width.
    #[allow(clippy::inline_always, reason = "see `Memory`")]
    #[inline(always)]
    pub(super) fn words<W: Word>(&self) -> &[Cell<W>] {
        W::owned((&self.words32, &self.words64))
    }

    /// Set every word to the low bits of `pattern`: what a scheme finds where its clear pass does not write.
    pub fn fill(&self, pattern: u64) {
        self.words32.iter().for_each(|w| w.set(pattern as u32));
        self.words64.iter().for_each(|w| w.set(pattern));
    }
}

// Inlined: a call costs its caller registers, even one that never happens.
#[allow(clippy::inline_always, reason = "see `Memory`")]
impl SharedView<'_> {
    /// Count an access outside of the words, and give what it reads.
    #[cold]
    #[inline(always)]
    fn miss<W: Word>(&self) -> W {
        self.outside.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        W::from_u64(NOTHING)
    }
}

impl<'a> SharedView<'a> {
    /// All words of a width.
    #[inline]
    pub(super) fn words<W: Word>(&self) -> &'a [W::Shared] {
        W::shared(self.words)
    }
}

impl<'a> OwnedView<'a> {
    /// These words of each of 64 records, from `first` on.
    #[inline]
    pub(super) fn rows<K: Kind, W: Word>(
        &self,
        words: Words<Pixel, K, W>,
        first: u32,
    ) -> Option<Rows<'a, W>> {
        let begin = index(&self.stride, words.at(first, 0));
        let record = if W::BITS == 64 { self.stride.words64 } else { self.stride.words32 };
        let (stride, count) = (record as usize, words.count() as usize);
        let all = W::owned(self.words).get(begin..begin + 63 * stride + count)?;
        Some(Rows { all, stride, count })
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl OwnedView<'_> {
    /// The same.
    #[cold]
    #[inline(always)]
    fn miss<W: Word>(&self) -> W {
        self.outside.set(self.outside.get() + 1);
        W::from_u64(NOTHING)
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl Arena for SharedView<'_> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, access: Access) -> W {
        let order = match access {
            Access::Plain => Order::Relaxed,
            Access::Atomic(order) => order,
        };
        let read = W::shared_load(self.words, index(&self.stride, at), order.for_load());
        read.unwrap_or_else(|| self.miss())
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, value: W, access: Access) {
        let order = match access {
            Access::Plain => Order::Relaxed,
            Access::Atomic(order) => order,
        };
        let written =
            W::shared_store(self.words, index(&self.stride, at), value, order.for_store());
        if written.is_none() {
            let _: W = self.miss();
        }
    }

    #[inline(always)]
    fn update<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, u: Update<W>, order: Order) -> W {
        let old = W::shared_update(self.words, index(&self.stride, at), u, order);
        old.unwrap_or_else(|| self.miss())
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl Arena for OwnedView<'_> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, _: Access) -> W {
        match W::owned(self.words).get(index(&self.stride, at)) {
            Some(cell) => cell.get(),
            None => self.miss(),
        }
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, value: W, _: Access) {
        match W::owned(self.words).get(index(&self.stride, at)) {
            Some(cell) => cell.set(value),
            None => {
                let _: W = self.miss();
            }
        }
    }

    #[inline(always)]
    fn update<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>, u: Update<W>, _: Order) -> W {
        let Some(cell) = W::owned(self.words).get(index(&self.stride, at)) else {
            return self.miss();
        };
        let old = cell.get();
        cell.set(u.apply(old));
        old
    }
}
