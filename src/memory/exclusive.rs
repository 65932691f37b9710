//! Exclusive memory: plain cells for the pixels of a tile that one worker owns; what belongs to the frame stays
//! atomic and shared. The same scheme and the same result, without the price of atomics.

use std::future::{Future, ready};

use super::arena::{Arena, Owned, OwnedView, Shared, SharedView};
use super::{Access, At, Atomic, Kind, Memory, Observer, Order, Space, Update, Word};

/// One worker's handle.
#[derive(Clone, Copy, Debug)]
pub struct Exclusive<'a, O> {
    pixel: OwnedView<'a>,
    global: SharedView<'a>,
    observer: &'a O,
}

impl<'a, O: Observer> Exclusive<'a, O> {
    /// A handle that reports to `observer`.
    #[must_use]
    pub fn new(pixel: &'a Owned, global: &'a Shared, observer: &'a O) -> Self {
        Self { pixel: pixel.view(), global: global.view(), observer }
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
        ready(if S::GLOBAL { self.global.read(at, access) } else { self.pixel.read(at, access) })
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
    ) -> impl Future<Output = W> + Unpin {
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
    fn spin(&self) -> impl Future<Output = ()> + Unpin {
        self.observer.spin();
        ready(())
    }
}
