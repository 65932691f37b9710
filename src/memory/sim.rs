//! Simulated memory: a poll performs exactly one operation.
//!
//! An operation first waits. The executor picks an invocation, grants one operation and polls: the waiting operation
//! happens, the scheme runs on to its next one, and that one waits. Memory is sequentially consistent: an operation
//! is a step, and steps happen one after another.

use std::cell::Cell;
use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll};

use super::arena::{Arena, Owned, OwnedView};
use super::{
    Access, At, Atomic, Counters, Kind, Layout, Mark, Memory, Observer, Order, Space, Update, Word,
};

/// The memory of a simulated device.
#[derive(Debug)]
pub struct Sim {
    pixel: Owned,
    global: Owned,
    granted: Cell<bool>,
    counters: Counters,
}

impl Sim {
    /// Memory for `pixels` pixels. Every word starts as `pattern`, so that a scheme can rely on nothing but its clear
    /// pass.
    #[must_use]
    pub fn new(layout: &Layout, pixels: usize, pattern: u64) -> Self {
        let (pixel, global) =
            (Owned::new(layout.per_pixel(), pixels), Owned::new(layout.per_frame(), 1));
        if pattern != 0 {
            pixel.fill(pattern);
            global.fill(pattern);
        }
        Self { pixel, global, granted: Cell::new(false), counters: Counters::default() }
    }

    /// Allow one operation: the next poll of an invocation performs it.
    #[inline]
    pub fn grant(&self) {
        self.granted.set(true);
    }

    /// Take back what was not used: the invocation had no operation left.
    #[inline]
    pub fn revoke(&self) {
        self.granted.set(false);
    }

    /// What was counted so far.
    #[must_use]
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    #[inline]
    fn arena<S: Space>(&self) -> OwnedView<'_> {
        if S::GLOBAL { self.global.view() } else { self.pixel.view() }
    }
}

/// An operation that waits for its grant.
struct Step<'a, F> {
    granted: &'a Cell<bool>,
    perform: F,
}

impl<T, F: FnMut() -> T + Unpin> Future for Step<'_, F> {
    type Output = T;

    #[inline]
    fn poll(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<T> {
        if self.granted.replace(false) { Poll::Ready((self.perform)()) } else { Poll::Pending }
    }
}

impl Memory for Sim {
    #[inline]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        let perform = move || {
            self.counters.read(access, W::BITS);
            self.arena::<S>().read(at, access)
        };
        Step { granted: &self.granted, perform }
    }

    #[inline]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        let perform = move || {
            self.counters.write(access, W::BITS);
            self.arena::<S>().write(at, value, access);
        };
        Step { granted: &self.granted, perform }
    }

    #[inline]
    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        let perform = move || {
            let old = self.arena::<S>().update(at, update, order);
            self.counters.update(update, old);
            old
        };
        Step { granted: &self.granted, perform }
    }

    /// Not an operation: the invocation goes straight on to its next attempt, which waits.
    #[inline]
    fn spin(&self, _: Mark) -> impl Future<Output = ()> + Unpin {
        self.counters.spin();
        std::future::ready(())
    }
}
