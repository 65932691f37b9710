//! What a search must not miss: mistakes of clear and resolve, which are concurrent passes like any other, and words
//! that nobody wrote. Each mistake is a scheme of its own, and the form without it is verified.

use fragloom::explore::program::controls::control;
use fragloom::explore::program::instances::instances;
use fragloom::explore::replay::replay_of;
use fragloom::explore::{
    Conditions, Family, Limits, Litmus, MemoryModel, Plan, Profile, Property, Subject, Survey,
    Token, Verdict, check, explore,
};
use fragloom::fragment::Fragment;
use fragloom::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Words};
use fragloom::scheme::{Config, Contract, Keeps, Keys, Outcome, Scheme};

const LIMITS: Limits<'_> = Limits { states: 1_000_000, cancelled: &|| false };

const MODELS: [MemoryModel; 2] = [MemoryModel::Sequential, MemoryModel::Relaxed(Profile::Vulkan)];

/// The key of no fragment.
const NOTHING: u64 = u64::MAX;

/// What a method that keeps the nearest fragment does besides.
const RIGHT: u32 = 0;
/// Resolve reads a word that clear forgets.
const FORGETS: u32 = 1;
/// Resolve goes through a word that all pixels share.
const SHARED_IN_RESOLVE: u32 = 2;
/// Clear does.
const SHARED_IN_CLEAR: u32 = 3;
/// Resolve counts pixels in a word that all share. This is no mistake.
const COUNTS: u32 = 4;

/// The nearest fragment, by an atomic minimum.
struct Nearest<const FORM: u32> {
    nearest: Words<Pixel, Atomic, u64>,
    hidden: Words<Pixel, Atomic, u32>,
    shared: Words<Global, Atomic, u64>,
}

impl<const FORM: u32> Scheme for Nearest<FORM> {
    const CONTRACT: Contract = Contract { words: "3", ..Contract::new("nearest", Keeps::One) };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        let (nearest, hidden) = (layout.pixel(1), layout.pixel(1));
        Self { nearest, hidden, shared: layout.global(1) }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        if FORM != SHARED_IN_CLEAR {
            mem.store(self.shared.at(0), 0, Order::Relaxed).await;
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        let mut cleared = pixel;
        if FORM == SHARED_IN_CLEAR {
            mem.store(self.shared.at(0), pixel.into(), Order::Relaxed).await;
            cleared = mem.load(self.shared.at(0), Order::Relaxed).await as u32;
        }
        mem.store(self.nearest.at(cleared, 0), NOTHING, Order::Relaxed).await;
        if FORM != FORGETS {
            mem.store(self.hidden.at(pixel, 0), 1, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let key = fragment.key();
        match mem.min(self.nearest.at(fragment.pixel, 0), key, Order::Relaxed).await {
            old if old <= key => Outcome::Culled,
            NOTHING => Outcome::Kept,
            _ => Outcome::Evicted,
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        if mem.load(self.hidden.at(pixel, 0), Order::Relaxed).await == 0 {
            return;
        }
        let mut nearest = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        let shared = self.shared.at(0);
        match FORM {
            SHARED_IN_RESOLVE => {
                mem.store(shared, nearest, Order::Relaxed).await;
                nearest = mem.load(shared, Order::Relaxed).await;
            }
            COUNTS => drop(mem.add(shared, 1, Order::Relaxed).await),
            _ => {}
        }
        if nearest != NOTHING {
            keys.push(nearest);
        }
    }
}

fn survey<const FORM: u32>(memory: MemoryModel, n: u32) -> Survey {
    let family = Family { fragments: n, ks: vec![1], helpers: 0 };
    let conditions = Conditions { memory, warp: None };
    Survey::new(&Subject::of::<Nearest<FORM>>(), &family, conditions, &LIMITS)
}

fn is_right(survey: &Survey) -> bool {
    assert!(survey.is_complete());
    survey.explored.iter().all(|(_, explored)| explored.violations.is_empty())
}

#[test]
fn the_forms_without_a_mistake_are_verified() {
    for memory in MODELS {
        let [alone, counts] = [survey::<RIGHT>(memory, 3), survey::<COUNTS>(memory, 3)];
        assert!(is_right(&alone) && is_right(&counts), "{memory}");
        // Resolve costs nothing where its invocations cannot meet.
        assert!(counts.states() > alone.states(), "{memory}: its interleavings are explored");
        println!("{memory}: {} states, {} with a counter", alone.states(), counts.states());
    }
}

#[test]
fn mistakes_of_clear_and_resolve_are_found_and_replayed() {
    fn found<const FORM: u32>(memory: MemoryModel, pixels: u32) {
        let survey = survey::<FORM>(memory, 2);
        let found = survey.violation(Property::Keeps);
        let (litmus, _, _) = found.unwrap_or_else(|| panic!("form {FORM} under {memory}"));
        assert_eq!(litmus.pixels, pixels, "form {FORM} under {memory}");
        let row = survey.row(Property::Keeps);
        assert_eq!(row.verdict, Verdict::Violated);
        let token: Token = row.token.as_ref().expect("a token").parse().expect("one of ours");
        let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
        let shown = replay_of(&survey.subject, &token).expect("the same operations");
        assert!(shown.run.violations().any(|(property, _)| *property == Property::Keeps));
        println!("form {FORM} under {memory}: {}", row.message);
    }
    for memory in MODELS {
        found::<FORGETS>(memory, 1);
        found::<SHARED_IN_RESOLVE>(memory, 2);
        found::<SHARED_IN_CLEAR>(memory, 2);
    }
}

/// Every sequentially consistent execution is one of relaxed memory: the row there inherits what is violated with more
/// fragments, with its token.
#[test]
fn a_violation_is_one_under_weaker_memory_too() {
    let method = fragloom::catalogue::method("ha64-cull@published").expect("it is built in");
    let subject = Subject::new(method).expect("a scheme");
    let plan = Plan { progress: Some(Vec::new()), simt: false, runs: 0, ..Plan::default() };
    let rows = check(&subject, &plan, &LIMITS);
    let of = |memory: &str| {
        let mut own = rows.iter().filter(|row| row.memory == memory);
        own.find(|row| row.property.as_deref() == Some("keeps")).expect("a row")
    };
    let [sequential, relaxed] = [of("sc"), of("relaxed")];
    assert_eq!(sequential.verdict, Verdict::Violated);
    assert_eq!(relaxed.verdict, Verdict::Violated);
    assert!(sequential.token.is_some());
    assert_eq!(relaxed.token, sequential.token);
    assert!(relaxed.message.starts_with("as under sc: "), "{}", relaxed.message);
    let bounds = [&sequential.bound, &relaxed.bound];
    assert_ne!(bounds[0], bounds[1], "each row has its own bound");
}

/// Each fault of a kind is found by what is meant for it, and by nothing else.
#[test]
fn what_is_varied_finds_what_nothing_else_does() {
    let find = |name: &str| control(name).expect("a control");
    let of = |name: &str, property: &str| {
        let plan = Plan { memory: vec![MemoryModel::Sequential], runs: 100, ..Plan::default() };
        let rows = check(&find(name), &plan, &LIMITS);
        rows.into_iter().find(|row| row.property.as_deref() == Some(property)).expect("a row")
    };
    // Values far apart do not show what compares too little of them.
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let family = Family { fragments: 3, ks: vec![1, 2], helpers: 0 };
    for name in ["control@upper-bits", "control@as-float", "control@data-zero"] {
        let all = instances(&find(name), &family);
        let wrong = |litmus: &Litmus| {
            let explored = explore(&find(name), litmus, conditions, &LIMITS);
            assert!(explored.complete);
            !explored.violations.is_empty()
        };
        assert!(all.len() > 20 && !all.iter().any(wrong), "{name}");
        assert_eq!(of(name, "keeps").verdict, Verdict::Violated, "{name}");
    }
    // Few fragments do not show what is wrong with the fourth entry.
    assert_eq!(of("control@fourth", "keeps").verdict, Verdict::Unknown);
    let random = of("control@fourth", "random-runs");
    assert_eq!((random.verdict, random.found.as_deref()), (Verdict::Violated, Some("keeps")));
    assert!(random.token.is_some() && random.instance.contains("k=4 "), "{random:?}");
    // It takes a pixel without fragments to show what such a pixel returns.
    let empty = of("control@no-fragment", "keeps");
    assert!(empty.verdict == Verdict::Violated && empty.instance.starts_with("n=0 "), "{empty:?}");
}
