//! Exclusive memory: plain cells for the pixels of a tile that one worker owns; what belongs to the frame stays atomic
//! and shared. The same scheme and the same result, without the cost of atomics.
//!
//! A tile that knows how many fragments it has takes pool indices from a range of its worker's own: no two workers
//! write the same cache line of a pool, or contend for its counter. Which fragment gets which index may then depend on
//! the workers. What is kept does not, since such ranges are used only where pools have room for all.

pub mod block;

use std::future::{Future, ready};

use self::block::OwnedBlock;
use super::arena::{Arena, Owned, OwnedView, Shared, SharedView};
use super::{
    Access, Ahead, At, Atomic, Event, InputAt, Inputs, Kind, Mark, Memory, Observer, Order, Pool,
    Space, Update, Word, complete,
};

/// One worker's handle.
#[derive(Clone, Copy, Debug)]
pub struct Exclusive<'a, O> {
    /// The pixel that the first record belongs to.
    first: u32,
    pixel: OwnedView<'a>,
    global: SharedView<'a>,
    /// The tile's own range of every pool.
    ahead: &'a [Ahead],
    inputs: &'a Inputs,
    observer: &'a O,
}

impl<'a, O: Observer> Exclusive<'a, O> {
    /// A handle that reports to `observer`.
    #[must_use]
    pub fn new(pixel: &'a Owned, global: &'a Shared, inputs: &'a Inputs, observer: &'a O) -> Self {
        let (pixel, global) = (pixel.view(), global.view());
        Self { first: 0, pixel, global, ahead: &[], inputs, observer }
    }

    /// The same, with records that are those of pixel `first` and the next ones.
    #[must_use]
    pub fn from(self, first: u32) -> Self {
        Self { first, ..self }
    }

    /// The same, taking the indices of pools from these.
    #[must_use]
    pub fn taking(self, ahead: &'a [Ahead]) -> Self {
        Self { ahead, ..self }
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
        let index = match pool.of(self.ahead).and_then(Ahead::next) {
            Some(index) => index,
            None => self.global.update(pool.counter(), Update::Add(1), Order::Relaxed),
        };
        self.observer.update(Update::Add(1u32), index);
        ready(index)
    }

    #[inline(always)]
    fn owned_block(&self, first: u32) -> Option<OwnedBlock<'_>> {
        if self.observer.counters().is_some() {
            return None;
        }
        let views = (self.pixel, self.global);
        Some(OwnedBlock::new(first.wrapping_sub(self.first), views, self.ahead))
    }

    #[inline(always)]
    fn part<F: Future>(&self, part: F) -> impl Future<Output = F::Output> {
        ready(complete(part))
    }

    #[inline(always)]
    fn input(&self, at: InputAt) -> u32 {
        self.observer.note(Event::Input);
        self.inputs.get(at)
    }

    /// There is no other invocation to wait for: a scheme that spins here would spin forever, and a pixel's lock is
    /// always free.
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
