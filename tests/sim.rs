//! The simulated device: priorities, passes without barriers, and a pixel that is watched.

mod support;

use fragloom::catalogue::Catalogue;
use fragloom::explore::replay::replay;
use fragloom::explore::sample::minimise::minimise_scene;
use fragloom::explore::{Limits, Token};
use fragloom::render::{Exec, Options, Policy, Rendering, Sim};
use fragloom::scene::Scene;
use support::{draw, lists, options, scene, sim, small_scenes};

/// Layers in random order on few pixels, so that invocations of a pixel overlap.
fn crowded() -> Scene {
    scene("synthetic:n=24,density=100", [5, 5])
}

fn under(method: &str, policy: Policy, seed: u64) -> Rendering {
    draw(&crowded(), &Options { exec: sim(policy, seed), ..options(method, Some(3)) })
}

#[test]
fn priorities_lose_nothing_that_must_stay() {
    for scene in small_scenes() {
        let exact = lists(&scene, &options("exact", Some(3)));
        for depth in [1, 3, 20] {
            let exec = sim(Policy::Pct(depth), 5);
            let drawn = draw(&scene, &Options { exec, ..options("kplus-array", Some(3)) });
            assert_eq!(*drawn.lists().expect("lists"), exact, "{} pct:{depth}", scene.name);
        }
    }
}

#[test]
fn priorities_find_what_a_race_loses_and_a_seed_repeats_it() {
    let lost = |seed| {
        let drawn = under("kb", Policy::Pct(3), seed);
        assert_eq!(
            *drawn.lists().expect("lists"),
            *under("kb", Policy::Pct(3), seed).lists().expect("lists")
        );
        drawn.report.dropped.get("lost").copied().unwrap_or(0)
    };
    let lost: Vec<u64> = (0..24).map(lost).collect();
    println!("kb, k = 3, pct:3: lost by seed {lost:?}");
    assert!(lost.iter().any(|&n| n > 0));
}

/// M17: without a barrier, a pixel is cleared after something was stored, or read before all was.
#[test]
fn a_missing_barrier_shows() {
    let scene = scene("synthetic:n=6,density=100", [16, 16]);
    let exact = lists(&scene, &options("exact", Some(3)));
    // The whole scene in flight: a lock that was not cleared yet looks taken, which hides most of what could go wrong.
    let is_right = |method, seed| {
        let exec = Exec::Sim(Sim { seed, resident: 4_096, ..Sim::default() });
        lists(&scene, &Options { exec, ..options(method, Some(3)) }) == exact
    };
    for method in ["kplus-array@M17", "kplus-array@M17-resolve"] {
        assert!((0..6).any(|seed| !is_right(method, seed)), "{method}");
    }
    assert!((0..6).all(|seed| is_right("kplus-array", seed)), "with its barriers it is right");
}

/// Where passes overlap, the steps told are still those of stores alone.
#[test]
fn a_pixel_is_watched_where_passes_overlap() {
    let exact = lists(&crowded(), &options("exact", None));
    for method in ["kplus-array", "kplus-array@M17", "kplus-array@M17-resolve"] {
        let exec = Exec::Sim(Sim { resident: 96, watch: Some([1, 3]), ..Sim::default() });
        let drawn = draw(&crowded(), &Options { exec, ..options(method, Some(3)) });
        let told = drawn.watched.expect("it was asked for");
        let mut keys: Vec<u64> = told.fragments.iter().map(|f| f.key()).collect();
        keys.sort_unstable();
        assert_eq!(keys, exact.pixel(1, 3), "{method}");
        let steps = |i: u32| told.steps.iter().filter(|&&s| s == i).count();
        assert!((0..24).all(|i| steps(i) >= 2), "{method}: {:?}", told.steps);
        assert!(told.steps.len() > 24 * 2 && told.steps.iter().all(|&s| s < 24), "{method}");
    }
}

#[test]
fn a_watched_pixel_is_told_fragment_by_fragment() {
    let scene = crowded();
    let watched = |pixel, method| {
        let settings = Sim { resident: 96, watch: Some(pixel), ..Sim::default() };
        let exec = Exec::Sim(settings);
        let drawn = draw(&scene, &Options { exec, ..options(method, Some(3)) });
        (drawn.watched.expect("it was asked for"), drawn.kept)
    };
    let exact = lists(&scene, &options("exact", None));
    for pixel in [[0, 0], [4, 2]] {
        let (told, kept) = watched(pixel, "kplus-array");
        let mut keys: Vec<u64> = told.fragments.iter().map(|f| f.key()).collect();
        keys.sort_unstable();
        assert_eq!(keys, exact.pixel(pixel[0], pixel[1]));
        assert_eq!(kept, draw(&scene, &options("exact", Some(3))).kept);
        let steps = |i: u32| told.steps.iter().filter(|&&s| s == i).count();
        assert!((0..24).all(|i| steps(i) >= 2), "each performs operations: {:?}", told.steps);
    }
    let outside = Exec::Sim(Sim { watch: Some([9, 9]), ..Sim::default() });
    assert_eq!(draw(&scene, &Options { exec: outside, ..options("kb", None) }).watched, None);
}

/// From thousands of invocations to a handful of steps.
#[test]
fn a_scene_that_fails_is_cut_down_to_a_pixel() {
    let scene = scene("cubes", [64, 48]);
    let limits = Limits { states: 500_000, cancelled: &|| false };
    for (method, most) in [
        ("kb", 2),
        ("kplus-array@one-test", 3),
        ("kplus-array@published", 4),
        ("kb-multi@unverified", 4),
    ] {
        let exec = Exec::Sim(Sim { resident: 1_024, seed: 3, ..Sim::default() });
        let options = Options { exec, ..options(method, Some(2)) };
        let Ok(token) = minimise_scene(&scene, &options, &limits) else {
            panic!("{method} fails on this scene")
        };
        let n = token.litmus.fragments.len();
        println!(
            "{method}: {n} fragments, {} steps: {}",
            token.schedule().len(),
            Token::Litmus(token.clone())
        );
        assert!(n <= most, "{method}: {}", token.litmus.describe());
        let replayed = replay(&Catalogue::built_in(), &token).expect("it is what it was made of");
        assert!(replayed.run.violations().any(|(p, _)| p.name() == token.property));
    }
    let fine = Options { exec: sim(Policy::Random, 0), ..options("kplus-array", Some(2)) };
    let refused = minimise_scene(&scene, &fine, &limits).map_err(|e| e.to_string());
    assert!(refused.is_err_and(|e| e.contains("no difference")), "nothing to cut down");
}
