//! Records divided by importance: never more than the budget, each pixel's own share and its nearest fragments, and the
//! same on every executor; what is no map, no gaze or no budget is named.

mod support;

use fragloom::render::{Animation, Resize};
use fragloom::render::{
    Exec, Factors, Importance, ImportanceMap, Options, Policy, Reach, Rendering, animate, render,
};
use fragloom::scene::Scene;
use proptest::prelude::*;
use support::{draw, lists, options, policies, scene, sim, small_scenes};

fn with(importance: Importance, average: f64, exec: Exec) -> Options {
    Options { k_average: Some(average), importance, exec, ..options("k-variable", None) }
}

/// What must hold of any frame: the shares fit, and every pixel holds its k nearest.
fn holds(scene: &Scene, drawn: &Rendering) {
    let report = &drawn.report;
    let found = report.importance.as_ref().expect("it divides by importance");
    let shares = drawn.shares.as_ref().expect("shares");
    let sum: u64 = shares.k.iter().map(|&k| u64::from(k)).sum();
    assert_eq!(found.shared, sum);
    assert!(sum <= found.records, "{sum} of {}", found.records);
    let pixels = u64::from(report.width) * u64::from(report.height);
    let blocks = scene.size.map(|edge| u64::from(edge.div_ceil(64)));
    let blocks = blocks[0] * blocks[1] * 64;
    // Four words a pixel, records, and sums of blocks and groups, twice.
    let bytes = 4 * (4 * pixels + 2 * found.records + 2 * (blocks + blocks.div_ceil(64)) + 2);
    assert_eq!(report.bytes, bytes);
    let all = lists(scene, &options("exact", None));
    let cut = all.cut(|pixel, keys| keys.truncate(shares.k[pixel] as usize));
    assert_eq!(*drawn.lists().expect("lists"), cut);
    assert_eq!(report.violations, Vec::<String>::new());
}

fn map(size: [u32; 2], kind: u32) -> ImportanceMap {
    let count = (size[0] * size[1]) as usize;
    let value = |i: usize| match kind {
        0 => 0,
        1 if i == count / 2 => u16::MAX,
        1 => 0,
        2 => u16::MAX,
        3 => u16::from(i.is_multiple_of(2)),
        _ => (i * 40_503 % 65_536) as u16,
    };
    ImportanceMap::new(size, (0..count).map(value).collect()).expect("a map")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// Over maps of zeros, of one bright pixel and of extremes, from 1x1 to 4096x1, and any budget.
    #[test]
    fn shares_never_exceed_the_budget(
        picture in prop_oneof![Just([1, 1]), Just([4_096, 1]), Just([1, 300]), (1..70u32, 1..40u32).prop_map(|(w, h)| [w, h])],
        of_map in prop_oneof![Just([1, 1]), Just([4_096, 1]), (1..20u32, 1..20u32).prop_map(|(w, h)| [w, h])],
        kind in 0..5u32,
        average in prop_oneof![Just(0.0), 0.0..3.0, 0.0..40.0],
        computed in any::<bool>(),
        alpha in 0.0..=1.0,
        seed in any::<u64>(),
    ) {
        let scene = scene("synthetic:n=9,tessellation=2,density=60", picture);
        let factors = if computed { Factors { map: true, ..Factors::COMPUTED } } else { Factors::MAPPED };
        let importance = Importance { factors, map: Some(map(of_map, kind)), alpha, seed, ..Importance::default() };
        let drawn = draw(&scene, &with(importance, average, Exec::Tile));
        holds(&scene, &drawn);
        if kind == 0 && !computed {
            prop_assert_eq!(drawn.report.kept, 0, "nothing is important");
        }
    }

    /// A budget in bytes is never exceeded, and is used to its last record.
    #[test]
    fn a_budget_in_bytes_is_kept(bytes in 70_000..600_000u64) {
        let scene = scene("synthetic:n=9,tessellation=2", [64, 64]);
        let options = Options { memory_budget: Some(bytes), ..options("k-variable", None) };
        let drawn = draw(&scene, &options);
        prop_assert!(drawn.report.bytes <= bytes && drawn.report.bytes + 8 > bytes);
        holds(&scene, &drawn);
        let budget = drawn.report.budget.expect("one was given");
        prop_assert_eq!(budget.beyond, drawn.report.generated - drawn.report.kept);
    }
}

#[test]
fn the_same_everywhere() {
    for scene in small_scenes() {
        let first = draw(&scene, &with(Importance::default(), 2.5, Exec::Tile));
        holds(&scene, &first);
        let execs = [Exec::Tile, Exec::Threads].into_iter().chain(policies().map(|p| sim(p, 7)));
        for exec in execs {
            for (threads, tile) in [(1, 64), (3, 16), (2, 32)] {
                let options =
                    Options { threads, tile, ..with(Importance::default(), 2.5, exec.clone()) };
                let drawn = draw(&scene, &options);
                assert_eq!(drawn.kept, first.kept, "{} {exec:?} {threads} {tile}", scene.name);
                assert_eq!(drawn.shares, first.shares, "{} {exec:?} {threads} {tile}", scene.name);
            }
        }
    }
}

#[test]
fn importance_attracts_records() {
    let scene = scene("layers:count=20", [64, 64]);
    let gaze = Importance {
        factors: Factors { periphery: true, ..Factors::MAPPED },
        map: Some(map([1, 1], 2)),
        gaze: Some([8.0, 8.0]),
        reach: Reach::HalfDiagonal,
        ..Importance::default()
    };
    let k = draw(&scene, &with(gaze, 8.0, Exec::Tile)).shares.expect("shares").k;
    assert!(k[8 * 64 + 8] > 2 * k[63 * 64 + 63], "{} {}", k[8 * 64 + 8], k[63 * 64 + 63]);
    let left = ImportanceMap::new([2, 1], vec![u16::MAX, 0]).expect("a map");
    let mapped = Importance { factors: Factors::MAPPED, map: Some(left), ..Importance::default() };
    let drawn = draw(&scene, &with(mapped, 8.0, Exec::Tile));
    let k = drawn.shares.expect("shares").k;
    assert!(k[0] > 15 && k[63] == 0, "{} {}", k[0], k[63]);
    assert!(drawn.report.warnings.iter().any(|w| w.contains("2x1") && w.contains("stretched")));
}

/// The first frame has none before it; the next ones have, and differ for it.
#[test]
fn the_fresnel_term_lags_one_frame() {
    let scene = scene("bottles:columns=2,rows=2,levels=1", [48, 48]);
    let animation = Animation { frames: 3, resize: Resize::Latent };
    let mut seen = Vec::new();
    let options = with(Importance::default(), 2.0, Exec::Tile);
    animate(&scene, &options, &animation, |frame| {
        let found = frame.rendering.report.importance.expect("it divides by importance");
        seen.push((found.fresnel_known, frame.rendering.shares.expect("shares").importance));
        Ok(())
    })
    .expect("frames");
    let known: Vec<bool> = seen.iter().map(|(known, _)| *known).collect();
    assert_eq!(known, [false, true, true]);
    let still = draw(&scene, &options);
    assert_eq!(still.shares.expect("shares").importance, seen[0].1, "a still is a first frame");
    let factors = Factors { fresnel: false, ..Factors::COMPUTED };
    let without = Importance { factors, ..Importance::default() };
    let without = draw(&scene, &with(without, 2.0, Exec::Tile));
    assert_eq!(without.shares.expect("shares").importance, seen[0].1, "1 everywhere");
}

#[test]
fn pixels_without_fragments_and_empty_scenes() {
    let mut empty = scene("layers:count=3", [20, 12]);
    empty.screen.clear();
    for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, 1)] {
        let drawn = draw(&empty, &with(Importance::default(), 3.0, exec));
        assert_eq!((drawn.report.kept, drawn.report.generated), (0, 0));
        holds(&empty, &drawn);
    }
    let sparse = scene("sphere", [40, 40]);
    let drawn = draw(&sparse, &with(Importance::default(), 1.0, Exec::Tile));
    let shares = drawn.shares.as_ref().expect("shares");
    assert_eq!(shares.k[0], 0, "the background gets no record");
    assert!(shares.k[20 * 40 + 20] >= 2, "what it does not take is there for others");
    holds(&sparse, &drawn);
}

#[test]
fn what_is_wrong_is_named() {
    let scene = scene("layers:count=3", [20, 12]);
    let refused = |options: Options| {
        let refused = render(&scene, &options).map(|_| ()).expect_err("it is wrong");
        (refused.place().to_owned(), refused.problem().to_owned())
    };
    let gaze = |at| Importance { gaze: Some(at), ..Importance::default() };
    let (place, problem) = refused(with(gaze([20.5, 3.0]), 1.0, Exec::Tile));
    assert_eq!(place, "--gaze");
    assert!(problem.contains("20x12"), "{problem}");
    let (place, _) = refused(with(Importance::default(), -1.0, Exec::Tile));
    assert_eq!(place, "--k-average");
    let (place, problem) = refused(with(Importance::default(), 1e9, Exec::Tile));
    assert_eq!(place, "--k-average");
    assert!(problem.contains("at most"), "{problem}");
    let both =
        Options { memory_budget: Some(1 << 20), ..with(Importance::default(), 1.0, Exec::Tile) };
    assert_eq!(refused(both).0, "--k-average");
    let small = Options { memory_budget: Some(100), ..options("k-variable", None) };
    let (place, problem) = refused(small);
    assert_eq!(place, "--memory-budget");
    assert!(problem.contains("one fragment"), "{problem}");
    // Fewer records than pixels are drawn, and said.
    let few = draw(&scene, &with(Importance::default(), 0.5, Exec::Tile));
    assert!(
        few.report.warnings.iter().any(|w| w.contains("120 records for 240 pixels")),
        "{few:?}"
    );
    holds(&scene, &few);
}
