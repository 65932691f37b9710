//! Native memory: std atomics that real threads contend on. Every operation is ready at once.

use std::cell::Cell;
use std::future::{Future, Ready, ready};

use super::arena::{Arena, Shared, SharedView};
use super::{
    Access, At, Atomic, Event, InputAt, Inputs, Kind, Mark, Memory, Observer, Order, Space, Update,
    Word,
};

/// Failed attempts after which a waiting thread yields its core once: the holder may not be running.
const SPINS_BEFORE_YIELD: u32 = 64;

thread_local! {
    /// How often this thread has waited.
    static WAITS: Cell<u32> = const { Cell::new(0) };
}

/// One thread's handle on shared storage. It holds nothing that changes, which lets the compiler keep its addresses in
/// registers across atomic operations.
#[derive(Clone, Copy, Debug)]
pub struct Native<'a, O> {
    pixel: SharedView<'a>,
    global: SharedView<'a>,
    inputs: &'a Inputs,
    observer: &'a O,
}

impl<'a, O: Observer> Native<'a, O> {
    /// A handle that reports to `observer`.
    #[must_use]
    pub fn new(pixel: &'a Shared, global: &'a Shared, inputs: &'a Inputs, observer: &'a O) -> Self {
        Self { pixel: pixel.view(), global: global.view(), inputs, observer }
    }

    #[inline(always)]
    fn arena<S: Space>(&self) -> &SharedView<'a> {
        if S::GLOBAL { &self.global } else { &self.pixel }
    }
}

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl<O: Observer> Memory for Native<'_, O> {
    #[inline(always)]
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        self.observer.read(access, W::BITS);
        ready(self.arena::<S>().read(at, access))
    }

    #[inline(always)]
    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
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
    ) -> impl Future<Output = W> + Unpin {
        let old = self.arena::<S>().update(at, update, order);
        self.observer.update(update, old);
        ready(old)
    }

    #[inline(always)]
    fn input(&self, at: InputAt) -> u32 {
        self.observer.note(Event::Input);
        self.inputs.get(at)
    }

    #[inline]
    fn spin(&self, _: Mark) -> impl Future<Output = ()> + Unpin {
        self.observer.spin();
        wait()
    }

    #[inline(always)]
    fn note(&self, event: Event) {
        self.observer.note(event);
    }
}

/// Pause, and occasionally yield.
#[cold]
fn wait() -> Ready<()> {
    let waits = WAITS.with(|w| w.replace(w.get().wrapping_add(1)));
    if waits % SPINS_BEFORE_YIELD == SPINS_BEFORE_YIELD - 1 {
        std::thread::yield_now();
    } else {
        std::hint::spin_loop();
    }
    ready(())
}
