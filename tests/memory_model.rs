//! The memory models against well-known litmus programs: which results each allows, and whether it calls a race.
//!
//! One table, [`PROGRAMS`], says what is expected of sequential consistency and of relaxed memory under each profile,
//! as complete sets where they are small. Results that the full model of Vulkan or C11 allows and the explorer
//! knowingly never shows are in the table too: a write is there before it is read, so nothing is found whose program
//! order and reads form a cycle (LB). `tests/axioms` compares all short programs of two threads with the axioms.

use fragloom::scheme::contract::{Dependence, Keeps};
use std::collections::BTreeSet;

use fragloom::explore::{
    Conditions, Entry, Limits, Litmus, MemoryModel, Profile, Property, Subject, explore,
};
use fragloom::fragment::{Fragment, data_of, depth_of, key};
use fragloom::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Plain, Update, Words};

use fragloom::scheme::{Config, Contract, Held, Keys, Outcome, Scheme};

/// The models, in the order of the table's columns.
const MODELS: [MemoryModel; 4] = [
    MemoryModel::Sequential,
    MemoryModel::Relaxed(Profile::Glsl),
    MemoryModel::Relaxed(Profile::Vulkan),
    MemoryModel::Relaxed(Profile::Wgsl),
];

/// A word of the pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    /// Atomic words, 0 at first.
    X,
    Y,
    Z,
    /// An atomic word that the clear pass leaves out.
    Unset,
    /// A plain word, 0 at first.
    D,
}

use Word::{D, Unset, X, Y, Z};

/// One step of a thread.
#[derive(Clone, Copy, Debug)]
enum Op {
    /// Read; the value is part of the result.
    Read(Word, Access),
    Write(Word, u32, Access),
    /// Update; the old value is part of the result.
    Update(Word, Update<u32>, Order),
    /// Go on only if the last value was this.
    Need(u32),
    /// Exchange 1 for 0, as often as it takes.
    Lock(Word, Order),
}

use Op::{Lock, Need, Read, Write};

const PLAIN: Access = Access::Plain;
const RLX: Access = Access::Atomic(Order::Relaxed);
const ACQ: Access = Access::Atomic(Order::Acquire);
const REL: Access = Access::Atomic(Order::Release);

const fn add(word: Word, order: Order) -> Op {
    Op::Update(word, Update::Add(1), order)
}

const fn exchange(word: Word, value: u32, order: Order) -> Op {
    Op::Update(word, Update::Exchange(value), order)
}

const fn cas(word: Word, expected: u32, new: u32, order: Order) -> Op {
    Op::Update(word, Update::CompareExchange { expected, new }, order)
}

/// Results: what each thread read, threads apart by commas, then after a bar the last values of the words asked for.
/// `-` was not reached, `g` is greater than 9.
#[derive(Clone, Copy, Debug)]
enum Results {
    /// These.
    Are(&'static str),
    /// So many, and none of these.
    Lack(usize, &'static str),
}

use Results::{Are, Lack};

/// What a model does with a program.
#[derive(Clone, Copy, Debug)]
struct Expected {
    results: Results,
    race: bool,
}

const fn allows(results: Results) -> Expected {
    Expected { results, race: false }
}

const fn races(results: Results) -> Expected {
    Expected { results, race: true }
}

struct Program {
    name: &'static str,
    threads: &'static [&'static [Op]],
    /// Words whose last values are part of the result.
    finals: &'static [Word],
    /// In the order of [`MODELS`].
    expected: [Expected; 4],
    /// What the full model allows besides, with the orders as written.
    omitted: &'static str,
}

impl Program {
    const fn new(
        name: &'static str,
        threads: &'static [&'static [Op]],
        expected: [Expected; 4],
    ) -> Self {
        Self { name, threads, finals: &[], expected, omitted: "" }
    }

    const fn finals(self, finals: &'static [Word]) -> Self {
        Self { finals, ..self }
    }

    const fn omits(self, omitted: &'static str) -> Self {
        Self { omitted, ..self }
    }
}

/// The same under all four.
const fn all(results: &'static str) -> [Expected; 4] {
    [allows(Are(results)); 4]
}

/// Relaxed memory shows more than sequential consistency, whatever the profile.
const fn weak(sequential: &'static str, relaxed: &'static str) -> [Expected; 4] {
    let relaxed = allows(Are(relaxed));
    [allows(Are(sequential)), relaxed, relaxed, relaxed]
}

/// The orders do what they are for, and WGSL has none.
const fn ordered(results: &'static str, wgsl: Expected) -> [Expected; 4] {
    let same = allows(Are(results));
    [same, same, same, wgsl]
}

const PROGRAMS: &[Program] = &[
    // Message passing.
    Program::new(
        "MP, relaxed",
        &[&[Write(X, 1, RLX), Write(Y, 1, RLX)], &[Read(Y, RLX), Read(X, RLX)]],
        weak("00 01 11", "00 01 10 11"),
    ),
    Program::new(
        "MP, release and acquire",
        &[&[Write(X, 1, RLX), Write(Y, 1, REL)], &[Read(Y, ACQ), Read(X, RLX)]],
        ordered("00 01 11", allows(Are("00 01 10 11"))),
    ),
    Program::new(
        "MP, release only",
        &[&[Write(X, 1, RLX), Write(Y, 1, REL)], &[Read(Y, RLX), Read(X, RLX)]],
        weak("00 01 11", "00 01 10 11"),
    ),
    Program::new(
        "MP, acquire only",
        &[&[Write(X, 1, RLX), Write(Y, 1, RLX)], &[Read(Y, ACQ), Read(X, RLX)]],
        weak("00 01 11", "00 01 10 11"),
    ),
    Program::new(
        "MP of plain data, release and acquire",
        &[&[Write(D, 1, PLAIN), Write(Y, 1, REL)], &[Read(Y, ACQ), Need(1), Read(D, PLAIN)]],
        ordered("0- 11", races(Are("0- 10 11"))),
    ),
    Program::new(
        "MP of plain data, relaxed",
        &[&[Write(D, 1, PLAIN), Write(Y, 1, RLX)], &[Read(Y, RLX), Need(1), Read(D, PLAIN)]],
        [
            allows(Are("0- 11")),
            allows(Are("0- 10 11")),
            races(Are("0- 10 11")),
            races(Are("0- 10 11")),
        ],
    ),
    Program::new(
        "MP of plain data, read in any case",
        &[&[Write(D, 1, PLAIN), Write(Y, 1, REL)], &[Read(Y, ACQ), Read(D, PLAIN)]],
        [
            allows(Are("00 01 11")),
            allows(Are("00 01 11")),
            races(Are("00 01 11")),
            races(Are("00 01 10 11")),
        ],
    ),
    // A relaxed read, then an acquire read of something else: only a barrier orders what came with the first.
    Program::new(
        "MP, the orders are on another word",
        &[
            &[Write(X, 1, RLX), Write(Z, 1, REL), Write(Y, 1, RLX)],
            &[Read(Y, RLX), Read(Z, ACQ), Read(X, RLX)],
        ],
        [
            allows(Are("000 001 011 111")),
            allows(Are("000 001 011 101 111")),
            allows(Lack(6, "010 110")),
            allows(Lack(8, "")),
        ],
    ),
    Program::new(
        "WRC: what was seen is passed on",
        &[&[Write(X, 1, RLX)], &[Read(X, RLX), Write(Y, 1, REL)], &[Read(Y, ACQ), Read(X, RLX)]],
        [
            allows(Lack(7, "1,10")),
            allows(Lack(7, "1,10")),
            allows(Lack(7, "1,10")),
            allows(Lack(8, "")),
        ],
    ),
    // Release sequences.
    Program::new(
        "an update passes a release on",
        &[
            &[Write(D, 1, PLAIN), Write(X, 1, REL)],
            &[cas(X, 1, 2, Order::Relaxed)],
            &[Read(X, ACQ), Need(2), Read(D, PLAIN)],
        ],
        ordered("0,0- 0,1- 1,0- 1,1- 1,21", races(Are("0,0- 0,1- 1,0- 1,1- 1,20 1,21"))),
    ),
    Program::new(
        "another thread's store does not pass a release on",
        &[
            &[Write(D, 1, PLAIN), Write(X, 1, REL)],
            &[Read(X, RLX), Need(1), Write(X, 2, RLX)],
            &[Read(X, ACQ), Need(2), Read(D, PLAIN)],
        ],
        [
            allows(Are("0,0- 0,1- 1,0- 1,1- 1,21")),
            allows(Are("0,0- 0,1- 1,0- 1,1- 1,20 1,21")),
            races(Are("0,0- 0,1- 1,0- 1,1- 1,20 1,21")),
            races(Are("0,0- 0,1- 1,0- 1,1- 1,20 1,21")),
        ],
    ),
    // A release barrier also covers every later store; a release store covers only itself.
    Program::new(
        "the same thread's later store does not pass a release on",
        &[
            &[Write(D, 1, PLAIN), Write(X, 1, REL), Write(X, 2, RLX)],
            &[Read(X, ACQ), Need(2), Read(D, PLAIN)],
        ],
        [
            allows(Are("0- 1- 21")),
            allows(Are("0- 1- 21")),
            races(Are("0- 1- 20 21")),
            races(Are("0- 1- 20 21")),
        ],
    ),
    // Store buffering: without sequentially consistent operations, nothing forbids 00.
    Program::new(
        "SB, relaxed",
        &[&[Write(X, 1, RLX), Read(Y, RLX)], &[Write(Y, 1, RLX), Read(X, RLX)]],
        weak("0,1 1,0 1,1", "0,0 0,1 1,0 1,1"),
    ),
    Program::new(
        "SB, release and acquire",
        &[&[Write(X, 1, REL), Read(Y, ACQ)], &[Write(Y, 1, REL), Read(X, ACQ)]],
        weak("0,1 1,0 1,1", "0,0 0,1 1,0 1,1"),
    ),
    Program::new(
        "SB, by exchanges",
        &[
            &[exchange(X, 1, Order::AcqRel), Read(Y, ACQ)],
            &[exchange(Y, 1, Order::AcqRel), Read(X, ACQ)],
        ],
        weak("00,01 01,00 01,01", "00,00 00,01 01,00 01,01"),
    ),
    // Independent reads of independent writes: two readers may disagree on the order of two writes.
    Program::new(
        "IRIW, release and acquire",
        &[
            &[Write(X, 1, REL)],
            &[Write(Y, 1, REL)],
            &[Read(X, ACQ), Read(Y, ACQ)],
            &[Read(Y, ACQ), Read(X, ACQ)],
        ],
        [
            allows(Lack(15, "10,10")),
            allows(Lack(16, "")),
            allows(Lack(16, "")),
            allows(Lack(16, "")),
        ],
    ),
    // Knowingly left out.
    Program::new(
        "LB, relaxed",
        &[&[Read(X, RLX), Write(Y, 1, RLX)], &[Read(Y, RLX), Write(X, 1, RLX)]],
        all("0,0 0,1 1,0"),
    )
    .omits("1,1"),
    Program::new(
        "LB, release and acquire",
        &[&[Read(X, ACQ), Write(Y, 1, REL)], &[Read(Y, ACQ), Write(X, 1, REL)]],
        all("0,0 0,1 1,0"),
    ),
    // A write may come before one that was performed earlier, in its word's order.
    Program::new(
        "2+2W, relaxed",
        &[&[Write(X, 2, RLX), Write(Y, 1, RLX)], &[Write(Y, 2, RLX), Write(X, 1, RLX)]],
        weak("|11 |12 |21", "|11 |12 |21 |22"),
    )
    .finals(&[X, Y]),
    // Nobody acquires, so that releases order nothing.
    Program::new(
        "2+2W, release",
        &[&[Write(X, 2, REL), Write(Y, 1, REL)], &[Write(Y, 2, REL), Write(X, 1, REL)]],
        weak("|11 |12 |21", "|11 |12 |21 |22"),
    )
    .finals(&[X, Y]),
    // Exchanges show which came first: that is load buffering.
    Program::new(
        "2+2W, by relaxed exchanges",
        &[
            &[exchange(X, 2, Order::Relaxed), exchange(Y, 1, Order::Relaxed)],
            &[exchange(Y, 2, Order::Relaxed), exchange(X, 1, Order::Relaxed)],
        ],
        all("00,12|12 02,02|11 12,00|21"),
    )
    .finals(&[X, Y])
    .omits("10,10|22"),
    Program::new(
        "3.2W, relaxed",
        &[
            &[Write(X, 2, RLX), Write(Y, 1, RLX)],
            &[Write(Y, 2, RLX), Write(Z, 1, RLX)],
            &[Write(Z, 2, RLX), Write(X, 1, RLX)],
        ],
        weak("|111 |112 |121 |122 |211 |212 |221", "|111 |112 |121 |122 |211 |212 |221 |222"),
    )
    .finals(&[X, Y, Z]),
    Program::new(
        "S, relaxed",
        &[&[Write(X, 2, RLX), Write(Y, 1, RLX)], &[Read(Y, RLX), Write(X, 1, RLX)]],
        weak("0|1 0|2 1|1", "0|1 0|2 1|1 1|2"),
    )
    .finals(&[X]),
    Program::new(
        "S, release and acquire",
        &[&[Write(X, 2, RLX), Write(Y, 1, REL)], &[Read(Y, ACQ), Write(X, 1, RLX)]],
        ordered("0|1 0|2 1|1", allows(Are("0|1 0|2 1|1 1|2"))),
    )
    .finals(&[X]),
    Program::new(
        "S, release only",
        &[&[Write(X, 2, RLX), Write(Y, 1, REL)], &[Read(Y, RLX), Write(X, 1, RLX)]],
        weak("0|1 0|2 1|1", "0|1 0|2 1|1 1|2"),
    )
    .finals(&[X]),
    Program::new(
        "S, acquire only",
        &[&[Write(X, 2, RLX), Write(Y, 1, RLX)], &[Read(Y, ACQ), Write(X, 1, RLX)]],
        weak("0|1 0|2 1|1", "0|1 0|2 1|1 1|2"),
    )
    .finals(&[X]),
    // An update reads an old value, and comes before writes that were performed earlier.
    Program::new(
        "MP to an update, relaxed",
        &[&[Write(X, 1, RLX), Write(Y, 1, RLX)], &[Read(Y, RLX), add(X, Order::Relaxed)]],
        weak("00|1 01|2 11|2", "00|1 01|2 10|1 11|2"),
    )
    .finals(&[X]),
    Program::new(
        "MP to an update, release and acquire",
        &[&[Write(X, 1, RLX), Write(Y, 1, REL)], &[Read(Y, ACQ), add(X, Order::Relaxed)]],
        ordered("00|1 01|2 11|2", allows(Are("00|1 01|2 10|1 11|2"))),
    )
    .finals(&[X]),
    // The head of a list is set up, and a flag says so; then another invocation puts a node in front. Its node is lost
    // if the set-up comes behind it in the head's order.
    Program::new(
        "a head that is ready, relaxed",
        &[
            &[Write(X, 1, RLX), Write(Y, 1, RLX)],
            &[Read(Y, RLX), Need(1), exchange(X, 2, Order::Relaxed)],
        ],
        weak("0-|1 11|2", "0-|1 10|1 11|2"),
    )
    .finals(&[X]),
    Program::new(
        "a head that is ready, release and acquire",
        &[
            &[Write(X, 1, RLX), Write(Y, 1, REL)],
            &[Read(Y, ACQ), Need(1), exchange(X, 2, Order::Relaxed)],
        ],
        ordered("0-|1 11|2", allows(Are("0-|1 10|1 11|2"))),
    )
    .finals(&[X]),
    Program::new(
        "R, relaxed",
        &[&[Write(X, 1, RLX), Write(Y, 1, RLX)], &[Write(Y, 2, RLX), Read(X, RLX)]],
        weak("0|1 1|1 1|2", "0|1 0|2 1|1 1|2"),
    )
    .finals(&[Y]),
    // Without sequentially consistent barriers, the order of two stores orders nothing else.
    Program::new(
        "R, release and acquire",
        &[&[Write(X, 1, RLX), Write(Y, 1, REL)], &[Write(Y, 2, REL), Read(X, ACQ)]],
        weak("0|1 1|1 1|2", "0|1 0|2 1|1 1|2"),
    )
    .finals(&[Y]),
    Program::new(
        "R, by exchanges",
        &[
            &[Write(X, 1, RLX), exchange(Y, 1, Order::AcqRel)],
            &[exchange(Y, 2, Order::AcqRel), Read(X, RLX)],
        ],
        ordered("0,11|2 2,00|1 2,01|1", allows(Are("0,10|2 0,11|2 2,00|1 2,01|1"))),
    )
    .finals(&[Y]),
    Program::new(
        "Z6.3, release and acquire",
        &[
            &[Write(X, 1, RLX), Write(Y, 1, REL)],
            &[Write(Y, 2, REL), Write(Z, 1, REL)],
            &[Read(Z, ACQ), Read(X, RLX)],
        ],
        weak("00|1 00|2 01|1 01|2 10|1 11|1 11|2", "00|1 00|2 01|1 01|2 10|1 10|2 11|1 11|2"),
    )
    .finals(&[Y]),
    // Coherence: every word alone is sequential.
    Program::new("CoRR", &[&[Write(X, 1, RLX)], &[Read(X, RLX), Read(X, RLX)]], all("00 01 11")),
    Program::new(
        "CoRR, two writers and two readers",
        &[
            &[Write(X, 1, RLX)],
            &[Write(X, 2, RLX)],
            &[Read(X, RLX), Read(X, RLX)],
            &[Read(X, RLX), Read(X, RLX)],
        ],
        [allows(Lack(47, "12,21 21,12 10,00 20,00")); 4],
    ),
    Program::new(
        "CoWW",
        &[&[Write(X, 1, RLX), Write(X, 2, RLX)], &[Read(X, RLX), Read(X, RLX)]],
        all("00|2 01|2 02|2 11|2 12|2 22|2"),
    )
    .finals(&[X]),
    Program::new(
        "CoWR",
        &[&[Write(X, 1, RLX), Read(X, RLX)], &[Write(X, 2, RLX)]],
        all("1|1 1|2 2|2"),
    )
    .finals(&[X]),
    Program::new(
        "CoRW",
        &[&[Read(X, RLX), Write(X, 1, RLX)], &[Write(X, 2, RLX)]],
        all("0|1 0|2 2|1"),
    )
    .finals(&[X]),
    // Updates are one step.
    Program::new(
        "two additions",
        &[&[add(X, Order::Relaxed)], &[add(X, Order::Relaxed)]],
        all("0,1|2 1,0|2"),
    )
    .finals(&[X]),
    Program::new(
        "three additions",
        &[&[add(X, Order::Relaxed)], &[add(X, Order::Relaxed)], &[add(X, Order::Relaxed)]],
        all("0,1,2|3 0,2,1|3 1,0,2|3 1,2,0|3 2,0,1|3 2,1,0|3"),
    )
    .finals(&[X]),
    Program::new(
        "two exchanges",
        &[&[exchange(X, 1, Order::Relaxed)], &[exchange(X, 2, Order::Relaxed)]],
        all("0,1|2 2,0|1"),
    )
    .finals(&[X]),
    Program::new(
        "an exchange and a store",
        &[&[exchange(X, 1, Order::Relaxed)], &[Write(X, 2, RLX)]],
        all("0|2 2|1"),
    )
    .finals(&[X]),
    Program::new(
        "loads and stores are two steps",
        &[&[Read(X, RLX), Write(X, 1, RLX)], &[Read(X, RLX), Write(X, 2, RLX)]],
        all("0,0|1 0,0|2 0,1|2 2,0|1"),
    )
    .finals(&[X]),
    Program::new(
        "one compare-exchange wins",
        &[&[cas(X, 0, 1, Order::Relaxed)], &[cas(X, 0, 2, Order::Relaxed)]],
        all("0,1|1 2,0|2"),
    )
    .finals(&[X]),
    // A compare-exchange that fails is a load, which may be stale.
    Program::new(
        "a compare-exchange fails on a stale value",
        &[&[Write(X, 1, RLX), Write(Y, 1, RLX)], &[Read(Y, RLX), cas(X, 1, 2, Order::Relaxed)]],
        weak("00|1 01|2 11|2", "00|1 01|2 10|1 11|2"),
    )
    .finals(&[X]),
    Program::new(
        "a compare-exchange after an acquire does not",
        &[&[Write(X, 1, RLX), Write(Y, 1, REL)], &[Read(Y, ACQ), cas(X, 1, 2, Order::Relaxed)]],
        ordered("00|1 01|2 11|2", allows(Are("00|1 01|2 10|1 11|2"))),
    )
    .finals(&[X]),
    // An exchange that changes nothing still releases, to an update that can only come later.
    Program::new(
        "an exchange of the same value releases",
        &[
            &[Write(D, 1, PLAIN), exchange(X, 0, Order::AcqRel), Write(Y, 1, RLX)],
            &[Read(Y, RLX), Need(1), exchange(X, 0, Order::Acquire), Read(D, PLAIN)],
        ],
        ordered("0,0-- 0,101", races(Are("0,0-- 0,100 0,101"))),
    ),
    Program::new(
        "an update that changes nothing releases",
        &[
            &[Write(Y, 1, RLX), Op::Update(X, Update::Or(0), Order::AcqRel)],
            &[exchange(X, 1, Order::AcqRel), Read(Y, RLX)],
        ],
        ordered("0,01 1,00 1,01", allows(Are("0,00 0,01 1,00 1,01"))),
    ),
    // Locks: a waiter's exchanges find their own value, and must not make states without end.
    Program::new(
        "lock, acquire and release",
        &[
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 1, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 2, PLAIN), Write(X, 0, REL)],
        ],
        ordered("0,1|2 2,0|1", races(Are("0,0|1 0,0|2 0,1|2 2,0|1"))),
    )
    .finals(&[D]),
    Program::new(
        "lock, taken by an exchange that releases too",
        &[
            &[Lock(X, Order::AcqRel), Read(D, PLAIN), Write(D, 1, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::AcqRel), Read(D, PLAIN), Write(D, 2, PLAIN), Write(X, 0, REL)],
        ],
        ordered("0,1|2 2,0|1", races(Are("0,0|1 0,0|2 0,1|2 2,0|1"))),
    )
    .finals(&[D]),
    Program::new(
        "lock, relaxed unlock",
        &[
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 1, PLAIN), Write(X, 0, RLX)],
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 2, PLAIN), Write(X, 0, RLX)],
        ],
        [
            allows(Are("0,1|2 2,0|1")),
            allows(Are("0,0|1 0,0|2 0,1|2 2,0|1")),
            races(Are("0,0|1 0,0|2 0,1|2 2,0|1")),
            races(Are("0,0|1 0,0|2 0,1|2 2,0|1")),
        ],
    )
    .finals(&[D]),
    Program::new(
        "lock, relaxed exchange",
        &[
            &[Lock(X, Order::Relaxed), Read(D, PLAIN), Write(D, 1, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::Relaxed), Read(D, PLAIN), Write(D, 2, PLAIN), Write(X, 0, REL)],
        ],
        [
            allows(Are("0,1|2 2,0|1")),
            allows(Are("0,0|1 0,0|2 0,1|2 2,0|1")),
            races(Are("0,0|1 0,0|2 0,1|2 2,0|1")),
            races(Are("0,0|1 0,0|2 0,1|2 2,0|1")),
        ],
    )
    .finals(&[D]),
    Program::new(
        "lock, three threads",
        &[
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 1, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 2, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::Acquire), Read(D, PLAIN), Write(D, 3, PLAIN), Write(X, 0, REL)],
        ],
        [
            allows(Are("0,1,2|3 0,3,1|2 2,0,1|3 2,3,0|1 3,0,2|1 3,1,0|2")),
            allows(Are("0,1,2|3 0,3,1|2 2,0,1|3 2,3,0|1 3,0,2|1 3,1,0|2")),
            allows(Are("0,1,2|3 0,3,1|2 2,0,1|3 2,3,0|1 3,0,2|1 3,1,0|2")),
            // The second section sees the first or nothing, the third any of both or nothing: 6 results for each of 6
            // orders; of two orders with the same third section, 3 results are the same.
            races(Lack(27, "1,1,1|1")),
        ],
    )
    .finals(&[D]),
    Program::new(
        "lock, three threads, taken by exchanges that release too",
        &[
            &[Lock(X, Order::AcqRel), Read(D, PLAIN), Write(D, 1, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::AcqRel), Read(D, PLAIN), Write(D, 2, PLAIN), Write(X, 0, REL)],
            &[Lock(X, Order::AcqRel), Read(D, PLAIN), Write(D, 3, PLAIN), Write(X, 0, REL)],
        ],
        [
            allows(Are("0,1,2|3 0,3,1|2 2,0,1|3 2,3,0|1 3,0,2|1 3,1,0|2")),
            allows(Are("0,1,2|3 0,3,1|2 2,0,1|3 2,3,0|1 3,0,2|1 3,1,0|2")),
            allows(Are("0,1,2|3 0,3,1|2 2,0,1|3 2,3,0|1 3,0,2|1 3,1,0|2")),
            races(Lack(27, "1,1,1|1")),
        ],
    )
    .finals(&[D]),
    // Races.
    Program::new(
        "two plain writes",
        &[&[Write(D, 1, PLAIN)], &[Write(D, 2, PLAIN)]],
        [allows(Are("|1 |2")), allows(Are("|1 |2")), races(Are("|1 |2")), races(Are("|1 |2"))],
    )
    .finals(&[D]),
    Program::new("two plain reads", &[&[Read(D, PLAIN)], &[Read(D, PLAIN)]], all("0,0")),
    Program::new(
        "a plain write to an atomic word",
        &[&[Write(X, 1, PLAIN)], &[Read(X, ACQ)]],
        [allows(Are("0 1")), allows(Are("0 1")), races(Are("0 1")), races(Are("0 1"))],
    ),
    Program::new(
        "a plain read of an atomic word",
        &[&[Write(X, 1, REL)], &[Read(X, PLAIN)]],
        [allows(Are("0 1")), allows(Are("0 1")), races(Are("0 1")), races(Are("0 1"))],
    ),
    Program::new(
        "a plain read beside atomic reads",
        &[&[Read(X, RLX)], &[Read(X, PLAIN)]],
        all("0,0"),
    ),
    Program::new(
        "a compare-exchange that fails is no write",
        &[&[cas(X, 1, 2, Order::Relaxed)], &[Read(X, PLAIN)]],
        all("0,0"),
    ),
    Program::new(
        "a compare-exchange that does not fail is one",
        &[&[cas(X, 0, 2, Order::Relaxed)], &[Read(X, PLAIN)]],
        [
            allows(Are("0,0 0,2")),
            allows(Are("0,0 0,2")),
            races(Are("0,0 0,2")),
            races(Are("0,0 0,2")),
        ],
    ),
    Program::new("atomic writes", &[&[Write(X, 1, RLX)], &[Write(X, 2, RLX)]], all("|1 |2"))
        .finals(&[X]),
    // A word that was never written holds anything, but the same for all.
    Program::new(
        "a word that was never written",
        &[&[Read(Unset, RLX)], &[Read(Unset, RLX), Read(Unset, RLX)]],
        all("0,00 1,11 g,gg"),
    ),
];

/// Threads of one program; `k` says which.
struct Threads {
    program: &'static Program,
    atomics: Words<Pixel, Atomic, u32>,
    plain: Words<Pixel, Plain, u32>,
    results: Words<Pixel, Plain, u32>,
}

/// Bits of a value in a result word.
const DIGIT: u32 = 4;

/// In a result: greater than 9, and not reached.
const GREATER: u32 = 0xE;

impl Threads {
    fn digit(value: u32) -> u32 {
        if value > 9 { GREATER } else { value }
    }

    async fn read<M: Memory>(&self, mem: &M, word: Word, access: Access) -> u32 {
        match word {
            D => mem.read(self.plain.at(0, 0), access).await,
            _ => mem.read(self.atomics.at(0, word as u32), access).await,
        }
    }

    async fn write<M: Memory>(&self, mem: &M, word: Word, value: u32, access: Access) {
        match word {
            D => mem.write(self.plain.at(0, 0), value, access).await,
            _ => mem.write(self.atomics.at(0, word as u32), value, access).await,
        }
    }
}

impl Scheme for Threads {
    const CONTRACT: Contract = Contract {
        title: "Threads of a litmus program",
        exact_when: "",
        dependence: Dependence::ArrivalAndInterleaving,
        ..Contract::new("threads", Keeps::All)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let program = &PROGRAMS[config.k.expect("a program's number") as usize];
        Self {
            program,
            atomics: layout.pixel(4),
            plain: layout.pixel(1),
            results: layout.pixel(program.threads.len() as u64),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, _: u32) {
        for word in [X, Y, Z, D] {
            self.write(mem, word, 0, RLX).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let thread = fragment.data;
        let (mut result, mut reads, mut last) = (u32::MAX, 0, 0);
        for &op in self.program.threads[thread as usize] {
            match op {
                Write(word, value, access) => self.write(mem, word, value, access).await,
                Read(word, access) => last = self.read(mem, word, access).await,
                Op::Update(word, update, order) => {
                    last = mem.update(self.atomics.at(0, word as u32), update, order).await;
                }
                Need(value) if last != value => break,
                Need(_) => {}
                Lock(word, order) => {
                    let mark = mem.mark();
                    while mem.exchange(self.atomics.at(0, word as u32), 1, order).await != 0 {
                        mem.spin(mark).await;
                    }
                }
            }
            if matches!(op, Read(..) | Op::Update(..)) {
                result &= !(0xF << (DIGIT * reads));
                result |= Self::digit(last) << (DIGIT * reads);
                reads += 1;
            }
        }
        mem.plain_store(self.results.at(0, thread), result).await;
        Outcome::Kept
    }

    /// Thread by thread what it read, then the last values.
    async fn resolve<M: Memory>(&self, mem: &M, _: u32, keys: &mut Keys) {
        for thread in 0..self.program.threads.len() as u32 {
            keys.push(key(thread, mem.plain_load(self.results.at(0, thread)).await));
        }
        for (place, &word) in (100..).zip(self.program.finals) {
            keys.push(key(place, self.read(mem, word, RLX).await));
        }
    }
}

/// What exploring showed.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Observed {
    results: BTreeSet<String>,
    race: bool,
    states: usize,
}

fn observe(number: usize, memory: MemoryModel) -> Observed {
    let program = &PROGRAMS[number];
    let threads = program.threads.len() as u32;
    let litmus = Litmus {
        pixels: 1,
        k: Some(number as u32),
        room: threads,
        fragments: (0..threads).map(|t| Entry(0, t, t, 0)).collect(),
        helpers: 0,
        table: None,
        inputs: Vec::new(),
    };
    let conditions = Conditions { memory, warp: None };
    let limits = Limits { states: 2_000_000, cancelled: &|| false };
    let explored = explore(&Subject::of::<Threads>(), &litmus, conditions, &limits);
    assert!(explored.complete, "{}, {memory}: {} states", program.name, explored.states);
    Observed {
        results: explored.outcomes.keys().map(|pixels| result(program, &pixels[0])).collect(),
        race: explored.violations.contains_key(&Property::RaceFree),
        states: explored.states,
    }
}

/// A result as the table writes it.
fn result(program: &Program, held: &Held) -> String {
    let Held::Keys(keys) = held else { panic!("it keeps a list") };
    let digit = |value: u32| match value {
        0..=9 => char::from_digit(value, 10).expect("a digit"),
        GREATER => 'g',
        _ => '-',
    };
    let reads =
        |ops: &[Op]| ops.iter().filter(|op| matches!(op, Read(..) | Op::Update(..))).count();
    let of_thread = |(ops, &key): (&&[Op], &u64)| {
        let digits = (0..reads(ops) as u32).map(|i| digit(data_of(key) >> (DIGIT * i) & 0xF));
        digits.collect::<String>()
    };
    let texts = program.threads.iter().zip(keys).map(of_thread);
    let mut text = texts.filter(|text| !text.is_empty()).collect::<Vec<_>>().join(",");
    let finals = keys.iter().filter(|&&key| depth_of(key) >= 100);
    let finals: String = finals.map(|&key| digit(Threads::digit(data_of(key)))).collect();
    if !finals.is_empty() {
        text += &format!("|{finals}");
    }
    text
}

fn words(text: &str) -> BTreeSet<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

/// What differs from the expected, if anything does.
fn mismatch(expected: &Expected, omitted: &str, observed: &Observed) -> Option<String> {
    let found = &observed.results;
    let wrong = match expected.results {
        Are(list) if words(list) != *found => Some(format!("expected {:?}", words(list))),
        Lack(count, _) if count != found.len() => Some(format!("expected {count} results")),
        Lack(_, list) if !words(list).is_disjoint(found) => {
            Some(format!("expected none of {list}"))
        }
        _ if !words(omitted).is_disjoint(found) => Some(format!("{omitted} is no longer omitted")),
        _ if expected.race != observed.race => Some(format!("expected a race: {}", expected.race)),
        _ => None,
    };
    wrong.map(|wrong| format!("{wrong}; found {} {found:?}, race {}", found.len(), observed.race))
}

/// Everything observed, program by program.
fn observed() -> &'static [[Observed; 4]] {
    static ALL: std::sync::OnceLock<Vec<[Observed; 4]>> = std::sync::OnceLock::new();
    ALL.get_or_init(|| {
        (0..PROGRAMS.len()).map(|number| MODELS.map(|memory| observe(number, memory))).collect()
    })
}

#[test]
fn the_models_allow_what_the_table_says() {
    let mut wrong = Vec::new();
    for (program, all) in PROGRAMS.iter().zip(observed()) {
        let states = all.each_ref().map(|o| o.states);
        let results = all.each_ref().map(|o| o.results.len());
        println!("{}: results {results:?}, states {states:?}", program.name);
        for ((memory, expected), observed) in MODELS.iter().zip(&program.expected).zip(all) {
            if let Some(difference) = mismatch(expected, program.omitted, observed) {
                wrong.push(format!("{}, {memory}: {difference}", program.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Weaker models show all that stronger ones do: barriers order at least what release and acquire order, and WGSL
/// orders nothing.
#[test]
fn weaker_models_allow_more() {
    for (program, all) in PROGRAMS.iter().zip(observed()) {
        for pair in all.windows(2) {
            assert!(pair[0].results.is_subset(&pair[1].results), "{}: {pair:?}", program.name);
        }
    }
}

/// Negative control: the table is not met if any one of its entries is another.
#[test]
fn an_entry_that_is_wrong_is_found() {
    let leak = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let mut altered = 0;
    for (program, all) in PROGRAMS.iter().zip(observed()) {
        for (&expected, observed) in program.expected.iter().zip(all) {
            let results = match expected.results {
                Are(list) => {
                    let fewer = list.split_whitespace().skip(1).collect::<Vec<_>>().join(" ");
                    vec![Are(leak(fewer)), Are(leak(format!("{list} 9,9")))]
                }
                Lack(count, _) => {
                    let shown = observed.results.first().expect("a result").clone();
                    vec![Lack(count + 1, ""), Lack(count - 1, ""), Lack(count, leak(shown))]
                }
            };
            let results = results.into_iter().map(|results| Expected { results, ..expected });
            let race = Expected { race: !expected.race, ..expected };
            for other in results.chain([race]) {
                let found = mismatch(&other, program.omitted, observed);
                assert!(found.is_some(), "{}: {other:?}", program.name);
                altered += 1;
            }
            let shown = observed.results.last().expect("a result");
            assert!(mismatch(&expected, shown, observed).is_some(), "{}", program.name);
        }
    }
    assert!(altered > 550, "{altered} entries");
}
