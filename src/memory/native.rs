//! Native memory: std atomics that real threads contend on. Every operation is ready at once.

use std::cell::Cell;
use std::future::{Future, Ready, ready};

use super::arena::{Arena, Shared, SharedView};
use super::{
    Access, Ahead, At, Atomic, Event, InputAt, Inputs, Kind, Mark, Memory, Observer, Order, Pool,
    Space, Update, Word, complete,
};

/// Failed attempts after which a waiting thread yields its core once: the holder may not be running.
const SPINS_BEFORE_YIELD: u32 = 64;

thread_local! {
    /// How often this thread has waited.
    static WAITS: Cell<u32> = const { Cell::new(0) };
}

/// One thread's handle on shared storage. It holds nothing that changes (what it takes ahead lies outside), which lets the compiler keep its addresses in
/// registers across atomic operations.
#[derive(Clone, Copy, Debug)]
pub struct Native<'a, O> {
    pixel: SharedView<'a>,
    global: SharedView<'a>,
    ahead: &'a [Ahead],
    inputs: &'a Inputs,
    observer: &'a O,
}

impl<'a, O: Observer> Native<'a, O> {
    /// A handle that reports to `observer`.
    #[must_use]
    pub fn new(pixel: &'a Shared, global: &'a Shared, inputs: &'a Inputs, observer: &'a O) -> Self {
        Self { pixel: pixel.view(), global: global.view(), ahead: &[], inputs, observer }
    }

    /// The same, taking the indices of pools from these, as long as there are any.
    #[must_use]
    pub fn taking(self, ahead: &'a [Ahead]) -> Self {
        Self { ahead, ..self }
    }

    /// Take so many indices ahead, from every pool. What is left of earlier ones is not handed out any more. Not an
    /// operation of an invocation: it is not observed, while an invocation that takes one of them is.
    pub fn take_ahead(&self, count: u32) {
        for ahead in self.ahead {
            let counter = ahead.pool().counter();
            ahead.set(self.global.update(counter, Update::Add(count), Order::Relaxed), count);
        }
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
    fn take(&self, pool: Pool) -> impl Future<Output = u32> + Unpin {
        let index = match pool.of(self.ahead).and_then(Ahead::next) {
            Some(index) => index,
            None => self.global.update(pool.counter(), Update::Add(1), Order::Relaxed),
        };
        self.observer.update(Update::Add(1u32), index);
        ready(index)
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

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    use super::*;
    use crate::memory::Layout;

    fn now<T>(ready: impl Future<Output = T>) -> T {
        match pin!(ready).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(value) => value,
            Poll::Pending => unreachable!("all operations are ready"),
        }
    }

    /// What a worker does wrong.
    #[derive(Clone, Copy, PartialEq)]
    enum Fault {
        None,
        /// It takes one fewer ahead than it hands out.
        OneTooFew,
        /// It begins every message where it began the first.
        SameAgain,
    }

    /// The indices that workers on threads get, sorted, and what is added to the counter. Each of their messages is
    /// how many fragments it has, and how many of these need an index.
    fn taken(workers: &[Vec<[u32; 2]>], fault: Fault) -> (Vec<u32>, u32) {
        let mut layout = Layout::default();
        let pool = layout.pool();
        let pixel = Shared::new(layout.per_pixel(), 0);
        let global = Shared::new(layout.per_frame(), 1);
        let inputs = Inputs::defaults(&layout);
        let work = |messages: &[[u32; 2]]| {
            let ahead = layout.ahead();
            let mem = Native::new(&pixel, &global, &inputs, &()).taking(&ahead);
            let mut indices = Vec::new();
            for &[fragments, need] in messages {
                match fault {
                    Fault::None => mem.take_ahead(fragments),
                    Fault::OneTooFew => {
                        let first = mem.global.update(
                            pool.counter(),
                            Update::Add(fragments - 1),
                            Order::Relaxed,
                        );
                        ahead[0].set(first, fragments);
                    }
                    Fault::SameAgain => ahead[0].set(0, fragments),
                }
                indices.extend((0..need).map(|_| now(mem.take(pool))));
            }
            indices
        };
        let mut all: Vec<u32> = std::thread::scope(|scope| {
            let threads: Vec<_> = workers.iter().map(|m| scope.spawn(|| work(m))).collect();
            threads.into_iter().flat_map(|thread| thread.join().expect("a worker")).collect()
        });
        all.sort_unstable();
        let counter = global.view().read(pool.counter(), Access::Atomic(Order::Relaxed));
        (all, counter)
    }

    fn workers(need: impl Fn(u32) -> u32) -> Vec<Vec<[u32; 2]>> {
        let message = |worker: u32| (1..90).map(move |i| 1 + i * (worker + 3) % 64);
        (0..4).map(|worker| message(worker).map(|n| [n, need(n)]).collect()).collect()
    }

    fn fragments(workers: &[Vec<[u32; 2]>]) -> u32 {
        workers.iter().flatten().map(|[fragments, _]| fragments).sum()
    }

    /// A pool with room for every fragment gives each an index of its own within it, as if none were taken ahead.
    #[test]
    fn indices_taken_ahead_are_those_of_the_counter() {
        let all = workers(|fragments| fragments);
        let right: Vec<u32> = (0..fragments(&all)).collect();
        assert_eq!(taken(&all, Fault::None), (right.clone(), fragments(&all)));
        // Those beyond what was taken ahead come from the counter.
        let more: Vec<Vec<[u32; 2]>> = vec![vec![[0, 3], [2, 3]], vec![[1, 1]]];
        assert_eq!(taken(&more, Fault::None), ((0..7).collect(), 7));
    }

    /// What is left over is lost to the others, but there is room for it.
    #[test]
    fn what_is_left_over_takes_no_room_from_others() {
        let some = workers(|fragments| fragments / 3);
        let (mut indices, counter) = taken(&some, Fault::None);
        let handed_out = indices.len();
        assert!(indices.iter().all(|&index| index < fragments(&some)));
        assert_eq!(counter, fragments(&some));
        indices.dedup();
        assert_eq!(indices.len(), handed_out, "none twice");
    }

    #[test]
    fn an_index_handed_out_twice_is_seen() {
        let all = workers(|fragments| fragments);
        for fault in [Fault::OneTooFew, Fault::SameAgain] {
            let (mut indices, _) = taken(&all, fault);
            let handed_out = indices.len();
            indices.dedup();
            assert!(indices.len() < handed_out);
        }
    }
}
