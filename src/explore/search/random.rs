//! Beyond the bound: random runs of random instances, many fragments deep, with any k. They verify nothing; they may
//! find what a small instance does not have: a fourth slot, a third level of a heap, a second page.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::constants::constants;
use super::explored::Limits;
use super::live::{self, Live};
use super::property::Property;
use crate::explore::program::guard::guarded;
use crate::explore::program::litmus::{Entry, Litmus};
use crate::explore::program::subject::Subject;
use crate::fragment::Data;
use crate::memory::asked::Action;
use crate::memory::{Declared, Per};
use crate::num::depth::{FARTHEST, Format};
use crate::num::random::Random;
use crate::scheme::contract::{Extra, Keeps};
use crate::scheme::hash_table::table::{Offsets, TableSettings, size_for_load};

/// The most fragments of an instance.
pub const MOST_FRAGMENTS: u32 = 200;

/// The largest k.
pub const MOST_K: u32 = 64;

/// The most pixels.
pub const MOST_PIXELS: u32 = 4;

/// The most fragments of a method that passes over them again and again.
const MOST_REPEATED: u64 = 40;

/// The most runs that look for a smaller failure.
const MOST_TRIALS: u32 = 4_000;

/// Runs after which it is asked whether more are worth it.
const BATCH: usize = 50;

/// One depth, and one data word, of so many is a constant of the source.
const DICTIONARY: u64 = 8;

/// Seeds that a smaller instance is tried with.
const TRIALS: u64 = 12;

/// Streams of the random numbers.
const STREAM: u64 = 0xD3A4;

/// Places in the source of operations: file, line, column; and what they do.
pub(in crate::explore) type Sites = BTreeMap<(&'static str, u32, u32), Action>;

/// What random runs have found.
pub(in crate::explore) struct Sampled {
    /// How many were asked for.
    pub(in crate::explore) runs: u64,
    /// How many came to their end.
    pub(in crate::explore) ended: u64,
    /// Where they made operations.
    pub(in crate::explore) sites: Sites,
    /// The first failing run, cut down.
    pub(in crate::explore) failure: Option<Failing>,
}

/// A run that fails.
pub(in crate::explore) struct Failing {
    pub(in crate::explore) litmus: Litmus,
    pub(in crate::explore) property: Property,
    pub(in crate::explore) message: String,
    pub(in crate::explore) live: Live,
    /// Failing runs, of all.
    pub(in crate::explore) count: u64,
}

/// Run random instances, with consecutive seeds.
pub(in crate::explore) fn sample(
    subject: &Subject,
    first: u64,
    runs: u64,
    limits: &Limits<'_>,
) -> Sampled {
    let inputs = guarded(|| {
        subject.case(&Litmus::of_one(subject.contract)).instance.layout().inputs().to_vec()
    });
    let inputs = inputs.unwrap_or_default();
    let constants = constants(&source(subject));
    let one = |i: u64| {
        let seed = first.wrapping_add(i);
        let litmus = draw(subject, &inputs, &constants, seed);
        let cancelled = (limits.cancelled)();
        (!cancelled).then(|| (seed, run(subject, &litmus, seed), litmus))
    };
    let mut all = Vec::new();
    for batch in (0..runs).step_by(BATCH) {
        let batch = batch..(batch + BATCH as u64).min(runs);
        let drawn: Vec<_> = batch.into_par_iter().filter_map(one).collect();
        let ended = drawn.iter().filter(|(_, live, _)| live.has_ended).count();
        let most_hang =
            2 * ended < drawn.len() && drawn.iter().all(|(_, live, _)| live.wrong.is_empty());
        all.extend(drawn);
        if most_hang {
            break;
        }
    }
    let mut sites = Sites::new();
    for (_, live, _) in &all {
        let found = live.sites.iter();
        sites.extend(found.map(|(s, action)| ((s.file(), s.line(), s.column()), *action)));
    }
    let count = all.iter().filter(|(_, live, _)| !live.wrong.is_empty()).count() as u64;
    let ended = all.iter().filter(|(_, live, _)| live.has_ended).count() as u64;
    // The smallest failing run is the best to begin with.
    let failed = all.into_iter().filter(|(_, live, _)| !live.wrong.is_empty());
    let failed = failed.min_by_key(|(_, _, litmus)| litmus.fragments.len());
    let failure = failed.map(|(seed, live, litmus)| {
        let (property, message) = live.wrong[0].clone();
        let failing = Failing { litmus, property, message, live, count };
        failing.shrink(subject, seed, limits)
    });
    Sampled { runs, ended, sites, failure }
}

/// The text that a method was compiled from: what its contract names, or the files that the compiler found it in, if
/// they are there. It serves for [`constants`] only.
fn source(subject: &Subject) -> String {
    let named = subject.contract.source;
    if !named.is_empty() {
        return named.to_owned();
    }
    let live = run(subject, &Litmus::of_one(subject.contract), 0);
    let mut files: Vec<&str> = live.sites.iter().map(|(site, _)| site.file()).collect();
    files.sort_unstable();
    files.dedup();
    let texts = files.into_iter().filter_map(|file| std::fs::read_to_string(file).ok());
    texts.collect::<Vec<String>>().concat()
}

/// One run; a panic outside of invocations is a violation.
fn run(subject: &Subject, litmus: &Litmus, seed: u64) -> Live {
    guarded(|| live::run(&subject.case(litmus), seed)).unwrap_or_else(|told| Live {
        moves: Vec::new(),
        wrong: vec![(Property::Panics, told)],
        sites: Vec::new(),
        has_ended: false,
    })
}

impl Failing {
    /// Leave out fragments and pixels, and lower k, as long as some run with the rest fails in the same way.
    fn shrink(mut self, subject: &Subject, seed: u64, limits: &Limits<'_>) -> Self {
        let mut left = MOST_TRIALS;
        let mut replace = |failing: &mut Self, litmus: Litmus| {
            !(limits.cancelled)() && failing.replace(subject, litmus, seed, &mut left)
        };
        self.drop_fragments(&mut replace);
        let mut pixel = 0;
        while pixel < self.litmus.pixels && self.litmus.pixels > 1 {
            let mut litmus = self.litmus.clone();
            litmus.pixels -= 1;
            litmus.fragments.retain(|f| f.0 != pixel);
            litmus.fragments.iter_mut().for_each(|f| f.0 -= u32::from(f.0 > pixel));
            pixel += u32::from(!replace(&mut self, litmus));
        }
        for k in 1..self.litmus.k.unwrap_or(1) {
            let litmus = Litmus { k: Some(k), ..self.litmus.clone() };
            if replace(&mut self, litmus) {
                break;
            }
        }
        self.drop_fragments(&mut replace);
        self
    }

    /// Leave out fragments: many at first, then one after another.
    fn drop_fragments(&mut self, replace: &mut dyn FnMut(&mut Self, Litmus) -> bool) {
        let mut chunk = self.litmus.fragments.len().div_ceil(2);
        let mut at = 0;
        while chunk > 0 {
            let n = self.litmus.fragments.len();
            if at >= n {
                (at, chunk) = (0, chunk / 2);
                continue;
            }
            let mut litmus = self.litmus.clone();
            litmus.fragments.drain(at..(at + chunk).min(n));
            let gone = n - litmus.fragments.len();
            litmus.room = litmus.room.saturating_sub(gone as u32).max(1);
            at = if replace(self, litmus) { 0 } else { at + chunk };
        }
    }

    /// Take a smaller instance, if one of a few runs of it fails in the same way.
    fn replace(&mut self, subject: &Subject, litmus: Litmus, seed: u64, left: &mut u32) -> bool {
        for trial in 0..TRIALS.min(u64::from(*left)) {
            *left -= 1;
            let live = run(subject, &litmus, seed.wrapping_add(trial));
            let wrong = live.wrong.iter().find(|(property, _)| *property == self.property);
            if let Some((_, message)) = wrong {
                self.message.clone_from(message);
                (self.litmus, self.live) = (litmus, live);
                return true;
            }
        }
        false
    }
}

/// A random instance of a method. Some of its depths and data words are constants of its source.
fn draw(subject: &Subject, declared: &[Declared], constants: &[u32], seed: u64) -> Litmus {
    let contract = subject.contract;
    let mut random = Random::new(seed, STREAM);
    let mut pick = |from: &[u64]| from[random.below(from.len() as u64) as usize];
    let most_k = u64::from(contract.max_k.min(MOST_K));
    let most_n = match contract.program.repeats {
        true => MOST_REPEATED,
        false => u64::from(MOST_FRAGMENTS),
    };
    let (k, n) = (pick(&[4, 8, most_k, most_k]), pick(&[8, 24, most_n, most_n]));
    let pixels = pick(&[1, 1, 1, 2, u64::from(MOST_PIXELS)]) as u32;
    let levels = pick(&[1, 3, n, 4 * n]);
    let close = pick(&[0, 1, 2]);
    let short = contract.is_pooled() && !contract.crosses();
    let short = short && pick(&[0, 0, 0, 1]) == 1;
    let datas = pick(&[2, n, 4 * n]);
    let k = contract.default_k.map(|_| 1 + random.below(k.min(most_k)) as u32);
    let n = 1 + random.below(n) as u32;
    let format = contract.depth_format.unwrap_or(Format::D32);
    let by_primitive = declared.iter().any(|input| matches!(input.per, Per::Primitive));
    let base = random.bits() as u32 & 0x7FFF_FFFF;
    let mut depth = || {
        if random.below(DICTIONARY) == 0 && !constants.is_empty() {
            let constant = constants[random.below(constants.len() as u64) as usize];
            return constant.min(FARTHEST);
        }
        let level = random.below(levels) as u32;
        match close {
            // Far apart, adjacent, or at the ends of the range.
            0 => (FARTHEST / levels.max(2) as u32).saturating_mul(level),
            1 => base + level * if format == Format::D32 { 1 } else { 256 },
            _ if level.is_multiple_of(2) => level / 2,
            _ => FARTHEST - level / 2,
        }
    };
    let depths: Vec<u32> = (0..n).map(|_| format.encode(depth())).collect();
    let mut random = Random::new(seed, STREAM + 1);
    let mut data = |depth: u32| {
        let number = random.below(datas) as u32;
        match contract.data {
            Some(Data::Nothing) => 0,
            _ if contract.keeps == Keeps::Visible => number | [16, 240][number as usize % 2] << 24,
            _ if by_primitive => number,
            _ if contract.has_slabs() => number | (random.below(256) as u32) << 24,
            Some(Data::Color) if contract.keeps.is_approximate() => {
                let alpha = [0, 255, random.below(256) as u32][random.below(3) as usize];
                number ^ 0x20_4080 | alpha << 24
            }
            None if random.below(DICTIONARY) == 0 && !constants.is_empty() => {
                constants[random.below(constants.len() as u64) as usize]
            }
            _ if close == 2 && number.is_multiple_of(2) => u32::MAX - number / 2,
            _ if close == 1 && number.is_multiple_of(3) => depth,
            _ => number,
        }
    };
    let datas: Vec<u32> = depths.iter().map(|&depth| data(depth)).collect();
    let mut random = Random::new(seed, STREAM + 2);
    let fragments = depths.into_iter().zip(datas);
    let mut fragments: Vec<Entry> = fragments
        .map(|(depth, data)| Entry(random.below(u64::from(pixels)) as u32, depth, data, 0))
        .collect();
    match contract.extra {
        Extra::Near => thicken(&mut fragments, &mut random),
        Extra::Primitive => (0..).zip(&mut fragments).for_each(|(i, f)| f.3 = i),
        Extra::Nothing | Extra::Rank => {}
    }
    let inputs = declared.iter().map(|input| words(input, pixels, &fragments, &mut random));
    let inputs = inputs.collect();
    let table = contract.crosses().then(|| {
        let load = 30 + random.below(66) as u32;
        let size = size_for_load(u64::from(n), load, [pixels, 1]);
        TableSettings {
            size,
            offsets: Offsets::Random,
            seed: random.bits(),
            ..TableSettings::default()
        }
    });
    let room = if short { 1 + random.below(u64::from(n)) as u32 } else { n };
    Litmus { pixels, k, room, fragments, helpers: 0, table, inputs }
}

/// Give fragments a thickness: none, or enough to reach another fragment's depth, just beyond it, or nearly so.
fn thicken(fragments: &mut [Entry], random: &mut Random) {
    for i in 0..fragments.len() {
        let other = fragments[random.below(fragments.len() as u64) as usize].1;
        let reach = fragments[i].1.saturating_sub(other);
        fragments[i].3 = match random.below(5) {
            0 => 0,
            1 => 1,
            2 => reach,
            3 => reach.saturating_sub(1),
            _ => reach.saturating_add(1),
        };
    }
}

/// Random words of an input.
fn words(input: &Declared, pixels: u32, fragments: &[Entry], random: &mut Random) -> Vec<u32> {
    let tried = if input.tried.is_empty() { &[input.default][..] } else { input.tried };
    let count = match input.per {
        Per::Pixel => u64::from(pixels),
        Per::Primitive => fragments.iter().map(|f| u64::from(f.2) + 1).max().unwrap_or(0),
        Per::Frame(words) => words,
    };
    (0..count).map(|_| tried[random.below(tried.len() as u64) as usize]).collect()
}
