//! Faults that must show, and where: the battery's checks turned red by built-in mutations, on the simulated device.
//! (`tests/loom.rs` has the faults of memory orders, which no sequentially consistent schedule can show.)

mod support;

use fragloom::render::{Options, Policy, Rendering};
use fragloom::scene::Scene;
use support::{draw, options, scene, sim};

const SEEDS: u64 = 12;

/// Layers in random order on few pixels, so that invocations of a pixel overlap.
fn crowded() -> Scene {
    scene("synthetic:n=24,density=100", [5, 5])
}

fn random(method: &str, k: Option<u32>, seed: u64) -> Rendering {
    draw(&crowded(), &Options { exec: sim(Policy::Random, seed), ..options(method, k) })
}

/// How many of the seeds give lists other than the exact ones.
fn wrong_seeds(method: &str, k: Option<u32>) -> usize {
    let exact = draw(&crowded(), &options("exact", k)).lists;
    (0..SEEDS).filter(|&seed| random(method, k, seed).lists != exact).count()
}

#[test]
fn the_correct_forms_survive_every_seed() {
    for method in ["kplus-array", "exact"] {
        assert_eq!(wrong_seeds(method, Some(3)), 0, "{method}");
    }
    for method in ["ab-ll", "ab-array"] {
        assert_eq!(wrong_seeds(method, None), 0, "{method}");
    }
    assert_eq!(wrong_seeds("z-buffer", Some(1)), 0);
}

#[test]
fn a_missing_second_test_is_caught() {
    assert!(wrong_seeds("kplus-array@one-test", Some(3)) > 0);
}

#[test]
fn a_non_atomic_counter_is_caught() {
    assert!(wrong_seeds("ab-array@plain-counter", None) > 0);
    let report = random("ab-array@plain-counter", None, 1).report;
    assert!(report.dropped["lost"] > 0, "and accounted for: {report:?}");
}

/// Its fault is in the memory order, so no interleaving of whole operations shows it: that takes loom.
#[test]
fn a_relaxed_unlock_is_invisible_under_sequential_consistency() {
    assert_eq!(wrong_seeds("kplus-array@M1", Some(3)), 0);
}

/// The published max-array writes the new fragment into entry 0 before it finds the farthest; an unlocked reader in
/// between is culled against it.
#[test]
fn the_published_order_of_writes_loses_fragments() {
    let lost = (0..SEEDS).map(|seed| {
        let report = random("kplus-array@published", Some(3), seed).report;
        report.dropped.get("lost").copied().unwrap_or(0)
    });
    let lost: Vec<u64> = lost.collect();
    println!("kplus-array@published, k = 3: lost by seed {lost:?}");
    assert!(lost.iter().sum::<u64>() > 0);
}

#[test]
fn kb_loses_fragments_reproducibly_by_seed() {
    let runs: Vec<Rendering> = (0..4).map(|seed| random("kb", Some(4), seed)).collect();
    for (seed, run) in (0..).zip(&runs) {
        assert!(run.report.dropped["lost"] > 0, "seed {seed}: {:?}", run.report);
        let again = random("kb", Some(4), seed);
        assert_eq!(again.report.image_hash, run.report.image_hash);
        assert_eq!(again.report.fragments_hash, run.report.fragments_hash);
        assert_eq!(again.report.dropped, run.report.dropped);
        assert_eq!(again.report.counters, run.report.counters);
    }
    assert!(runs.windows(2).all(|w| w[0].report.fragments_hash != w[1].report.fragments_hash));
    let torn: u64 = runs.iter().map(|r| r.report.torn).sum();
    assert!(torn > 0, "depth of one fragment, data of another");
}

/// Few invocations in flight: the fewer, the less is lost; one at a time, nothing.
#[test]
fn kb_loses_nothing_without_overlap() {
    let exact = draw(&crowded(), &options("exact", Some(4))).lists;
    let one = fragloom::render::Sim { resident: 1, ..fragloom::render::Sim::default() };
    let exec = fragloom::render::Exec::Sim(one);
    assert_eq!(draw(&crowded(), &Options { exec, ..options("kb", Some(4)) }).lists, exact);
}
