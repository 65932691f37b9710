//! The HA-buffer against a sequential reference table, filled one fragment after another: the same cells under every
//! schedule, on every executor and at every load; and what is lost where there is no room.

mod support;

use std::collections::BTreeMap;
use std::future::Future;
use std::pin::{Pin, pin};
use std::task::{Context, Poll, Waker};

use fragloom::effect::csg::Expression;
use fragloom::fragment::{Fragment, data_of, depth_of, key};
use fragloom::memory::sim::Sim as Memory;
use fragloom::memory::{Inputs, Layout, Word};
use fragloom::num::depth::Format;
use fragloom::num::random::Random;
use fragloom::raster::Grid;
use fragloom::render::{
    Data, Effect, Exec, Lists, Offsets, Options, Policy, Rendering, Shadows, Sim, TableOptions,
};
use fragloom::scene::Scene;
use fragloom::scheme::hash_table::ha::{self, Bits32, Bits64, HaBuffer, Record};
use fragloom::scheme::hash_table::hash_coherent::HashCoherent;
use fragloom::scheme::hash_table::table::TableSettings;
use fragloom::scheme::{Cells, Config, Keys, Outcome, Scheme};
use proptest::prelude::*;
use support::{draw, lists, options, scene, sim};

// ---------------------------------------------------------------------------------------------------------------------
// The sequential reference table.

/// A pixel's column and row.
type Place = (u32, u32);

/// A record: its age, what is compared behind it, and its pixel.
type Held = (u32, u64, Place);

/// Robin Hood insertion into a list of cells, sequentially, as in section 4.1.3.
struct Book {
    size: [u32; 2],
    offsets: Vec<[u32; 2]>,
    cells: BTreeMap<Place, Held>,
    dropped: Vec<(Place, u64)>,
    duplicates: usize,
}

impl Book {
    fn new(settings: &TableSettings) -> Self {
        let (cells, dropped) = (BTreeMap::new(), Vec::new());
        Self { size: settings.size, offsets: settings.offsets(), cells, dropped, duplicates: 0 }
    }

    /// `rank`: nearer is larger, and larger data among equals.
    fn insert(&mut self, pixel: (u32, u32), rank: u64) {
        let (mut own, mut age) = ((rank, pixel), 1);
        while let Some(offset) = self.offsets.get(age - 1) {
            let (x, y) = own.1;
            let place = ((x + offset[0]) % self.size[0], (y + offset[1]) % self.size[1]);
            let mine = (age as u32, own.0, own.1);
            match self.cells.get(&place).copied() {
                None => {
                    self.cells.insert(place, mine);
                    return;
                }
                Some(other) if (other.0, other.1) == (mine.0, mine.1) => {
                    self.duplicates += 1;
                    return;
                }
                Some(other) if (other.0, other.1) < (mine.0, mine.1) => {
                    self.cells.insert(place, mine);
                    (own, age) = ((other.1, other.2), other.0 as usize);
                }
                Some(_) => {}
            }
            age += 1;
        }
        self.dropped.push((own.1, own.0));
    }

    /// As it would be read back: age, then what is compared.
    fn words(&self, bits: u32) -> Vec<u64> {
        let [width, height] = self.size;
        let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let word = |&(age, rank, _): &Held| u64::from(age) << (bits - 8) | rank;
        all.map(|place| self.cells.get(&place).map_or(0, word)).collect()
    }
}

/// What is compared behind the age: the depth of 24 bits reversed, then the data.
fn rank64(key: u64) -> u64 {
    u64::from(0xFF_FFFF - depth_of(key)) << 32 | u64::from(data_of(key))
}

fn rank32(key: u64) -> u64 {
    u64::from(0xFF_FFFF - depth_of(key))
}

// ---------------------------------------------------------------------------------------------------------------------
// Schemes on a memory whose steps we choose.

struct Ran {
    cells: Vec<u64>,
    lists: Vec<Keys>,
    outcomes: Vec<Outcome>,
}

/// Run one invocation to its end.
fn finish<F: Future>(mem: &Memory<()>, future: F) -> F::Output {
    let mut future = pin!(future);
    let context = &mut Context::from_waker(Waker::noop());
    loop {
        match future.as_mut().poll(context) {
            Poll::Ready(result) => return result,
            Poll::Pending => mem.grant(),
        }
    }
}

/// All fragments at once, stepped in a random order.
fn run<S: Scheme<Holds = Keys>>(config: &Config, fragments: &[Fragment], seed: u64) -> Ran {
    let mut layout = Layout::default();
    let scheme = S::new(config, &mut layout);
    let mem = Memory::new(
        &layout,
        config.grid.storage_pixels(),
        Inputs::defaults(&layout),
        0xDEAD_BEEF_5EED_F00D,
        (),
    );
    finish(&mem, scheme.clear_frame(&mem));
    for index in 0..scheme.invocations(0) {
        finish(&mem, scheme.frame(&mem, 0, index));
    }
    let mut outcomes = vec![Outcome::Kept; fragments.len()];
    type Running<'a> = Pin<Box<dyn Future<Output = Outcome> + 'a>>;
    let invocation = |f: &Fragment| -> Running<'_> { Box::pin(scheme.store(&mem, *f)) };
    let mut live: Vec<(usize, Running<'_>)> =
        fragments.iter().map(invocation).enumerate().collect();
    let context = &mut Context::from_waker(Waker::noop());
    // To their first operation.
    live.retain_mut(|(i, invocation)| match invocation.as_mut().poll(context) {
        Poll::Ready(outcome) => {
            outcomes[*i] = outcome;
            false
        }
        Poll::Pending => true,
    });
    let mut random = Random::new(seed, 0);
    while !live.is_empty() {
        let chosen = random.below(live.len() as u64) as usize;
        mem.grant();
        if let Poll::Ready(outcome) = live[chosen].1.as_mut().poll(context) {
            outcomes[live.swap_remove(chosen).0] = outcome;
        }
    }
    let lists = (0..config.grid.storage_pixels() as u32).map(|pixel| {
        let mut keys = Keys::new();
        finish(&mem, scheme.resolve(&mem, pixel, &mut keys));
        keys
    });
    let lists = lists.collect();
    let cells = match scheme.readback().expect("a table").cells {
        Cells::Words32(words) => mem.copy(words),
        Cells::Words64(words) => mem.copy(words),
    };
    Ran { cells, lists, outcomes }
}

/// What one table is tried with.
#[derive(Clone, Debug)]
struct Case {
    config: Config,
    /// Position, depth and data.
    fragments: Vec<((u32, u32), u32, u32)>,
    seed: u64,
}

impl Case {
    fn fragments(&self) -> Vec<Fragment> {
        let fragment = |&((x, y), depth, data): &((u32, u32), u32, u32)| Fragment {
            pixel: self.config.grid.pixel(x, y),
            depth,
            data,
            extra: 0,
        };
        self.fragments.iter().map(fragment).collect()
    }

    fn book(&self, rank: fn(u64) -> u64) -> Book {
        let mut book = Book::new(&self.config.table);
        for &(pixel, depth, data) in &self.fragments {
            book.insert(pixel, rank(key(depth, data)));
        }
        book
    }

    fn generated(&self, pixel: u32) -> Vec<u64> {
        let of_pixel = self.fragments().into_iter().filter(|f| f.pixel == pixel);
        let mut keys: Vec<u64> = of_pixel.map(Fragment::key).collect();
        keys.sort_unstable();
        keys
    }
}

/// Tables of 1 to 64 cells over screens that they cover, by `more` cells on each axis; few depths, so that there are
/// ties; few offsets, so that some are equal.
fn cases(covers: bool) -> impl Strategy<Value = Case> {
    let screen = (1u32..=8, 1u32..=8);
    let more = (0u32..=3, 0u32..=3);
    let ages = prop::sample::select(vec![3u32, 15, 255]);
    let kinds =
        prop::sample::select(vec![Offsets::Random, Offsets::FarthestPoint, Offsets::Digits]);
    (screen, more, ages, kinds, any::<u64>(), any::<u64>()).prop_flat_map(
        move |((w, h), (dx, dy), ages, offsets, seed, order)| {
            let wide = if covers { w + dx } else { (w / 2).max(1) };
            let size = [wide.min(64), (h + dy).min(64 / wide.min(64)).max(h.min(64 / wide))];
            let (w, h) = if covers { (w, h.min(size[1])) } else { (w, h) };
            let grid = Grid { width: w, height: h, tile: 16 };
            let table = TableSettings { size, ages, offsets, seed, ..TableSettings::default() };
            let depth = prop_oneof![0u32..4, 0xFF_FFFEu32..=0xFF_FFFF, 0u32..=0xFF_FFFF];
            let fragment = ((0..w, 0..h), depth, 0u32..3);
            prop::collection::vec(fragment, 0..90).prop_map(move |fragments| {
                let generated = fragments.len() as u64;
                let config = Config { grid, table, generated, ..Config::default() };
                Case { config, fragments, seed: order }
            })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Cell for cell the reference table, under every schedule; also where fragments find no room.
    #[test]
    fn tables_are_those_of_the_reference(case in cases(true)) {
        let (book, ran) = (case.book(rank64), run::<HaBuffer<Bits64>>(&case.config, &case.fragments(), case.seed));
        prop_assert_eq!(&ran.cells, &book.words(64));
        let gone = ran.outcomes.iter().filter(|&&o| o != Outcome::Kept).count();
        prop_assert_eq!(gone, book.dropped.len() + book.duplicates);
        // The lists hold all but those that the reference dropped, and come out sorted.
        for (pixel, list) in (0..).zip(&ran.lists) {
            prop_assert!(list.is_sorted_by_key(|&key| depth_of(key)), "pixel {}", pixel);
            let mut expected = case.generated(pixel);
            expected.dedup();
            let (x, y) = case.config.grid.place(pixel);
            let lost = book.dropped.iter().filter(|(at, _)| *at == (x, y));
            let lost: Vec<u64> = lost.map(|&(_, rank)| rank).collect();
            expected.retain(|&key| !lost.contains(&rank64(key)));
            let mut found = list.clone();
            found.sort_unstable();
            prop_assert_eq!(found, expected, "pixel {}", pixel);
        }
        let book = case.book(rank32);
        let ran = run::<HaBuffer<Bits32>>(&case.config, &case.fragments(), case.seed);
        prop_assert_eq!(ran.cells, book.words(32));
    }

    /// Fragments that are alike are all kept, where there is room.
    #[test]
    fn multisets_are_kept(case in cases(true)) {
        let ran = run::<HaBuffer<Bits64, ha::Multiset>>(&case.config, &case.fragments(), case.seed);
        let dropped = ran.outcomes.iter().filter(|&&o| o != Outcome::Kept).count();
        let kept: usize = ran.lists.iter().map(Vec::len).sum();
        prop_assert_eq!(kept + dropped, case.fragments.len());
        prop_assert!(ran.outcomes.iter().all(|&o| o == Outcome::Kept || o == Outcome::Age));
    }

    /// With keys in its records, a table may also be narrower than the screen.
    #[test]
    fn explicit_keys_need_no_screen(case in prop_oneof![cases(true), cases(false)]) {
        let ran = run::<HashCoherent>(&case.config, &case.fragments(), case.seed);
        let dropped = ran.outcomes.iter().filter(|&&o| o != Outcome::Kept).count();
        let mut missing = 0;
        for (pixel, list) in (0..).zip(&ran.lists) {
            let (generated, mut found) = (case.generated(pixel), list.clone());
            found.sort_unstable();
            let mut rest = generated.iter();
            prop_assert!(found.iter().all(|key| rest.any(|other| other == key)), "pixel {}", pixel);
            missing += generated.len() - found.len();
        }
        prop_assert_eq!(missing, dropped);
    }

    /// Where the table is narrower than the screen, ages do not identify pixels; but every walk ends, within the table.
    #[test]
    fn narrow_tables_end(case in cases(false)) {
        let ran = run::<HaBuffer<Bits64>>(&case.config, &case.fragments(), case.seed);
        let stored = ran.cells.iter().filter(|&&cell| cell != 0).count();
        let kept = ran.outcomes.iter().filter(|&&o| o == Outcome::Kept).count();
        prop_assert_eq!(stored, kept);
    }
}

/// Where pixels fold onto each other, lists are wrong: that is what the size is for.
#[test]
fn narrow_tables_confuse_pixels() {
    let grid = Grid { width: 2, height: 1, tile: 16 };
    let table = TableSettings { size: [1, 4], ages: 4, ..TableSettings::default() };
    let config = Config { grid, table, generated: 2, ..Config::default() };
    let case = Case { config, fragments: vec![((0, 0), 5, 1), ((1, 0), 7, 2)], seed: 0 };
    let ran = run::<HaBuffer<Bits64>>(&case.config, &case.fragments(), 0);
    assert_eq!(ran.lists[0], ran.lists[1], "both pixels see both fragments");
}

#[test]
fn records_keep_age_depth_and_data() {
    for age in [1, 2, 128, 255] {
        for (depth, data) in [(0, 0), (0xFF_FFFF, u32::MAX), (0x12_3456, 0x789A_BCDE)] {
            let wide = Bits64::pack(age, key(depth, data));
            assert_eq!((Bits64::age(wide), Bits64::key(wide)), (age, key(depth, data)));
            let narrow = Bits32::pack(age, key(depth, data));
            assert_eq!((Bits32::age(narrow), Bits32::key(narrow)), (age, key(depth, 0)));
            assert!(wide.to_u64() > Bits64::pack(age - 1, key(0, u32::MAX)), "the older wins");
            assert!(depth == 0 || wide < Bits64::pack(age, key(depth - 1, 0)), "then the nearer");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Whole frames.

const EDGE: u32 = 96;

/// More fragments than pixels, of many triangles.
fn crowded() -> Scene {
    crowded_at(EDGE)
}

fn crowded_at(edge: u32) -> Scene {
    scene("synthetic:n=12,tessellation=3,density=24", [edge, edge])
}

/// Pixels on each side of the largest test: `FRAGLOOM_EDGE`, for full sizes.
fn full_edge() -> u32 {
    let edge = std::env::var("FRAGLOOM_EDGE").ok();
    edge.map_or(EDGE, |edge| edge.parse().expect("FRAGLOOM_EDGE: a number of pixels"))
}

fn with(method: &str, exec: Exec, data: Data, table: TableOptions) -> Options {
    Options { exec, data, table, depth_format: Some(Format::D24), ..options(method, None) }
}

fn loaded(load: u32) -> TableOptions {
    TableOptions { load: Some(load), ..TableOptions::default() }
}

fn schedules() -> impl Iterator<Item = Exec> {
    let five =
        [Policy::Random, Policy::RoundRobin, Policy::Reverse, Policy::Warp(32), Policy::Pct(3)];
    let seeds = |policy: Policy| (0..20).map(move |seed| sim(policy.clone(), seed));
    five.into_iter().flat_map(seeds)
}

fn without_alike(drawn: &Rendering) -> Lists {
    drawn.lists().expect("lists").cut(|_, keys| keys.dedup())
}

/// The table is the same, bit for bit, and holds what the exact reference holds: for every load, on every executor,
/// under five policies with twenty seeds each.
#[test]
fn no_schedule_changes_a_table() {
    let edge = full_edge();
    let scene = crowded_at(edge);
    let exact = |data| draw(&scene, &with("exact", Exec::Tile, data, TableOptions::default()));
    let (triangles, colors) = (exact(Data::Primitive), exact(Data::Color));
    assert!(triangles.report.generated > 2 * u64::from(edge * edge));
    for load in [30, 50, 80, 90, 95] {
        let first = draw(&scene, &with("ha64", Exec::Tile, Data::Primitive, loaded(load)));
        let table = first.report.table.clone().expect("it has a table");
        assert!((table.load - f64::from(load)).abs() < 1.0, "{} of {load}", table.load);
        for exec in [Exec::Tile, Exec::Threads].into_iter().chain(schedules()) {
            let drawn = draw(&scene, &with("ha64", exec.clone(), Data::Primitive, loaded(load)));
            assert_eq!(drawn.report.table.as_ref(), Some(&table), "{load} {exec:?}");
            assert_eq!(
                *drawn.lists().expect("lists"),
                *triangles.lists().expect("lists"),
                "{load} {exec:?}"
            );
            assert_eq!(drawn.report.dropped, BTreeMap::new());
        }
        for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, load.into())] {
            let drawn = draw(&scene, &with("ha64", exec.clone(), Data::Color, loaded(load)));
            assert_eq!(*drawn.lists().expect("lists"), without_alike(&colors), "{load} {exec:?}");
            let alike = colors.report.generated - drawn.report.kept;
            assert_eq!(drawn.report.dropped.get("duplicate").copied().unwrap_or(0), alike);
            let drawn = draw(&scene, &with("ha64-multiset", exec, Data::Color, loaded(load)));
            assert_eq!(*drawn.lists().expect("lists"), *colors.lists().expect("lists"), "{load}");
        }
    }
}

/// The same on other scenes, half of the runs with colours.
#[test]
fn no_schedule_changes_a_list() {
    let glass = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/glass.toml");
    for name in ["cubes", "gears", "bottles", "hairball:strands=150", "stack:count=30", glass] {
        let scene = scene(name, [full_edge(); 2]);
        let exact = |data| draw(&scene, &with("exact", Exec::Tile, data, TableOptions::default()));
        let words = [Data::Primitive, Data::Color];
        let right = words.map(|data| (data, without_alike(&exact(data))));
        let execs = [Exec::Tile, Exec::Threads, Exec::Tile, Exec::Threads];
        let all = execs.into_iter().chain(schedules()).enumerate();
        let mut tables = BTreeMap::new();
        for (i, exec) in all {
            let (data, lists) = &right[i / 2 % 2];
            let drawn = draw(&scene, &with("ha64", exec.clone(), *data, loaded(80)));
            assert_eq!(*drawn.lists().expect("lists"), *lists, "{name} {exec:?}");
            let table = drawn.report.table.expect("a table").hash;
            assert_eq!(tables.entry(i / 2 % 2).or_insert_with(|| table.clone()), &table);
        }
    }
}

/// Coplanar layers of one colour: what the duplicate rule does, on purpose.
#[test]
fn of_fragments_that_are_alike_one_is_kept_and_the_others_are_counted() {
    let mut scene = scene("synthetic:n=6,tessellation=2", [40, 30]);
    scene.screen.extend_from_within(..24);
    let exact = draw(&scene, &with("exact", Exec::Tile, Data::Color, TableOptions::default()));
    let alike = exact.report.generated - without_alike(&exact).entries.len() as u64;
    assert!(alike > 0, "the scene has some");
    for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, 1), sim(Policy::Warp(8), 1)] {
        let drawn = draw(&scene, &with("ha64", exec.clone(), Data::Color, TableOptions::default()));
        assert_eq!(drawn.report.dropped, BTreeMap::from([("duplicate".to_owned(), alike)]));
        assert_eq!(*drawn.lists().expect("lists"), without_alike(&exact), "{exec:?}");
        assert_eq!(drawn.report.violations, Vec::<String>::new());
        let all = with("ha64-multiset", exec, Data::Color, TableOptions::default());
        assert_eq!(lists(&scene, &all), *exact.lists().expect("lists"));
    }
}

/// Without data, fragments are alike where their depths are.
#[test]
fn depths_alone_are_those_of_the_reference() {
    let scene = crowded();
    let exact = draw(&scene, &with("exact", Exec::Tile, Data::Nothing, TableOptions::default()));
    for load in [50, 90] {
        for exec in [Exec::Tile, Exec::Threads, sim(Policy::Pct(3), 4), sim(Policy::Random, 4)] {
            let drawn = draw(&scene, &with("ha32", exec, Data::Nothing, loaded(load)));
            assert_eq!(*drawn.lists().expect("lists"), without_alike(&exact));
        }
    }
}

/// The reference table for a scene's fragments.
fn book_of(scene: &Scene, settings: &TableSettings) -> Book {
    let exact = with("exact", Exec::Tile, Data::Primitive, TableOptions::default());
    let all = lists(scene, &exact);
    let mut book = Book::new(settings);
    for y in 0..scene.size[1] {
        for x in 0..scene.size[0] {
            all.pixel(x, y).iter().for_each(|&key| book.insert((x, y), rank64(key)));
        }
    }
    book
}

/// What has no room is exactly what the reference drops, under every schedule.
#[test]
fn an_age_limit_and_a_full_table_lose_what_is_named() {
    let scene = scene("synthetic:n=12,tessellation=3,density=24", [48, 48]);
    let full = [48, 48];
    let cases = [
        (TableOptions { ages: 3, ..loaded(80) }, "age"),
        (TableOptions { ages: 15, ..loaded(95) }, "age"),
        (TableOptions { size: Some(full), ..TableOptions::default() }, "full"),
        (TableOptions { size: Some([64, 80]), ages: 9, ..TableOptions::default() }, "age"),
    ];
    for (hash, reason) in cases {
        let first = draw(&scene, &with("ha64", Exec::Tile, Data::Primitive, hash.clone()));
        let table = first.report.table.as_ref().expect("a table");
        let settings = TableSettings {
            size: [table.width, table.height],
            ages: hash.ages,
            ..TableSettings::default()
        };
        let book = book_of(&scene, &settings);
        assert!(!book.dropped.is_empty(), "{hash:?}");
        let named = BTreeMap::from([(reason.to_owned(), book.dropped.len() as u64)]);
        let mut missing: Vec<((u32, u32), u64)> = book.dropped.clone();
        missing.sort_unstable();
        let policies = [Policy::Random, Policy::RoundRobin, Policy::Warp(16), Policy::Reverse];
        let simulated = policies.map(|policy| sim(policy, 3));
        for exec in [Exec::Tile, Exec::Threads].into_iter().chain(simulated) {
            let drawn = draw(&scene, &with("ha64", exec.clone(), Data::Primitive, hash.clone()));
            assert_eq!(drawn.report.dropped, named, "{exec:?}");
            assert_eq!(drawn.report.violations, Vec::<String>::new());
            assert_eq!(drawn.report.table, first.report.table, "{exec:?}");
            assert_eq!(lost(&scene, drawn.lists().expect("lists")), missing, "{exec:?}");
        }
    }
}

/// Which fragments a list lacks.
fn lost(scene: &Scene, found: &Lists) -> Vec<((u32, u32), u64)> {
    let exact = with("exact", Exec::Tile, Data::Primitive, TableOptions::default());
    let all = lists(scene, &exact);
    let mut missing = Vec::new();
    for y in 0..scene.size[1] {
        for x in 0..scene.size[0] {
            let kept = found.pixel(x, y);
            let gone = all.pixel(x, y).iter().filter(|key| !kept.contains(key));
            missing.extend(gone.map(|&key| ((x, y), rank64(key))));
        }
    }
    missing.sort_unstable();
    missing
}

/// Every record is tried once at each age up to its own, by the invocation that carries it.
#[test]
fn probes_are_the_sum_of_ages() {
    let scene = crowded();
    for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, 2)] {
        let report = draw(&scene, &with("ha64", exec, Data::Primitive, loaded(80))).report;
        let table = report.table.expect("a table");
        let sum: u64 = (1..).zip(&table.ages).map(|(age, count)| age * count).sum();
        assert_eq!(report.counters["probes"], sum);
        assert_eq!(table.ages.iter().sum::<u64>(), report.kept);
        assert_eq!(table.ages.len(), table.max_age as usize);
    }
}

/// Monotonicity and Proposition A after every step, a million of them and more; and the check can fail.
#[test]
fn what_must_always_be_true_is() {
    let checked = |policy: Policy, seed| {
        Exec::Sim(Sim { policy, seed, resident: 96, record: false, watch: None, check: true })
    };
    let scene = crowded();
    let (mut steps, hash) = (0, || TableOptions { ages: 31, ..loaded(80) });
    for (seed, policy) in (0..).zip([Policy::Random, Policy::RoundRobin, Policy::Warp(8)]) {
        for method in ["ha64", "ha32", "ha64-cull"] {
            let run = with(method, checked(policy.clone(), seed), Data::Color, hash());
            let report = draw(&scene, &run).report;
            assert_eq!(report.violations, Vec::<String>::new(), "{method}");
            steps += report.checked.expect("it was asked for");
        }
    }
    println!("{steps} steps");
    assert!(steps >= 1_000_000, "{steps}");
    for method in ["ha64@no-depth", "ha64@load-store"] {
        let run = with(method, checked(Policy::Random, 0), Data::Color, hash());
        let report = draw(&scene, &run).report;
        assert!(report.violations[0].contains(" steps: "), "{method}: {:?}", report.violations);
    }
}

/// As listed, resolve never sees the largest age of a block.
#[test]
fn the_published_traversal_loses_the_last_of_every_block() {
    let scene = crowded();
    let hash = || loaded(50);
    let right = draw(&scene, &with("ha64", Exec::Tile, Data::Primitive, hash())).report;
    let drawn = draw(&scene, &with("ha64@published", Exec::Tile, Data::Primitive, hash())).report;
    assert_eq!(drawn.table, right.table, "it is all in the table");
    assert!(drawn.dropped["lost"] >= u64::from((EDGE / 8).pow(2)), "{:?}", drawn.dropped);
}

// ---------------------------------------------------------------------------------------------------------------------
// Early culling.

/// Nothing that can be seen is culled, under any of these schedules; as published, something is under some.
#[test]
fn early_culling_is_conservative_and_as_published_it_is_not() {
    let glass = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/glass.toml");
    let scene = scene(glass, [72, 54]);
    let (mut culled, mut wrong) = (0, 0);
    let schedules = schedules().step_by(4);
    for exec in [Exec::Tile, Exec::Threads].into_iter().chain(schedules) {
        let run =
            |method| draw(&scene, &with(method, exec.clone(), Data::Color, loaded(80))).report;
        let right = run("ha64-cull");
        assert_eq!(right.violations, Vec::<String>::new(), "{exec:?}");
        assert_eq!(right.dropped.get("lost"), None, "{exec:?}");
        culled += right.culled;
        wrong += run("ha64-cull@published").dropped.get("lost").copied().unwrap_or(0);
    }
    println!("{culled} culled; as published, {wrong} that can be seen");
    assert!(culled > 0 && wrong > 0);
}

/// A threshold that nothing reaches culls nothing.
#[test]
fn without_a_threshold_all_is_kept() {
    let scene = scene("layers:count=9,alpha=0.5", [24, 24]);
    let hash = TableOptions { threshold: 1.0, ..TableOptions::default() };
    let drawn = draw(&scene, &with("ha64-cull", Exec::Threads, Data::Color, hash));
    let exact = draw(&scene, &with("exact", Exec::Tile, Data::Color, TableOptions::default()));
    assert_eq!(*drawn.lists().expect("lists"), without_alike(&exact));
    let opaque = TableOptions { threshold: 0.4, ..TableOptions::default() };
    let drawn = draw(&scene, &with("ha64-cull", Exec::Tile, Data::Color, opaque)).report;
    assert_eq!((drawn.kept, drawn.culled), (24 * 24, 8 * 24 * 24), "half of the light is enough");
}

// ---------------------------------------------------------------------------------------------------------------------
// What lists are used for.

/// Effects take lists of any method.
#[test]
fn effects_are_the_same_on_a_hash_table() {
    let file = |name: &str| format!("{}/scenes/{name}", env!("CARGO_MANIFEST_DIR"));
    let (solids, glass, ball) = (file("csg.toml"), file("shadows.toml"), "sphere".to_owned());
    let csg = Expression::parse("(block & ball) - (along | across | through)").expect("right");
    let shadows = Some(Shadows::default());
    let media = Effect::Media { density: 1.0 };
    let ldi = Effect::Ldi { voxels: Some(16) };
    let cases = [
        (&solids, Effect::Csg(csg), Data::Primitive, None, "ha64"),
        (&solids, media, Data::Primitive, None, "ha64"),
        (&ball, ldi, Data::Nothing, None, "ha32"),
        (&glass, Effect::Transparency, Data::Color, shadows, "ha64"),
    ];
    for (name, effect, data, shadows, method) in cases {
        let scene = scene(name, [72, 60]);
        let drawn = |method: &str, exec| {
            let options = with(method, exec, data, TableOptions::default());
            draw(&scene, &Options { effect: effect.clone(), shadows, ..options })
        };
        let right = drawn("ab-ll", Exec::Tile);
        for exec in [Exec::Tile, Exec::Threads, sim(Policy::Random, 5)] {
            let found = drawn(method, exec);
            assert_eq!(found.report.dropped, BTreeMap::new(), "{method} {name}");
            assert_eq!(found.image, right.image, "{method} {name}");
            assert_eq!(found.report.open_pixels, right.report.open_pixels);
            assert_eq!(found.report.solid_voxels, right.report.solid_voxels);
        }
    }
}
