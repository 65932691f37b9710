//! Where a scheme's words are.
//!
//! A scheme declares its words once, before any memory exists; a declaration hands back [`Words`], typed by space
//! (one record per pixel, or one block for the frame), kind (atomic or plain) and width. All 32-bit words of a pixel
//! form one record, so that a fragment touches neighbouring cache lines; 64-bit words form a second one.

pub mod address;
pub mod inputs;
pub mod names;
pub mod pool;

use std::marker::PhantomData;
use std::ops::Range;

use self::names::Names;
use super::word::Word;

pub use address::{Address, Numbering, Snapshot};
pub use inputs::{Declared, Input, InputAt, Inputs, Per};
pub use pool::{Ahead, Pool};

/// Words that belong to a pixel.
#[derive(Clone, Copy, Debug)]
pub enum Pixel {}

/// Words that belong to the whole frame: pools, counters, tables.
#[derive(Clone, Copy, Debug)]
pub enum Global {}

/// Words reached by atomic operations.
#[derive(Clone, Copy, Debug)]
pub enum Atomic {}

/// Words reached by plain loads and stores only.
#[derive(Clone, Copy, Debug)]
pub enum Plain {}

/// [`Pixel`] or [`Global`].
pub trait Space: Copy + Unpin {
    /// Belongs to the frame.
    const GLOBAL: bool;
}

impl Space for Pixel {
    const GLOBAL: bool = false;
}

impl Space for Global {
    const GLOBAL: bool = true;
}

/// [`Atomic`] or [`Plain`].
pub trait Kind: Copy + Unpin {
    /// Reached by atomic operations.
    const ATOMIC: bool;
}

impl Kind for Atomic {
    const ATOMIC: bool = true;
}

impl Kind for Plain {
    const ATOMIC: bool = false;
}

/// A run of words that a scheme declared.
#[derive(Debug)]
pub struct Words<S, K, W> {
    first: u64,
    count: u64,
    typed: PhantomData<(S, K, W)>,
}

/// The address of one word.
#[derive(Debug)]
pub struct At<S, K, W> {
    /// Which pixel's record; 0 in global space.
    pub pixel: u32,
    /// Which word of the record, or of global space.
    pub word: u64,
    typed: PhantomData<(S, K, W)>,
}

impl<S, K, W> Clone for Words<S, K, W> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, K, W> Copy for Words<S, K, W> {}

impl<S, K, W> At<S, K, W> {
    /// A word by its place, for memories that have no type for it.
    #[inline(always)]
    pub(super) fn new(pixel: u32, word: u64) -> Self {
        Self { pixel, word, typed: PhantomData }
    }

    /// The same word of another pixel.
    #[inline(always)]
    pub(super) fn on(self, pixel: u32) -> Self {
        Self { pixel, ..self }
    }
}

impl<S, K, W> Clone for At<S, K, W> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, K, W> Copy for At<S, K, W> {}

impl<K, W> Words<Pixel, K, W> {
    /// Word `i` of a pixel's run. A faulty scheme may go beyond it; memories check addresses.
    #[inline(always)]
    #[must_use]
    pub fn at(self, pixel: u32, i: u32) -> At<Pixel, K, W> {
        At { pixel, word: self.first + u64::from(i), typed: PhantomData }
    }
}

impl<K, W> Words<Global, K, W> {
    /// Word `i` of the frame's run.
    #[inline(always)]
    #[must_use]
    pub fn at(self, i: u64) -> At<Global, K, W> {
        At { pixel: 0, word: self.first + i, typed: PhantomData }
    }
}

impl<K, W> Words<Global, K, W> {
    /// The index within the run of the word at this place among the frame's words of its width, if it belongs to the
    /// run.
    #[must_use]
    pub fn index_of(self, word: u64) -> Option<u64> {
        word.checked_sub(self.first).filter(|&index| index < self.count)
    }

    /// The places, among the frame's words of its width, of `count` words of the run from `first` on; `None` if it has
    /// not so many.
    #[inline]
    pub(super) fn run(self, first: u64, count: u64) -> Option<Range<usize>> {
        let begin = (self.first + first) as usize;
        (first + count <= self.count).then(|| begin..begin + count as usize)
    }
}

impl<S, K, W> Words<S, K, W> {
    /// How many words the run has (per pixel, in pixel space).
    #[inline(always)]
    #[must_use]
    pub fn count(self) -> u64 {
        self.count
    }
}

/// Sizes of one space's two records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sizes {
    /// 32-bit words.
    pub words32: u64,
    /// 64-bit words.
    pub words64: u64,
}

impl Sizes {
    /// Bytes of both.
    #[must_use]
    pub fn bytes(self) -> u64 {
        4 * self.words32 + 8 * self.words64
    }
}

/// All declarations of a scheme.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    pixel: Sizes,
    global: Sizes,
    locks: Vec<u64>,
    interlocks: u64,
    pools: Vec<u64>,
    growing: Vec<Growing>,
    inputs: Vec<Declared>,
    names: Names,
}

/// Words of the frame whose values never decrease while fragments are stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Growing {
    /// 32 or 64.
    pub bits: u32,
    /// Places among the frame's words of this width.
    pub words: std::ops::Range<u64>,
}

impl Layout {
    /// Declare `count` words for every pixel.
    pub fn pixel<K: Kind, W: Word>(&mut self, count: u64) -> Words<Pixel, K, W> {
        let words = Words::take(&mut self.pixel, count);
        self.names.give::<Pixel, W>(words.first, count);
        words
    }

    /// Declare `count` words for the frame.
    pub fn global<K: Kind, W: Word>(&mut self, count: u64) -> Words<Global, K, W> {
        let words = Words::take(&mut self.global, count);
        self.names.give::<Global, W>(words.first, count);
        words
    }

    /// The name, for people, of the words that are declared next: `layout.named("depth").pixel(8)`.
    pub fn named(&mut self, name: &'static str) -> &mut Self {
        self.names.next(name);
        self
    }

    /// The name of a word, with its place where several have one name, as in `depth[3]`; `None` if it was declared
    /// without.
    #[must_use]
    pub fn name_of(&self, address: Address) -> Option<String> {
        self.names.of(address)
    }

    /// Declare a pool from which every fragment takes at most one index, when it is stored. An index is a name: the
    /// scheme compares it with the pool's size, and finds words by it ([`pool`]).
    pub fn pool(&mut self) -> Pool {
        self.names.next_or("pool");
        let pool = Pool { counter: self.global(1), number: self.pools.len() as u32 };
        self.pools.push(pool.counter.first);
        pool
    }

    fn pools(&self) -> impl Iterator<Item = Pool> {
        let counter = |&first| Words { first, count: 1, typed: PhantomData };
        (0..).zip(&self.pools).map(move |(number, first)| Pool { counter: counter(first), number })
    }

    /// The pool whose counter is this 32-bit word of the frame.
    #[must_use]
    pub fn pool_at(&self, word: u64) -> Option<Pool> {
        self.pools().find(|pool| pool.counter.first == word)
    }

    /// What a worker takes ahead from every pool: nothing yet.
    #[must_use]
    pub fn ahead(&self) -> Vec<Ahead> {
        self.pools().map(Ahead::none).collect()
    }

    /// Declare words that the application fills before the frame, and that no invocation writes.
    pub fn input(&mut self, declared: Declared) -> Input {
        self.inputs.push(declared);
        Input { table: self.inputs.len() as u32 - 1 }
    }

    /// The inputs, in the order of their declaration.
    #[must_use]
    pub fn inputs(&self) -> &[Declared] {
        &self.inputs
    }

    /// Declare a lock for every pixel: a word that is 0 when free, taken by an exchange that finds 0 or by a
    /// compare-exchange, and freed by a write of 0. Search checks mutual exclusion.
    pub fn lock(&mut self) -> Words<Pixel, Atomic, u32> {
        self.names.next_or("lock");
        let words = self.pixel(1);
        self.locks.push(words.first);
        words
    }

    /// Declare the turn of the ordered interlock, a word for every pixel. It stands for what a device keeps in
    /// hardware, and is not part of the method's own storage.
    pub fn interlock(&mut self) -> Words<Pixel, Atomic, u32> {
        self.interlocks += 1;
        self.names.next_or("turn");
        self.pixel(1)
    }

    /// Say that no store invocation ever makes these words smaller. Checks verify it.
    pub fn grows<W: Word>(&mut self, words: Words<Global, Atomic, W>) {
        let all = words.first..words.first + words.count;
        self.growing.push(Growing { bits: W::BITS, words: all });
    }

    /// Words whose values never decrease while fragments are stored.
    #[must_use]
    pub fn growing(&self) -> &[Growing] {
        &self.growing
    }

    /// Words of a pixel that stand for hardware.
    #[must_use]
    pub fn interlocks(&self) -> u64 {
        self.interlocks
    }

    /// The 32-bit words of a pixel that are locks.
    #[must_use]
    pub fn locks(&self) -> &[u64] {
        &self.locks
    }

    /// Words of one pixel.
    #[must_use]
    pub fn per_pixel(&self) -> Sizes {
        self.pixel
    }

    /// Words of the frame.
    #[must_use]
    pub fn per_frame(&self) -> Sizes {
        self.global
    }

    /// Bytes for an image of this many pixels.
    #[must_use]
    pub fn bytes(&self, pixels: u64) -> u64 {
        self.pixel.bytes().saturating_mul(pixels).saturating_add(self.global.bytes())
    }
}

impl<S, K, W: Word> Words<S, K, W> {
    fn take(sizes: &mut Sizes, count: u64) -> Self {
        let total = if W::BITS == 64 { &mut sizes.words64 } else { &mut sizes.words32 };
        let first = *total;
        *total += count;
        Self { first, count, typed: PhantomData }
    }
}
