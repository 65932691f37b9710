//! Race litmus pixels on a device: many copies at once, many times, in orders that bring a pixel's fragments close
//! together or far apart, or under [`pressure`](super::pressure). The outcomes are counted against every outcome that the explorer finds, and others explained
//! one by one ([`outcomes`]).

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::crosscheck::{Status, holding};
use super::outcomes::{self, Class, Outcome, Possible};
use super::pressure::Pressure;
use crate::exec::clock::Stopwatch;
use crate::explore::Subject;
use crate::explore::program::litmus::Litmus;
use crate::fragment::{Data, Fragment, depth_of};
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::twin::bounds::Bounds;
use crate::gpu::twin::light::Simulator;
use crate::gpu::twin::merged;
use crate::gpu::twin::program::Program;
use crate::gpu::twin::resolve::draw;
use crate::gpu::twin::shape::{Shape, constants};
use crate::gpu::twin::source::Twin;
use crate::num::depth::Format;
use crate::num::planes::Distances;
use crate::num::random::Random;
use crate::num::rate;
use crate::raster::{Grid, Record};
use crate::scheme::contract::{Contract, Extra};
use crate::scheme::hash_table::table::{DEFAULT_LOAD, TableSettings, size_for_load};
use crate::scheme::{Config, Depth, Held, HeldKind};

/// Copies of a litmus pixel in one picture.
const COPIES: u32 = 4_096;

/// How a picture of copies is arranged in memory.
const GRID: Grid = Grid { width: 64, height: 64, tile: 16 };

/// Room for what a pixel emits, for each of its fragments: a race may emit some several times.
const ROOM: u32 = 4;

/// What time is spent on: copies that run, and all else.
const RUNS: &str = "runs";
const BESIDES: &str = "besides";

/// How much to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Fragments of a pixel, from 2 up to this.
    pub fragments: u32,
    /// How often each instance is run, in each of three orders.
    pub repeats: u64,
    /// About how many instances are run at most, evenly chosen.
    pub instances: usize,
    /// Instead of three fixed orders, three with these settings.
    pub pressure: Option<Pressure>,
}

impl Default for Extent {
    fn default() -> Self {
        Self { fragments: 3, repeats: 4, instances: usize::MAX, pressure: None }
    }
}

/// The results of a method's litmus pixels on a device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stressed {
    /// The adapter.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// The method.
    pub method: String,
    /// Litmus pixels.
    pub instances: u64,
    /// Litmus pixels that have too many states to be explored, and were not run.
    pub unexplored: u64,
    /// Copies run, in total.
    pub runs: u64,
    /// Outcomes that the explorer finds, over all instances.
    pub possible: u64,
    /// Those of them that were observed.
    pub seen: u64,
    /// Runs after which the pixel did not hold what it must, of a method that keeps a list that arrival does not decide.
    pub wrong: u64,
    /// Runs whose outcome an interleaving gives.
    pub sequential: u64,
    /// Runs whose outcome is that of no interleaving, but which relaxed memory allows.
    pub relaxed: u64,
    /// Runs whose outcome no explored execution explains.
    pub outside: u64,
    /// Copies run in a second, compiling and exploring left out. Reported only.
    pub runs_per_second: f64,
    /// An upper bound, at 95 %, of the rate of runs of these last two kinds: not seen is not never.
    pub rate_at_most: f64,
    /// The outcomes of these last two kinds, one by one.
    pub outcomes: Vec<Outcome>,
    /// Equal if all runs had the outcome of an interleaving.
    pub status: Status,
    /// The reason, or what equality does not prove.
    pub reason: String,
}

/// Run a twin's litmus pixels.
///
/// # Errors
/// The device is lost. The result says what it cannot do.
pub fn stress(device: &Device, twin: Twin, extent: Extent) -> Result<Stressed> {
    let subject = Subject::new(twin.method)?;
    let contract = subject.contract;
    let mut sum = Stressed {
        adapter: device.name.name.clone(),
        driver: device.name.driver.clone(),
        method: twin.name(),
        instances: 0,
        unexplored: 0,
        runs: 0,
        possible: 0,
        seen: 0,
        wrong: 0,
        sequential: 0,
        relaxed: 0,
        outside: 0,
        runs_per_second: 0.0,
        rate_at_most: 1.0,
        outcomes: Vec::new(),
        status: Status::Equal,
        reason: String::new(),
    };
    let (mut known, mut program) = (BTreeSet::new(), None);
    let mut watch = Stopwatch::start();
    let all = outcomes::copied(&subject, extent.fragments);
    let step = all.len().div_ceil(extent.instances.max(1)).max(1);
    for litmus in all.into_iter().step_by(step) {
        if contract.crosses() && known.contains(&litmus.fragments) {
            continue;
        }
        let Some(mut possible) = Possible::new(&subject, &litmus) else {
            sum.unexplored += 1;
            continue;
        };
        let mut tally: BTreeMap<Held, u64> =
            possible.interleavings().map(|held| (held.clone(), 0)).collect();
        if contract.crosses() {
            // Copies share one table in which all find room, so they must all find room in the explored table too.
            let mut all = litmus.generated(0);
            contract.keep(&mut all, None);
            if !tally.keys().eq([&Held::Keys(all)]) {
                continue;
            }
            known.insert(litmus.fragments.clone());
        }
        sum.possible += tally.len() as u64;
        let ran = program_for(&mut program, device, twin, copied(contract, &litmus)).and_then(
            |program| {
                watch.lap(BESIDES);
                run(program, &litmus, extent, &mut tally)
            },
        );
        watch.lap(RUNS);
        match ran {
            Ok(others) => {
                let mut right = litmus.generated(0);
                contract.keep(&mut right, litmus.k);
                let right = tally.get(&Held::Keys(right)).copied();
                let all = 3 * extent.repeats * u64::from(COPIES);
                let right = right.filter(|_| !contract.is_arrival_dependent());
                sum.wrong += right.map_or(0, |right| all - right);
                for ((held, beyond), runs) in others {
                    sum.outcomes.push(possible.explain(&held, beyond, runs)?);
                }
            }
            Err(Failure::Unsupported(why)) => {
                sum.status = Status::Unsupported;
                sum.reason = why;
                return Ok(sum);
            }
            Err(failure) => return Err(failure),
        }
        sum.instances += 1;
        sum.runs += 3 * extent.repeats * u64::from(COPIES);
        sum.seen += tally.values().filter(|&&count| count > 0).count() as u64;
        sum.sequential += tally.values().sum::<u64>();
    }
    sum.relaxed = sum.of(Class::Relaxed).map(|outcome| outcome.runs).sum();
    sum.outside = sum.of(Class::Outside).map(|outcome| outcome.runs).sum();
    sum.rate_at_most = rate::at_most(sum.relaxed + sum.outside, sum.runs);
    let seconds = watch.seconds().get(RUNS).copied().unwrap_or_default();
    sum.runs_per_second = if seconds > 0.0 { sum.runs as f64 / seconds } else { 0.0 };
    let first = sum.of(Class::Outside).next().cloned();
    if let Some(first) = first {
        let more = if first.complete { "" } else { " (relaxed memory: not all explored)" };
        let first = format!("{}: {}{more}", first.litmus, first.outcome);
        let runs = sum.outside;
        sum.reason = format!("{runs} runs that no explored execution explains, first {first}");
        sum.status = Status::Different;
    } else if sum.relaxed > 0 {
        sum.status = Status::Different;
        sum.reason = format!("{} runs show that memory is relaxed", sum.relaxed);
    } else {
        let seen = sum.seen < sum.possible;
        let reasons = [
            (!twin.not_guaranteed().is_empty(), twin.not_guaranteed()),
            (seen, "not every outcome was observed: a device may schedule as it likes"),
            (sum.unexplored > 0, "some litmus pixels have too many states to be explored"),
        ];
        sum.reason = holding(&reasons);
    }
    Ok(sum)
}

impl Stressed {
    /// The outcomes of a class.
    fn of(&self, class: Class) -> impl Iterator<Item = &Outcome> {
        self.outcomes.iter().filter(move |outcome| outcome.class == class)
    }
}

/// The configuration of a picture of copies.
fn copied(contract: &Contract, litmus: &Litmus) -> Config {
    let one = litmus.config(contract);
    let copies = u64::from(COPIES);
    Config {
        pixels: COPIES,
        generated: one.generated * copies,
        bounded: one.bounded * copies,
        pages: one.pages * copies,
        records: one.records * copies,
        grid: GRID,
        table: TableSettings {
            size: size_for_load(one.generated * copies, DEFAULT_LOAD, [GRID.width, GRID.height]),
            ..TableSettings::default()
        },
        ..one
    }
}

/// The program of a configuration: the last one, if it is the same.
fn program_for<'a, 'd>(
    last: &'a mut Option<Program<'d>>,
    device: &'d Device,
    twin: Twin,
    config: Config,
) -> Result<&'a Program<'d>> {
    let known = last.take().filter(|program| program.shape.config == config);
    let program = match known {
        Some(program) => program,
        None => {
            let shape = Shape::new(twin.method, config)?;
            let record = Record { depth: Format::D32, data: Data::Color };
            let constants = constants(&shape, record, [0; 3]);
            Program::new(device, twin, shape, constants)?
        }
    };
    Ok(last.insert(program))
}

/// Run an instance, and give the outcomes that are not in the tally, with the words beyond its room that a pixel
/// emitted.
fn run(
    program: &Program<'_>,
    litmus: &Litmus,
    extent: Extent,
    tally: &mut BTreeMap<Held, u64>,
) -> Result<BTreeMap<(Held, u32), u64>> {
    let (method, contract) = (program.twin.method, program.shape.contract);
    let distances = program.shape.config.distances;
    let n = litmus.fragments.len() as u32;
    let config = program.shape.config;
    let colors = Simulator::new(method, &config)
        .map(|simulator| Colors::new(simulator, contract, litmus, Bounds::of(method, &config)));
    let room = match (method.holds(), &colors) {
        (_, Some(colors)) => colors.simulator.room() as u32,
        (HeldKind::Records, _) => ROOM * n * merged::WORDS,
        _ => ROOM * n,
    };
    let starts: Vec<u32> = (0..=COPIES).map(|pixel| pixel * room).collect();
    if let Some(pressure) = &extent.pressure {
        program.press(pressure.beside(program.device)?, pressure.burst);
    }
    let mut others = BTreeMap::new();
    let mut fill = true;
    for repeat in 0..extent.repeats {
        for (number, order) in (0..).zip(Arrangement::ALL) {
            let fragments = match &extent.pressure {
                Some(pressure) => {
                    let own: Vec<Fragment> = litmus.fragments(contract).collect();
                    pressure.arrange(&own, COPIES, 3 * repeat + number)
                }
                None => order.arrange(contract, litmus, repeat),
            };
            // The explorer tries both wherever a word is read that was never written.
            program.fill(if fill { 0 } else { u8::MAX });
            fill = !fill;
            let geometry = |function: &str| program.compute(function, &fragments);
            let got = draw(program, &[0; 256], &starts, geometry)?;
            for pixel in 0..COPIES as usize {
                let found = match &colors {
                    Some(colors) => colors.held(pixel as u32, got.pixel(pixel), tally),
                    None => held(method.holds(), got.pixel(pixel), &distances),
                };
                let beyond = got.counts[pixel].saturating_sub(room);
                match tally.get_mut(&found).filter(|_| beyond == 0) {
                    Some(count) => *count += 1,
                    None => *others.entry((found, beyond)).or_default() += 1,
                }
            }
        }
    }
    Ok(others)
}

/// What the pixels of a method that approximates hold.
struct Colors {
    simulator: Simulator,
    bounds: Bounds,
    /// The fragments of a pixel in canonical order, where what it holds depends on where on the screen it is.
    placed: Option<Vec<Fragment>>,
}

impl Colors {
    fn new(simulator: Simulator, contract: &Contract, litmus: &Litmus, bounds: Bounds) -> Self {
        let placed = contract.extra == Extra::Primitive;
        Self { simulator, bounds, placed: placed.then(|| litmus.sorted(contract, 0)) }
    }

    /// What these words of a pixel are: of the explored outcomes, the one that they are near enough to. Where the place
    /// on the screen matters, outcomes are those of another place; then it is the only one, if the pixel holds what it
    /// must in its own.
    fn held(&self, pixel: u32, words: &[u64], explored: &BTreeMap<Held, u64>) -> Held {
        let light = self.simulator.light(pixel, words);
        let found = Held::Light(light);
        let is_near = |known: &Held| match known {
            Held::Light(known) => self.bounds.is_near(known, &light),
            _ => false,
        };
        let known = match &self.placed {
            Some(fragments) => {
                let right = self.simulator.expected(pixel, fragments).as_ref() == Some(&found);
                explored.keys().next().filter(|_| right && explored.len() == 1)
            }
            None => explored.keys().find(|known| is_near(known)),
        };
        known.cloned().unwrap_or(found)
    }
}

/// What a device emits for a pixel. A depth is a record without data, or none.
fn held(kind: HeldKind, words: &[u64], distances: &Distances) -> Held {
    match (kind, merged::merged(words)) {
        (HeldKind::Records, Some(all)) => Held::Records(merged::held(&all, distances)),
        (HeldKind::Depth, _) => {
            let depth = words.first().copied().map(depth_of).map(Depth);
            Held::Depth(depth.unwrap_or_default())
        }
        _ => Held::Keys(words.to_vec()),
    }
}

/// The positions of a pixel's fragments among all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Arrangement {
    /// In neighbouring lanes.
    Together,
    /// In different workgroups.
    Apart,
    /// Anywhere.
    Shuffled,
}

impl Arrangement {
    const ALL: [Self; 3] = [Self::Together, Self::Apart, Self::Shuffled];

    fn arrange(self, contract: &Contract, litmus: &Litmus, seed: u64) -> Vec<Fragment> {
        let own: Vec<Fragment> = litmus.fragments(contract).collect();
        let on = |pixel: u32| move |f: &Fragment| Fragment { pixel, ..*f };
        let mut all: Vec<Fragment> = match self {
            Self::Apart => {
                own.iter().flat_map(|f| (0..COPIES).map(move |pixel| on(pixel)(f))).collect()
            }
            _ => (0..COPIES).flat_map(|pixel| own.iter().map(on(pixel))).collect(),
        };
        let mut random = Random::new(seed, 0);
        match self {
            // Also in orders other than that of the litmus pixel.
            Self::Together => all.chunks_mut(own.len()).for_each(|own| random.shuffle(own)),
            Self::Apart => random.shuffle(&mut all[..COPIES as usize]),
            Self::Shuffled => random.shuffle(&mut all),
        }
        all
    }
}
