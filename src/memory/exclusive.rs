//! Exclusive memory: plain cells for the pixels of a tile that one worker owns; what belongs to the frame stays
//! atomic and shared. The same scheme and the same result, without the price of atomics.

use std::future::{Future, ready};

use super::arena::{Arena, Owned, Shared};
use super::{Access, At, Atomic, Kind, Memory, Observer, Order, Space, Update, Word};

/// One worker's handle.
#[derive(Debug)]
pub struct Exclusive<'a, O> {
    pixel: &'a Owned,
    global: &'a Shared,
    observer: O,
}

impl<'a, O: Observer> Exclusive<'a, O> {
    /// A handle that reports to `observer`.
    #[must_use]
    pub fn new(pixel: &'a Owned, global: &'a Shared, observer: O) -> Self {
        Self { pixel, global, observer }
    }

    /// What it reported to.
    pub fn into_observer(self) -> O {
        self.observer
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<O: Observer> Memory for Exclusive<'_, O> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> {
        self.observer.read(access, W::BITS);
        ready(if S::GLOBAL { self.global.read(at, access) } else { self.pixel.read(at, access) })
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> {
        self.observer.write(access, W::BITS);
        if S::GLOBAL {
            self.global.write(at, value, access);
        } else {
            self.pixel.write(at, value, access);
        }
        ready(())
    }

    #[inline(always)]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> {
        let old = if S::GLOBAL {
            self.global.update(at, update, order)
        } else {
            self.pixel.update(at, update, order)
        };
        self.observer.update(update, old);
        ready(old)
    }

    /// Nobody else can be waited for: a scheme that spins here would spin for ever, and a pixel's lock is always free.
    #[inline]
    fn spin(&self) -> impl Future<Output = ()> {
        self.observer.spin();
        ready(())
    }
}
