//! Exclusive memory: plain cells for the pixels of a tile that one worker owns; what belongs to the frame stays
//! atomic and shared. The same scheme and the same result, without the price of atomics.
//!
//! A tile that knows how many fragments it has takes pool indices from a range that is its worker's alone: no two workers
//! write the same cache line of a pool, or wait for its counter. Which fragment gets which index may then depend on the
//! workers; what is kept does not, since a range is shared only where pools have room for all.

use std::cell::Cell;
use std::future::{Future, ready};

use super::arena::{Arena, Owned, OwnedView, Shared, SharedView};
use super::{
    Access, At, Atomic, Event, Kind, Mark, Memory, Observer, Order, Pool, Space, Update, Word,
};

/// One worker's handle.
#[derive(Clone, Copy, Debug)]
pub struct Exclusive<'a, O> {
    /// The pixel that the first record belongs to.
    first: u32,
    pixel: OwnedView<'a>,
    global: SharedView<'a>,
    /// The next index of the tile's own range of every pool.
    next: Option<&'a Cell<u32>>,
    observer: &'a O,
}

impl<'a, O: Observer> Exclusive<'a, O> {
    /// A handle that reports to `observer`. `next` is the first index of the tile's range in pools, if it has one.
    #[must_use]
    pub fn new(
        pixel: &'a Owned,
        global: &'a Shared,
        next: Option<&'a Cell<u32>>,
        observer: &'a O,
    ) -> Self {
        Self::from(0, pixel, global, next, observer)
    }

    /// A handle whose records are those of pixel `first` and the next ones.
    #[must_use]
    pub fn from(
        first: u32,
        pixel: &'a Owned,
        global: &'a Shared,
        next: Option<&'a Cell<u32>>,
        observer: &'a O,
    ) -> Self {
        Self { first, pixel: pixel.view(), global: global.view(), next, observer }
    }

    #[inline(always)]
    fn own<S, K, W>(&self, at: At<S, K, W>) -> At<S, K, W> {
        at.on(at.pixel.wrapping_sub(self.first))
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<O: Observer> Memory for Exclusive<'_, O> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        self.observer.read(access, W::BITS);
        ready(if S::GLOBAL {
            self.global.read(at, access)
        } else {
            self.pixel.read(self.own(at), access)
        })
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        self.observer.write(access, W::BITS);
        if S::GLOBAL {
            self.global.write(at, value, access);
        } else {
            self.pixel.write(self.own(at), value, access);
        }
        ready(())
    }

    #[inline(always)]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        let old = if S::GLOBAL {
            self.global.update(at, update, order)
        } else {
            self.pixel.update(self.own(at), update, order)
        };
        self.observer.update(update, old);
        ready(old)
    }

    #[inline(always)]
    fn take(&self, pool: Pool) -> impl Future<Output = u32> + Unpin {
        let index = match self.next {
            Some(next) => next.replace(next.get() + 1),
            None => self.global.update(pool.counter(), Update::Add(1), Order::Relaxed),
        };
        self.observer.update(Update::Add(1u32), index);
        ready(index)
    }

    /// Nobody else can be waited for: a scheme that spins here would spin for ever, and a pixel's lock is always free.
    #[inline]
    fn spin(&self, _: Mark) -> impl Future<Output = ()> + Unpin {
        self.observer.spin();
        ready(())
    }

    #[inline(always)]
    fn note(&self, event: Event) {
        self.observer.note(event);
    }
}
