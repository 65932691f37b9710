//! Stochastic transparency (Enderton, Sintorn, Shirley, Luebke, I3D 2010): a pixel has S samples, and a fragment covers
//! a share α of them, opaquely.
//!
//! A fragment covers floor(α S + ξ) samples, ξ in [0, 1), and which these are: both by a hash of its triangle, its pixel
//! and the seed ([`bits`]), so that every fragment has a set of its own, the same on every machine. α S is exact: S times
//! the opacity byte, over 255.
//!
//! * `stochastic@plain` (section 2): every sample keeps its nearest fragment, by an atomic minimum; a pixel is the mean.
//! * `stochastic` (section 3.1, alpha correction): besides, the exact 1 - Π (1 - α) (`passing`), to which the samples'
//!   colour is scaled. Where no sample is covered, the colour is lost.
//! * `stochastic@depth` (section 3.2): a first pass keeps the nearest depth of every sample; a second one sums C V(z), V
//!   being the share of samples whose depth is z or more, so that a fragment sees itself; scaled as above.
//!
//! Equal depths: of those that claim a sample, the canonical order decides; by depth alone, all of them do. Sums are
//! exact integers of bytes and counts; 2^24 fragments have room. In the mean over seeds, the plain form is OVER.

use std::marker::PhantomData;

use super::passing::Passing;
use super::{alpha, approximate, premultiplied};
use crate::fragment::{Fragment, data_of};
use crate::memory::{Atomic, Inputs, Layout, Memory, Order, Pixel, Words};
use crate::num::depth::EMPTY;
use crate::num::random::{Random, bits};
use crate::raster::Grid;
use crate::scheme::contract::{Extra, Form, Limit};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// The most samples a pixel.
pub const MOST_SAMPLES: u32 = 64;

/// The stream of the random numbers.
const STREAM: u64 = 0x5A3B;

/// Which samples a fragment covers.
#[derive(Clone, Copy, Debug)]
struct Samples {
    count: u32,
    seed: u64,
    grid: Grid,
    /// Whether fragments have sets of their own.
    own: bool,
}

impl Samples {
    fn new(config: &Config, own: bool) -> Self {
        let approximation = config.approximation;
        Self { count: approximation.samples, seed: approximation.seed, grid: config.grid, own }
    }

    /// Bit i is sample i.
    fn of(&self, pixel: u32, fragment: Fragment) -> u64 {
        let (x, y) = self.grid.place(pixel);
        let place = u64::from(y) << 32 | u64::from(x);
        let triangle = if self.own { fragment.extra } else { 0 };
        let mut random = Random::new(bits(self.seed, STREAM, place), u64::from(triangle));
        let covered = self.count * alpha(fragment.data);
        let mut left = covered / 255 + u32::from(random.below(255) < u64::from(covered % 255));
        // Every set of that size is as likely as every other (Knuth, TAOCP 2, 3.4.2, algorithm S).
        let mut set = 0;
        for i in 0..self.count {
            if random.below(u64::from(self.count - i)) < u64::from(left) {
                set |= 1 << i;
                left -= 1;
            }
        }
        set
    }

    /// The samples of a set.
    fn each(set: u64) -> impl Iterator<Item = u32> {
        (0..MOST_SAMPLES).filter(move |i| set >> i & 1 == 1)
    }
}

/// A sample that no fragment covers.
const NONE: u64 = u64::MAX;

/// The form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// Whether the opacity is the exact one.
    const CORRECTED: bool = true;
    /// Whether every fragment has a sample set of its own.
    const OWN: bool = true;
}

/// Samples that keep their nearest fragment.
#[derive(Debug)]
pub struct Stochastic<V = Corrected> {
    samples: Samples,
    nearest: Words<Pixel, Atomic, u64>,
    passing: Option<Passing>,
    variant: PhantomData<V>,
}

/// The mean of samples; `through` is the exact share of light that passes, if it is known.
fn mean(nearest: &[u64], through: Option<f64>) -> Light {
    let mut sums = [0_u32; 3];
    let covered = nearest.iter().filter(|&&sample| sample != NONE);
    for &sample in covered.clone() {
        let [r, g, b, _] = data_of(sample).to_le_bytes().map(u32::from);
        sums.iter_mut().zip([r, g, b]).for_each(|(sum, c)| *sum += c);
    }
    let covered = covered.count() as f64;
    if covered == 0.0 {
        return Light { transmittance: through.unwrap_or(1.0), ..Light::default() };
    }
    let all = nearest.len() as f64;
    let transmittance = through.unwrap_or((all - covered) / all);
    let color = sums.map(|sum| f64::from(sum) / (255.0 * covered) * (1.0 - transmittance));
    Light { color, transmittance, kept: 0 }
}

impl<V: Variant> Scheme for Stochastic<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let samples = Samples::new(config, V::OWN);
        Self {
            samples,
            nearest: layout.named("nearest").pixel(u64::from(samples.count)),
            passing: V::CORRECTED.then(|| Passing::new(layout)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.samples.count {
            mem.store(self.nearest.at(pixel, i), NONE, Order::Relaxed).await;
        }
        if let Some(passing) = &self.passing {
            passing.clear(mem, pixel).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let each = mem.block();
        for i in Samples::each(self.samples.of(pixel, fragment)) {
            mem.min(self.nearest.at(pixel, i), fragment.key(), Order::Relaxed).await;
        }
        mem.merge(each).await;
        if let Some(passing) = &self.passing {
            passing.add::<_, Self>(mem, pixel, alpha(fragment.data)).await;
        }
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let mut nearest = [NONE; MOST_SAMPLES as usize];
        for (i, sample) in (0..self.samples.count).zip(&mut nearest) {
            *sample = mem.load(self.nearest.at(pixel, i), Order::Relaxed).await;
        }
        let through = match &self.passing {
            Some(passing) => Some(passing.get(mem, pixel).await),
            None => None,
        };
        *held = mean(&nearest[..self.samples.count as usize], through);
    }

    /// A fault is held to what the right form gives.
    fn expected(&self, _: &Inputs, pixel: u32, generated: &[Fragment]) -> Option<Light> {
        let samples = Samples { own: true, ..self.samples };
        let mut nearest = [NONE; MOST_SAMPLES as usize];
        for &fragment in generated {
            for i in Samples::each(samples.of(pixel, fragment)) {
                nearest[i as usize] = nearest[i as usize].min(fragment.key());
            }
        }
        let alphas = generated.iter().map(|f| alpha(f.data));
        let through = self.passing.as_ref().map(|passing| passing.of(alphas));
        Some(mean(&nearest[..samples.count as usize], through))
    }
}

const CONTRACT: Contract = Contract {
    title: "stochastic transparency: opacity as a share of samples, with the exact alpha",
    paper: "Enderton, Sintorn, Shirley, Luebke 2010",
    section: "3.1",
    words: "2s + 2",
    published_words: Some("2s + 1"),
    exact_when: "a pixel has one layer that covers a sample",
    ties: "canonical: the smaller data word is nearer",
    needs: "64-bit atomic min and add, relaxed",
    wgsl: Some("storage buffers; 64-bit atomicMin where there is one; sums as two 32-bit words"),
    extra: Extra::Primitive,
    source: include_str!("stochastic.rs"),
    ..approximate("stochastic", Limit::Nowhere)
};

/// With the exact alpha.
#[derive(Debug)]
pub struct Corrected;

/// The mean of the samples.
#[derive(Debug)]
pub struct PlainMean;

/// All fragments of a pixel take the same samples.
#[derive(Debug)]
pub struct SameSamples;

impl Variant for Corrected {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for PlainMean {
    const CONTRACT: Contract = Contract {
        name: "stochastic@plain",
        title: "stochastic transparency: opacity as a share of samples",
        section: "2",
        words: "2s",
        published_words: Some("2s"),
        exact_when: "a pixel has one layer whose opacity is a multiple of 1/s",
        needs: "64-bit atomic min, relaxed",
        ..CONTRACT
    };
    const CORRECTED: bool = false;
}

impl Variant for SameSamples {
    const CONTRACT: Contract = Contract {
        name: "stochastic@same-samples",
        title: "Fault same-samples: all fragments of a pixel draw the same random numbers",
        form: Form::Mutation,
        ..CONTRACT
    };
    const OWN: bool = false;
}

/// Samples that keep their nearest depth; colours by the share of samples that see them.
#[derive(Debug)]
pub struct StochasticDepth {
    samples: Samples,
    nearest: Words<Pixel, Atomic, u32>,
    sums: Words<Pixel, Atomic, u64>,
    passing: Passing,
}

impl StochasticDepth {
    /// What a fragment adds to the sums, if so many samples see it.
    fn terms(data: u32, seen: u32) -> [u64; 4] {
        let [r, g, b] = premultiplied(data);
        [r, g, b, 255 * alpha(data)].map(|c| u64::from(c) * u64::from(seen))
    }
}

fn scaled(sums: [u64; 4], through: f64) -> Light {
    let [r, g, b, a] = sums.map(|sum| sum as f64);
    let color = if a == 0.0 { [0.0; 3] } else { [r, g, b].map(|c| c / a * (1.0 - through)) };
    Light { color, transmittance: through, kept: 0 }
}

impl Scheme for StochasticDepth {
    const CONTRACT: Contract = Contract {
        name: "stochastic@depth",
        title: "depth-based stochastic transparency: two passes, visibility from samples",
        section: "3.2",
        program: Program::of(&[
            Pass::new("depths", PassKind::Prepare, Barrier::Pixel),
            Pass::store(Barrier::Pixel),
        ]),
        words: "s + 10",
        published_words: Some("s + 5"),
        exact_when: "a pixel has one layer",
        ties: "all count alike",
        needs: "32-bit atomic min, 64-bit atomic add, relaxed; two geometry passes",
        wgsl: Some("storage buffers; sums as two 32-bit words with a carry"),
        ..CONTRACT
    };

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let samples = Samples::new(config, true);
        Self {
            samples,
            nearest: layout.named("nearest").pixel(u64::from(samples.count)),
            sums: layout.named("sums").pixel(4),
            passing: Passing::new(layout),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.samples.count {
            mem.store(self.nearest.at(pixel, i), EMPTY, Order::Relaxed).await;
        }
        for i in 0..4 {
            mem.store(self.sums.at(pixel, i), 0, Order::Relaxed).await;
        }
        self.passing.clear(mem, pixel).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let pixel = fragment.pixel;
        let each = mem.block();
        for i in Samples::each(self.samples.of(pixel, fragment)) {
            mem.min(self.nearest.at(pixel, i), fragment.depth, Order::Relaxed).await;
        }
        mem.merge(each).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let mut seen = 0;
        for i in 0..self.samples.count {
            let nearest = mem.load(self.nearest.at(pixel, i), Order::Relaxed).await;
            seen += u32::from(fragment.depth <= nearest);
        }
        for (i, term) in (0..).zip(Self::terms(fragment.data, seen)) {
            mem.add(self.sums.at(pixel, i), term, Order::Relaxed).await;
        }
        self.passing.add::<_, Self>(mem, pixel, alpha(fragment.data)).await;
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let mut sums = [0; 4];
        for (i, sum) in (0..).zip(&mut sums) {
            *sum = mem.load(self.sums.at(pixel, i), Order::Relaxed).await;
        }
        *held = scaled(sums, self.passing.get(mem, pixel).await);
    }

    fn expected(&self, _: &Inputs, pixel: u32, generated: &[Fragment]) -> Option<Light> {
        let mut nearest = [EMPTY; MOST_SAMPLES as usize];
        for &fragment in generated {
            for i in Samples::each(self.samples.of(pixel, fragment)) {
                nearest[i as usize] = nearest[i as usize].min(fragment.depth);
            }
        }
        let mut sums = [0; 4];
        for fragment in generated {
            let all = &nearest[..self.samples.count as usize];
            let seen = all.iter().filter(|&&nearest| fragment.depth <= nearest).count() as u32;
            let terms = Self::terms(fragment.data, seen);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        Some(scaled(sums, self.passing.of(generated.iter().map(|f| alpha(f.data)))))
    }
}
