//! Simulated memory: a poll performs exactly one operation.
//!
//! An operation first waits. The executor picks an invocation, grants one operation and polls: the waiting operation
//! happens, the scheme runs on to its next one, and that one waits. Memory is sequentially consistent: an operation
//! is a step, and steps happen one after another.
//!
//! A waiting operation is kept small, since thousands of invocations wait at one each: it stores the index of its word,
//! not how the index was computed. It also reads its word when it begins to wait, so that the word is in the cache by
//! the time of its turn.

use std::cell::Cell;
use std::future::Future;
use std::hint::black_box;
use std::marker::PhantomData;
use std::pin::Pin;
use std::task::{Context, Poll};

use super::arena::Owned;
use super::{
    Access, Address, At, Atomic, Event, Global, InputAt, Inputs, Kind, Layout, Mark, Memory,
    Observer, Order, Space, Update, Word, Words,
};

/// The memory of a simulated device; its operations are reported to an observer.
#[derive(Debug)]
pub struct Sim<O> {
    pixel: Owned,
    global: Owned,
    inputs: Inputs,
    /// What an access outside of the words finds: zeros, set anew each time.
    nowhere: (Cell<u32>, Cell<u64>),
    granted: Cell<bool>,
    /// An invocation has waited since this was last asked.
    waited: Cell<bool>,
    /// Whether changes are recorded.
    telling: Cell<bool>,
    changed: Cell<Option<Change>>,
    observer: O,
}

/// What an operation did to a word of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// 32 or 64.
    pub bits: u32,
    /// Place among the frame's words of this width.
    pub word: u64,
    /// What was there.
    pub old: u64,
    /// What is there.
    pub new: u64,
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<O: Observer> Sim<O> {
    /// Memory for `pixels` pixels. Every word starts as `pattern`, so that a scheme can rely on nothing but its clear
    /// pass.
    #[must_use]
    pub fn new(layout: &Layout, pixels: usize, inputs: Inputs, pattern: u64, observer: O) -> Self {
        let (pixel, global) =
            (Owned::new(layout.per_pixel(), pixels), Owned::new(layout.per_frame(), 1));
        if pattern != 0 {
            pixel.fill(pattern);
            global.fill(pattern);
        }
        Self {
            pixel,
            global,
            inputs,
            nowhere: Default::default(),
            granted: Cell::new(false),
            waited: Cell::new(false),
            telling: Cell::new(false),
            changed: Cell::new(None),
            observer,
        }
    }

    /// Allow one operation: the next poll of an invocation performs it.
    #[inline]
    pub fn grant(&self) {
        self.granted.set(true);
    }

    /// Whether an invocation has waited since this was last asked.
    #[inline]
    pub fn take_waited(&self) -> bool {
        self.waited.get() && self.waited.replace(false)
    }

    /// Start or stop recording changes to the frame's words.
    pub fn tell_changes(&self, telling: bool) {
        self.telling.set(telling);
        self.changed.set(None);
    }

    /// What the last operation changed, if it was a word of the frame.
    pub fn take_change(&self) -> Option<Change> {
        self.changed.take()
    }

    /// The value of a word.
    #[must_use]
    pub fn value(&self, address: Address) -> Option<u64> {
        let (arena, record) = match address.pixel {
            None => (&self.global, 0),
            Some(pixel) => (&self.pixel, pixel),
        };
        arena.value(record, address.bits, address.word)
    }

    /// Accesses so far that went outside of the words.
    pub fn outside(&self) -> u64 {
        self.pixel.outside() + self.global.outside()
    }

    /// All values of a run of the frame's words.
    pub fn copy<W: Word>(&self, words: Words<Global, Atomic, W>) -> Vec<u64> {
        let all = self.global.words::<W>();
        (0..words.count()).map(|i| all[words.at(i).word as usize].get().to_u64()).collect()
    }

    #[inline(always)]
    fn changes<S: Space, W: Word>(&self, index: usize, old: W, new: W) {
        if S::GLOBAL && self.telling.get() && index < self.global.words::<W>().len() {
            let (old, new) = (old.to_u64(), new.to_u64());
            self.changed.set(Some(Change { bits: W::BITS, word: index as u64, old, new }));
        }
    }

    /// What sees the operations.
    pub fn observer(&self) -> &O {
        &self.observer
    }

    #[inline(always)]
    fn arena<S: Space>(&self) -> &Owned {
        if S::GLOBAL { &self.global } else { &self.pixel }
    }

    /// An access outside of the words.
    #[cold]
    fn nowhere<S: Space, W: Word>(&self) -> &Cell<W> {
        self.arena::<S>().miss();
        self.nowhere.0.set(0);
        self.nowhere.1.set(0);
        let (narrow, wide) = (&self.nowhere.0, &self.nowhere.1);
        &W::owned((std::slice::from_ref(narrow), std::slice::from_ref(wide)))[0]
    }

    #[inline(always)]
    fn step<'a, S: Space, K: Kind, W: Word, T, P>(
        &'a self,
        at: At<S, K, W>,
        perform: P,
    ) -> Step<'a, O, S, W, P>
    where
        P: FnMut(&'a Self, &'a Cell<W>) -> T,
    {
        Step { mem: self, index: self.arena::<S>().index(at), perform, typed: PhantomData }
    }
}

/// An operation on a word that waits for its grant.
struct Step<'a, O, S, W, P> {
    mem: &'a Sim<O>,
    index: usize,
    perform: P,
    typed: PhantomData<(S, W)>,
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<'a, O, S, W, T, P> Future for Step<'a, O, S, W, P>
where
    O: Observer,
    S: Space,
    W: Word,
    P: FnMut(&'a Sim<O>, &'a Cell<W>) -> T + Unpin,
{
    type Output = T;

    #[inline(always)]
    fn poll(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<T> {
        let Self { mem, index, .. } = *self;
        let words = mem.arena::<S>().words::<W>();
        if mem.granted.replace(false) {
            let word = words.get(index).unwrap_or_else(|| mem.nowhere::<S, W>());
            return Poll::Ready((self.perform)(mem, word));
        }
        if let Some(word) = words.get(index) {
            black_box(word.get());
        }
        Poll::Pending
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<O: Observer> Memory for Sim<O> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        self.step(at, move |mem: &Self, word| {
            mem.observer.read(access, W::BITS);
            word.get()
        })
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        let index = self.arena::<S>().index(at);
        self.step(at, move |mem: &Self, word| {
            mem.observer.write(access, W::BITS);
            mem.changes::<S, W>(index, word.get(), value);
            word.set(value);
        })
    }

    #[inline(always)]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        _: Order,
    ) -> impl Future<Output = W> + Unpin {
        let index = self.arena::<S>().index(at);
        self.step(at, move |mem: &Self, word| {
            let old = word.get();
            let new = update.apply(old);
            word.set(new);
            mem.changes::<S, W>(index, old, new);
            mem.observer.update(update, old);
            old
        })
    }

    #[inline(always)]
    fn input(&self, at: InputAt) -> u32 {
        self.observer.note(Event::Input);
        self.inputs.get(at)
    }

    /// Not an operation: the invocation goes straight on to its next attempt, which waits.
    #[inline]
    fn spin(&self, _: Mark) -> impl Future<Output = ()> + Unpin {
        self.observer.spin();
        self.waited.set(true);
        std::future::ready(())
    }

    #[inline(always)]
    fn note(&self, event: Event) {
        self.observer.note(event);
    }
}
