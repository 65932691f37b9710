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
//!   load: who sees a full array also sees an entry 0 at least as new, and stale values are farther, hence safe.
//! * Depths are atomic words, since entry 0 is read outside the lock. The lock is taken by an acquire exchange and
//!   released by a release store, not by a plain one.
//! * Ties: the unlocked test culls only what is strictly behind; inside the lock whole keys decide, so that the kept
//!   set is the k smallest in canonical order whatever the order of arrival.

pub mod faults;
mod invariant;

use std::future::Future;
use std::marker::PhantomData;

use crate::fragment::{Fragment, data_of, depth_of, key, pair_key};
use crate::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Plain, Snapshot, Words, both};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Demand, Form, Keeps, Program};
use crate::scheme::parts::lock::{FREE, SpinLock};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The correct form, or a fault in it: each constant is as it must be unless a fault says otherwise.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How the lock is taken.
    const LOCK: Order = Order::Acquire;
    /// How the lock is released.
    const UNLOCK: Unlock = Unlock::Write(Access::Atomic(Order::Release));
    /// How the counter is read before the lock.
    const COUNTER_READ: Order = Order::Acquire;
    /// How the counter is raised.
    const COUNTER_RAISE: Order = Order::Release;
    /// Whether an element is in place before the counter is raised.
    const ELEMENT_FIRST: bool = true;
    /// Whether the new farthest is found before anything is written.
    const FARTHEST_FIRST: bool = true;
    /// Whether the cull test is repeated inside the lock.
    const SECOND_TEST: bool = true;
    /// Whether that test compares whole keys, and not depths alone.
    const WHOLE_KEYS: bool = true;
    /// Whether a fragment that finds its pixel empty leaves the clearing to the clear pass.
    const CLEARED_BEFORE: bool = true;
    /// Whether a lane that wins the lock leaves the loop at once, with the critical section inside of it.
    const SECTION_IN_LOOP: bool = true;
    /// How long an attempt at the lock is repeated.
    const PATIENCE: Patience = Patience::Endless;

    /// The test inside the lock.
    #[inline(always)]
    #[must_use]
    fn is_nearer(fragment: Fragment, farthest: u64) -> bool {
        if Self::WHOLE_KEYS {
            fragment.key() < farthest
        } else {
            fragment.depth < depth_of(farthest)
        }
    }
}

/// How a lock is released.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlock {
    /// By a write.
    Write(Access),
    /// By an exchange.
    Exchange(Order),
}

/// What a fragment does that does not get the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// It tries until it does.
    Endless,
    /// After so many attempts it goes away, and says nothing.
    Drops(u32),
    /// After every so many attempts it frees the lock, whoever holds it. It ends all the same: another must have taken
    /// the lock since for its next attempt to fail, and each of the others takes it once.
    Frees(u32),
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// The method.
#[derive(Debug)]
pub struct KPlusArray<V> {
    k: u32,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    depth: Words<Pixel, Atomic, u32>,
    data: Words<Pixel, Plain, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    name: "kplus-array",
    title: "k+-buffer: spin lock and max-array",
    paper: "Vasilakis, Fudos 2014",
    section: "3.1, 3.2, Algorithms 1 and 3 (K+B-Array)",
    form: Form::Correct,
    program: Program::STORE,
    words: "2k + 2",
    frame_words: "0",
    published_words: Some("2k + 2"),
    keeps: Keeps::Nearest,
    exact_when: "always",
    arrival_dependent: false,
    racy: false,
    judged: false,
    ties: "canonical: the smaller data word is nearer",
    overflow: "the farthest is evicted",
    needs: "acquire and release on a 32-bit word; forward progress of the lock's holder",
    wgsl: Some("storage buffers; a lock is outside WGSL's guarantees (relaxed atomics only)"),
    depth_format: None,
    default_k: Some(8),
    max_k: u32::MAX / 4,
    demand: Demand::Nothing,
    page: 1,
    interlock: false,
    source: include_str!("kplus_array.rs"),
    ..Contract::BASE
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl<V: Variant> Scheme for KPlusArray<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            lock: SpinLock::new(layout),
            counter: layout.pixel(1),
            depth: layout.pixel(u64::from(k)),
            data: layout.pixel(u64::from(k)),
            variant: PhantomData,
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
        let test = mem.block();
        let seen = mem.load(counter, V::COUNTER_READ).await;
        if seen == self.k
            && fragment.depth > mem.load(self.depth.at(pixel, 0), Order::Relaxed).await
        {
            return Outcome::Culled;
        }
        mem.merge(test).await;
        if !V::CLEARED_BEFORE {
            let empty = mem.block();
            if seen == 0 {
                mem.store(counter, 0, Order::Relaxed).await;
                mem.store(self.depth.at(pixel, 0), EMPTY, Order::Relaxed).await;
            }
            mem.merge(empty).await;
        }
        if !V::SECTION_IN_LOOP {
            let wait = mem.block();
            let mark = mem.mark();
            while self.lock.try_acquire(mem, pixel, V::LOCK).await != FREE {
                mem.spin(mark).await;
            }
            mem.merge(wait).await;
        }
        let _attempts = mem.block();
        let mark = mem.mark();
        let mut failures = 0;
        loop {
            let attempt = mem.block();
            let found = if V::SECTION_IN_LOOP {
                self.lock.try_acquire(mem, pixel, V::LOCK).await
            } else {
                FREE
            };
            if found == FREE {
                let count = mem.load(counter, Order::Relaxed).await;
                let mut outcome = Outcome::Culled;
                if count < self.k {
                    // Append, into entry 0 if it is the farthest; only then raise the counter.
                    if !V::ELEMENT_FIRST {
                        mem.store(counter, count + 1, V::COUNTER_RAISE).await;
                    }
                    let mut last = fragment.key();
                    if count > 0 {
                        let farthest = pair_key(self.entry(mem, pixel, 0).await);
                        if last > farthest {
                            self.put(mem, pixel, 0, last).await;
                            last = farthest;
                        }
                    }
                    self.put(mem, pixel, count, last).await;
                    if V::ELEMENT_FIRST {
                        mem.store(counter, count + 1, V::COUNTER_RAISE).await;
                    }
                    outcome = Outcome::Kept;
                } else {
                    let mut farthest = u64::MAX;
                    if V::SECOND_TEST {
                        farthest = pair_key(self.entry(mem, pixel, 0).await);
                    }
                    if V::is_nearer(fragment, farthest) {
                        // Find who will be the farthest before anything is written.
                        if !V::FARTHEST_FIRST {
                            self.put(mem, pixel, 0, fragment.key()).await;
                        }
                        let (mut place, mut farthest) = (0, fragment.key());
                        for i in 1..self.k {
                            // The data word decides only among equal depths, and is read only then.
                            let depth = mem.load(self.depth.at(pixel, i), Order::Relaxed).await;
                            if depth >= depth_of(farthest) {
                                let data = mem.plain_load(self.data.at(pixel, i)).await;
                                if key(depth, data) > farthest {
                                    (place, farthest) = (i, key(depth, data));
                                }
                            }
                        }
                        if place != 0 {
                            self.put(mem, pixel, place, fragment.key()).await;
                        }
                        self.put(mem, pixel, 0, farthest).await;
                        outcome = Outcome::Evicted;
                    }
                }
                match V::UNLOCK {
                    Unlock::Write(access) => self.lock.release(mem, pixel, access).await,
                    Unlock::Exchange(order) => {
                        self.lock.exchange_free(mem, pixel, order).await;
                    }
                }
                return outcome;
            }
            mem.merge(attempt).await;
            match V::PATIENCE {
                Patience::Endless => mem.spin(mark).await,
                Patience::Drops(attempts) => {
                    failures += 1;
                    if failures == attempts {
                        return Outcome::Kept;
                    }
                }
                Patience::Frees(attempts) => {
                    failures += 1;
                    let time_out = mem.block();
                    if failures % attempts == 0 {
                        self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                    }
                    mem.merge(time_out).await;
                }
            }
        }
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        self.check(words, pixel, moment)
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        for i in 0..count {
            keys.push(pair_key(self.entry(mem, pixel, i).await));
        }
    }
}

impl<V: Variant> KPlusArray<V> {
    /// Depth and data word of an entry.
    #[inline(always)]
    #[track_caller]
    fn entry<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> impl Future<Output = (u32, u32)> {
        both(
            mem.load(self.depth.at(pixel, i), Order::Relaxed),
            mem.plain_load(self.data.at(pixel, i)),
        )
    }

    #[inline(always)]
    #[track_caller]
    fn put<M: Memory>(
        &self,
        mem: &M,
        pixel: u32,
        i: u32,
        entry: u64,
    ) -> impl Future<Output = ((), ())> {
        both(
            mem.plain_store(self.data.at(pixel, i), data_of(entry)),
            mem.store(self.depth.at(pixel, i), depth_of(entry), Order::Relaxed),
        )
    }
}
