//! One battery over the catalogue, and over the tests' own schemes of other kinds: every method runs through the same
//! properties, as its contract says.
//!
//! * the accounting balances, on every executor
//! * an order-independent method gives the exact lists (`exact -k`), on every executor and under every policy
//! * a racy method gives them too where no two invocations of a pixel overlap, unless it depends on arrival
//! * with k = 1 it is a Z-buffer; with k >= the depth complexity an A-buffer
//! * its storage is what its formula says
//! * what it names as deterministic is
//! * where only equal depths may be confused, depths are exact and records are fragments' under every policy
//! * nothing it keeps was invented, and overflow is counted

mod support;
#[path = "support/toys/mod.rs"]
mod toys;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::fragment::depth_of;
use fragloom::raster::Grid;
use fragloom::render::{Data, Exec, Kept, Lists, Options, Policy, Report, reference};
use fragloom::scene::Scene;
use fragloom::scheme::approximate::Approximation;
use fragloom::scheme::contract::{Contract, Demand, Dependence, Form, Keeps, Limit, Overflow};
use fragloom::scheme::hash_table::table::TableSettings;
use fragloom::scheme::{Config, HeldKind};
use support::{contract, draw, lists, method, options, policies, scene, sim, small_scenes};

/// The methods that promise something, with a k that bites on the small scenes and one that does not.
fn cases() -> Vec<(Method, Option<u32>)> {
    let catalogue = toys::catalogue();
    let with_k = |method: Method| {
        let contract = method.contract();
        let takes_k = contract.keeps == Keeps::Nearest || contract.default_k.is_some();
        let ks = if takes_k { vec![Some(3), Some(64)] } else { vec![None] };
        ks.into_iter().map(move |k| (method, k))
    };
    catalogue.promised().flat_map(with_k).collect()
}

/// Those that keep fragments one by one.
fn cases_with_lists() -> Vec<(Method, Option<u32>)> {
    let mut cases = cases();
    cases.retain(|(method, _)| method.holds() == HeldKind::Fragments);
    cases
}

/// What is there one by one after a draw.
fn entries(kept: &Kept) -> u64 {
    match kept {
        Kept::Fragments(lists) => lists.entries.len() as u64,
        Kept::Records(lists) => lists.entries.len() as u64,
        Kept::Color(pixels) => pixels.iter().map(|light| u64::from(light.kept)).sum(),
        Kept::Depths(_) | Kept::Gone(_) => 0,
    }
}

fn executors() -> Vec<Exec> {
    let mut all = vec![Exec::Tile, Exec::Threads];
    all.extend(policies().map(|p| sim(p, 11)));
    all
}

fn with(method: Method, k: Option<u32>, exec: Exec) -> Options {
    Options { method, k, exec, threads: 2, ..Options::default() }
}

/// What a method is held to: all fragments in its words, and what it promises of them.
fn held_to(scene: &Scene, method: Method, k: Option<u32>) -> (Lists, Kept) {
    let reference = reference(scene, &with(method, k, Exec::Tile)).expect("a reference");
    (reference.all, reference.kept.expect("it says what it keeps"))
}

/// What it promises.
fn promised(scene: &Scene, method: Method, k: Option<u32>) -> Kept {
    held_to(scene, method, k).1
}

fn balances(report: &Report) -> bool {
    let dropped: u64 = report.dropped.values().sum();
    report.generated + report.duplicated + report.torn
        == report.kept + report.merged + report.culled + report.evicted + dropped
}

#[test]
fn accounts_balance_everywhere() {
    for scene in small_scenes() {
        let generated = draw(&scene, &options("exact", None)).report.generated;
        for (method, k) in cases() {
            for exec in executors() {
                let drawn = draw(&scene, &with(method, k, exec.clone()));
                let report = &drawn.report;
                assert!(balances(report), "{method} {exec:?}: {report:?}");
                assert_eq!(report.generated, generated, "{method} {exec:?}");
                assert_eq!(report.kept, entries(&drawn.kept), "{method} {exec:?}");
                assert_eq!(report.violations, Vec::<String>::new());
                if matches!(method.contract().overflow, Overflow::Never(_)) {
                    let short =
                        ["overflow", "pool", "age"].map(|reason| report.dropped.get(reason));
                    assert!(short.iter().all(|n| n.is_none_or(|&n| n == 0)), "{method} {report:?}");
                }
            }
        }
    }
}

/// With a k for all fragments, an approximation that says so gives the exact picture.
#[test]
fn approximations_are_exact_where_contracts_say_so() {
    let says_so = |c: &Contract| c.keeps == Keeps::Approximate(Limit::EnoughK);
    let (mut compared, mut differ) = (0, 0);
    for scene in small_scenes() {
        let exact = draw(&scene, &options("exact", None)).image;
        for (method, k) in cases().into_iter().filter(|(m, _)| says_so(m.contract())) {
            for exec in executors() {
                let image = draw(&scene, &with(method, k, exec)).image;
                assert!(k == Some(3) || image == exact, "{method} {}", scene.name);
                compared += 1;
                differ += u32::from(image != exact);
            }
        }
    }
    assert!(compared > 0 && differ > 0, "{differ} of {compared} differ: with k = 3, some must");
}

#[test]
fn order_independent_methods_give_the_exact_lists() {
    for scene in small_scenes() {
        let exact = |c: &Contract| c.order_independent() && c.keeps != Keeps::Some;
        for (method, k) in cases().into_iter().filter(|(m, _)| exact(m.contract())) {
            let expected = promised(&scene, method, k);
            for exec in executors() {
                let drawn = draw(&scene, &with(method, k, exec.clone()));
                assert_eq!(drawn.kept, expected, "{method} k {k:?} {exec:?} {}", scene.name);
            }
        }
    }
}

#[test]
fn every_method_is_exact_one_invocation_after_another() {
    for scene in small_scenes() {
        let exact = |c: &Contract| !c.is_arrival_dependent() && c.keeps != Keeps::Some;
        for (method, k) in cases().into_iter().filter(|(m, _)| exact(m.contract())) {
            let expected = promised(&scene, method, k);
            for exec in [Exec::Tile, sim(Policy::Order, 0), sim(Policy::Reverse, 0)] {
                let drawn = draw(&scene, &with(method, k, exec.clone()));
                assert_eq!(drawn.kept, expected, "{method} k {k:?} {exec:?} {}", scene.name);
            }
        }
    }
}

/// Arrival shows only at ties or overflow; on a scene without either, one invocation after another is exact for all.
/// (Published forms that merge round at every fragment; approximations that depend on arrival say nothing of many.)
#[test]
fn arrival_dependent_methods_are_exact_without_ties_and_overflow() {
    let scene = scene("synthetic:n=9", [24, 24]);
    let rounds = |c: &Contract| c.keeps == Keeps::Merged && c.form == Form::Published;
    let open = |c: &Contract| c.keeps.is_approximate() && c.is_arrival_dependent();
    let named = |c: &Contract| !matches!(c.keeps, Keeps::Visible | Keeps::Some);
    let exact = |c: &Contract| !rounds(c) && !open(c) && named(c);
    for (method, k) in cases().into_iter().filter(|(m, _)| exact(m.contract())) {
        let expected = promised(&scene, method, k);
        let drawn = draw(&scene, &with(method, k, Exec::Tile));
        assert_eq!(drawn.kept, expected, "{method} k {k:?}");
    }
}

#[test]
fn k_one_is_a_z_buffer_and_large_k_an_a_buffer() {
    for scene in small_scenes() {
        let nearest = lists(&scene, &options("z-buffer", None));
        let all = lists(&scene, &options("ab-ll", None));
        let exact = |c: &Contract| c.keeps == Keeps::Nearest && !c.is_arrival_dependent();
        for (method, _) in cases().into_iter().filter(|(m, _)| exact(m.contract())) {
            assert_eq!(lists(&scene, &with(method, Some(1), Exec::Tile)), nearest, "{method}");
            assert_eq!(lists(&scene, &with(method, Some(64), Exec::Tile)), all, "{method}");
        }
    }
}

/// Whatever k, and with equal depths, coplanar duplicates, and fragments on the near and far planes.
#[test]
fn correct_k_methods_equal_exact_for_every_k() {
    let hand_made = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/screen.toml");
    let scenes = [scene("synthetic:n=70,density=100", [6, 6]), scene(hand_made, [45, 33])];
    let correct = |c: &Contract| c.keeps == Keeps::Nearest && c.form == Form::Correct;
    for scene in &scenes {
        for method in Catalogue::built_in().promised().filter(|m| correct(m.contract())) {
            for k in [1, 2, 4, 8, 16, 32, 64] {
                let expected = promised(scene, method, Some(k));
                for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, u64::from(k))] {
                    let drawn = draw(scene, &with(method, Some(k), exec.clone()));
                    assert_eq!(drawn.kept, expected, "{method} k {k} {exec:?}");
                }
            }
        }
    }
}

/// One round for each layer, or for as many layers as a round takes; and one to see that nothing is left.
#[test]
fn rounds_are_as_many_as_layers_ask_for() {
    let scene = scene("layers:count=6", [17, 9]);
    let cases = [
        ("depth-peel", Some(64), 7),
        ("depth-peel@published", Some(64), 7),
        ("depth-peel-dual", None, 4),
        ("kplus-multi", Some(4), 2),
        ("kplus-multi", Some(2), 4),
        ("kplus-array", Some(2), 1),
    ];
    for (method, k, rounds) in cases {
        for exec in executors() {
            let report = draw(&scene, &with(self::method(method), k, exec.clone())).report;
            assert_eq!(report.rounds, rounds, "{method} {k:?} {exec:?}");
        }
    }
}

#[test]
fn a_memory_budget_is_never_exceeded() {
    // Whole tiles: what is allocated is then what the picture needs.
    let scene = scene("synthetic:n=8,tessellation=3", [64, 64]);
    for (method, k) in cases() {
        let contract = method.contract();
        let takes_k = contract.default_k.is_some();
        let k = k.filter(|_| !takes_k);
        for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, 3)] {
            let full = draw(&scene, &with(method, k, exec.clone())).report;
            for bytes in [full.bytes, full.bytes / 3 * 2] {
                let options =
                    Options { memory_budget: Some(bytes), ..with(method, k, exec.clone()) };
                let Ok(drawn) = fragloom::render::render(&scene, &options) else {
                    let fixed = !contract.words.contains('k');
                    assert!(contract.demand == Demand::Nothing && fixed, "{method}");
                    continue;
                };
                let report = drawn.report;
                assert!(report.bytes <= bytes, "{method}: {} of {bytes}", report.bytes);
                assert!(balances(&report), "{method}: {report:?}");
                assert_eq!(report.violations, Vec::<String>::new(), "{method}");
                let budget = report.budget.expect("one was given");
                assert_eq!(budget.histogram.iter().sum::<u64>(), 64 * 64);
                let pooled = contract.demand == Demand::Generated && !contract.crosses();
                if let Some(room) = budget.room.filter(|_| pooled) {
                    let found = report.kept + report.merged;
                    assert_eq!(found, room.min(report.generated), "{method}: all it has room for");
                }
            }
        }
    }
}

/// Tiles that one worker draws one after another may share its range of a pool, but not where the pool is too small.
#[test]
fn a_budget_holds_for_small_tiles_too() {
    let scene = scene("synthetic:n=8,tessellation=3", [64, 64]);
    for method in ["ab-ll", "ab-ll-bucket", "ab-ll-double", "kb-ll"] {
        let options = Options { tile: 16, threads: 1, ..options(method, None) };
        let bytes = draw(&scene, &options).report.bytes / 3 * 2;
        let report = draw(&scene, &Options { memory_budget: Some(bytes), ..options }).report;
        let room = report.budget.and_then(|budget| budget.room).expect("a pool");
        assert!(room < report.generated, "{method}");
        assert_eq!(report.kept, room, "{method}");
    }
}

#[test]
fn a_budget_that_is_too_small_is_refused() {
    let scene = scene("layers:count=4", [16, 16]);
    for method in ["kplus-array", "kplus-sb", "ab-ll", "ab-array", "z-buffer"] {
        let options = Options { memory_budget: Some(100), ..options(method, None) };
        let refused =
            fragloom::render::render(&scene, &options).map(|_| ()).expect_err("too little");
        assert!(refused.to_string().contains("--memory-budget"), "{refused}");
        assert!(refused.problem().contains("needs"), "{refused}");
    }
}

/// Section 3.3: k and the histogram decide; what no pixel has room for is reported beforehand.
#[test]
fn a_budget_chooses_the_largest_k() {
    let scene = scene("synthetic:n=14,tessellation=3", [40, 28]);
    for method in ["kplus-array", "kplus-heap", "kplus-sb", "kb-mdt64", "kb-ps"] {
        let with_k = |k| draw(&scene, &options(method, Some(k))).report;
        for k in [1, 3, 9] {
            // What the layout of whole tiles takes.
            let enough = Options { memory_budget: Some(1 << 30), ..options(method, None) };
            assert_eq!(draw(&scene, &enough).report.k, Some(14), "{method}: no more than there is");
            let bytes = with_k(k).bytes * 64 * 64 / (40 * 28) + 4_096;
            let chosen = Options { memory_budget: Some(bytes), ..options(method, None) };
            let report = draw(&scene, &chosen).report;
            let budget = report.budget.expect("one was given");
            assert!(report.k >= Some(k), "{method}: {:?} of {k}", report.k);
            assert_eq!(budget.beyond, report.generated - report.kept, "{method}");
        }
    }
}

#[test]
fn what_is_named_deterministic_is() {
    let scene = scene("synthetic:n=14,tessellation=3", [40, 28]);
    for (method, k) in cases() {
        let reports: Vec<_> = executors()
            .into_iter()
            .map(|exec| draw(&scene, &with(method, k, exec)).report)
            .map(|r| (r.deterministic.clone(), serde_json::to_value(r).unwrap()))
            .collect();
        let (names, first) = &reports[0];
        assert!(names.iter().any(|n| n == "generated"));
        for (_, report) in &reports {
            for name in names {
                assert_eq!(report[name], first[name], "{method} {name}");
            }
        }
    }
}

/// A scene's numbers, as a method is configured with them: all are different.
fn told(k: u32) -> Config {
    Config {
        k: Some(k),
        pixels: 9_000,
        generated: 1_000,
        max_depth_complexity: 70,
        bounded: 600,
        pages: 300,
        grid: Grid { width: 90, height: 100, tile: 16 },
        table: TableSettings { size: [96, 110], ..TableSettings::default() },
        records: 700,
        mask_words: 5,
        approximation: Approximation { moments: 6, samples: 13, ..Approximation::default() },
        ..Config::default()
    }
}

/// Storage of a pixel and of the frame, in words of 4 bytes, without what stands for hardware.
fn storage(method: Method, k: u32) -> Option<[u64; 2]> {
    let instance = method.instance(&told(k))?;
    let layout = instance.layout();
    let pixel = layout.per_pixel().bytes() / 4 - layout.interlocks();
    Some([pixel, layout.per_frame().bytes() / 4])
}

/// A sum of products of a number and a letter, as contracts have it: `2k + 2`, `2S + G + H`.
fn formula(text: &str, contract: &Contract, k: u32) -> u64 {
    let config = told(k);
    let blocks = u64::from(config.pixels).div_ceil(64);
    // -k is the number of slots of a method that has no k of its own.
    let own = contract.keeps == Keeps::FirstArrivals;
    let slots = if own { k } else { config.max_depth_complexity };
    let letter = |name: char| match name {
        'k' => u64::from(k),
        'n' => u64::from(slots),
        'F' => config.generated,
        'S' => config.bounded,
        'G' => blocks,
        'H' => blocks.div_ceil(64),
        'Q' => config.pages,
        'C' => config.table.cells(),
        'M' => config.records,
        'd' => config.mask_words.into(),
        'm' => config.approximation.moments.into(),
        's' => config.approximation.samples.into(),
        'B' => 12 * 13,
        other => panic!("{other} in {text}"),
    };
    let term = |term: &str| {
        let digits = term.trim_end_matches(char::is_alphabetic);
        let factor: u64 = if digits.is_empty() { 1 } else { digits.parse().expect("a number") };
        term[digits.len()..].chars().map(letter).product::<u64>() * factor
    };
    text.split(" + ").map(term).sum()
}

#[test]
fn storage_is_what_the_formulas_say() {
    for &method in toys::catalogue().methods() {
        let contract = method.contract();
        for k in [1, 2, 8, 32].into_iter().filter(|&k| k <= contract.max_k) {
            if let Some(words) = storage(method, k) {
                let said = [contract.words, contract.frame_words].map(|f| formula(f, contract, k));
                assert_eq!(words, said, "{method} k {k}");
            }
        }
    }
}

/// Table 1 of the k+-buffer paper, as far as it gives words per pixel.
#[test]
fn bounded_methods_need_what_their_paper_says() {
    let table = [
        ("kb", "2k"),
        ("kb-sr", "3n"),
        ("kb-mdt32", "2k"),
        ("kb-mdt64", "2k"),
        ("kb-ps", "2k"),
        ("kplus-array", "2k + 2"),
        ("kplus-heap", "2k + 2"),
    ];
    for (name, said) in table {
        let contract = contract(name);
        assert_eq!(contract.published_words, Some(said), "{name}");
        assert_eq!(contract.words, said, "{name}: and ours needs no more");
    }
}

/// Depth peeling by depth alone loses all but one of equal depths, says so, and breaks no promise.
#[test]
fn one_of_every_depth_is_kept_and_the_others_are_counted() {
    let scene = scene("hairball", [128, 128]);
    for exec in [Exec::Tile, Exec::Threads] {
        let drawn = draw(&scene, &with(method("depth-peel@published"), Some(8), exec));
        assert!(drawn.report.dropped["lost"] > 0, "the scene has ties");
        assert_eq!(drawn.report.violations, Vec::<String>::new());
        assert_eq!(drawn.kept, promised(&scene, method("depth-peel@published"), Some(8)));
        assert_ne!(*drawn.lists().expect("lists"), lists(&scene, &options("exact", Some(8))));
    }
}

#[test]
fn overflow_drops_by_arrival_and_is_counted() {
    let scene = scene("synthetic:n=14", [24, 24]);
    let all = lists(&scene, &options("exact", None));
    let sizes = all.offsets.windows(2).map(|w| w[1] - w[0]);
    let overflow: u64 = sizes.map(|f| f.saturating_sub(5)).sum();
    let limited = cases().into_iter().filter(|(m, _)| m.contract().keeps == Keeps::FirstArrivals);
    let names: Vec<&str> = limited.map(|(m, _)| m.name()).collect();
    assert_eq!(names, ["ab-array", "kb-sr"]);
    for name in names {
        for exec in executors() {
            let report = draw(&scene, &with(method(name), Some(5), exec)).report;
            assert_eq!(report.dropped.get("overflow"), Some(&overflow), "{name}");
            assert_eq!(report.kept + overflow, report.generated);
            assert!(!report.deterministic.contains(&"image_hash".to_owned()));
        }
    }
}

/// All methods keep only what was generated, and the list of each pixel is sorted.
#[test]
fn nothing_is_invented() {
    let scene = scene("cubes", [48, 40]);
    for (method, k) in cases_with_lists().into_iter().filter(|(m, _)| !m.contract().is_racy()) {
        let all = held_to(&scene, method, k).0;
        let lists = lists(&scene, &with(method, k, Exec::Threads));
        for y in 0..40 {
            for x in 0..48 {
                let (kept, generated) = (lists.pixel(x, y), all.pixel(x, y));
                assert!(kept.is_sorted());
                assert!(kept.iter().all(|key| generated.contains(key)), "{} {x} {y}", method);
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_before_it_is_drawn() {
    use fragloom::render::render;
    let scene = scene("layers:count=40", [64, 64]);
    let with_limit = |method: &str, k, max_memory| {
        render(&scene, &Options { max_memory, ..options(method, k) }).map(|_| ())
    };
    let needs = |e: fragloom::error::Error| e.problem().to_owned();
    let kept = 40 * 64 * 64 * 16;
    for method in ["exact", "ab-ll", "ab-array"] {
        let refused = with_limit(method, None, kept - 1).map_err(needs).expect_err("too little");
        assert!(refused.contains(&format!("{kept} bytes for kept fragments")), "{refused}");
        assert_eq!(with_limit(method, None, 4 * kept), Ok(()));
    }
    // A record of one fragment is 12 bytes by tile, and 56 in a list. Where pixels hold a colour, nothing is kept.
    let records = 40 * 64 * 64 * (12 + 56);
    let refused =
        with_limit("dfb+ofm", Some(40), records - 1).map_err(needs).expect_err("too little");
    assert!(refused.contains(&format!("{records} bytes for kept fragments")), "{refused}");
    assert_eq!(with_limit("wboit", None, kept), Ok(()));
    let refused =
        with_limit("kplus-array", Some(8), 300_000).map_err(needs).expect_err("too little");
    assert!(refused.contains("for kept fragments"), "{refused}");
    let refused =
        with_limit("kplus-array", Some(8), 600_000).map_err(needs).expect_err("too little");
    assert!(refused.contains("for storage on 'tile'"), "{refused}");
    // Pixels that wait for each other are all in memory at once: nine tiles, not one for each of two threads.
    let nine_tiles = support::scene("layers:count=4", [192, 192]);
    let on_nine = |method: &str| {
        let options = Options { max_memory: 2_600_000, ..options(method, Some(8)) };
        render(&nine_tiles, &options).map(|_| ()).map_err(needs)
    };
    assert_eq!(on_nine("kplus-array"), Ok(()));
    let refused = on_nine("kplus-sb").expect_err("too little");
    assert!(refused.contains("for storage on 'tile'"), "{refused}");
}

/// Depths as they must be, and nothing but what was generated.
fn has_right_depths(lists: &Lists, expected: &Lists, all: &Lists) -> bool {
    let depths = |keys: &[u64]| keys.iter().copied().map(depth_of).collect::<Vec<_>>();
    (0..lists.height).all(|y| {
        (0..lists.width).all(|x| {
            let kept = lists.pixel(x, y);
            let generated = all.pixel(x, y);
            depths(kept) == depths(expected.pixel(x, y))
                && kept.iter().all(|key| generated.contains(key))
        })
    })
}

#[test]
fn only_equal_depths_are_confused_where_contracts_say_so() {
    let ties = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/screen.toml");
    let (mut found, mut differ) = (0, 0);
    for scene in small_scenes().into_iter().chain([scene(ties, [120, 240])]) {
        for (method, k) in
            cases().into_iter().filter(|(m, _)| m.contract().dependence == Dependence::Ties)
        {
            let data = Data::Primitive;
            let held_to = Options { data, ..with(method, k, Exec::Tile) };
            let held_to = reference(&scene, &held_to).expect("a reference");
            let Some(Kept::Fragments(expected)) = held_to.kept else { panic!("{method}: lists") };
            for exec in executors() {
                let options = Options { data, ..with(method, k, exec.clone()) };
                let lists = lists(&scene, &options);
                let right = has_right_depths(&lists, &expected, &held_to.all);
                assert!(right, "{method} k {k:?} {exec:?} {}", scene.name);
                found += 1;
                differ += u32::from(lists != expected);
            }
        }
    }
    assert!(found > 0 && differ > 0, "{found} runs, {differ} with ties confused");
}

/// Negative controls: each of the battery's judgements can say no. (`tests/mutations.rs` has the lists'.)
#[test]
fn the_battery_can_fail() {
    let scene = scene("synthetic:n=24,density=100", [5, 5]);
    let run = |name, exec| draw(&scene, &with(method(name), Some(3), exec)).report;
    let mut report = run("kplus-array", Exec::Tile);
    assert!(balances(&report));
    report.evicted += 1;
    assert!(!balances(&report), "one fragment too many");

    let racy = [run("kb", Exec::Tile), run("kb", sim(Policy::RoundRobin, 0))];
    let hashes = racy.each_ref().map(|r| &r.fragments_hash);
    assert_ne!(hashes[0], hashes[1], "were it named deterministic, it would be found");
    assert!(!racy[0].deterministic.contains(&"fragments_hash".to_owned()));

    let all = held_to(&scene, method("kb"), Some(3)).0;
    let cut = all.cut(|_, keys| keys.truncate(3));
    let torn = lists(&scene, &with(method("kb"), Some(3), sim(Policy::RoundRobin, 0)));
    assert!(has_right_depths(&cut, &cut, &all) && !has_right_depths(&torn, &cut, &all));

    let words = storage(method("kplus-array"), 8);
    let contract = contract("kplus-array");
    assert_eq!(words.map(|w| w[0]), Some(formula("2k + 2", contract, 8)));
    for wrong in ["2k + 1", "k + 2", "2", "3k + 2"] {
        assert_ne!(words.map(|w| w[0]), Some(formula(wrong, contract, 8)), "{wrong}");
    }
}
