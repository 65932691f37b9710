//! Faults that can be built into the max-array. Each is one change of the correct form; the numbers are those of
//! [`crate::catalogue::faults`].

use super::{CONTRACT, Contract, Patience, Unlock, Variant};
use crate::memory::{Access, Order};
use crate::scheme::contract::{Barrier, Pass, Program};

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

/// M2 at the other end: who takes the lock does not acquire what its last holder released.
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

/// M3: a cap on the spin loop, and no word about what became of the fragment. Published shaders have a cap of 200.
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

/// M4: a time-out that takes its holder for dead.
#[derive(Debug)]
pub enum TimeOut {}

impl Variant for TimeOut {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@M4",
        "Fault M4: frees the lock after two failed attempts, whoever holds it",
        "no fragment fails twice to get the lock",
    );
    const PATIENCE: Patience = Patience::Frees(2);
}

/// M5: who finds the counter 0 takes itself for the first, and clears the pixel before it has the lock.
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
/// entry 0 for the farthest that is not, or one that nobody wrote.
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
        arrival_dependent: true,
        ties: "the first to arrive stays",
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
        racy: false,
        needs: "acquire and release on a 32-bit word; independent progress of the lanes of a warp",
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
