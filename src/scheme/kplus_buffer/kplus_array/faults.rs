//! Faults that can be built into the max-array. Each is one change of the correct form; the numbers are those of
//! [`crate::catalogue::faults`]. They have a body of their own, [`Faulty`], with a constant for every place where a
//! fault can be; the correct form has a body without them.

use std::marker::PhantomData;

use super::KPlusArray;
use crate::fragment::{Fragment, depth_of, key, pair_key};
use crate::memory::{Access, Layout, Memory, Order, Snapshot};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Contract, Dependence};
use crate::scheme::parts::lock::FREE;
use crate::scheme::program::{Barrier, Pass, Program};
use crate::scheme::{Config, Keys, Moment, Outcome, Scheme};

/// A fault: each constant is as it must be unless the fault says otherwise.
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
    /// Whether the critical section is inside the loop, so that a lane that wins the lock leaves the loop at once.
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

/// What an invocation does if it does not get the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// It tries until it does.
    Endless,
    /// After so many attempts it gives up, and reports nothing.
    Drops(u32),
    /// After every so many attempts it frees the lock, whichever invocation holds it. It ends all the same: another
    /// must have taken the lock since for its next attempt to fail, and each of the others takes it once.
    Frees(u32),
}

/// The max-array with a fault.
#[derive(Debug)]
pub struct Faulty<V> {
    array: KPlusArray,
    variant: PhantomData<V>,
}

/// No fault: the same operations as the correct form's, which a test of the explorer compares.
#[derive(Debug)]
pub enum NoFault {}

/// The correct form's contract, with the operations of this file.
const CONTRACT: Contract = Contract { source: include_str!("faults.rs"), ..super::CONTRACT };

impl Variant for NoFault {
    const CONTRACT: Contract = CONTRACT;
}

impl<V: Variant> Scheme for Faulty<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self { array: KPlusArray::new(config, layout), variant: PhantomData }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.array.clear(mem, pixel).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (array, pixel) = (&self.array, fragment.pixel);
        let test = mem.block();
        let seen = mem.load(array.counter.at(pixel, 0), V::COUNTER_READ).await;
        if seen == array.k
            && fragment.depth > mem.load(array.depth.at(pixel, 0), Order::Relaxed).await
        {
            return Outcome::Culled;
        }
        mem.merge(test).await;
        if !V::CLEARED_BEFORE {
            self.clear_if_empty(mem, pixel, seen).await;
        }
        if !V::SECTION_IN_LOOP {
            self.wait_for_lock(mem, pixel).await;
        }
        let _attempts = mem.block();
        let mark = mem.mark();
        let mut failures = 0;
        loop {
            let attempt = mem.block();
            let found = if V::SECTION_IN_LOOP {
                array.lock.try_acquire(mem, pixel, V::LOCK).await
            } else {
                FREE
            };
            if found == FREE {
                let outcome = self.insert(mem, fragment).await;
                match V::UNLOCK {
                    Unlock::Write(access) => array.lock.release(mem, pixel, access).await,
                    Unlock::Exchange(order) => {
                        array.lock.exchange_free(mem, pixel, order).await;
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
                        array.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                    }
                    mem.merge(time_out).await;
                }
            }
        }
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        self.array.check(words, pixel, moment)
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        self.array.resolve(mem, pixel, keys).await;
    }
}

impl<V: Variant> Faulty<V> {
    /// M5: clear the pixel if its counter is 0.
    async fn clear_if_empty<M: Memory>(&self, mem: &M, pixel: u32, seen: u32) {
        let empty = mem.block();
        if seen == 0 {
            mem.store(self.array.counter.at(pixel, 0), 0, Order::Relaxed).await;
            mem.store(self.array.depth.at(pixel, 0), EMPTY, Order::Relaxed).await;
        }
        mem.merge(empty).await;
    }

    /// M19: spin until the lock is taken.
    async fn wait_for_lock<M: Memory>(&self, mem: &M, pixel: u32) {
        let wait = mem.block();
        let mark = mem.mark();
        while self.array.lock.try_acquire(mem, pixel, V::LOCK).await != FREE {
            mem.spin(mark).await;
        }
        mem.merge(wait).await;
    }

    /// The critical section.
    async fn insert<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (array, pixel) = (&self.array, fragment.pixel);
        let count = mem.load(array.counter.at(pixel, 0), Order::Relaxed).await;
        if count < array.k {
            self.append(mem, fragment, count).await;
            return Outcome::Kept;
        }
        let mut farthest = u64::MAX;
        if V::SECOND_TEST {
            farthest = pair_key(array.entry(mem, pixel, 0).await);
        }
        if !V::is_nearer(fragment, farthest) {
            return Outcome::Culled;
        }
        self.replace(mem, fragment).await;
        Outcome::Evicted
    }

    /// Append, into entry 0 if it is the farthest; raise the counter before or after.
    async fn append<M: Memory>(&self, mem: &M, fragment: Fragment, count: u32) {
        let (array, pixel) = (&self.array, fragment.pixel);
        let counter = array.counter.at(pixel, 0);
        if !V::ELEMENT_FIRST {
            mem.store(counter, count + 1, V::COUNTER_RAISE).await;
        }
        let mut last = fragment.key();
        if count > 0 {
            let farthest = pair_key(array.entry(mem, pixel, 0).await);
            if last > farthest {
                array.put(mem, pixel, 0, last).await;
                last = farthest;
            }
        }
        array.put(mem, pixel, count, last).await;
        if V::ELEMENT_FIRST {
            mem.store(counter, count + 1, V::COUNTER_RAISE).await;
        }
    }

    /// Replace the farthest; find the new farthest before or after anything is written.
    async fn replace<M: Memory>(&self, mem: &M, fragment: Fragment) {
        let (array, pixel, new) = (&self.array, fragment.pixel, fragment.key());
        if !V::FARTHEST_FIRST {
            array.put(mem, pixel, 0, new).await;
        }
        let (mut place, mut farthest) = (0, new);
        for i in 1..array.k {
            let depth = mem.load(array.depth.at(pixel, i), Order::Relaxed).await;
            if depth >= depth_of(farthest) {
                let data = mem.plain_load(array.data.at(pixel, i)).await;
                if key(depth, data) > farthest {
                    (place, farthest) = (i, key(depth, data));
                }
            }
        }
        if place != 0 {
            array.put(mem, pixel, place, new).await;
        }
        array.put(mem, pixel, 0, farthest).await;
    }
}

/// Where only memory orders differ.
const SEQUENTIAL: &str = "under sequential consistency only";

/// Where interleavings show it.
const ALONE: &str = "no two invocations of a pixel overlap";

/// M1: the lock is released by a plain store, as published: neither atomic nor ordered after what was written under
/// the lock.
#[derive(Debug)]
pub enum PlainUnlock {}

impl Variant for PlainUnlock {
    const CONTRACT: Contract =
        CONTRACT.fault("kplus-array@M1", "Fault M1: unlock by a plain store", SEQUENTIAL);
    const UNLOCK: Unlock = Unlock::Write(Access::Plain);
}

/// M1: the store is atomic, but not ordered, so what was written under the lock may become visible later.
#[derive(Debug)]
pub enum RelaxedUnlock {}

impl Variant for RelaxedUnlock {
    const CONTRACT: Contract =
        CONTRACT.fault("kplus-array@M1-relaxed", "Fault M1: unlock by a relaxed store", SEQUENTIAL);
    const UNLOCK: Unlock = Unlock::Write(Access::Atomic(Order::Relaxed));
}

/// M2: the lock is released by an exchange, which orders nothing either when it is relaxed.
#[derive(Debug)]
pub enum RelaxedExchange {}

impl Variant for RelaxedExchange {
    const CONTRACT: Contract =
        CONTRACT.fault("kplus-array@M2", "Fault M2: unlock by a relaxed exchange", SEQUENTIAL);
    const UNLOCK: Unlock = Unlock::Exchange(Order::Relaxed);
}

/// M2 at the other end: an invocation that takes the lock does not acquire what its last holder released.
#[derive(Debug)]
pub enum RelaxedLock {}

impl Variant for RelaxedLock {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M2-acquire",
        "Fault M2: the lock is taken by a relaxed exchange",
        SEQUENTIAL,
    );
    const LOCK: Order = Order::Relaxed;
}

/// M3: a cap on the spin loop, and no report of what became of the fragment. Published shaders have a cap of 200.
#[derive(Debug)]
pub enum SpinCap {}

impl Variant for SpinCap {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M3",
        "Fault M3: drops a fragment after two failed attempts, silently",
        "no fragment fails twice to get the lock",
    );
    const PATIENCE: Patience = Patience::Drops(2);
}

/// M4: a time-out that takes the lock's holder for dead.
#[derive(Debug)]
pub enum TimeOut {}

impl Variant for TimeOut {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M4",
        "Fault M4: frees the lock after two failed attempts, whichever invocation holds it",
        "no fragment fails twice to get the lock",
    );
    const PATIENCE: Patience = Patience::Frees(2);
}

/// M5: an invocation that finds the counter 0 takes itself for the first, and clears the pixel before it has the lock.
#[derive(Debug)]
pub enum ClearsOutside {}

impl Variant for ClearsOutside {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M5",
        "Fault M5: clears the pixel outside the lock if its counter is 0",
        ALONE,
    );
    const CLEARED_BEFORE: bool = false;
}

/// M6: the counter is read and raised by relaxed operations, so a full array may be seen before its entry 0.
#[derive(Debug)]
pub enum RelaxedCounter {}

impl Variant for RelaxedCounter {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M6",
        "Fault M6: the counter of the unlocked test is read and raised relaxed",
        SEQUENTIAL,
    );
    const COUNTER_READ: Order = Order::Relaxed;
    const COUNTER_RAISE: Order = Order::Relaxed;
}

/// M6 without weak memory: the counter is raised before the element is in place, so an unlocked reader may take an
/// entry 0 for the farthest that is not, or one that was never written.
#[derive(Debug)]
pub enum EarlyCount {}

impl Variant for EarlyCount {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M6-early-count",
        "Fault M6: the counter is raised before the element is in place",
        ALONE,
    );
    const ELEMENT_FIRST: bool = false;
}

/// M9: at equal depth, the first to arrive stays.
#[derive(Debug)]
pub enum EqualDepthStops {}

impl Variant for EqualDepthStops {
    const CONTRACT: Contract = Contract {
        ties: "the first to arrive stays",
        dependence: Dependence::ArrivalAndInterleaving,
        ..CONTRACT.fault("kplus-array@M9", "Fault M9: equal depth is culled", "depths differ")
    };
    const WHOLE_KEYS: bool = false;
}

/// M17: nothing stands between clear and store.
#[derive(Debug)]
pub enum NoBarrierBeforeStore {}

impl Variant for NoBarrierBeforeStore {
    const CONTRACT: Contract = Contract {
        program: Program::of(&[Pass::store(Barrier::Missing)]),
        ..CONTRACT.fault(
            "kplus-array@M17",
            "Fault M17: no barrier between clear and store",
            "no store begins before its pixel's clear has ended",
        )
    };
}

/// M17: nothing stands between store and resolve.
#[derive(Debug)]
pub enum NoBarrierBeforeResolve {}

impl Variant for NoBarrierBeforeResolve {
    const CONTRACT: Contract = Contract {
        program: Program { before_resolve: Barrier::Missing, ..Program::STORE },
        ..CONTRACT.fault(
            "kplus-array@M17-resolve",
            "Fault M17: no barrier between store and resolve",
            "no resolve begins before its pixel's stores have ended",
        )
    };
}

/// M19: the loop ends before the critical section begins. Where the lanes of a warp come together again after a loop,
/// the one that holds the lock waits for those that wait for it.
#[derive(Debug)]
pub enum SpinsFirst {}

impl Variant for SpinsFirst {
    const CONTRACT: Contract = Contract {
        needs: "acquire and release on a 32-bit word; independent progress of the lanes of a warp",
        dependence: CONTRACT.dependence,
        ..CONTRACT.fault(
            "kplus-array@M19",
            "Fault M19: spins first, with the critical section after the loop",
            "always, where lanes of a warp do not wait for each other; else it hangs",
        )
    };
    const SECTION_IN_LOOP: bool = false;
}

/// The test inside the lock is missing: between the unlocked test and the lock, others may have stored nearer
/// fragments.
#[derive(Debug)]
pub enum OneTest {}

impl Variant for OneTest {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@one-test",
        "Fault one-test: no second cull test inside the lock",
        ALONE,
    );
    const SECOND_TEST: bool = false;
}

/// The published order of writes, and nothing else of the published form: a new fragment stands in entry 0, the
/// farthest's place, until the farthest is found.
#[derive(Debug)]
pub enum RootFirst {}

impl Variant for RootFirst {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@root-first",
        "Fault root-first: entry 0 is overwritten before the new farthest is found",
        ALONE,
    );
    const FARTHEST_FIRST: bool = false;
}
