//! Weighted blended order-independent transparency (`McGuire`, Bavoil, JCGT 2(2), 2013).
//!
//! One geometry pass: `S_C` = Σ C w, `S_α` = Σ α w, R = Π (1 - α), with C = α c and the paper's w(z, α), which has α as a
//! factor ([`Weight`]). Resolve: `S_C` / `S_α` (1 - R) + B R; B where `S_α` is 0. It is exact for one layer, whatever the
//! weight; with equal weights, it is the mean colour by opacity.
//!
//! Sums are integers at scale 2^34 in 64 bits. A term is at most 3e3 of 2^34, so that 2^18 fragments of a pixel have
//! room. The smallest term, of opacity 1/255 at the smallest weight, is 6.7e5 units of `S_α`: it is right to 7.5e-7 of
//! itself. R is a sum of logarithms (`passing`).
//!
//! The weights are made for distances of about 0.1 to 500 units. A scene in other units is weighted otherwise: the unit
//! is the scene's, and is not changed here. Where rays are parallel, z is the distance from the eye's plane, 0 at least.
//!
//! * `@published-f32`: all five in single precision, as blended.

use std::marker::PhantomData;

use super::blend::Blended;
use super::passing::Passing;
use super::{alpha, approximate, arrivals, real};
use crate::fragment::Fragment;
use crate::memory::{Atomic, Inputs, Layout, Memory, Order, Pixel, Words};
use crate::num::planes::Distances;
use crate::scheme::contract::{Dependence, Form, Limit};
use crate::scheme::parts::lock;
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// The paper's weights, each times the opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weight {
    /// 10 / (1e-5 + (z/5)² + (z/200)⁶), between 1e-2 and 3e3.
    #[default]
    Eq7,
    /// 10 / (1e-5 + (z/10)³ + (z/200)⁶), between 1e-2 and 3e3.
    Eq8,
    /// 0.03 / (1e-5 + (z/200)⁴), between 1e-2 and 3e3.
    Eq9,
    /// 3e3 (1 - d)³ of the depth-buffer value d, at least 1e-2.
    Eq10,
}

impl Weight {
    /// All, in the paper's order.
    pub const ALL: [Self; 4] = [Self::Eq7, Self::Eq8, Self::Eq9, Self::Eq10];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Eq7 => "eq7",
            Self::Eq8 => "eq8",
            Self::Eq9 => "eq9",
            Self::Eq10 => "eq10",
        }
    }

    /// The weight of a fragment at distance `z`, depth-buffer value `d` (0 to 1) and opacity `alpha`: 0 to 3e3.
    #[must_use]
    pub fn at(self, z: f64, d: f64, alpha: f64) -> f64 {
        let square = |x: f64| x * x;
        let far = square(z / 200.0);
        let of_depth = match self {
            Self::Eq7 => 10.0 / (1e-5 + square(z / 5.0) + far * far * far),
            Self::Eq8 => 10.0 / (1e-5 + square(z / 10.0) * (z / 10.0) + far * far * far),
            Self::Eq9 => 0.03 / (1e-5 + far * far),
            Self::Eq10 => 3e3 * square(1.0 - d) * (1.0 - d),
        };
        alpha * of_depth.clamp(1e-2, 3e3)
    }
}

/// One unit of a sum.
const SCALE: f64 = (1u64 << 34) as f64;

/// The form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// Whether the weight depends on depth.
    const WEIGHTED: bool = true;
    /// Whether a colour is multiplied by its opacity once more.
    const TWICE: bool = false;
    /// Whether R is kept in 8 bits.
    const EIGHT_BITS: bool = false;
}

/// The method.
#[derive(Debug)]
pub struct Wboit<V = Correct> {
    distances: Distances,
    weight: Weight,
    sums: Words<Pixel, Atomic, u64>,
    passing: Passing,
    /// R in 8 bits, for the fault that keeps it so.
    byte: Option<Words<Pixel, Atomic, u32>>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "weighted blended OIT: one pass, colours by a weight of depth and opacity",
    paper: "McGuire, Bavoil 2013",
    section: "equations 2, 7 to 10",
    words: "10",
    published_words: Some("5"),
    exact_when: "a pixel has one layer",
    needs: "64-bit atomic add, relaxed",
    wgsl: Some("storage buffers; sums as two 32-bit words with a carry"),
    source: include_str!("wboit.rs"),
    ..approximate("wboit", Limit::Nowhere)
};

/// A fragment's weight.
fn weight(weight: Weight, distances: &Distances, fragment: Fragment) -> f64 {
    let d = distances.format.decode(fragment.depth);
    let z = distances.planes.along(d).max(0.0);
    weight.at(z, d, f64::from(alpha(fragment.data)) / 255.0)
}

impl<V: Variant> Wboit<V> {
    /// What a fragment adds to the sums.
    fn terms(&self, fragment: Fragment, weighted: bool, twice: bool) -> [u64; 4] {
        let a = f64::from(alpha(fragment.data)) / 255.0;
        let w = if weighted { weight(self.weight, &self.distances, fragment) } else { 1.0 };
        let [r, g, b] = real(fragment.data).map(|c| if twice { c * a } else { c });
        [r, g, b, a].map(|x| libm::round(x * w * SCALE) as u64)
    }
}

/// What sums stand for.
fn light(sums: [u64; 4], through: f64) -> Light {
    let [r, g, b, a] = sums.map(|sum| sum as f64);
    if a == 0.0 {
        return Light { transmittance: through, ..Light::default() };
    }
    let color = [r, g, b].map(|c| c / a * (1.0 - through));
    Light { color, transmittance: through, kept: 0 }
}

impl<V: Variant> Scheme for Wboit<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            distances: config.distances,
            weight: config.approximation.weight,
            sums: layout.named("sums").pixel(4),
            passing: Passing::new(layout),
            byte: V::EIGHT_BITS.then(|| layout.named("byte").pixel(1)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..4 {
            mem.store(self.sums.at(pixel, i), 0, Order::Relaxed).await;
        }
        self.passing.clear(mem, pixel).await;
        if let Some(byte) = self.byte {
            mem.store(byte.at(pixel, 0), 255, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        for (i, term) in (0..).zip(self.terms(fragment, V::WEIGHTED, V::TWICE)) {
            mem.add(self.sums.at(pixel, i), term, Order::Relaxed).await;
        }
        match self.byte {
            None => self.passing.add::<_, Self>(mem, pixel, alpha(fragment.data)).await,
            Some(byte) => eighth(mem, byte, fragment).await,
        }
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let mut sums = [0; 4];
        for (i, sum) in (0..).zip(&mut sums) {
            *sum = mem.load(self.sums.at(pixel, i), Order::Relaxed).await;
        }
        let through = match self.byte {
            None => self.passing.get(mem, pixel).await,
            Some(byte) => f64::from(mem.load(byte.at(pixel, 0), Order::Relaxed).await) / 255.0,
        };
        *held = light(sums, through);
    }

    /// A fault is held to what the right form gives.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        let mut sums = [0; 4];
        for &fragment in generated {
            let terms = self.terms(fragment, true, false);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        Some(light(sums, self.passing.of(generated.iter().map(|f| alpha(f.data)))))
    }
}

/// R in 8 bits: a product that is rounded at every fragment.
async fn eighth<M: Memory>(mem: &M, byte: Words<Pixel, Atomic, u32>, fragment: Fragment) {
    let at = byte.at(fragment.pixel, 0);
    let through = 255 - alpha(fragment.data);
    let _tries = mem.block();
    let mark = mem.mark();
    loop {
        let attempt = mem.block();
        let old = mem.load(at, Order::Relaxed).await;
        let new = (old * through + 127) / 255;
        if mem.compare_exchange(at, old, new, Order::Relaxed).await == old {
            return;
        }
        mem.merge(attempt).await;
        mem.spin(mark).await;
    }
}

const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract { name, title, form: Form::Mutation, ..CONTRACT }
}

macro_rules! variants {
    ($($(#[$doc:meta])* $name:ident: $contract:expr $(, $const:ident: $value:expr)*;)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name;

        impl Variant for $name {
            const CONTRACT: Contract = $contract;
            $(const $const: bool = $value;)*
        }
    )*};
}

variants! {
    /// The method.
    Correct: CONTRACT;
    /// The weight is a constant: a gather that ignores depth.
    ConstantWeight: fault(
        "wboit@constant-weight", "Fault constant-weight: a constant weight is left in, so that depth does not count"
    ), WEIGHTED: false;
    /// The colour comes premultiplied, and is multiplied again.
    PremultipliedTwice: fault(
        "wboit@premultiplied-twice", "Fault premultiplied-twice: a colour is multiplied by its opacity twice"
    ), TWICE: true;
    /// R is kept in 8 bits.
    EightBits: Contract {
        words: "11",
        ..fault("wboit@eight-bits", "Fault eight-bits: the transmittance is accumulated in 8 bits")
    }, EIGHT_BITS: true;
}

/// As published: five floats of a pixel, blended in single precision.
#[derive(Debug)]
pub struct PublishedF32 {
    distances: Distances,
    weight: Weight,
    floats: Blended<5>,
}

impl PublishedF32 {
    /// What a fragment makes of the floats: three sums of colour, one of opacity, and R.
    fn blend(&self, fragment: Fragment, i: usize, old: f32) -> f32 {
        let a = alpha(fragment.data) as f32 / 255.0;
        if i == 4 {
            return old * (1.0 - a);
        }
        let w = weight(self.weight, &self.distances, fragment) as f32;
        let [r, g, b] = real(fragment.data).map(|c| c as f32);
        old + [r, g, b, a][i] * w
    }
}

impl PublishedF32 {
    /// What fragments in this order of arrival give.
    fn arrived(&self, fragments: &[Fragment]) -> Light {
        let mut floats = [0.0, 0.0, 0.0, 0.0, 1.0];
        for &fragment in fragments {
            (0..5).for_each(|i| floats[i] = self.blend(fragment, i, floats[i]));
        }
        light_f32(floats)
    }
}

fn light_f32([r, g, b, a, through]: [f32; 5]) -> Light {
    let color = if a == 0.0 { [0.0; 3] } else { [r, g, b].map(|c| c / a * (1.0 - through)) };
    Light { color: color.map(f64::from), transmittance: through.into(), kept: 0 }
}

impl Scheme for PublishedF32 {
    const CONTRACT: Contract = Contract {
        name: "wboit@published-f32",
        title: "weighted blended OIT, sums in single precision",
        form: Form::Published,
        words: "6",
        dependence: Dependence::Arrival,
        needs: lock::NEEDS,
        wgsl: lock::WGSL,
        ..CONTRACT
    };

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let weight = config.approximation.weight;
        Self { distances: config.distances, weight, floats: Blended::new(layout) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.floats.clear(mem, pixel, [0.0, 0.0, 0.0, 0.0, 1.0]).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        self.floats.blend(mem, fragment.pixel, |i, old| self.blend(fragment, i, old)).await;
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        *held = light_f32(self.floats.get(mem, pixel).await);
    }

    /// The sum of two floats does not depend on their order.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        (generated.len() <= 2).then(|| self.arrived(generated))
    }

    fn possible(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Vec<Light> {
        arrivals(generated).map(|order| self.arrived(&order)).collect()
    }
}
