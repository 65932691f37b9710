//! k+-buffer with a max-array (Vasilakis, Fudos, "k+-buffer: fragment synchronized k-buffer", I3D 2014; K+B-Array), in
//! its correct form.
//!
//! A spin lock per pixel guards an array whose entry 0 is always its farthest. While there is room, a fragment is
//! appended; then it replaces the farthest, and the new farthest moves to entry 0. A cull test before the lock spares
//! distant fragments the wait.
//!
//! What the correct form does differently from Algorithm 3 (kept as `kplus-array@published`), and why:
//! * Entry 0 never holds anything nearer than the true farthest: the new farthest is found *before* anything is
//!   written, and the freed entry is written before entry 0. The published order puts the new fragment into entry 0
//!   first, and an unlocked reader may be culled against it.
//! * The counter is raised by a release store after the element is in place, and read before the lock by an acquire
//!   load: an invocation that sees a full array also sees an entry 0 at least as new, and stale values are farther,
//!   hence safe.
//! * Depths are atomic words, since entry 0 is read outside the lock. The lock is taken by an acquire exchange and
//!   released by a release store, not by a plain one.
//! * Ties: the unlocked test culls only what is strictly behind; inside the lock whole keys decide, so that the kept
//!   set is the k smallest in canonical order whatever the order of arrival.

pub mod faults;
mod invariant;

use std::future::Future;

use crate::fragment::{Fragment, data_of, depth_of, key, pair_key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Snapshot, Words, both};
use crate::scheme::contract::Keeps;
use crate::scheme::parts::lock::reach::{Reach, Updated, updated};
use crate::scheme::parts::lock::{FREE, SpinLock};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The method.
#[derive(Debug)]
pub struct KPlusArray<R: Reach = Plain> {
    k: u32,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    depth: Words<Pixel, Atomic, u32>,
    data: Words<Pixel, R::Kind, u32>,
}

const CONTRACT: Contract = Contract {
    title: "k+-buffer: spin lock and max-array",
    section: "3.1, 3.2, Algorithms 1 and 3 (K+B-Array)",
    published_words: Some("2k + 2"),
    source: include_str!("kplus_array.rs"),
    ..super::locked("kplus-array", Keeps::Nearest)
};

/// The correct form, or a mended one: `R` says how the lock's holder reaches its words.
pub trait Variant: Reach {
    /// This form's contract.
    const CONTRACT: Contract;
}

impl Variant for Plain {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Atomic {
    const CONTRACT: Contract = CONTRACT
        .mended("kplus-array@atomic", "k+-buffer: spin lock and max-array, all words atomic");
}

impl Variant for Updated {
    const CONTRACT: Contract = updated(
        CONTRACT,
        "kplus-array@rmw",
        "k+-buffer: spin lock and max-array, all accesses updates",
    );
}

impl<R: Variant> Scheme for KPlusArray<R> {
    const CONTRACT: Contract = R::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    /// One body, no inner `async fn`: see `memory::both`.
    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let counter = self.counter.at(pixel, 0);
        // A full array's farthest is in entry 0: what lies behind it need not wait for the lock.
        let test = mem.block();
        if mem.load(counter, R::ACQUIRE).await == self.k
            && fragment.depth > R::load(mem, self.depth.at(pixel, 0), Order::Relaxed).await
        {
            return Outcome::Culled;
        }
        mem.merge(test).await;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, R::ACQUIRE).await == FREE {
                let new = fragment.key();
                let count = R::load(mem, counter, Order::Relaxed).await;
                let mut outcome = Outcome::Culled;
                if count < self.k {
                    // Append, into entry 0 if it is the farthest; only then raise the counter.
                    let mut last = new;
                    if count > 0 {
                        let farthest = pair_key(self.entry(mem, pixel, 0).await);
                        if last > farthest {
                            self.put(mem, pixel, 0, last).await;
                            last = farthest;
                        }
                    }
                    self.put(mem, pixel, count, last).await;
                    R::store(mem, counter, count + 1, Order::Release).await;
                    outcome = Outcome::Kept;
                } else if new < pair_key(self.entry(mem, pixel, 0).await) {
                    // Find the new farthest before anything is written.
                    let (mut place, mut farthest) = (0, new);
                    for i in 1..self.k {
                        // The data word decides only among equal depths, and is read only then.
                        let depth = R::load(mem, self.depth.at(pixel, i), Order::Relaxed).await;
                        if depth >= depth_of(farthest) {
                            let data = R::read(mem, self.data.at(pixel, i)).await;
                            if key(depth, data) > farthest {
                                (place, farthest) = (i, key(depth, data));
                            }
                        }
                    }
                    // The new record takes the place of the new farthest, which takes that of entry 0, the evicted one.
                    if place != 0 {
                        self.put(mem, pixel, place, new).await;
                    }
                    self.put(mem, pixel, 0, farthest).await;
                    outcome = Outcome::Evicted;
                }
                R::release(mem, self.lock, pixel).await;
                return outcome;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        self.check(words, pixel, moment)
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        for i in 0..count {
            let (depth, data) = (self.depth.at(pixel, i), self.data.at(pixel, i));
            let record = both(mem.load(depth, Order::Relaxed), mem.read(data, R::SETTLED)).await;
            keys.push(pair_key(record));
        }
    }
}

impl<R: Reach> KPlusArray<R> {
    /// Depth and data word of an entry.
    #[inline(always)]
    #[track_caller]
    fn entry<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> impl Future<Output = (u32, u32)> {
        both(
            R::load(mem, self.depth.at(pixel, i), Order::Relaxed),
            R::read(mem, self.data.at(pixel, i)),
        )
    }

    #[inline(always)]
    #[track_caller]
    fn put<M: Memory>(&self, mem: &M, pixel: u32, i: u32, entry: u64) -> impl Future {
        both(
            R::write(mem, self.data.at(pixel, i), data_of(entry)),
            R::store(mem, self.depth.at(pixel, i), depth_of(entry), Order::Relaxed),
        )
    }
}
