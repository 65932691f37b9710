//! Moment-based transparency (Münstermann, Krumpen, Klein, Peters, PACMCGIT 1(1), 2018) with 4, 6 or 8 power moments.
//!
//! Two geometry passes. The first sums the absorbance A = -ln(1 - α) of a pixel's fragments and its moments A u^j, where
//! u is the fragment's distance on a logarithmic scale, -1 at the camera's near plane and 1 at its far plane (where rays
//! are parallel, on a linear one). The second reconstructs the transmittance T(u) in front of each fragment
//! ([`super::moments`]) and sums `S_C` = Σ C T and `S_α` = Σ α T. Resolve: `S_C` / `S_α` (1 - e^-b_0) + B e^-b_0; B where `b_0`
//! is 0. It is exact for one layer. An opaque fragment counts as A = 10: it lets 4.5e-5 of the light through.
//!
//! Moments are integers at scale 2^40 in 64 bits: A <= 10, |u| <= 1, so that 2^19 fragments have room, and a term is
//! right to 2^-41. So T(u) is one f64 for every arrival, and the second pass adds integers, too.
//!
//! Where a pixel holds much, T may be too small for any number (65,536 opaque layers: e^-163,840). Only ratios of T
//! count. So T is taken relative to that of the nearest fragment, which a full-screen pass computes between both: at
//! scale 2^32, at most 2^14. (T is not quite monotonous, so that a ratio may be above 1.) 2^18 fragments have room.
//!
//! * `@published-f32`: moments, reconstruction and sums in single precision, as blended; where that fails, a pixel's
//!   colour is no number, and is drawn black.

use super::blend::Blended;
use super::moments::{Guard, MOST, log_transmittance};
use super::{alpha, approximate, arrivals, real};
use crate::fragment::Fragment;
use crate::memory::{Atomic, Inputs, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::depth::EMPTY;
use crate::num::planes::Distances;
use crate::scheme::contract::{Dependence, Form, Limit};
use crate::scheme::parts::lock;
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// The absorbance of an opaque fragment, and the largest.
const OPAQUE: f64 = 10.0;

/// One unit of a moment.
const MOMENT: f64 = (1u64 << 40) as f64;

/// One unit of a weighted sum.
const SUM: f64 = (1u64 << 32) as f64;

/// The largest transmittance relative to the nearest fragment's.
const MOST_RATIO: f64 = (1 << 14) as f64;

/// Moments of a pixel: `b_0` to `b_m`; those beyond are 0.
type Moments = [u64; MOST + 1];

/// The method.
#[derive(Debug)]
pub struct Mbt {
    scale: Scale,
    moments: u32,
    sums: Words<Pixel, Atomic, u64>,
    nearest: Words<Pixel, Atomic, u32>,
    /// The logarithm of T at the nearest fragment, as the bits of an f64.
    reference: Words<Pixel, Plain, u64>,
    weighted: Words<Pixel, Atomic, u64>,
}

/// Where distances lie between the planes.
#[derive(Clone, Copy, Debug)]
struct Scale {
    distances: Distances,
    first: f64,
    length: f64,
}

impl Scale {
    fn new(distances: Distances) -> Self {
        let planes = distances.planes;
        let ends = [planes.near, planes.far];
        let [first, last] = if planes.parallel { ends } else { ends.map(libm::log) };
        Self { distances, first, length: last - first }
    }

    /// From -1 at the near plane to 1 at the far plane.
    fn at(&self, depth: u32) -> f64 {
        self.of_distance(self.distances.along(depth))
    }

    fn of_distance(&self, along: f64) -> f64 {
        let place = if self.distances.planes.parallel { along } else { libm::log(along) };
        ((place - self.first) / self.length * 2.0 - 1.0).clamp(-1.0, 1.0)
    }
}

/// The absorbance of a fragment.
fn absorbance(fragment: Fragment) -> f64 {
    of_opacity(alpha(fragment.data))
}

fn of_opacity(alpha: u32) -> f64 {
    match alpha {
        255 => OPAQUE,
        alpha => -libm::log(f64::from(255 - alpha) / 255.0),
    }
}

/// What is absorbed in front of each distance, 0 to 1, as `mbt` reconstructs it from all fragments of a pixel, in any
/// order.
#[must_use]
pub fn absorbed(
    fragments: &[Fragment],
    distances: Distances,
    moments: u32,
    along: &[f64],
) -> Vec<f64> {
    let scale = Scale::new(distances);
    let mut sums = [0.0; MOST + 1];
    for fragment in fragments {
        let (u, mut power) = (scale.at(fragment.depth), absorbance(*fragment));
        for sum in &mut sums[..=moments as usize] {
            *sum += power;
            power *= u;
        }
    }
    let whole = sums[0];
    let normalised = std::array::from_fn(|i| sums[i + 1] / whole);
    let at = |&along: &f64| {
        let u = scale.of_distance(along);
        let log = log_transmittance(whole, &normalised, moments, u, Guard::Clamped);
        if whole > 0.0 { 1.0 - libm::exp(log) } else { 0.0 }
    };
    along.iter().map(at).collect()
}

/// What a fragment of each opacity byte adds to `b_0`.
#[must_use]
pub fn absorbances() -> Box<[u64; 256]> {
    Box::new(std::array::from_fn(|alpha| libm::round(of_opacity(alpha as u32) * MOMENT) as u64))
}

impl Mbt {
    /// What a fragment adds to the moments.
    fn terms(&self, fragment: Fragment) -> Moments {
        let u = self.scale.at(fragment.depth);
        let mut power = absorbance(fragment) * MOMENT;
        let mut terms = [0; MOST + 1];
        for term in &mut terms[..=self.moments as usize] {
            // Two's complement: sums wrap around 0.
            *term = libm::round(power) as i64 as u64;
            power *= u;
        }
        terms
    }

    /// The logarithm of T at a depth.
    fn log_at(&self, sums: &Moments, depth: u32) -> f64 {
        if sums[0] == 0 {
            return 0.0;
        }
        let whole = sums[0] as f64;
        let normalised = std::array::from_fn(|i| sums[i + 1] as i64 as f64 / whole);
        let u = self.scale.at(depth);
        log_transmittance(whole / MOMENT, &normalised, self.moments, u, Guard::Clamped)
    }

    /// What a fragment adds to the weighted sums.
    fn weighted(&self, sums: &Moments, reference: f64, fragment: Fragment) -> [u64; 4] {
        let ratio = libm::exp(self.log_at(sums, fragment.depth) - reference).min(MOST_RATIO);
        let [r, g, b] = real(fragment.data);
        let a = f64::from(alpha(fragment.data)) / 255.0;
        [r, g, b, a].map(|x| libm::round(x * ratio * SUM) as u64)
    }

    async fn sums<M: Memory>(&self, mem: &M, pixel: u32) -> Moments {
        let mut sums = [0; MOST + 1];
        for (i, sum) in (0..=self.moments).zip(&mut sums) {
            *sum = mem.load(self.sums.at(pixel, i), Order::Relaxed).await;
        }
        sums
    }
}

/// What sums stand for.
fn light(whole: u64, weighted: [u64; 4]) -> Light {
    let through = libm::exp(-(whole as f64) / MOMENT);
    let [r, g, b, a] = weighted.map(|sum| sum as f64);
    let color = if a == 0.0 { [0.0; 3] } else { [r, g, b].map(|c| c / a * (1.0 - through)) };
    Light { color, transmittance: through, kept: 0 }
}

const PROGRAM: Program = Program::of(&[
    Pass::new("moments", PassKind::Prepare, Barrier::Pixel),
    Pass::new("nearest", PassKind::Screen, Barrier::Pixel),
    Pass::store(Barrier::Pixel),
]);

const CONTRACT: Contract = Contract {
    title: "moment-based OIT: two passes, transmittance from power moments of the absorbance",
    paper: "Münstermann, Krumpen, Klein, Peters 2018",
    section: "3, 4, algorithms 1 to 4",
    program: PROGRAM,
    words: "2m + 13",
    published_words: Some("m + 5"),
    exact_when: "a pixel has one layer, which is not opaque",
    needs: "64-bit atomic add, 32-bit atomic min, relaxed; two geometry passes",
    wgsl: Some("storage buffers; sums as two 32-bit words with a carry"),
    source: include_str!("mbt.rs"),
    ..approximate("mbt", Limit::Nowhere)
};

impl Scheme for Mbt {
    const CONTRACT: Contract = CONTRACT;

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let moments = config.approximation.moments;
        Self {
            scale: Scale::new(config.distances),
            moments,
            sums: layout.named("sums").pixel(u64::from(moments) + 1),
            nearest: layout.named("nearest").pixel(1),
            reference: layout.named("reference").pixel(1),
            weighted: layout.named("weighted").pixel(4),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..=self.moments {
            mem.store(self.sums.at(pixel, i), 0, Order::Relaxed).await;
        }
        for i in 0..4 {
            mem.store(self.weighted.at(pixel, i), 0, Order::Relaxed).await;
        }
        mem.store(self.nearest.at(pixel, 0), EMPTY, Order::Relaxed).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let terms = self.terms(fragment);
        for (i, term) in (0..=self.moments).zip(terms) {
            mem.add(self.sums.at(fragment.pixel, i), term, Order::Relaxed).await;
        }
        mem.min(self.nearest.at(fragment.pixel, 0), fragment.depth, Order::Relaxed).await;
    }

    async fn screen<M: Memory>(&self, mem: &M, _: usize, pixel: u32) {
        let sums = self.sums(mem, pixel).await;
        let nearest = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        let reference = if nearest == EMPTY { 0.0 } else { self.log_at(&sums, nearest) };
        mem.plain_store(self.reference.at(pixel, 0), reference.to_bits()).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let sums = self.sums(mem, pixel).await;
        let reference = f64::from_bits(mem.plain_load(self.reference.at(pixel, 0)).await);
        for (i, term) in (0..).zip(self.weighted(&sums, reference, fragment)) {
            mem.add(self.weighted.at(pixel, i), term, Order::Relaxed).await;
        }
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let whole = mem.load(self.sums.at(pixel, 0), Order::Relaxed).await;
        let mut weighted = [0; 4];
        for (i, sum) in (0..).zip(&mut weighted) {
            *sum = mem.load(self.weighted.at(pixel, i), Order::Relaxed).await;
        }
        *held = light(whole, weighted);
    }

    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        let mut sums = [0u64; MOST + 1];
        for &fragment in generated {
            let terms = self.terms(fragment);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum = sum.wrapping_add(term));
        }
        let reference = generated.first().map_or(0.0, |nearest| self.log_at(&sums, nearest.depth));
        let mut weighted = [0; 4];
        for &fragment in generated {
            let terms = self.weighted(&sums, reference, fragment);
            weighted.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        Some(light(sums[0], weighted))
    }
}

/// As published: everything in single precision.
#[derive(Debug)]
pub struct PublishedF32 {
    scale: Scale,
    moments: u32,
    sums: Blended<9>,
    weighted: Blended<4>,
}

impl PublishedF32 {
    /// Blend a fragment into moment `i`.
    fn moment(&self, fragment: Fragment, i: usize, old: f32) -> f32 {
        let u = self.scale.at(fragment.depth) as f32;
        let mut term = absorbance(fragment) as f32;
        (0..i).for_each(|_| term *= u);
        if i <= self.moments as usize { old + term } else { old }
    }

    /// Blend a fragment into weighted sum `i`.
    fn weighted(&self, sums: &[f32; MOST + 1], fragment: Fragment, i: usize, old: f32) -> f32 {
        let whole = sums[0];
        let normalised = std::array::from_fn(|i| sums[i + 1] / whole);
        let u = self.scale.at(fragment.depth) as f32;
        let log = log_transmittance(whole, &normalised, self.moments, u, Guard::Published);
        let [r, g, b] = real(fragment.data).map(|c| c as f32);
        let a = alpha(fragment.data) as f32 / 255.0;
        old + [r, g, b, a][i] * libm::expf(log)
    }
}

impl PublishedF32 {
    /// What fragments give that arrive in these orders in the first and in the second pass.
    fn arrived(&self, [first, second]: [&[Fragment]; 2]) -> Light {
        let (mut sums, mut weighted) = ([0.0; 9], [0.0; 4]);
        for &fragment in first {
            (0..9).for_each(|i| sums[i] = self.moment(fragment, i, sums[i]));
        }
        for &fragment in second {
            (0..4).for_each(|i| weighted[i] = self.weighted(&sums, fragment, i, weighted[i]));
        }
        light_f32(sums[0], weighted)
    }
}

fn light_f32(whole: f32, [r, g, b, a]: [f32; 4]) -> Light {
    if whole == 0.0 {
        return Light::default();
    }
    let through = libm::expf(-whole);
    // There are many bit patterns that are no number: here it is always the same.
    let real = |x: f32| if x.is_nan() { f64::NAN } else { f64::from(x) };
    let color = [r, g, b].map(|c| real(c / a * (1.0 - through)));
    Light { color, transmittance: real(through), kept: 0 }
}

impl Scheme for PublishedF32 {
    const CONTRACT: Contract = Contract {
        name: "mbt@published-f32",
        title: "moment-based OIT in single precision, with the published bias",
        form: Form::Published,
        program: Program::of(&[
            Pass::new("moments", PassKind::Prepare, Barrier::Pixel),
            Pass::store(Barrier::Pixel),
        ]),
        words: "15",
        dependence: Dependence::Arrival,
        needs: lock::NEEDS,
        wgsl: lock::WGSL,
        ..CONTRACT
    };

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            scale: Scale::new(config.distances),
            moments: config.approximation.moments,
            sums: Blended::new(layout),
            weighted: Blended::new(layout),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.sums.clear(mem, pixel, [0.0; 9]).await;
        self.weighted.clear(mem, pixel, [0.0; 4]).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        self.sums.blend(mem, fragment.pixel, |i, old| self.moment(fragment, i, old)).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let sums = self.sums.get(mem, fragment.pixel).await;
        let blend = |i, old| self.weighted(&sums, fragment, i, old);
        self.weighted.blend(mem, fragment.pixel, blend).await;
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let [whole, ..] = self.sums.get(mem, pixel).await;
        *held = light_f32(whole, self.weighted.get(mem, pixel).await);
    }

    /// The sum of two floats does not depend on their order.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        (generated.len() <= 2).then(|| self.arrived([generated, generated]))
    }

    /// Both passes have an order of their own.
    fn possible(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Vec<Light> {
        let all: Vec<Vec<Fragment>> = arrivals(generated).collect();
        let pairs = all.iter().flat_map(|first| all.iter().map(move |second| [first, second]));
        pairs.map(|[first, second]| self.arrived([first, second])).collect()
    }
}
