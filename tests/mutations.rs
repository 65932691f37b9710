//! Faults that must show, and where: the battery's checks turned red by built-in mutations, on the simulated device.
//! (`tests/loom.rs` has the faults of memory orders, which no sequentially consistent schedule can show.)

mod support;

use fragloom::exec::drive::{Pipeline, complete};
use fragloom::exec::interpret::Interpreted;
use fragloom::fragment::{Fragment, key};
use fragloom::memory::Inputs;
use fragloom::memory::arena::{Owned, Shared};
use fragloom::memory::exclusive::Exclusive;
use fragloom::num::depth::FARTHEST;
use fragloom::render::{Exec, Options, Policy, Rendering};
use fragloom::scene::Scene;
use fragloom::scheme::{Config, Held, Keys, Outcome};
use support::{draw, lists, method, options, scene, sim};

const SEEDS: u64 = 12;

/// Layers in random order on few pixels, so that invocations of a pixel overlap.
fn crowded() -> Scene {
    scene("synthetic:n=24,density=100", [5, 5])
}

/// Three layers, the last of them between the others: for what goes wrong while an array fills.
fn few() -> Scene {
    scene("synthetic:n=3,density=100,seed=2", [7, 7])
}

fn random(scene: &Scene, method: &str, k: Option<u32>, seed: u64) -> Rendering {
    draw(scene, &Options { exec: sim(Policy::Random, seed), ..options(method, k) })
}

/// How many of the seeds give lists other than the exact ones.
fn wrong_seeds(scene: &Scene, method: &str, k: Option<u32>) -> usize {
    let exact = lists(scene, &options("exact", k));
    (0..SEEDS)
        .filter(|&seed| *random(scene, method, k, seed).lists().expect("lists") != exact)
        .count()
}

#[test]
fn the_correct_forms_survive_every_seed() {
    for method in ["kplus-array", "kb-ll", "exact"] {
        assert_eq!(wrong_seeds(&crowded(), method, Some(3)), 0, "{method}");
    }
    for method in ["ab-ll", "ab-ll-paged", "ab-ll-bucket", "ab-ll-double", "ab-array"] {
        assert_eq!(wrong_seeds(&crowded(), method, None), 0, "{method}");
    }
    assert_eq!(wrong_seeds(&crowded(), "z-buffer", Some(1)), 0);
    assert_eq!(wrong_seeds(&few(), "kplus-array", Some(2)), 0);
}

#[test]
fn faults_that_interleavings_show_are_caught() {
    let (many, few) = (crowded(), few());
    for (method, scene, k) in [
        ("kplus-array@M3", &many, Some(3)),
        ("kplus-array@M4", &many, Some(3)),
        ("kplus-array@M5", &few, Some(2)),
        ("kplus-array@M6-early-count", &few, Some(2)),
        ("kplus-array@one-test", &many, Some(3)),
        ("kplus-array@root-first", &many, Some(3)),
        ("kplus-array@published-fixed-unlock", &many, Some(3)),
        ("ab-array@plain-counter", &many, None),
        ("ab-ll@plain-head", &many, None),
        ("ab-ll-paged@no-lock", &many, None),
        ("ab-ll-double@M11", &many, None),
        ("kb-ll@M11", &many, Some(3)),
        ("z-buffer@load-store", &many, Some(1)),
    ] {
        let wrong = wrong_seeds(scene, method, k);
        println!("{method}: {wrong} of {SEEDS} seeds");
        assert!(wrong > 0, "{method}");
    }
}

#[test]
fn what_they_lose_is_accounted_for() {
    for method in ["kplus-array@M3", "ab-array@plain-counter", "ab-ll@plain-head"] {
        let k = method.starts_with("kplus").then_some(3);
        let lost = |seed| random(&crowded(), method, k, seed).report.dropped.get("lost").copied();
        assert!((0..SEEDS).any(|seed| lost(seed).is_some_and(|n| n > 0)), "{method}");
    }
}

/// Their faults are in memory orders, so no interleaving of whole operations shows them: that takes loom. Or in how
/// lanes of a warp wait for each other (M19), or nowhere (M11).
#[test]
fn faults_that_interleavings_do_not_show() {
    for fault in ["M1", "M1-relaxed", "M2", "M2-acquire", "M6", "M19"] {
        assert_eq!(wrong_seeds(&crowded(), &format!("kplus-array@{fault}"), Some(3)), 0, "{fault}");
    }
    assert_eq!(wrong_seeds(&crowded(), "ab-ll@M11", None), 0);
}

/// M14: a third fragment of a pixel lands in the next one, and is not reported as dropped.
#[test]
fn a_bound_test_that_is_off_by_one_is_caught() {
    let cubes = scene("cubes", [48, 40]);
    let run = |method| random(&cubes, method, Some(2), 1).report;
    let [right, wrong] = ["ab-array", "ab-array@M14"].map(run);
    assert_eq!((right.torn, right.dropped.get("lost")), (0, None));
    assert!(wrong.torn > 0 && wrong.dropped["lost"] > 0, "{wrong:?}");
}

/// One pixel on memory that one thread owns: what became of its fragments, what it holds, and how often a word was used
/// that is not the method's.
fn run(method: &str, config: &Config, fragments: &[(u32, u32)]) -> (Vec<Outcome>, Keys, u64) {
    let instance = self::method(method).instance(config).expect("it has memory");
    let inputs = Inputs::defaults(instance.layout());
    let scheme = Interpreted { instance: &*instance, inputs: &inputs };
    let pixel = Owned::new(instance.layout().per_pixel(), 1);
    let global = Shared::new(instance.layout().per_frame(), 1);
    let mem = Exclusive::new(&pixel, &global, &inputs, &());
    scheme.clear(&mem, 0..1);
    let store =
        |&(depth, data)| complete(scheme.store(&mem, Fragment { pixel: 0, depth, data, extra: 0 }));
    let outcomes = fragments.iter().map(store).collect();
    let mut held = Held::Keys(Keys::new());
    scheme.resolve(&mem, 0, &mut held);
    let Held::Keys(mut keys) = held else { panic!("it keeps lists") };
    keys.sort_unstable();
    (outcomes, keys, pixel.outside() + global.outside())
}

fn pixel(method: &str, generated: u64, fragments: &[(u32, u32)]) -> (Vec<Outcome>, Keys) {
    let config = Config {
        k: Some(2),
        pixels: 1,
        generated,
        max_depth_complexity: 2,
        bounded: 2,
        pages: 8,
        ..Config::default()
    };
    let (outcomes, keys, outside) = run(method, &config, fragments);
    assert_eq!(outside, 0, "{method}");
    (outcomes, keys)
}

/// M9: of equal depths, the two smallest data words are the nearest.
#[test]
fn an_equal_depth_that_stops_the_insertion_is_caught() {
    let fragments = [(5, 3), (5, 2), (5, 1)];
    assert_eq!(pixel("kplus-array", 3, &fragments).1, [key(5, 1), key(5, 2)]);
    assert_eq!(pixel("kplus-array@M9", 3, &fragments).1, [key(5, 2), key(5, 3)]);
}

/// M18.
#[test]
fn a_far_plane_that_is_rejected_is_caught() {
    for data in [0, 7, u32::MAX] {
        let fragment = [(FARTHEST, data)];
        let kept = (vec![Outcome::Kept], vec![key(FARTHEST, data)]);
        assert_eq!(pixel("z-buffer", 1, &fragment), kept);
        assert_eq!(pixel("z-buffer@M18", 1, &fragment), (vec![Outcome::Culled], vec![]));
    }
    assert_eq!(pixel("z-buffer@M18", 1, &[(FARTHEST - 1, 9)]).1, [key(FARTHEST - 1, 9)]);
}

#[test]
fn a_full_pool_is_refused() {
    let (outcomes, keys) = pixel("ab-ll", 2, &[(3, 0), (2, 0), (1, 0)]);
    assert_eq!(outcomes, [Outcome::Kept, Outcome::Kept, Outcome::Pool]);
    assert_eq!(keys, [key(2, 0), key(3, 0)]);
}

/// Of two pages, for eight fragments, the ninth gets none, and raises no counter.
#[test]
fn a_full_pool_of_pages_is_refused() {
    let fragments: Vec<(u32, u32)> = (0..10).map(|i| (i, 0)).collect();
    let config = Config { pixels: 1, pages: 2, ..Config::default() };
    let (outcomes, keys, _) = run("ab-ll-paged", &config, &fragments);
    assert_eq!(outcomes[..8], [Outcome::Kept; 8]);
    assert_eq!(outcomes[8..], [Outcome::Pool; 2]);
    assert!(keys.into_iter().eq((0..8).map(|depth| key(depth, 0))));
}

/// M14 of the pool, which is as large as the scene: it takes one that is not.
#[test]
fn a_pool_bound_that_is_off_by_one_is_caught() {
    let outside = |method, fragments: &[_]| {
        let config = Config { pixels: 1, generated: 2, ..Config::default() };
        run(method, &config, fragments).2
    };
    let three = [(3, 0), (2, 0), (1, 0)];
    assert!(outside("ab-ll@M14", &three) > 0);
    assert_eq!([outside("ab-ll@M14", &three[1..]), outside("ab-ll", &three)], [0, 0]);
}

/// The published max-array writes the new fragment into entry 0 before it finds the farthest; an unlocked reader in
/// between is culled against it.
#[test]
fn the_published_order_of_writes_loses_fragments() {
    let lost = (0..SEEDS).map(|seed| {
        let report = random(&crowded(), "kplus-array@published", Some(3), seed).report;
        report.dropped.get("lost").copied().unwrap_or(0)
    });
    let lost: Vec<u64> = lost.collect();
    println!("kplus-array@published, k = 3: lost by seed {lost:?}");
    assert!(lost.iter().sum::<u64>() > 0);
}

#[test]
fn kb_loses_fragments_reproducibly_by_seed() {
    let runs: Vec<Rendering> = (0..4).map(|seed| random(&crowded(), "kb", Some(4), seed)).collect();
    for (seed, run) in (0..).zip(&runs) {
        assert!(run.report.dropped["lost"] > 0, "seed {seed}: {:?}", run.report);
        let again = random(&crowded(), "kb", Some(4), seed);
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
    let exact = lists(&crowded(), &options("exact", Some(4)));
    let one = fragloom::render::Sim { resident: 1, ..fragloom::render::Sim::default() };
    let exec = Exec::Sim(one);
    assert_eq!(lists(&crowded(), &Options { exec, ..options("kb", Some(4)) }), exact);
}
