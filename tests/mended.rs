//! Mended forms under relaxed memory in which nothing is ordered, as WGSL has it: the verdict of each, with its bound;
//! and that it is the updates that mend: reads alone, or writes alone, do not.

use std::future::Future;

use fragloom::catalogue::{self, Catalogue};
use fragloom::explore::{
    Conditions, Family, Limits, Litmus, MemoryModel, Profile, Property, Subject, Survey, Verdict,
    properties,
};
use fragloom::memory::{Access, At, Atomic, Memory, Order, Space, Word};
use fragloom::scheme::kplus_buffer::kplus_array::{KPlusArray, Variant};
use fragloom::scheme::parts::lock::SpinLock;
use fragloom::scheme::parts::lock::reach::{Reach, Updated};
use fragloom::scheme::{Contract, Form, Held};

const LIMITS: Limits<'static> = Limits { states: 5_000_000, cancelled: &|| false };

fn survey(subject: &Subject, profile: Profile, fragments: u32) -> Survey {
    let family = Family { fragments, ks: vec![1, 2, 3], helpers: 0 };
    let conditions = Conditions { memory: MemoryModel::Relaxed(profile), warp: None };
    Survey::new(subject, &family, conditions, &LIMITS)
}

fn subject(method: &str) -> Subject {
    Subject::new(catalogue::method(method).expect("a method")).expect("it has invocations")
}

/// Up to so many fragments, a form keeps its promise or not. `fragloom check` says *unknown* of the updated heaps, since
/// instances of this size do not reach all of their operations.
const VERDICTS: &[(&str, u32, Verdict)] = &[
    ("ab-ll-paged@atomic", 2, Verdict::Violated),
    ("ab-ll-paged@rmw", 3, Verdict::Verified),
    ("kb-ll@atomic", 2, Verdict::Violated),
    ("kb-ll@rmw", 2, Verdict::Verified),
    ("kplus-array@atomic", 2, Verdict::Violated),
    ("kplus-array@rmw", 3, Verdict::Verified),
    ("kplus-array@word64", 3, Verdict::Verified),
    ("kplus-heap@atomic", 2, Verdict::Violated),
    ("kplus-heap@rmw", 2, Verdict::Verified),
    ("kplus-sb@atomic", 2, Verdict::Violated),
    ("kplus-sb@rmw", 2, Verdict::Verified),
];

#[test]
fn each_form_has_its_verdict() {
    let mended = |c: &&Contract| c.form == Form::Mended;
    let names: Vec<&str> =
        Catalogue::built_in().contracts().filter(mended).map(|c| c.name).collect();
    assert!(names.iter().copied().eq(VERDICTS.iter().map(|&(name, ..)| name)), "{names:?}");
    for &(name, fragments, expected) in VERDICTS {
        let survey = survey(&subject(name), Profile::Wgsl, fragments);
        let keeps = survey.row(Property::Keeps);
        println!("{name}, n <= {fragments}: {} in {} states", keeps.verdict.name(), keeps.states);
        assert_eq!(keeps.verdict, expected, "{keeps:?}");
        if expected == Verdict::Violated {
            assert!(keeps.token.is_some(), "{keeps:?}");
            // It is not torn by a race of plain words: there are none.
            assert_ne!(survey.row(Property::RaceFree).verdict, Verdict::Violated);
            continue;
        }
        assert!(survey.is_complete());
        for property in properties(&survey.subject, survey.conditions.memory) {
            assert_eq!(survey.row(property).verdict, expected, "{:?}", survey.row(property));
        }
        // Where the pool has room for all.
        let roomy = |(l, _): &&(Litmus, _)| l.room as usize >= l.fragments.len();
        for (litmus, explored) in survey.explored.iter().filter(roomy) {
            let k = litmus.k.map_or(usize::MAX, |k| k as usize);
            let exact = |pixel| litmus.generated(pixel).into_iter().take(k).collect::<Vec<_>>();
            let exact: Vec<Held> = (0..litmus.pixels).map(exact).map(Held::Keys).collect();
            assert!(explored.outcomes.keys().eq([&exact]), "{}", litmus.describe());
        }
    }
}

/// What they mend.
#[test]
fn the_forms_without_are_violated() {
    for &(name, ..) in VERDICTS {
        let (base, _) = name.split_once('@').expect("a form");
        let row = survey(&subject(base), Profile::Wgsl, 2).row(Property::Keeps);
        assert_eq!(row.verdict, Verdict::Violated, "{row:?}");
    }
}

/// Atomic words are no loss where the lock orders.
#[test]
fn atomic_words_hold_where_a_lock_does() {
    for method in ["kplus-array@atomic", "ab-ll-paged@atomic"] {
        let row = survey(&subject(method), Profile::Vulkan, 3).row(Property::Keeps);
        assert_eq!(row.verdict, Verdict::Verified, "{row:?}");
    }
}

#[track_caller]
fn loads<M: Memory, S: Space, W: Word>(
    mem: &M,
    at: At<S, Atomic, W>,
) -> impl Future<Output = W> + Unpin {
    mem.load(at, Order::Relaxed)
}

#[track_caller]
fn stores<M: Memory, S: Space, W: Word>(
    mem: &M,
    at: At<S, Atomic, W>,
    value: W,
) -> impl Future<Output: Copy + Unpin> + Unpin {
    mem.store(at, value, Order::Relaxed)
}

/// A way in which some accesses are updates and others are not.
macro_rules! half {
    ($way:ident, $name:literal, $read:expr, $write:expr) => {
        #[derive(Debug)]
        enum $way {}

        impl Variant for $way {
            const CONTRACT: Contract = Updated::CONTRACT.mended($name, $name);
        }

        impl Reach for $way {
            type Kind = Atomic;
            const ACQUIRE: Order = Order::Relaxed;
            const SETTLED: Access = Access::Atomic(Order::Relaxed);

            #[track_caller]
            fn read<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Atomic, W>,
            ) -> impl Future<Output = W> + Unpin {
                $read(mem, at)
            }

            #[track_caller]
            fn write<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Atomic, W>,
                value: W,
            ) -> impl Future<Output: Copy + Unpin> + Unpin {
                $write(mem, at, value)
            }

            #[track_caller]
            fn load<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Atomic, W>,
                _: Order,
            ) -> impl Future<Output = W> + Unpin {
                $read(mem, at)
            }

            #[track_caller]
            fn store<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Atomic, W>,
                value: W,
                _: Order,
            ) -> impl Future<Output: Copy + Unpin> + Unpin {
                $write(mem, at, value)
            }

            #[track_caller]
            fn release<M: Memory>(
                mem: &M,
                lock: SpinLock,
                pixel: u32,
            ) -> impl Future<Output: Copy + Unpin> + Unpin {
                Updated::release(mem, lock, pixel)
            }
        }
    };
}

half!(LoadsRead, "kplus-array@loads-read", loads, Updated::write);
half!(StoresWrite, "kplus-array@stores-write", Updated::read, stores);

#[test]
fn reads_and_writes_must_both_be_updates() {
    for subject in
        [Subject::of::<KPlusArray<LoadsRead>>(), Subject::of::<KPlusArray<StoresWrite>>()]
    {
        let row = survey(&subject, Profile::Wgsl, 2).row(Property::Keeps);
        println!("{}: {}", subject.contract.name, row.message);
        assert_eq!(row.verdict, Verdict::Violated, "{row:?}");
    }
}
