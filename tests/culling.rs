//! Occupancy culling: it never changes a result, whatever the scene, the method, k and the mask; and it is counted where
//! fragments were rejected.

mod support;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::num::depth::FARTHEST;
use fragloom::render::{Exec, Options, Policy, keeps_nearest, render};
use fragloom::scene::{Scene, ScreenTriangle};
use proptest::prelude::*;
use support::{draw, method, options, policies, scene, sim, small_scenes};

const KS: [u32; 6] = [1, 4, 8, 16, 32, 64];
const WORDS: [u32; 4] = [1, 2, 4, 8];

/// The methods that keep the nearest fragments, whatever the interleaving.
fn culled() -> Vec<Method> {
    let all = Catalogue::built_in();
    let nearest = |m: &Method| keeps_nearest(m.contract()) && m.contract().order_independent();
    all.promised().filter(nearest).collect()
}

fn with(method: Method, k: u32, cull: Option<u32>, exec: Exec) -> Options {
    let k = method.contract().default_k.map(|_| k);
    Options { method, k, cull, exec, threads: 2, ..Options::default() }
}

/// A picture whose every pixel has fragments of these depth codes.
fn layers(codes: &[u32], size: [u32; 2]) -> Scene {
    let mut scene = scene("layers:count=1", size);
    scene.screen.clear();
    let [width, height] = size.map(f64::from);
    for (i, &code) in (0u32..).zip(codes) {
        // The loader rounds to this code: the product is exact enough for all 32 bits.
        let z = f64::from(code) / f64::from(u32::MAX);
        let corner = |x: f64, y: f64| [x, y, z];
        let shade = 0.1 + 0.8 * f64::from(i % 7) / 7.0;
        scene.screen.push(ScreenTriangle {
            points: [corner(0.0, 0.0), corner(0.0, 2.0 * height), corner(2.0 * width, 0.0)],
            color: [shade as f32, 0.5, 0.25, 0.5],
        });
    }
    scene
}

fn codes() -> impl Strategy<Value = Vec<u32>> {
    let depth = prop_oneof![
        3 => 0..=FARTHEST,
        2 => (0..64u32).prop_map(|i| (i << 26).min(FARTHEST)),
        2 => (0..64u32, -1..=1i64).prop_map(|(i, by)| ((i64::from(i) << 26) + by).clamp(0, FARTHEST.into()) as u32),
        1 => Just(FARTHEST),
        1 => Just(0),
        1 => (0..30u32).prop_map(|i| 0x4000_0000 + i),
    ];
    prop_oneof![
        prop::collection::vec(depth, 1..90),
        // Near and far are the same.
        (0..=FARTHEST, 1..40usize).prop_map(|(z, n)| vec![z; n]),
        // All but the last in the first interval.
        (1..80u32).prop_map(|n| (0..n).chain([FARTHEST]).collect()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_result_never_changes(
        codes in codes(), k in prop::sample::select(&KS[..]), words in prop::sample::select(&WORDS[..]), which in any::<prop::sample::Index>(),
    ) {
        let scene = layers(&codes, [3, 2]);
        let all = culled();
        let method = all[which.index(all.len())];
        let hash = |cull, exec| draw(&scene, &with(method, k, cull, exec)).report;
        let plain = hash(None, Exec::Tile);
        for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, 5)] {
            let found = hash(Some(words), exec);
            prop_assert_eq!(&found.fragments_hash, &plain.fragments_hash, "{} k {} d {}", method, k, words);
            prop_assert_eq!(&found.image_hash, &plain.image_hash);
            prop_assert_eq!(&found.violations, &Vec::<String>::new());
        }
    }
}

/// Every such method, k and mask, on scenes of different character.
#[test]
fn no_method_is_harmed() {
    let methods = culled();
    assert!(methods.len() >= 9, "{methods:?}");
    let mut rejected = 0;
    for scene in small_scenes() {
        for &method in &methods {
            for (k, words) in [(1, 1), (3, 1), (4, 2), (8, 8), (64, 1)] {
                let plain = draw(&scene, &with(method, k, None, Exec::Tile));
                let with = draw(&scene, &with(method, k, Some(words), Exec::Tile));
                assert_eq!(with.kept, plain.kept, "{method} k {k} d {words} {}", scene.name);
                rejected += with.report.culling.expect("it was asked for").rejected_before;
            }
        }
    }
    assert!(rejected > 100_000, "{rejected}");
}

/// The bound of a pixel is the same on every executor, and what it rejects too.
#[test]
fn the_same_everywhere() {
    for scene in small_scenes() {
        for name in ["kplus-array", "kb-ps", "kplus-sb", "k-variable", "z-buffer"] {
            let of = |exec| {
                let report = draw(&scene, &with(method(name), 3, Some(2), exec)).report;
                let culling = report.culling.expect("it was asked for");
                (report.fragments_hash, report.generated, culling.rejected_before)
            };
            let first = of(Exec::Tile);
            for exec in [Exec::Threads].into_iter().chain(policies().map(|p| sim(p, 3))) {
                assert_eq!(of(exec.clone()), first, "{name} {exec:?} {}", scene.name);
            }
        }
        let passes = |exec| draw(&scene, &with(method("occupancy"), 3, Some(2), exec)).kept;
        let first = passes(Exec::Tile);
        for exec in [Exec::Threads].into_iter().chain(policies().map(|p| sim(p, 3))) {
            assert_eq!(passes(exec), first, "{}", scene.name);
        }
    }
}

/// What is counted adds up, and fewer fragments reach the lock.
#[test]
fn fewer_fragments_reach_the_lock() {
    // Dense: most of its fragments are not among the eight nearest.
    let scene = scene("hairball:strands=4000,radius=0.008", [192, 192]);
    let plain = draw(&scene, &options("kplus-array", Some(8))).report;
    let culled = Options { cull: Some(2), ..options("kplus-array", Some(8)) };
    let report = draw(&scene, &culled).report;
    assert_eq!(report.fragments_hash, plain.fragments_hash);
    let culling = report.culling.expect("it was asked for");
    assert_eq!(culling.rejected_before + culling.rejected_inside, report.culled);
    let attempts = [&plain.counters, &report.counters].map(|c| c["exchange"]);
    println!("{} fragments, attempts {attempts:?}, rejected {culling:?}", report.generated);
    assert!(2 * attempts[1] < report.generated, "{attempts:?} of {}", report.generated);
    assert!(attempts[1] < attempts[0]);
    assert_eq!(
        (culling.words, culling.words_reusing),
        (5, Some(3)),
        "d + 3, and the k-buffer has room"
    );
    let large = Options { cull: Some(32), ..options("kplus-array", Some(8)) };
    let large = draw(&scene, &large).report.culling.expect("it was asked for");
    assert_eq!((large.words, large.words_reusing), (35, Some(27)), "d + 3, d - k + 3");
}

#[test]
fn what_cannot_be_culled_is_named() {
    let scene = scene("layers:count=3", [20, 12]);
    let refused = |method: &str, words| {
        let options = Options { cull: Some(words), ..options(method, None) };
        render(&scene, &options).map(|_| ()).expect_err("it is wrong").to_string()
    };
    assert!(refused("ab-ll", 2).contains("ab-ll keeps more than the nearest"));
    assert!(refused("exact", 2).contains("no store pass"));
    for words in [0, 257] {
        assert!(refused("kplus-array", words).contains("1 to 256"));
    }
    // Too few intervals for k: allowed, in vain, and said.
    let vain = Options { cull: Some(1), ..options("kplus-array", Some(32)) };
    let report = draw(&scene, &vain).report;
    assert!(report.warnings.iter().any(|w| w.contains("nothing is culled")), "{report:?}");
    let budget =
        Options { memory_budget: Some(4_000), cull: Some(2), ..options("kplus-array", None) };
    let wrong = render(&scene, &budget).map(|_| ()).expect_err("too little").to_string();
    assert!(wrong.contains("culling alone needs"), "{wrong}");
}
