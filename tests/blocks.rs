//! What a scheme stores block by block is what it stores fragment by fragment: the same words, outcomes and indices
//! after every block; or after several primitives' fragments of a block, where they are stored together. `Scheme::store`
//! is the specification, which is what runs where operations are counted. Where an invocation may end with another one's
//! fragment, it is as many of every outcome.

mod support;
#[path = "support/toys/mod.rs"]
mod toys;

use fragloom::exec::Method;
use fragloom::exec::drive::Pipeline;
use fragloom::exec::method::Instance;
use fragloom::exec::table::TableWords;
use fragloom::fragment::Fragment;
use fragloom::memory::arena::{Owned, Shared};
use fragloom::memory::exclusive::Exclusive;
use fragloom::memory::{
    Atomic, Counters, Inputs, Layout, Memory, Observer, Order, OwnedBlock, Pixel, Words,
};
use fragloom::num::depth::{FARTHEST, Format};
use fragloom::num::random::Random;
use fragloom::raster::{Batch, Grid};
use fragloom::render::{Options, Report};
use fragloom::scene::Scene;
use fragloom::scheme::contract::{Accounting, Contract, Keeps};
use fragloom::scheme::hash_table::table::TableSettings;
use fragloom::scheme::program::{PassKind, Program};
use fragloom::scheme::{Config, Keys, Outcome, Outcomes, Scheme};
use support::{draw, scene, small_scenes};

/// Blocks of a tile.
const BLOCKS: u32 = 4;
const PIXELS: u32 = 64 * BLOCKS;

/// Blocks that are stored.
const BATCHES: usize = 24;

/// The tile's first pixel: tiles do not begin at 0.
const FIRST: u32 = 3 * PIXELS;

/// The first index of the worker's range of a pool.
const RANGE: u32 = 1_000;

/// What is seen after a block, or after several batches of it.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    /// Of each batch.
    outcomes: Vec<Outcomes>,
    /// All words, the pixels' own and the frame's.
    words: [(Vec<u32>, Vec<u64>); 2],
    /// The cells of a hash table, if there is one.
    table: Option<TableWords>,
}

const OUTCOMES: [Outcome; 8] = [
    Outcome::Kept,
    Outcome::Culled,
    Outcome::Evicted,
    Outcome::Overflow,
    Outcome::Pool,
    Outcome::Duplicate,
    Outcome::Age,
    Outcome::Merged,
];

impl Seen {
    /// Whether the same fragments are kept, and as many have every outcome. If none was ever dropped for its age, all
    /// words are the same; else largest ages may be others, and alike fragments may be dropped for either reason.
    fn crosses(&self, other: &Self, dropped: bool) -> bool {
        let counts = |seen: &Self| OUTCOMES.map(|outcome| seen.count(outcome));
        if dropped {
            return self.table == other.table && self.gone() == other.gone();
        }
        self.words == other.words && counts(self) == counts(other)
    }

    fn count(&self, outcome: Outcome) -> u64 {
        self.outcomes.iter().map(|all| all.count(outcome)).sum()
    }

    /// How many fragments were not kept.
    fn gone(&self) -> u32 {
        self.outcomes.iter().map(|all| all.gone().count_ones()).sum()
    }
}

/// Blocks of all kinds: whole, nearly whole, sparse, single fragments, none; few depths and data words, so that many are
/// equal, and the smallest and the largest of them.
fn batches(seed: u64, format: Format) -> Vec<Batch> {
    let far = [1 << 31, FARTHEST].map(|code| format.encode(code));
    let mut random = Random::new(seed, 0);
    let mut batch = || {
        let mask = match random.below(6) {
            0 | 1 => u64::MAX,
            2 => !(1 << random.below(64)),
            3 => random.below(u64::MAX) & random.below(u64::MAX),
            4 => 1 << random.below(64),
            _ => random.below(u64::MAX),
        };
        let first = FIRST + 64 * random.below(BLOCKS.into()) as u32;
        let fragment = |bit: u32| Fragment {
            pixel: first + bit,
            depth: [0, 1, 7, 8, far[0], far[1]][random.below(6) as usize],
            data: [0, 5, u32::MAX][random.below(3) as usize],
            extra: 0,
        };
        let fragments: Vec<_> = (0..64).filter(|bit| mask >> bit & 1 == 1).map(fragment).collect();
        if fragments.is_empty() { Batch::default() } else { Batch::of_block(&fragments) }
    };
    (0..BATCHES).map(|_| batch()).filter(|batch| !batch.is_empty()).collect()
}

/// How blocks are stored.
#[derive(Clone, Copy)]
struct Case {
    /// Fragments that the method is told of.
    generated: u64,
    /// Indices that the worker has ahead.
    ahead: Option<u32>,
    /// Blocks that earlier geometry passes see, too.
    prepared: usize,
}

/// All that is seen if blocks are stored one after another, and those of a group together where the scheme does so.
fn run<O: Observer + Default>(
    scheme: &dyn for<'a> Pipeline<Exclusive<'a, O>>,
    (program, layout): (&Program, &Layout),
    groups: &[Vec<Batch>],
    Case { ahead, prepared, .. }: Case,
) -> Vec<Seen> {
    let own = Owned::new(layout.per_pixel(), PIXELS as usize);
    let shared = Shared::new(layout.per_frame(), 1);
    own.fill(0x5A5A_5A5A_5A5A_5A5A);
    let (inputs, observer) = (Inputs::defaults(layout), O::default());
    let indices = ahead.map_or_else(Vec::new, |_| layout.ahead());
    indices.iter().for_each(|pool| pool.set(RANGE, ahead.unwrap_or(0)));
    let mem = Exclusive::new(&own, &shared, &inputs, &observer).from(FIRST).taking(&indices);
    scheme.clear_frame(&mem);
    scheme.clear(&mem, FIRST..FIRST + PIXELS);
    for (pass, number) in program.passes.iter().zip(0..) {
        match pass.kind {
            PassKind::Prepare => {
                let seen = groups.iter().flatten().take(prepared);
                seen.for_each(|batch| scheme.prepare(&mem, number, batch));
            }
            PassKind::Screen => scheme.screen(&mem, number, FIRST..FIRST + PIXELS),
            PassKind::Frame => scheme.frame(&mem, number, 0..scheme.invocations(number)),
            PassKind::Store => {}
        }
    }
    let store = |group: &Vec<Batch>| {
        let mut outcomes = vec![Outcomes::default(); group.len()];
        if scheme.together(&mem, group[0].first()) >= group.len() {
            scheme.store_together(&mem, group, &mut outcomes);
        } else {
            let single = group.iter().zip(&mut outcomes);
            single.for_each(|(batch, outcomes)| scheme.store(&mem, batch, outcomes));
        }
        let table = scheme.readback().map(|readback| TableWords::new(&readback, &shared));
        Seen { outcomes, words: [own.all(), shared.all()], table }
    };
    groups.iter().map(store).collect()
}

/// Batches in groups of one; and in groups of so many, block by block, as a tile has them.
fn groups(batches: &[Batch], most: usize) -> Vec<Vec<Batch>> {
    let mut batches = batches.to_vec();
    if most > 1 {
        batches.sort_by_key(Batch::first);
    }
    let blocks = batches.chunk_by(|a, b| most > 1 && a.first() == b.first());
    blocks.flat_map(|block| block.chunks(most)).map(<[Batch]>::to_vec).collect()
}

/// The sizes of groups, and the number of the first of them after which the two ways differ.
fn differ(of: (&Contract, &dyn Instance), batches: &[Batch], case: Case) -> Option<(usize, usize)> {
    let sizes = if together(of.1) > 0 { &[1, 3, BATCHES][..] } else { &[1] };
    sizes.iter().find_map(|&size| Some((size, differ_in(of, &groups(batches, size), case)?)))
}

/// Of how many primitives a block's fragments are stored together.
fn together(instance: &dyn Instance) -> usize {
    let layout = instance.layout();
    let own = Owned::new(layout.per_pixel(), PIXELS as usize);
    let shared = Shared::new(layout.per_frame(), 1);
    let inputs = Inputs::defaults(layout);
    let mem = Exclusive::new(&own, &shared, &inputs, &()).from(FIRST);
    instance.compiled().map_or(0, |compiled| compiled.exclusive().together(&mem, FIRST))
}

fn differ_in(
    (contract, instance): (&Contract, &dyn Instance),
    groups: &[Vec<Batch>],
    case: Case,
) -> Option<usize> {
    let compiled = instance.compiled()?;
    let of = (&contract.program, instance.layout());
    let blocks = run::<()>(compiled.exclusive(), of, groups, case);
    let single = run::<Counters>(compiled.exclusive_counted(), of, groups, case);
    // An outcome is that of a fragment.
    let none = |(group, seen): (&Vec<Batch>, &Seen)| {
        group.iter().zip(&seen.outcomes).any(|(batch, all)| all.gone() & !batch.mask() != 0)
    };
    if let Some(number) = groups.iter().zip(&blocks).position(none) {
        return Some(number);
    }
    if contract.accounting != Accounting::Crossing {
        return blocks.iter().zip(&single).position(|(a, b)| a != b);
    }
    let mut dropped = false;
    blocks.iter().zip(&single).position(|(a, b)| {
        dropped |= [a, b].iter().any(|seen| seen.count(Outcome::Age) > 0);
        !a.crosses(b, dropped)
    })
}

/// For a seed: of small k, and of tables of several sizes, with room for all ages and for few.
fn config(seed: u64, generated: u64) -> Config {
    let size = [[64, 64], [37, 64], [32, 90]][seed as usize % 3];
    let ages = if seed % 2 == 1 { 6 } else { 255 };
    Config {
        k: Some(1 + seed as u32 % 3),
        pixels: FIRST + PIXELS,
        generated,
        max_depth_complexity: 24,
        bounded: generated,
        pages: 64,
        records: generated,
        grid: Grid { width: 32, height: 32, tile: 16 },
        table: TableSettings { size, ages, ..TableSettings::default() },
        ..Config::default()
    }
}

const fn case(generated: u64, ahead: Option<u32>, prepared: usize) -> Case {
    Case { generated, ahead, prepared }
}

/// Room for all, with indices ahead for all, for some of the blocks, and for none; a pool that is too small; fragments
/// that earlier passes did not see; and so many at a pixel that lists are long.
const CASES: [Case; 9] = [
    case(4_000, Some(2_000), BATCHES),
    case(4_000, Some(150), BATCHES),
    case(4_000, Some(0), BATCHES),
    case(4_000, None, BATCHES),
    case(1_100, Some(2_000), BATCHES),
    case(70, None, BATCHES),
    case(4_000, Some(2_000), 9),
    case(20_000, Some(2_000), BATCHES),
    case(20_000, Some(150), BATCHES),
];

fn first_difference(method: Method) -> Option<String> {
    let contract = method.contract();
    for (number, case) in CASES.into_iter().enumerate() {
        // Its buckets are of the depths that were seen.
        if case.prepared < BATCHES && method.name() == "depth-peel-bucket" {
            continue;
        }
        for seed in 0..6 {
            let instance = method.instance(&config(seed, case.generated))?;
            let batches = batches(seed, contract.depth_format.unwrap_or_default());
            let found = differ((contract, &*instance), &batches, case);
            if let Some((size, group)) = found {
                return Some(format!("{method}: case {number}, seed {seed}, {group} of {size}"));
            }
        }
    }
    None
}

#[test]
fn blocks_are_stored_as_their_fragments_are() {
    let catalogue = toys::catalogue();
    // Those with an interlock wait for an earlier fragment of their pixel, as ranks tell.
    let alone = |method: &&Method| !method.contract().is_interlocked();
    let methods: Vec<_> = catalogue.methods().iter().filter(alone).collect();
    let differences: Vec<_> = methods.iter().filter_map(|&&m| first_difference(m)).collect();
    assert!(differences.is_empty(), "{differences:#?}");
    println!("{} methods, {} runs each", methods.len(), 6 * CASES.len());
    assert!(methods.len() > 40);
}

/// `dfb` resolves the 1,024 that came first.
#[test]
fn blocks_with_more_fragments_than_a_local_array_has_room_for() {
    let method = support::method("dfb");
    let fragment = |depth: u32| Fragment { pixel: FIRST + 70, depth, data: 7, extra: 0 };
    let batches: Vec<_> =
        (0..1_030).map(|i| Batch::of_block(&[fragment(i * 77 % 1_030)])).collect();
    let case = case(2_000, None, batches.len());
    let instance = method.instance(&config(0, case.generated)).expect("it has words");
    let contract = method.contract();
    assert_eq!(differ((contract, &*instance), &batches, case), None);
    let compiled = instance.compiled().expect("for executors");
    let of = (&contract.program, instance.layout());
    let seen = run::<()>(compiled.exclusive(), of, &groups(&batches, 1), case);
    let gone = seen.iter().filter(|seen| seen.count(Outcome::Overflow) == 1);
    assert_eq!(gone.count(), 6);
}

/// The same of whole frames, with all that a tile does besides when nothing is counted; also with pools that are too
/// small.
#[test]
fn frames_are_the_same_if_nothing_is_counted() {
    let same = |scene: &Scene, options: &Options| {
        let [counted, other] = [true, false]
            .map(|counters| draw(scene, &Options { counters, threads: 1, ..options.clone() }));
        let what = format!("{} {} {:?}", options.method, scene.name, options.memory_budget);
        assert_eq!(counted.image, other.image, "{what}");
        let without = |report: Report| Report {
            counters: Default::default(),
            seconds: Default::default(),
            ..report
        };
        assert_eq!(without(counted.report), without(other.report.clone()), "{what}");
        other.report.dropped.values().sum::<u64>()
    };
    let mut frames = 0;
    for method in toys::catalogue().promised() {
        let k = method.contract().default_k.map(|_| 3);
        // The last one has long lists, with room for two thirds of its fragments, too.
        let scenes = small_scenes().into_iter().chain([scene("layers:count=20", [64, 64])]);
        for scene in scenes {
            let options = Options { method, k, ..Options::default() };
            let _ = same(&scene, &options);
            frames += 1;
            // A pool without room for a third of the fragments, or more.
            if matches!(method.name(), "ab-ll" | "kb-ab-ll" | "ab-ll-double") {
                // A node takes 12 bytes or more, and a tile's heads 4 by pixel.
                let generated = draw(&scene, &options).report.generated;
                let memory_budget = Some(4 * 64 * 64 + 64 + 8 * generated);
                let k = if method.contract().budget_chooses_k() { None } else { k };
                let dropped = same(&scene, &Options { memory_budget, k, ..options });
                assert!(dropped > 0, "{method} {}: the pool is too small", scene.name);
                frames += 1;
            }
        }
    }
    println!("{frames} frames, each drawn twice");
    assert!(frames > 200);
}

/// A Z-buffer whose block form has a fault.
struct Faulty<const FAULT: u32> {
    nearest: Words<Pixel, Atomic, u64>,
}

const FAULTS: [&str; 11] = [
    "none",
    "the last bit is left out",
    "bits that are not set are stored, too",
    "of equal fragments, the later one is not culled",
    "what is evicted counts as kept",
    "it stores, and says that it did not: outcomes are those of the second time",
    "what is culled counts as evicted, too",
    "of batches stored together, the last is left out",
    "of batches stored together, the later ones go first",
    "of batches stored together, all outcomes are the first one's",
    "of batches stored together, the second is stored as the first says",
];

impl<const FAULT: u32> Scheme for Faulty<FAULT> {
    const CONTRACT: Contract = Contract::new("faulty", Keeps::One);

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { nearest: layout.pixel(1) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.nearest.at(pixel, 0), u64::MAX, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let own = fragment.key();
        let old = mem.min(self.nearest.at(fragment.pixel, 0), own, Order::Relaxed).await;
        match (own >= old, old) {
            (true, _) => Outcome::Culled,
            (false, u64::MAX) => Outcome::Kept,
            (false, _) => Outcome::Evicted,
        }
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        let Some(nearest) = block.pixels(self.nearest) else { return false };
        let [mut culled, mut evicted] = [0_u64; 2];
        let mask = match FAULT {
            1 => batch.mask() & u64::MAX >> 1,
            2 => u64::MAX,
            _ => batch.mask(),
        };
        for bit in (0..64).filter(|bit| mask >> bit & 1 == 1) {
            let (key, old) = (batch.get(bit).key(), nearest[bit as usize].get());
            nearest[bit as usize].set(key.min(old));
            if key > old || key == old && FAULT != 3 {
                culled |= 1 << bit;
            } else if old != u64::MAX && FAULT != 4 {
                evicted |= 1 << bit;
            }
        }
        let evicted = if FAULT == 6 { culled | evicted } else { evicted };
        outcomes.assign([(culled, Outcome::Culled), (evicted, Outcome::Evicted)]);
        FAULT != 5
    }

    fn together(&self) -> usize {
        if FAULT < 7 { 0 } else { 4 }
    }

    fn store_together(
        &self,
        block: &OwnedBlock<'_>,
        batches: &[Batch],
        outcomes: &mut [Outcomes],
    ) -> bool {
        let mut all: Vec<_> = batches.iter().zip(outcomes).collect();
        match FAULT {
            7 => drop(all.pop()),
            8 => all.reverse(),
            _ => {}
        }
        let mut first = Outcomes::default();
        for (i, (batch, outcomes)) in all.into_iter().enumerate() {
            let again = if FAULT == 10 && i == 1 { &batches[0] } else { batch };
            self.store_block(block, again, outcomes);
            if FAULT == 9 && i > 0 {
                *outcomes = first.clone();
            }
            first = if i == 0 { outcomes.clone() } else { first };
        }
        true
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        keys.push(mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await);
    }
}

#[test]
fn faults_of_block_forms_are_found() {
    let found = [
        first_difference(Method::of::<Faulty<0>>()),
        first_difference(Method::of::<Faulty<1>>()),
        first_difference(Method::of::<Faulty<2>>()),
        first_difference(Method::of::<Faulty<3>>()),
        first_difference(Method::of::<Faulty<4>>()),
        first_difference(Method::of::<Faulty<5>>()),
        first_difference(Method::of::<Faulty<6>>()),
        first_difference(Method::of::<Faulty<7>>()),
        first_difference(Method::of::<Faulty<8>>()),
        first_difference(Method::of::<Faulty<9>>()),
        first_difference(Method::of::<Faulty<10>>()),
    ];
    for (found, fault) in found.iter().zip(FAULTS) {
        assert_eq!(found.is_none(), fault == "none", "{fault}: {found:?}");
    }
}
