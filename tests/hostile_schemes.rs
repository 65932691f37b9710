//! What must not bring the checker down, and must be called by its name: schemes that panic, that never end, that
//! leave their words, or that keep state outside of memory.

#![allow(clippy::while_immutable_condition, reason = "loops without an end are what is tested")]

use std::sync::atomic::{AtomicU32, Ordering};

use fragloom::explore::replay::{of_outcome, replay_of};
use fragloom::explore::{
    Conditions, Finding, Limits, Litmus, MemoryModel, Plan, Profile, Property, Subject, Token,
    Verdict, check, explore,
};
use fragloom::fragment::Fragment;
use fragloom::memory::{Atomic, Layout, Memory, Order, Pixel, Snapshot, Words};
use fragloom::scheme::{Config, Contract, Held, Keeps, Keys, Moment, Outcome, Scheme};

const LIMITS: Limits<'_> = Limits { states: 1_000_000, cancelled: &|| false };

/// The key of no fragment.
const NOTHING: u64 = u64::MAX;

/// What the nearest fragment's method does besides.
const RIGHT: u32 = 0;
const PANICS_IN_STORE: u32 = 1;
const PANICS_AT_ONCE: u32 = 2;
const PANICS_IN_RESOLVE: u32 = 3;
const PANICS_IN_NEW: u32 = 4;
const PANICS_IN_INVARIANT: u32 = 5;
const PANICS_IN_CLEAR: u32 = 6;
/// Waits for the other fragment without saying so.
const WAITS: u32 = 10;
/// Never ends, whatever it reads.
const LOOPS: u32 = 11;
/// Never ends, and accesses nothing.
const LOOPS_IN_BLOCKS: u32 = 12;
const LOOPS_IN_RESOLVE: u32 = 13;
const LOOPS_IN_CLEAR: u32 = 14;
/// Every invocation counts itself on the host, and goes by that.
const COUNTS: u32 = 20;
/// The same in the scheme's own memory.
const COUNTS_IN_SELF: u32 = 21;
/// Leaves its depth on the host, for whichever invocation comes next.
const LEAVES: u32 = 22;
/// Resolve counts.
const COUNTS_IN_RESOLVE: u32 = 23;

static COUNTER: AtomicU32 = AtomicU32::new(0);

/// The nearest fragment, by an atomic minimum.
struct Nearest<const FORM: u32> {
    nearest: Words<Pixel, Atomic, u64>,
    count: Words<Pixel, Atomic, u32>,
    own: AtomicU32,
}

impl<const FORM: u32> Scheme for Nearest<FORM> {
    const CONTRACT: Contract = Contract { words: "3", ..Contract::new("nearest", Keeps::One) };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        assert!(FORM != PANICS_IN_NEW || config.generated < 2, "room for one fragment only");
        Self { nearest: layout.pixel(1), count: layout.pixel(1), own: AtomicU32::new(0) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.nearest.at(pixel, 0), NOTHING, Order::Relaxed).await;
        mem.store(self.count.at(pixel, 0), 0, Order::Relaxed).await;
        while FORM == LOOPS_IN_CLEAR {
            mem.store(self.count.at(pixel, 0), 0, Order::Relaxed).await;
        }
        assert!(FORM != PANICS_IN_CLEAR || pixel == 0, "one pixel only");
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        assert!(FORM != PANICS_AT_ONCE || fragment.depth == 0, "a fragment behind the near plane");
        let count = self.count.at(fragment.pixel, 0);
        while FORM == LOOPS_IN_BLOCKS {
            let block = mem.block();
            mem.merge(block).await;
        }
        let before = mem.add(count, 1, Order::Relaxed).await;
        assert!(FORM != PANICS_IN_STORE || before < 1, "a second fragment");
        while FORM == LOOPS || FORM == WAITS && before == 0 {
            if FORM == WAITS && mem.load(count, Order::Relaxed).await != 1 {
                break;
            }
            mem.load(count, Order::Relaxed).await;
        }
        let mut key = fragment.key();
        let strange = match FORM {
            COUNTS => COUNTER.fetch_add(1, Ordering::Relaxed) % 3 == 2,
            COUNTS_IN_SELF => self.own.fetch_add(1, Ordering::Relaxed) % 5 == 4,
            LEAVES => COUNTER.swap(fragment.depth, Ordering::Relaxed) == u32::MAX - 1,
            _ => false,
        };
        if strange {
            key = 7;
        }
        match mem.min(self.nearest.at(fragment.pixel, 0), key, Order::Relaxed).await {
            old if old <= key => Outcome::Culled,
            NOTHING => Outcome::Kept,
            _ => Outcome::Evicted,
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.count.at(pixel, 0), Order::Relaxed).await;
        assert!(FORM != PANICS_IN_RESOLVE || count < 2, "too many fragments");
        while FORM == LOOPS_IN_RESOLVE && count >= 2 {
            mem.load(self.count.at(pixel, 0), Order::Relaxed).await;
        }
        let key = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        let odd = COUNTER.fetch_add(u32::from(FORM == COUNTS_IN_RESOLVE), Ordering::Relaxed) % 2;
        if key != NOTHING && !(FORM == COUNTS_IN_RESOLVE && odd == 1) {
            keys.push(key);
        }
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, _: Moment) -> Result<(), String> {
        let count = words.get(self.count.at(pixel, 0)).unwrap_or(0);
        assert!(FORM != PANICS_IN_INVARIANT || count < 2, "more than one");
        Ok(())
    }
}

fn rows<const FORM: u32>() -> Vec<Finding> {
    let subject = Subject::of::<Nearest<FORM>>();
    let plan = Plan { fragments: Some(2), ..Plan::default() };
    check(&subject, &plan, &LIMITS)
}

/// The first row that is violated, with its property.
fn violated<'a>(rows: &'a [Finding], property: &str) -> &'a Finding {
    let found = rows.iter().find(|row| row.property.as_deref() == Some(property));
    let row = found.unwrap_or_else(|| panic!("no row {property}: {rows:#?}"));
    assert_eq!(row.verdict, Verdict::Violated, "{row:#?}");
    row
}

fn none_verified(rows: &[Finding]) {
    let verified = rows.iter().find(|row| row.verdict == Verdict::Verified);
    assert_eq!(verified, None);
}

#[test]
fn the_form_without_a_mistake_is_not_accused() {
    let rows = rows::<RIGHT>();
    let wrong = rows.iter().find(|row| row.verdict == Verdict::Violated);
    assert_eq!(wrong, None);
    assert!(rows.iter().all(|row| {
        !["panics", "repeats"].contains(&row.property.as_deref().unwrap_or_default())
    }));
}

#[test]
fn a_panic_is_a_violation_with_its_schedule() {
    fn one<const FORM: u32>(text: &str, steps: u64) {
        let rows = rows::<FORM>();
        let row = violated(&rows, "panics");
        assert!(
            row.message.contains(text) && row.message.contains("hostile_schemes.rs:"),
            "{row:#?}"
        );
        assert_eq!(row.steps, Some(steps), "{row:#?}");
        let token: Token = row.token.as_ref().expect("a token").parse().expect("valid");
        let Token::Litmus(token) = token else { panic!("of a litmus pixel") };
        let replayed = replay_of(&Subject::of::<Nearest<FORM>>(), &token).expect("replays");
        let told = replayed.run.violations().map(|(_, told)| told.clone()).collect::<Vec<_>>();
        assert!(told.iter().any(|told| told.contains(text)), "{told:?}");
        assert!(replayed.table().iter().flatten().any(|cell| cell == "panics"));
        none_verified(&rows);
    }
    one::<PANICS_IN_STORE>("a second fragment", 3);
    one::<PANICS_AT_ONCE>("a fragment behind the near plane", 1);
    one::<PANICS_IN_RESOLVE>("too many fragments", 6);
    one::<PANICS_IN_CLEAR>("one pixel only", 3);
}

/// There is no schedule to a panic before anything runs.
#[test]
fn a_panic_outside_of_invocations_is_named() {
    let new = rows::<PANICS_IN_NEW>();
    let row = violated(&new, "panics");
    assert!(row.message.contains("room for one fragment only") && row.token.is_none(), "{row:#?}");
    none_verified(&new);
    let invariant = rows::<PANICS_IN_INVARIANT>();
    let row = violated(&invariant, "invariant");
    assert!(row.message.contains("the invariant panics at"), "{row:#?}");
    assert!(row.message.contains("more than one") && row.token.is_some(), "{row:#?}");
}

#[test]
fn a_loop_without_a_wait_is_unknown_and_named() {
    fn one<const FORM: u32>(operation: &str) {
        let source = include_str!("hostile_schemes.rs");
        let rows = rows::<FORM>();
        none_verified(&rows);
        for row in &rows {
            assert_eq!(row.verdict, Verdict::Unknown, "{row:#?}");
            if row.property.as_deref() == Some("random-runs") {
                assert!(row.message.contains("runs did not come to an end"), "{row:#?}");
                continue;
            }
            // The place of the operation, in line and column, and what to do.
            let rest = row.message.strip_prefix("tests/hostile_schemes.rs:").expect("a place");
            let mut numbers = rest.split(':').map(str::parse::<usize>);
            let (line, column) = (numbers.next(), numbers.next());
            let (Some(Ok(line)), Some(Ok(column))) = (line, column) else { panic!("{rest}") };
            let at = &source.lines().nth(line - 1).expect("a line")[column - 1..];
            assert!(at.starts_with(operation), "{at} in {row:#?}");
            assert!(row.message.contains("mem.spin(mark)"), "{row:#?}");
        }
    }
    one::<WAITS>("load");
    one::<LOOPS>("load");
    one::<LOOPS_IN_BLOCKS>("block");
    one::<LOOPS_IN_RESOLVE>("load");
    one::<LOOPS_IN_CLEAR>("store");
}

#[test]
fn state_outside_of_memory_is_found() {
    fn one<const FORM: u32>() {
        let rows = rows::<FORM>();
        let row = violated(&rows, "repeats");
        assert!(row.message.contains("keeps state outside of its words"), "{row:#?}");
        assert!(
            row.message.contains("hostile_schemes.rs:") || FORM == COUNTS_IN_RESOLVE,
            "{row:#?}"
        );
        none_verified(&rows);
    }
    one::<COUNTS>();
    one::<COUNTS_IN_SELF>();
    one::<LEAVES>();
    one::<COUNTS_IN_RESOLVE>();
}

/// Also where nothing else is asked: a bound of states names the option that raises it.
#[test]
fn a_bound_of_states_says_what_would_raise_it() {
    let plan = Plan {
        fragments: Some(2),
        memory: vec![MemoryModel::Sequential],
        runs: 0,
        ..Plan::default()
    };
    let limits = Limits { states: 5, cancelled: &|| false };
    for row in check(&Subject::of::<Nearest<RIGHT>>(), &plan, &limits) {
        assert_eq!(row.verdict, Verdict::Unknown);
        assert!(row.message.contains("more than 5 states: raise --max-states"), "{row:#?}");
        assert!(row.message.contains("MiB"), "{row:#?}");
    }
}

/// Stores a fragment one word behind those of its pixel, of which there are so many.
struct Beyond<const WORDS: u32> {
    keys: Words<Pixel, Atomic, u64>,
}

impl<const WORDS: u32> Scheme for Beyond<WORDS> {
    const CONTRACT: Contract = Contract { words: "2", ..Contract::new("beyond", Keeps::One) };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { keys: layout.pixel(WORDS.into()) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for word in 0..WORDS {
            mem.store(self.keys.at(pixel, word), NOTHING, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let key = fragment.key();
        mem.store(self.keys.at(fragment.pixel, WORDS), key, Order::Relaxed).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for word in 0..WORDS {
            let key = mem.load(self.keys.at(pixel, word), Order::Relaxed).await;
            keys.extend(Some(key).filter(|&key| key != NOTHING));
        }
    }
}

/// What a robust device makes of an access outside of a buffer: nothing, or an access to its last word, if it has one.
#[test]
fn an_access_outside_is_dropped_or_clamped() {
    fn one<const WORDS: u32>(results: &[usize]) {
        let subject = Subject::of::<Beyond<WORDS>>();
        let litmus = Litmus::of_one(subject.contract);
        for memory in [MemoryModel::Sequential, MemoryModel::Relaxed(Profile::Wgsl)] {
            let conditions = Conditions { memory, warp: None };
            let explored = explore(&subject, &litmus, conditions, &LIMITS);
            assert!(explored.complete && explored.violations.contains_key(&Property::Bounds));
            let lengths: Vec<usize> = explored.outcomes.keys().map(|all| all[0].len()).collect();
            assert_eq!(lengths, results, "{WORDS} words, {memory}");
            for (pixels, schedule) in &explored.outcomes {
                let token = of_outcome(&subject, &litmus, conditions, schedule).expect("it runs");
                let replayed = replay_of(&subject, &token).expect("replays");
                assert_eq!(replayed.run.end.as_ref().map(|end| &end.pixels), Some(pixels));
                let wrong = replayed.run.violations().find(|(p, _)| *p == Property::Bounds);
                assert!(wrong.is_some(), "{replayed:?}");
                let dropped = pixels == &[Held::Keys(Vec::new())];
                let cells = || replayed.table().into_iter().flatten();
                assert_eq!(cells().any(|cell| cell == "outside := 0"), dropped, "{replayed:?}");
                assert_eq!(cells().any(|cell| cell == "p0[1]L := 0"), !dropped, "{replayed:?}");
            }
        }
        // Random runs do the same, and theirs are replayed too.
        let rows = check(&subject, &Plan { fragments: Some(1), ..Plan::default() }, &LIMITS);
        violated(&rows, "bounds");
        let tokens = rows.iter().filter_map(|row| row.token.as_ref());
        for token in tokens {
            let Token::Litmus(token) = token.parse().expect("valid") else { panic!("of a pixel") };
            replay_of(&subject, &token).expect("replays");
        }
    }
    one::<2>(&[0, 1]);
    one::<0>(&[0]);
}
