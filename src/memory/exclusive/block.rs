//! The words of a block of pixels that one worker owns, for schemes that store a block's fragments at once.

use std::cell::Cell;
use std::marker::PhantomData;

use crate::memory::arena::{Arena, OwnedView, Rows, SharedView};
use crate::memory::{
    Ahead, At, Atomic, Global, Kind, Order, Pixel, Plain, Pool, Update, Word, Words,
};

/// 64 pixels' words, and what their worker has of the frame's.
#[derive(Clone, Copy, Debug)]
pub struct OwnedBlock<'a> {
    /// The record of the first of them.
    first: u32,
    pixel: OwnedView<'a>,
    global: SharedView<'a>,
    ahead: &'a [Ahead],
}

/// Some of the frame's words, one after another.
#[derive(Debug)]
pub struct Run<'a, K, W: Word> {
    words: &'a [W::Shared],
    kind: PhantomData<K>,
}

impl<'a> OwnedBlock<'a> {
    pub(super) fn new(
        first: u32,
        (pixel, global): (OwnedView<'a>, SharedView<'a>),
        ahead: &'a [Ahead],
    ) -> Self {
        Self { first, pixel, global, ahead }
    }

    /// The only word of this width that each of the pixels has; `None` if a pixel has more of them.
    #[inline]
    #[must_use]
    pub fn pixels<K: Kind, W: Word>(&self, words: Words<Pixel, K, W>) -> Option<&'a [Cell<W>; 64]> {
        self.rows(words)?.single()
    }

    /// These words of each of the pixels; `None` if memory has not so many pixels.
    #[inline]
    #[must_use]
    pub fn rows<K: Kind, W: Word>(&self, words: Words<Pixel, K, W>) -> Option<Rows<'a, W>> {
        self.pixel.rows(words, self.first)
    }

    /// So many of the frame's words, from word `first` on; `None` if there are not so many.
    #[inline]
    #[must_use]
    pub fn run<K: Kind, W: Word>(
        &self,
        words: Words<Global, K, W>,
        first: u64,
        count: u64,
    ) -> Option<Run<'a, K, W>> {
        let words = self.global.words::<W>().get(words.run(first, count)?)?;
        Some(Run { words, kind: PhantomData })
    }

    /// All of them; `None` if memory has not so many.
    #[inline]
    #[must_use]
    pub fn all<W: Word>(&self, words: Words<Global, Plain, W>) -> Option<Run<'a, Plain, W>> {
        self.run(words, 0, words.count())
    }

    /// The value of one of the frame's words; `None` if memory has no such word.
    #[inline]
    #[must_use]
    pub fn value<K: Kind, W: Word>(&self, at: At<Global, K, W>) -> Option<W> {
        Some(W::peek(self.global.words::<W>().get(at.word as usize)?))
    }

    /// Write the larger of one of the frame's words and a value, by one atomic operation, and give the word before;
    /// `None` if memory has no such word.
    #[inline]
    #[must_use]
    pub fn max<W: Word>(&self, at: At<Global, Atomic, W>, value: W) -> Option<W> {
        self.global.words::<W>().get(at.word as usize)?;
        Some(self.global.update(at, Update::Max(value), Order::Relaxed))
    }

    /// The first of a pool's next indices, if the worker has so many ahead. They are not taken.
    #[inline]
    #[must_use]
    pub fn next(&self, pool: Pool, count: u32) -> Option<u32> {
        pool.of(self.ahead)?.first(count)
    }

    /// Take so many of them, no more than [`Self::next`] has found.
    #[inline]
    pub fn take(&self, pool: Pool, count: u32) {
        if let Some(ahead) = pool.of(self.ahead) {
            ahead.skip(count);
        }
    }
}

impl<K: Kind, W: Word> Run<'_, K, W> {
    /// The values of the first of them; `None` if there are not so many.
    #[inline]
    #[must_use]
    pub fn values<const N: usize>(&self) -> Option<[W; N]> {
        Some(self.words.first_chunk()?.each_ref().map(W::peek))
    }
}

impl<W: Word> Run<'_, Plain, W> {
    /// Write one of them, if there is such a one; whether there is.
    #[inline]
    #[must_use]
    pub fn write(&self, place: u64, value: W) -> bool {
        self.words.get(place as usize).map(|word| W::put(word, value)).is_some()
    }

    /// Ways to write each of them.
    #[inline]
    pub fn writers(&self) -> impl Iterator<Item = impl FnOnce(W)> {
        self.words.iter().map(|word| move |value| W::put(word, value))
    }
}
