//! Native memory: std atomics that real threads contend on. Every operation is ready at once.

use std::cell::Cell;
use std::future::{Future, Ready, ready};

use super::arena::{Arena, Shared};
use super::{Access, At, Atomic, Kind, Memory, Observer, Order, Space, Update, Word};

/// Failed attempts after which a waiting thread gives up its core for once: the holder may not be running.
const SPINS_BEFORE_YIELD: u32 = 64;

/// One thread's handle on shared storage.
#[derive(Debug)]
pub struct Native<'a, O> {
    pixel: &'a Shared,
    global: &'a Shared,
    observer: O,
    spins: Cell<u32>,
}

impl<'a, O: Observer> Native<'a, O> {
    /// A handle that reports to `observer`.
    #[must_use]
    pub fn new(pixel: &'a Shared, global: &'a Shared, observer: O) -> Self {
        Self { pixel, global, observer, spins: Cell::new(0) }
    }

    /// What it reported to.
    pub fn into_observer(self) -> O {
        self.observer
    }

    #[inline(always)]
    fn arena<S: Space>(&self) -> &'a Shared {
        if S::GLOBAL { self.global } else { self.pixel }
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<O: Observer> Memory for Native<'_, O> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> {
        self.observer.read(access, W::BITS);
        ready(self.arena::<S>().read(at, access))
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> {
        self.observer.write(access, W::BITS);
        self.arena::<S>().write(at, value, access);
        ready(())
    }

    #[inline(always)]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> {
        let old = self.arena::<S>().update(at, update, order);
        self.observer.update(update, old);
        ready(old)
    }

    #[inline]
    fn spin(&self) -> impl Future<Output = ()> {
        self.observer.spin();
        wait(&self.spins)
    }
}

/// Pause, and now and then yield.
#[cold]
fn wait(spins: &Cell<u32>) -> Ready<()> {
    spins.set(spins.get().wrapping_add(1));
    if spins.get().is_multiple_of(SPINS_BEFORE_YIELD) {
        std::thread::yield_now();
    } else {
        std::hint::spin_loop();
    }
    ready(())
}
