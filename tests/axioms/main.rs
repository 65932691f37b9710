//! Relaxed memory as the explorer runs it, step by step, against its axioms: both give the same results for every
//! litmus program of two threads that is short enough. `FRAGLOOM_ALL_LITMUS=1` compares longer ones, too.
//!
//! Negative controls: no axiom can be left out, and none of C++11's own added.

mod axioms;
mod program;

use std::collections::BTreeSet;

use axioms::{Axioms, MODEL, Outcome, outcome, results};
use fragloom::explore::{
    Conditions, Entry, Limits, Litmus, MemoryModel, Profile, Subject, explore,
};
use fragloom::fragment::{Fragment, data_of, key};
use fragloom::memory::Order::{self, AcqRel, Acquire, Relaxed, Release};
use fragloom::memory::{Access, Atomic, Layout, Memory, Pixel, Plain, Update, Words};
use fragloom::scheme::contract::{Dependence, Keeps};
use fragloom::scheme::{Config, Contract, Held, Keys, Outcome as Fate, Scheme};
use program::Kind::{self, Exchange, IfOther, IfZero, Keep, Load, Max, Store};
use program::{MOST, Op, Program, describe, in_all_orders, programs, value};

/// A program's threads as invocations. Depth and data of a fragment are its thread: 16 bits for each operation, the
/// lowest first, and the thread's number above.
struct Threads {
    words: Words<Pixel, Atomic, u32>,
    read: Words<Pixel, Plain, u32>,
}

const KINDS: [Kind; 7] = [Load, Store, Exchange, Keep, Max, IfZero, IfOther];
const ORDERS: [Order; 4] = [Relaxed, Acquire, Release, AcqRel];

/// A thread as depth and data.
fn encode(thread: usize, ops: &[Op]) -> (u32, u32) {
    let op = |op: &Op| {
        let kind = KINDS.iter().position(|&k| k == op.kind).expect("a kind") as u64;
        let order = ORDERS.iter().position(|&o| o == op.order).expect("an order") as u64;
        1 | u64::from(op.word) << 1 | order << 2 | kind << 4
    };
    let ops = ops.iter().rev().fold(0, |all, next| all << 16 | op(next));
    let all = ops | (thread as u64) << 48;
    ((all >> 32) as u32, all as u32)
}

/// The thread's number, and its operations.
fn decode(fragment: Fragment) -> (usize, impl Iterator<Item = Op>) {
    let all = fragment.key();
    let codes = (0..MOST).map(move |place| (all >> (16 * place)) as usize & 0xFFFF);
    let op = |code: usize| Op {
        kind: KINDS[code >> 4],
        word: (code >> 1 & 1) as u8,
        order: ORDERS[code >> 2 & 3],
    };
    ((all >> 48) as usize, codes.filter(|code| code & 1 != 0).map(op))
}

impl Scheme for Threads {
    const CONTRACT: Contract = Contract {
        title: "Two threads of a litmus program",
        exact_when: "",
        dependence: Dependence::ArrivalAndInterleaving,
        ..Contract::new("two-threads", Keeps::All)
    };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { words: layout.pixel(2), read: layout.pixel(2) }
    }

    async fn clear<M: Memory>(&self, mem: &M, _: u32) {
        mem.store(self.words.at(0, 0), 0, Relaxed).await;
        mem.store(self.words.at(0, 1), 0, Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Fate {
        let (thread, ops) = decode(fragment);
        let mut all = 0;
        for (place, op) in ops.enumerate() {
            let (at, own) = (self.words.at(0, u32::from(op.word)), value(thread, place));
            let update = match op.kind {
                Load => {
                    all |= mem.load(at, op.order).await << (4 * place);
                    continue;
                }
                Store => {
                    mem.store(at, own, op.order).await;
                    continue;
                }
                Exchange => Update::Exchange(own),
                Keep => Update::Or(0),
                Max => Update::Max(own),
                IfZero => Update::CompareExchange { expected: 0, new: own },
                IfOther => Update::CompareExchange { expected: value(1 - thread, 0), new: own },
            };
            all |= mem.update(at, update, op.order).await << (4 * place);
        }
        mem.plain_store(self.read.at(0, thread as u32), all).await;
        Fate::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, _: u32, keys: &mut Keys) {
        for thread in 0..2 {
            keys.push(key(thread, mem.plain_load(self.read.at(0, thread)).await));
        }
        for word in 0..2 {
            keys.push(key(2 + word, mem.read(self.words.at(0, word), Access::Plain).await));
        }
    }
}

/// All results by exploring, and the states.
fn explored(program: &Program, profile: Profile) -> (BTreeSet<Outcome>, usize) {
    let thread = |thread: usize| {
        let (depth, data) = encode(thread, &program[thread]);
        Entry(0, depth, data, 0)
    };
    let litmus = Litmus {
        pixels: 1,
        k: None,
        room: 2,
        fragments: vec![thread(0), thread(1)],
        helpers: 0,
        table: None,
        inputs: Vec::new(),
    };
    let conditions = Conditions { memory: MemoryModel::Relaxed(profile), warp: None };
    let limits = Limits { states: 100_000, cancelled: &|| false };
    let explored = explore(&Subject::of::<Threads>(), &litmus, conditions, &limits);
    assert!(explored.complete, "{}", describe(program));
    let outcome = |pixels: &Vec<Held>| {
        let Held::Keys(keys) = &pixels[0] else { panic!("it keeps a list") };
        let [a, b, x, y] = [0, 1, 2, 3].map(|i| data_of(keys[i]));
        let of = |all: u32, place: usize| all >> (4 * place) & 0xF;
        let read = std::array::from_fn(|i| of([a, b][i / MOST], i % MOST));
        outcome(read, [x, y])
    };
    (explored.outcomes.keys().map(outcome).collect(), explored.states)
}

/// What the two say differently of a program.
fn difference(program: &Program, profile: Profile, axioms: Axioms) -> Option<String> {
    let (found, expected) = (explored(program, profile).0, results(program, profile, axioms));
    let hex = |set: Vec<&Outcome>| set.iter().map(|o| format!("{o:08x}")).collect::<Vec<_>>();
    (found != expected).then(|| {
        let missing = hex(expected.difference(&found).collect());
        let wrong = hex(found.difference(&expected).collect());
        format!("{profile:?}: {}\nmissing {missing:?}, wrong {wrong:?}", describe(program))
    })
}

/// Compare every `step`th program of a family, or all if asked to. Says how many programs the family has.
fn compare(alphabet: &[(Kind, Order)], most: usize, step: usize, profile: Profile) -> usize {
    let step = if std::env::var_os("FRAGLOOM_ALL_LITMUS").is_some() { 1 } else { step };
    let (mut all, mut compared) = (0, 0);
    for program in programs(alphabet, most) {
        if all % step == 0 {
            if let Some(difference) = difference(&program, profile, MODEL) {
                panic!("{difference}");
            }
            compared += 1;
        }
        all += 1;
    }
    println!("{profile:?}, up to {most} operations: {compared} of {all} programs compared");
    assert_eq!(compared, all.div_ceil(step));
    all
}

/// Loads, stores and exchanges, in all orders.
#[test]
fn two_operations_of_each_thread() {
    let alphabet = in_all_orders(&[Load, Store, Exchange]);
    for profile in [Profile::Vulkan, Profile::Glsl] {
        assert_eq!(compare(&alphabet, 2, 1, profile), 16_004);
    }
}

/// Updates of all kinds: such as fail, and such as leave the value as it is.
#[test]
fn two_operations_with_all_updates() {
    let relaxed = KINDS.map(|kind| (kind, Relaxed));
    assert_eq!(compare(&relaxed, 2, 1, Profile::Wgsl), 9_534);
    for profile in [Profile::Vulkan, Profile::Glsl] {
        assert_eq!(compare(&in_all_orders(&KINDS), 2, 149, profile), 1_203_852);
    }
}

#[test]
fn three_operations_of_each_thread() {
    let three = [(Load, Acquire), (Store, Release), (Exchange, Relaxed)];
    assert_eq!(compare(&three, 3, 1, Profile::Vulkan), 15_990);
    assert_eq!(compare(&three, 3, 7, Profile::Glsl), 15_990);
    let keeping = [(Load, Relaxed), (Store, Relaxed), (Keep, Release)];
    assert_eq!(compare(&keeping, 3, 7, Profile::Vulkan), 15_990);
    let more = [(Load, Relaxed), (Store, Relaxed), (IfOther, AcqRel)];
    assert_eq!(compare(&[three, more].concat(), 3, 307, Profile::Vulkan), 854_895);
}

/// Negative control: with any other axioms, some program is told apart.
#[test]
fn each_axiom_is_needed() {
    let relaxed = &[(Load, Relaxed), (Store, Relaxed), (Exchange, Relaxed)][..];
    let updates = &[(Load, Acquire), (Store, Release), (Exchange, Relaxed)][..];
    let stores = &[(Load, Acquire), (Store, Relaxed), (Store, Release)][..];
    let others = [
        ("writes are not coherent", 2, relaxed, Axioms { writes_are_coherent: false, ..MODEL }),
        ("reads are not coherent", 2, relaxed, Axioms { reads_are_coherent: false, ..MODEL }),
        ("updates are not atomic", 2, relaxed, Axioms { atomicity: false, ..MODEL }),
        ("load buffering", 2, relaxed, Axioms { causality: false, ..MODEL }),
        ("no 2+2W", 2, relaxed, Axioms { write_order_is_causal: true, ..MODEL }),
        ("nothing synchronises", 2, stores, Axioms { synchronises: false, ..MODEL }),
        ("updates end release sequences", 3, updates, Axioms { updates_continue: false, ..MODEL }),
        ("stores continue them", 3, stores, Axioms { own_stores_continue: true, ..MODEL }),
    ];
    for (name, most, alphabet, axioms) in others {
        let of_sequences = axioms.own_stores_continue || !axioms.updates_continue;
        // A barrier also covers later stores and earlier reads: two threads need no release sequences.
        let profiles = [Profile::Vulkan, Profile::Glsl];
        for &profile in &profiles[..if of_sequences { 1 } else { 2 }] {
            let differs = |program| difference(&program, profile, axioms);
            let found = programs(alphabet, most).find_map(differs);
            println!("{name}: {}", found.unwrap_or_else(|| panic!("{name} makes no difference")));
        }
    }
}
