//! loom models of the lock and of the insertions, through the very source of the schemes.
//!
//! loom explores interleavings together with what the orderings allow (C11 without load buffering). It returns success
//! also when one of its limits stops it, so every model counts its executions and asserts a floor. Waiters are pruned
//! after `patience` failed attempts: nothing here is exhaustive beyond that.

#[path = "support/loom_memory.rs"]
mod loom_memory;
#[path = "../examples/user_scheme.rs"]
#[allow(dead_code, reason = "its main function")]
mod user_scheme;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

use fragloom::exec::drive::{Pipeline, complete};
use fragloom::fragment::sort;
use fragloom::fragment::{Data, Fragment};
use fragloom::memory::{Access, Layout, Memory, Order, Pixel, Plain, Words};
use fragloom::raster::Grid;
use fragloom::scheme::a_buffer::ab_array::{AbArray, AtomicAdd, LoadStore};
use fragloom::scheme::a_buffer::ab_ll::{AbLinkedList, PlainHead, PublishedFirst};
use fragloom::scheme::a_buffer::ab_ll_paged::AbPagedList;
use fragloom::scheme::hash_table::ha::{Bits32, Bits64, HaBuffer};
use fragloom::scheme::hash_table::table::{Offsets, TableSettings};
use fragloom::scheme::k_buffer::kb_ll::{self, KNearestList};
use fragloom::scheme::k_buffer::kb_mdt64::KbMdt64;
use fragloom::scheme::k_buffer::z_buffer::{self, ZBuffer};
use fragloom::scheme::kplus_buffer::kplus_array::KPlusArray;
use fragloom::scheme::kplus_buffer::kplus_array::faults::{self, Faulty, Variant};
use fragloom::scheme::kplus_buffer::kplus_heap::{self, KPlusHeap};
use fragloom::scheme::parts::lock::{FREE, SpinLock};
use fragloom::scheme::program::PassKind;
use fragloom::scheme::{Config, Keys, Scheme, exact};
use loom::sync::Arc;
use loom_memory::{Loom, Storage};
use user_scheme::CasList;

/// Run a model; how many executions loom explored, or the message of the one that failed.
fn explore(model: impl Fn() + Sync + Send + 'static) -> Result<usize, String> {
    static SILENCE: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _one_at_a_time = SILENCE.lock();
    let count = std::sync::Arc::new(AtomicUsize::new(0));
    let counter = count.clone();
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        loom::model(move || {
            counter.fetch_add(1, Ordering::Relaxed);
            model();
        });
    }));
    let executions = count.load(Ordering::Relaxed);
    match outcome {
        Ok(()) => Ok(executions),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            Err(format!("execution {executions}: {}", text.unwrap_or_default()))
        }
    }
}

/// A message that a check of ours makes: only a failed property refutes, never one of loom's limits.
const WRONG: &str = "wrong contents";

fn fragments(depths: &[u32]) -> Vec<Fragment> {
    (0..).zip(depths).map(|(data, &depth)| Fragment { pixel: 0, depth, data, extra: 0 }).collect()
}

/// One thread per group of fragments; all of one pixel. Afterwards it must hold the exact answer.
fn insertion<S: Scheme<Holds = Keys>>(
    config: Config,
    groups: &[&[u32]],
    patience: u32,
) -> impl Fn() + Sync + Send + 'static {
    let all: Vec<Vec<Fragment>> = {
        let mut flat = fragments(&groups.concat());
        if S::CONTRACT.data == Some(Data::Nothing) {
            flat.iter_mut().for_each(|fragment| fragment.data = 0);
        }
        let mut rest = flat.as_slice();
        let take = |group: &&[u32]| {
            let (head, tail) = rest.split_at(group.len());
            rest = tail;
            head.to_vec()
        };
        groups.iter().map(take).collect()
    };
    let mut expected = exact::pixel(&all.concat(), S::CONTRACT.reference_k(config.k));
    S::CONTRACT.keep(&mut expected, config.k);
    move || {
        let mut layout = Layout::default();
        let scheme = Arc::new(S::new(&config, &mut layout));
        let storage = Arc::new(Storage::new(&layout, 1));
        let mem = Loom::new(&storage, patience);
        Pipeline::clear_frame(&*scheme, &mem);
        Pipeline::clear(&*scheme, &mem, 0..1);
        for (number, pass) in S::CONTRACT.program.passes.iter().enumerate() {
            if pass.kind == PassKind::Frame {
                let all = 0..Pipeline::<Loom<'_>>::invocations(&*scheme, number);
                Pipeline::frame(&*scheme, &mem, number, all);
            }
        }
        let spawn = |group: Vec<Fragment>| {
            let (scheme, storage) = (scheme.clone(), storage.clone());
            loom::thread::spawn(move || store(&*scheme, &storage, &group, patience))
        };
        let threads: Vec<_> = all[1..].iter().cloned().map(spawn).collect();
        store(&*scheme, &storage, &all[0], patience);
        for thread in threads {
            thread.join().expect("a thread that does not panic");
        }
        let mut keys = Keys::new();
        complete(scheme.resolve(&mem, 0, &mut keys));
        sort::canonical(&mut keys);
        assert_eq!(keys, expected, "{WRONG}");
    }
}

fn store<S: Scheme>(scheme: &S, storage: &Storage, group: &[Fragment], patience: u32) {
    let mem = Loom::new(storage, patience);
    for &fragment in group {
        complete(Scheme::store(scheme, &mem, fragment));
    }
}

fn k(k: u32) -> Config {
    Config {
        k: Some(k),
        pixels: 1,
        generated: 8,
        max_depth_complexity: 8,
        bounded: 8,
        pages: 8,
        ..Config::default()
    }
}

/// Holds, in at least `floor` executions.
#[track_caller]
fn holds(name: &str, floor: usize, model: impl Fn() + Sync + Send + 'static) {
    let executions = explore(model).unwrap_or_else(|e| panic!("{name}: {e}"));
    println!("{name}: {executions} executions");
    assert!(executions >= floor, "{name}: only {executions} executions");
}

/// Is refuted, by a check and not by a limit.
#[track_caller]
fn is_caught(name: &str, model: impl Fn() + Sync + Send + 'static) {
    let message = explore(model).expect_err("a fault that nothing catches");
    println!("{name}: {}", message.lines().next().unwrap_or_default());
    // A word that was never written, taken for an index, leads out of memory.
    let wrong = message.contains(WRONG) || message.contains("index out of bounds");
    assert!(wrong, "{name}: {message}");
}

/// Threads that each raise a plain word under the lock, `rounds` times.
fn counting(threads: u32, rounds: u32, unlock: Order, patience: u32) -> impl Fn() + Sync + Send {
    move || {
        let mut layout = Layout::default();
        let lock = SpinLock::new(&mut layout);
        let word: Words<Pixel, Plain, u32> = layout.pixel(1);
        let storage = Arc::new(Storage::new(&layout, 1));
        let mem = Loom::new(&storage, patience);
        complete(lock.clear(&mem, 0));
        complete(mem.plain_store(word.at(0, 0), 0));
        let raise = move |storage: &Storage| {
            let mem = Loom::new(storage, patience);
            for _ in 0..rounds {
                complete(raise_once(&mem, lock, word, unlock));
            }
        };
        let others: Vec<_> = (1..threads)
            .map(|_| {
                let storage = storage.clone();
                loom::thread::spawn(move || raise(&storage))
            })
            .collect();
        raise(&storage);
        for thread in others {
            thread.join().expect("a thread that does not panic");
        }
        let sum = complete(mem.plain_load(word.at(0, 0)));
        assert_eq!(sum, threads * rounds, "{WRONG}");
    }
}

async fn raise_once(mem: &Loom<'_>, lock: SpinLock, word: Words<Pixel, Plain, u32>, unlock: Order) {
    let mark = mem.mark();
    loop {
        if lock.try_acquire(mem, 0, Order::Acquire).await == FREE {
            let value = mem.plain_load(word.at(0, 0)).await;
            mem.plain_store(word.at(0, 0), value + 1).await;
            lock.release(mem, 0, Access::Atomic(unlock)).await;
            return;
        }
        mem.spin(mark).await;
    }
}

#[test]
fn the_lock_excludes() {
    holds("lock, 2 threads x 1, patience 3", 9, counting(2, 1, Order::Release, 3));
    holds("lock, 2 threads x 2, patience 2", 100, counting(2, 2, Order::Release, 2));
    holds("lock, 3 threads x 1, patience 1", 5_000, counting(3, 1, Order::Release, 1));
}

#[test]
fn a_relaxed_unlock_of_the_lock_is_caught() {
    is_caught("lock with a relaxed unlock", counting(2, 1, Order::Relaxed, 3));
}

#[test]
fn the_max_array_keeps_the_nearest() {
    type Array = KPlusArray;
    holds("kplus-array k=1, 2x1", 20, insertion::<Array>(k(1), &[&[5], &[3]], 2));
    holds("kplus-array k=2, 2x1", 20, insertion::<Array>(k(2), &[&[5], &[3]], 2));
    holds("kplus-array k=1, 2x2", 300, insertion::<Array>(k(1), &[&[9, 3], &[5, 4]], 1));
    holds("kplus-array k=2, 2x2", 300, insertion::<Array>(k(2), &[&[9, 3], &[5, 4]], 1));
    holds("kplus-array k=1, 3x1", 100_000, insertion::<Array>(k(1), &[&[5], &[3], &[4]], 1));
    holds("kplus-array k=1, 2x2, ties", 300, insertion::<Array>(k(1), &[&[4, 4], &[4, 4]], 1));
}

/// M1, M2: without release at one end or acquire at the other, a holder may work on what was there before the last one.
#[test]
fn a_lock_without_order_is_caught() {
    fn caught<V: Variant + Send + 'static>() {
        let name = V::CONTRACT.name;
        is_caught(name, insertion::<Faulty<V>>(k(2), &[&[5], &[3]], 2));
    }
    caught::<faults::PlainUnlock>();
    caught::<faults::RelaxedUnlock>();
    caught::<faults::RelaxedExchange>();
    caught::<faults::RelaxedLock>();
}

/// M6: the second thread sees both entries counted, but in entry 0 still the nearer one; the fragment between them is
/// culled. In order, an invocation that sees the count sees the entry.
#[test]
fn an_unordered_early_out_is_caught() {
    let groups: &[&[u32]] = &[&[5, 9], &[7]];
    is_caught("kplus-array@M6", insertion::<Faulty<faults::RelaxedCounter>>(k(2), groups, 1));
    let early = insertion::<Faulty<faults::EarlyCount>>(k(2), groups, 1);
    is_caught("kplus-array@M6-early-count", early);
    holds("kplus-array k=2, 2+1", 50, insertion::<KPlusArray>(k(2), groups, 1));
}

/// Interleavings alone show these.
#[test]
fn faults_of_the_max_array_are_caught() {
    fn caught<V: Variant + Send + 'static>(k_: u32, groups: &'static [&'static [u32]]) {
        is_caught(V::CONTRACT.name, insertion::<Faulty<V>>(k(k_), groups, 2));
    }
    caught::<faults::OneTest>(1, &[&[5], &[3]]);
    caught::<faults::SpinCap>(2, &[&[5], &[3]]);
    caught::<faults::TimeOut>(2, &[&[5], &[3]]);
    caught::<faults::ClearsOutside>(2, &[&[5], &[3]]);
    caught::<faults::RootFirst>(2, &[&[5, 9, 1], &[4]]);
}

#[test]
fn a_non_atomic_counter_is_caught() {
    is_caught("ab-array@plain-counter", insertion::<AbArray<LoadStore>>(k(4), &[&[5], &[3]], 2));
}

#[test]
fn a_head_replaced_in_two_steps_is_caught() {
    is_caught("ab-ll@plain-head", insertion::<AbLinkedList<PlainHead>>(k(1), &[&[5], &[3]], 2));
}

#[test]
fn a_minimum_in_three_steps_is_caught() {
    type Fault = ZBuffer<z_buffer::LoadStore>;
    is_caught("z-buffer@load-store", insertion::<Fault>(k(1), &[&[5], &[3]], 2));
}

/// M11, equivalent: a node may be published before it is written, since no invocation reads it before the barrier.
#[test]
fn publishing_first_changes_nothing() {
    type Equivalent = AbLinkedList<PublishedFirst>;
    holds("ab-ll@M11, 2x2", 20_000, insertion::<Equivalent>(k(1), &[&[5, 1], &[3, 2]], 2));
}

#[test]
fn the_other_insertions_lose_nothing() {
    holds("ab-array, 2x2", 100, insertion::<AbArray<AtomicAdd>>(k(4), &[&[5, 1], &[3, 2]], 2));
    holds("ab-ll, 2x2", 20_000, insertion::<AbLinkedList>(k(1), &[&[5, 1], &[3, 2]], 2));
    holds("z-buffer, 3x1", 500, insertion::<ZBuffer>(k(1), &[&[5], &[3], &[3]], 2));
}

#[test]
fn the_max_heap_keeps_the_nearest() {
    holds("kplus-heap k=1, 2x1", 20, insertion::<KPlusHeap>(k(1), &[&[5], &[3]], 2));
    holds("kplus-heap k=2, 2+1", 150, insertion::<KPlusHeap>(k(2), &[&[5, 9], &[7]], 1));
    holds("kplus-heap k=2, 2x2", 400, insertion::<KPlusHeap>(k(2), &[&[9, 3], &[5, 4]], 1));
    let groups: &[&[u32]] = &[&[5, 9], &[7]];
    is_caught("kplus-heap@M6", insertion::<KPlusHeap<kplus_heap::RelaxedCounter>>(k(2), groups, 1));
    is_caught(
        "kplus-heap@M1",
        insertion::<KPlusHeap<kplus_heap::PlainUnlock>>(k(2), &[&[5], &[3]], 2),
    );
}

/// Pages are linked, and the sorted list walked, while others insert.
#[test]
fn lists_that_are_read_while_they_grow_lose_nothing() {
    holds("ab-ll-paged, 2x1", 9, insertion::<AbPagedList>(k(1), &[&[5], &[3]], 2));
    holds("kb-ll k=1, 2x1", 30, insertion::<KNearestList>(k(1), &[&[5], &[3]], 2));
    holds("kb-ll k=2, 2x1", 30, insertion::<KNearestList>(k(2), &[&[5], &[3]], 2));
    is_caught(
        "kb-ll@relaxed",
        insertion::<KNearestList<kb_ll::RelaxedPublication>>(k(2), &[&[5], &[3]], 2),
    );
}

#[test]
fn a_chain_of_minima_keeps_the_nearest() {
    holds("kb-mdt64 k=2, 2x1", 4, insertion::<KbMdt64>(k(2), &[&[5], &[3]], 2));
    holds("kb-mdt64 k=2, 3x1", 2_000, insertion::<KbMdt64>(k(2), &[&[5], &[3], &[4]], 2));
}

/// The list by compare-exchange of `examples/user_scheme.rs`, which tries again where the head has changed.
#[test]
fn a_list_by_compare_exchange_loses_nothing() {
    holds("list by CAS, 2x1", 10, insertion::<CasList<false>>(k(1), &[&[5], &[3]], 2));
    holds("list by CAS, 2x2", 100, insertion::<CasList<false>>(k(1), &[&[5, 1], &[3, 2]], 2));
    is_caught("list by CAS, broken", insertion::<CasList<true>>(k(1), &[&[5], &[3]], 2));
}

/// One pixel on a table of so many cells in a row, whose offsets are 0, 1, 2, ... round and round.
fn hashed(cells: u32, ages: u32) -> Config {
    let base = u64::from(cells);
    let seed = (0..ages).rev().fold(0, |seed, age| seed * base + u64::from(age) % base);
    let table = TableSettings {
        size: [cells, 1],
        ages,
        offsets: Offsets::Digits,
        seed,
        ..TableSettings::default()
    };
    Config { grid: Grid { width: 1, height: 1, tile: 16 }, table, ..k(1) }
}

#[test]
fn the_hash_table_loses_nothing() {
    let two = insertion::<HaBuffer<Bits64>>(hashed(4, 4), &[&[5, 2], &[3]], 1);
    holds("ha64, 2 and 1", 20, two);
    holds(
        "ha64, 2 and 2",
        100,
        insertion::<HaBuffer<Bits64>>(hashed(4, 4), &[&[5, 2], &[3, 4]], 1),
    );
    holds("ha64, alike", 5, insertion::<HaBuffer<Bits32>>(hashed(3, 3), &[&[5], &[5], &[4]], 1));
    holds("ha64, three", 100, insertion::<HaBuffer<Bits64>>(hashed(4, 4), &[&[5], &[2], &[3]], 1));
}

#[test]
fn faults_of_the_hash_table_are_caught() {
    use fragloom::scheme::hash_table::ha::faults;
    type Faulty<V> = HaBuffer<Bits64, V>;
    let groups: &[&[u32]] = &[&[5, 2], &[3]];
    is_caught("load-store", insertion::<Faulty<faults::LoadStore>>(hashed(4, 4), groups, 1));
    is_caught("no-reinsert", insertion::<Faulty<faults::NotReinserted>>(hashed(4, 4), groups, 1));
    is_caught("max-age", insertion::<Faulty<faults::AgeUntold>>(hashed(4, 4), groups, 1));
}
