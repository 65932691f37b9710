//! Which invocations must be scheduled for all to end: the idioms of the published progress models (Sorensen et al.,
//! "Specifying and testing GPU workgroup progress models", OOPSLA 2021, Table 1), reconvergence of warps, helper
//! invocations, and marks that claim too much.

use fragloom::catalogue;
use fragloom::explore::search::progress::ends;
use fragloom::explore::{
    Conditions, Entry, Explored, Finding, Limits, Litmus, MemoryModel, Plan, Progress, Property,
    Subject, Token, Verdict, check, explore, replay, termination,
};
use fragloom::fragment::{Fragment, key};
use fragloom::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use fragloom::num::depth::FARTHEST;
use fragloom::scheme::contract::Keeps;

use fragloom::scheme::parts::lock::{FREE, SpinLock};
use fragloom::scheme::{Config, Contract, Keys, Outcome, Scheme};

fn subject(method: &str) -> Subject {
    Subject::new(catalogue::method(method).expect("a method")).expect("it has invocations")
}

const LIMITS: Limits<'static> = Limits { states: 2_000_000, cancelled: &|| false };

/// A lock, the critical section inside of the loop.
const MUTEX: usize = 0;
/// A lock, taken in a loop of its own.
const SPINS_FIRST: usize = 1;
/// A lock without blocks, so that nothing says where lanes come together.
const NO_BLOCKS: usize = 2;
/// Invocation 0 sets a flag; the others wait for it.
const TO_HIGHER: usize = 3;
/// The last invocation sets a flag; the others wait for it.
const TO_LOWER: usize = 4;
/// All wait until those that have arrived are the lowest numbers: a missing one is below one that has arrived.
const LINEAR_BARRIER: usize = 5;
/// All wait for all.
const BARRIER: usize = 6;
/// No invocation waits.
const NO_WAIT: usize = 7;
/// An invocation that has failed `k` times gives up, but claims that every attempt is like the first.
const COUNTS: usize = 8;

/// What comes next depends on the place that was taken, which `here` leaves out.
const FORGETS: usize = 9;
/// Only the end depends on it; `here` leaves it out, too.
const FORGETS_ITS_END: usize = 10;
/// `here` lists it.
const REMEMBERS: usize = 11;

const NAMES: [&str; 12] = [
    "mutex",
    "spins-first",
    "no-blocks",
    "to-higher",
    "to-lower",
    "linear-barrier",
    "barrier",
    "no-wait",
    "counts",
    "forgets",
    "forgets-its-end",
    "remembers",
];

/// An idiom. The fragment's data word is the invocation's number, for those idioms in which it matters.
struct Waits<const IDIOM: usize> {
    count: u32,
    patience: u32,
    lock: SpinLock,
    flag: Words<Pixel, Atomic, u32>,
    /// Entries so far, and their depths and data.
    filled: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
}

impl<const IDIOM: usize> Waits<IDIOM> {
    /// What the lock guards.
    async fn append<M: Memory>(&self, mem: &M, fragment: Fragment) {
        let pixel = fragment.pixel;
        let place = mem.plain_load(self.filled.at(pixel, 0)).await;
        mem.plain_store(self.depth.at(pixel, place), fragment.depth).await;
        mem.plain_store(self.data.at(pixel, place), fragment.data).await;
        mem.plain_store(self.filled.at(pixel, 0), place + 1).await;
        self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
    }

    /// Wait until the flag is as requested.
    async fn wait<M: Memory>(&self, mem: &M, pixel: u32, until: impl Fn(u32) -> bool) {
        let wait = mem.block();
        let mark = mem.mark();
        while !until(mem.load(self.flag.at(pixel, 0), Order::Acquire).await) {
            mem.spin(mark).await;
        }
        mem.merge(wait).await;
    }
}

impl<const IDIOM: usize> Scheme for Waits<IDIOM> {
    const CONTRACT: Contract = Contract {
        title: "An idiom that waits",
        words: "3 + 2F",
        exact_when: "",
        ..Contract::new(NAMES[IDIOM], Keeps::All)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            count: config.generated as u32,
            patience: config.k.unwrap_or(3),
            lock: SpinLock::new(layout),
            flag: layout.pixel(1),
            filled: layout.pixel(1),
            depth: layout.pixel(config.generated),
            data: layout.pixel(config.generated),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.store(self.flag.at(pixel, 0), 0, Order::Relaxed).await;
        mem.plain_store(self.filled.at(pixel, 0), 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (pixel, own) = (fragment.pixel, fragment.data);
        let flag = self.flag.at(pixel, 0);
        match IDIOM {
            MUTEX => {
                let _attempts = mem.block();
                let mark = mem.mark();
                loop {
                    let attempt = mem.block();
                    if self.lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
                        self.append(mem, fragment).await;
                        return Outcome::Kept;
                    }
                    mem.merge(attempt).await;
                    mem.spin(mark).await;
                }
            }
            SPINS_FIRST => {
                let wait = mem.block();
                let mark = mem.mark();
                while self.lock.try_acquire(mem, pixel, Order::Acquire).await != FREE {
                    mem.spin(mark).await;
                }
                mem.merge(wait).await;
                self.append(mem, fragment).await;
            }
            NO_BLOCKS | COUNTS => {
                let mark = mem.mark();
                let mut failures = 0;
                while self.lock.try_acquire(mem, pixel, Order::Acquire).await != FREE {
                    failures += 1;
                    if IDIOM == COUNTS && failures == self.patience {
                        return Outcome::Culled;
                    }
                    mem.spin(mark).await;
                }
                self.append(mem, fragment).await;
            }
            TO_HIGHER if own == 0 => mem.store(flag, 1, Order::Release).await,
            TO_LOWER if own + 1 == self.count => mem.store(flag, 1, Order::Release).await,
            TO_HIGHER | TO_LOWER => self.wait(mem, pixel, |flag| flag == 1).await,
            LINEAR_BARRIER => {
                mem.or(flag, 1 << own, Order::AcqRel).await;
                self.wait(mem, pixel, |arrived| arrived & (arrived + 1) == 0).await;
            }
            BARRIER => {
                mem.add(flag, 1, Order::AcqRel).await;
                self.wait(mem, pixel, |arrived| arrived == self.count).await;
            }
            FORGETS | FORGETS_ITS_END | REMEMBERS => {
                let place = mem.add(flag, 1, Order::Relaxed).await;
                let live = [u64::from(place)];
                mem.here(if IDIOM == REMEMBERS { &live } else { &[] });
                let more = u32::from(IDIOM == FORGETS) * place;
                mem.add(flag, more, Order::Relaxed).await;
                return if place == 0 { Outcome::Kept } else { Outcome::Culled };
            }
            _ => {
                let place = mem.add(flag, 1, Order::Relaxed).await;
                mem.plain_store(self.depth.at(pixel, place), fragment.depth).await;
                mem.plain_store(self.data.at(pixel, place), fragment.data).await;
            }
        }
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let filled = match IDIOM {
            NO_WAIT => mem.load(self.flag.at(pixel, 0), Order::Relaxed).await,
            _ => mem.plain_load(self.filled.at(pixel, 0)).await,
        };
        for i in 0..filled {
            let depth = mem.plain_load(self.depth.at(pixel, i)).await;
            keys.push(key(depth, mem.plain_load(self.data.at(pixel, i)).await));
        }
    }
}

fn instance(n: u32, k: Option<u32>) -> Litmus {
    let fragments = (0..n).map(|i| Entry(0, FARTHEST, i, 0)).collect();
    Litmus { pixels: 1, k, room: n, fragments, helpers: 0, table: None, inputs: Vec::new() }
}

/// Under which models an idiom ends.
fn who_ends<const IDIOM: usize>(n: u32, warp: Option<u32>) -> String {
    let subject = Subject::of::<Waits<IDIOM>>();
    let found = ends(&subject, &instance(n, None), warp, &LIMITS).expect("few states");
    println!("{} n={n} warp {warp:?}: {} states", NAMES[IDIOM], found.states);
    let models = Progress::ALL.iter().zip(&found.lassos);
    models.filter(|(_, lasso)| lasso.is_none()).map(|(m, _)| m.name()).collect::<Vec<_>>().join(" ")
}

const ALL: &str = "unfair hsa obe hsa+obe lobe fair";

/// The mutex needs invocations that have begun to go on; a message to a higher number needs lower ones to get their
/// turn; a message to a lower number needs all to.
#[test]
fn the_published_table() {
    for n in [2, 3] {
        assert_eq!(who_ends::<MUTEX>(n, None), "obe hsa+obe lobe fair");
        assert_eq!(who_ends::<SPINS_FIRST>(n, None), "obe hsa+obe lobe fair");
        assert_eq!(who_ends::<NO_BLOCKS>(n, None), "obe hsa+obe lobe fair");
        assert_eq!(who_ends::<TO_HIGHER>(n, None), "hsa hsa+obe lobe fair");
        assert_eq!(who_ends::<TO_LOWER>(n, None), "fair");
        assert_eq!(who_ends::<BARRIER>(n, None), "fair");
        assert_eq!(who_ends::<NO_WAIT>(n, None), ALL);
    }
}

/// What only linear occupancy-bound execution and full fairness give: 2 has arrived, 0 waits for 1, and no other model
/// has to schedule 1, which is not the lowest and has not begun. With two invocations the lowest is the missing one.
#[test]
fn the_linear_barrier() {
    assert_eq!(who_ends::<LINEAR_BARRIER>(2, None), "hsa hsa+obe lobe fair");
    assert_eq!(who_ends::<LINEAR_BARRIER>(3, None), "lobe fair");
}

/// Lanes that leave a spin loop wait for those that cannot, since the lock's holder is among those that wait. With the
/// critical section inside the loop, those that fail wait for the holder instead, and no lane spins forever.
#[test]
fn a_loop_before_the_critical_section_hangs_a_warp() {
    for n in [2, 3] {
        assert_eq!(who_ends::<SPINS_FIRST>(n, Some(32)), "");
        assert_eq!(who_ends::<MUTEX>(n, Some(32)), ALL);
    }
    assert_eq!(who_ends::<SPINS_FIRST>(2, Some(1)), "obe hsa+obe lobe fair", "a warp of one lane");
    assert_eq!(who_ends::<SPINS_FIRST>(3, Some(2)), "", "two of them");
}

fn plan(progress: &[Progress], helpers: u32) -> Plan {
    let (fragments, ks) = (Some(2), vec![1]);
    Plan { fragments, ks, progress: Some(progress.to_vec()), helpers, ..Plan::default() }
}

fn row<'a>(rows: &'a [Finding], progress: &str) -> &'a Finding {
    let row = rows.iter().find(|row| row.progress.as_deref() == Some(progress));
    row.unwrap_or_else(|| panic!("no row for {progress}"))
}

/// The row is violated by a schedule that never ends, and its token shows it again.
#[track_caller]
fn hangs(subject: &Subject, row: &Finding) {
    assert_eq!(row.verdict, Verdict::Violated, "{row:?}");
    let token = row.token.as_ref().expect("a token").parse().expect("a token of ours");
    let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
    let shown = replay::replay_of(subject, &token).expect("the same operations");
    assert!(shown.run.end.is_none(), "an invocation has not ended");
    println!("{}, {:?}: {}, {}", row.method, row.progress, row.instance, row.message);
    match row.message.strip_prefix("after ") {
        Some(_) => assert!(row.message.ends_with("can move any more") && shown.cycle == 0),
        None => assert!(row.message.starts_with("never ends: ") && shown.cycle > 0, "{row:?}"),
    }
}

#[test]
fn a_check_says_which_lock_hangs_a_warp() {
    let (right, wrong) = (Subject::of::<Waits<MUTEX>>(), Subject::of::<Waits<SPINS_FIRST>>());
    let plan = plan(&[Progress::Hsa, Progress::Fair], 0);
    let rows = termination(&right, &plan, &LIMITS);
    assert_eq!(row(&rows, "fair").verdict, Verdict::Verified);
    assert_eq!(row(&rows, "simt").verdict, Verdict::Verified);
    hangs(&right, row(&rows, "hsa"));
    let rows = termination(&wrong, &plan, &LIMITS);
    assert_eq!(row(&rows, "fair").verdict, Verdict::Verified);
    hangs(&wrong, row(&rows, "simt"));
}

/// The same of methods of the catalogue.
#[test]
fn an_unbounded_spin_under_lockstep_is_found() {
    let (right, wrong) = (subject("kplus-array"), subject("kplus-array@M19"));
    let plan = plan(&[Progress::Fair], 0);
    let rows = termination(&right, &plan, &LIMITS);
    assert!(rows.iter().all(|row| row.verdict == Verdict::Verified), "{rows:?}");
    let rows = termination(&wrong, &plan, &LIMITS);
    assert_eq!(row(&rows, "fair").verdict, Verdict::Verified);
    hangs(&wrong, row(&rows, "simt"));
}

/// A helper's exchange may return anything, forever; it does no harm to the others.
#[test]
fn a_helper_may_never_get_the_lock() {
    let subject = Subject::of::<Waits<MUTEX>>();
    let rows = termination(&subject, &plan(&[Progress::Obe, Progress::Fair], 1), &LIMITS);
    hangs(&subject, row(&rows, "obe"));
    hangs(&subject, row(&rows, "fair"));
    assert!(row(&rows, "fair").instance.contains("helpers=1"), "{rows:?}");
    for with_helper in [Subject::of::<Waits<NO_WAIT>>(), self::subject("z-buffer")] {
        let rows = termination(&with_helper, &plan(&[Progress::Fair], 1), &LIMITS);
        assert!(rows.iter().all(|row| row.verdict == Verdict::Verified), "{rows:?}");
    }
}

/// Its writes have no effect, and what it believes to hold it does not.
#[test]
fn a_helper_changes_nothing() {
    let memory = vec![MemoryModel::Sequential];
    let plan =
        Plan { simt: false, memory, fragments: Some(3), ks: vec![1, 2], runs: 0, ..plan(&[], 1) };
    for method in ["kplus-array", "z-buffer", "ab-ll", "ab-array"] {
        let rows = check(&subject(method), &plan, &LIMITS);
        assert!(rows.len() > 5, "{rows:?}");
        for row in rows {
            assert_eq!(row.verdict, Verdict::Verified, "{row:?}");
        }
    }
}

/// Without blocks nothing is known about where lanes come together: no verdict, and the row says so.
#[test]
fn waits_in_no_block_have_no_verdict_under_simt() {
    let rows =
        termination(&Subject::of::<Waits<NO_BLOCKS>>(), &plan(&[Progress::Fair], 0), &LIMITS);
    assert_eq!(row(&rows, "fair").verdict, Verdict::Verified);
    let simt = row(&rows, "simt");
    assert_eq!(simt.verdict, Verdict::Unknown);
    assert!(simt.message.contains("1 waits stand in no block"), "{simt:?}");
}

fn explored<const IDIOM: usize>(n: u32, k: u32) -> Explored {
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    explore(&Subject::of::<Waits<IDIOM>>(), &instance(n, Some(k)), conditions, &LIMITS)
}

/// Search takes two invocations for one where they are at one place and say that nothing else matters; what comes next,
/// and how they end, shows whether that is true.
#[test]
fn a_list_of_what_matters_that_leaves_something_out_is_found() {
    for found in [explored::<FORGETS>(2, 1), explored::<FORGETS_ITS_END>(2, 1)] {
        let message = &found.violations[&Property::Invariant].message;
        assert!(message.contains("claims more than is true"), "{message}");
    }
    let honest = explored::<REMEMBERS>(3, 1);
    assert!(!honest.violations.contains_key(&Property::Invariant), "{honest:?}");
}

/// An invocation that counts its attempts is not where it was before. Search would take it for that, and never see it
/// give up; repeating the wait shows the difference.
#[test]
fn a_mark_that_claims_too_much_is_found() {
    for patience in 2..=16 {
        let found = explored::<COUNTS>(2, patience);
        let message = &found.violations[&Property::Invariant].message;
        assert!(message.contains("claims more than is true"), "{message}");
        assert!(message.contains("progress.rs"), "{message}");
    }
    for honest in [explored::<MUTEX>(3, 1), explored::<NO_BLOCKS>(3, 1)] {
        assert!(!honest.violations.contains_key(&Property::Invariant), "{honest:?}");
        assert!(honest.claims > 30, "{} comparisons", honest.claims);
    }
    let at_once = explored::<COUNTS>(2, 1);
    assert!(at_once.claims == 0 && !at_once.violations.contains_key(&Property::Invariant));
    let plan = Plan { memory: vec![MemoryModel::Sequential], ..plan(&[], 0) };
    let rows = check(&Subject::of::<Waits<COUNTS>>(), &plan, &LIMITS);
    let invariant = rows.iter().find(|row| row.property.as_deref() == Some("invariant"));
    assert_eq!(invariant.map(|row| row.verdict), Some(Verdict::Violated), "{rows:?}");
}
