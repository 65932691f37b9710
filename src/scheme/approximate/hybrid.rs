//! Hybrid transparency (Maule, Comba, Torchelsen, Bastos, I3D 2013): the k nearest fragments of a pixel exactly, its
//! core; of the others, its tail, the average.
//!
//! c̄ = ΣC / Σα and ᾱ = Σα / m over the m fragments of the tail, and `T_tail` = (1 - ᾱ)^m. Pixel: core + `T_core` (c̄ (1 -
//! `T_tail`) + `T_tail` B). With k for all fragments it is the exact picture.
//!
//! One pass. The core is a k+-buffer under a spin lock ([`locked_row`]); what it culls or evicts goes into the tail's
//! sums. Which fragments that is does not depend on arrival, and the sums are exact integers: of bytes, C = α c. There
//! is room for 2^24 fragments.
//!
//! * `hybrid@product`: `T_tail` is the exact product Π (1 - α) of the tail.
//! * `kplus-array+tail` (`kplus-array --tail`, as in nvpro-samples' `vk_order_independent_transparency`): what has no
//!   room goes to the blending unit, which puts it over the rest of the tail in the order of arrival. It depends on
//!   arrival where the tail has two fragments.

use std::marker::PhantomData;

use super::passing::Passing;
use super::{alpha, approximate, arrivals, premultiplied};
use crate::fragment::{Fragment, data_of, pair_key};
use crate::memory::{At, Atomic, Inputs, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::ray::Ray;
use crate::scheme::contract::{Dependence, Form, Limit};
use crate::scheme::parts::lock::{self, SpinLock};
use crate::scheme::parts::locked_row::{self, Row};
use crate::scheme::parts::slots::{OfPixel, entry};
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// The form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// What becomes of the tail.
    const TAIL: Tail = Tail::Average;
    /// Whether the tail's colour is multiplied by its opacity.
    const OPACITY: bool = true;
}

/// What becomes of what has no room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tail {
    /// Its mean colour, with a transmittance from its mean opacity.
    Average,
    /// Its mean colour, with the exact transmittance.
    Product,
    /// Blended in the order of arrival, later in front.
    Blended,
}

/// The method.
#[derive(Debug)]
pub struct Hybrid<V = Average> {
    k: u32,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    depth: Words<Pixel, Atomic, u32>,
    data: Words<Pixel, Plain, u32>,
    /// Of the tail: red, green, blue, and opacity with the number of fragments; or all of it in one word, if it is
    /// blended.
    tail: Words<Pixel, Atomic, u64>,
    product: Option<Passing>,
    variant: PhantomData<V>,
}

/// Where the number of fragments begins in the last sum.
const COUNT: u32 = 40;

/// The sums of a tail.
type Sums = [u64; 4];

/// What a fragment adds to them.
fn terms(data: u32) -> Sums {
    let [r, g, b] = premultiplied(data).map(u64::from);
    [r, g, b, 1 << COUNT | u64::from(alpha(data))]
}

/// The colour of a core and a tail. `opacity`: whether the tail's colour is multiplied by its opacity.
fn light(core: Ray, kept: u32, tail: Sums, product: Option<f64>, opacity: bool) -> Light {
    let (front, [r, g, b, last]) = (Light { kept, ..core.light() }, tail);
    let (count, alphas) = (last >> COUNT, (last & ((1 << COUNT) - 1)) as f64);
    if count == 0 || alphas == 0.0 {
        return front;
    }
    let count = count as f64;
    let through = product.unwrap_or_else(|| libm::pow(1.0 - alphas / 255.0 / count, count));
    let share = if opacity { 1.0 - through } else { 1.0 };
    let behind = [r, g, b].map(|c| c as f64 / (255.0 * alphas) * share);
    let color = std::array::from_fn(|i| front.color[i] + front.transmittance * behind[i]);
    Light { color, transmittance: front.transmittance * through, kept }
}

/// A core, whose keys may come in any order.
fn core(keys: &mut [u64]) -> Ray {
    keys.sort_unstable();
    let mut ray = Ray::default();
    keys.iter().for_each(|key| ray.over(data_of(*key)));
    ray
}

impl<V: Variant> Hybrid<V> {
    fn slots(&self, pixel: u32) -> OfPixel {
        OfPixel { depth: self.depth, data: self.data, pixel }
    }
}

impl<V: Variant> Scheme for Hybrid<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            tail: layout.named("tail").pixel(if V::TAIL == Tail::Blended { 1 } else { 4 }),
            product: (V::TAIL == Tail::Product).then(|| Passing::new(layout)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
        let empty = if V::TAIL == Tail::Blended { Ray::default().to_word() } else { 0 };
        for i in 0..self.tail.count() as u32 {
            mem.store(self.tail.at(pixel, i), empty, Order::Relaxed).await;
        }
        if let Some(product) = &self.product {
            product.clear(mem, pixel).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let (slots, counter) = (self.slots(pixel), self.counter.at(pixel, 0));
        let row = Row { slots, k: self.k, heap: false, lock: self.lock, counter };
        let insertion = mem.block();
        let gone = locked_row::insert::<_, _, Self>(mem, row, fragment).await;
        mem.merge(insertion).await;
        let Some(gone) = gone else { return Outcome::Kept };
        if V::TAIL == Tail::Blended {
            blend(mem, self.tail.at(pixel, 0), data_of(gone)).await;
            return Outcome::Merged;
        }
        for (i, term) in (0..).zip(terms(data_of(gone))) {
            mem.add(self.tail.at(pixel, i), term, Order::Relaxed).await;
        }
        if let Some(product) = &self.product {
            product.add::<_, Self>(mem, pixel, alpha(data_of(gone))).await;
        }
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        let mut keys = Vec::with_capacity(count as usize);
        for i in 0..count {
            keys.push(pair_key(entry(mem, self.slots(pixel), i).await));
        }
        if V::TAIL == Tail::Blended {
            let mut ray = core(&mut keys);
            ray.through(Ray::of_word(mem.load(self.tail.at(pixel, 0), Order::Relaxed).await));
            *held = Light { kept: count, ..ray.light() };
            return;
        }
        let mut tail = [0; 4];
        for (i, sum) in (0..).zip(&mut tail) {
            *sum = mem.load(self.tail.at(pixel, i), Order::Relaxed).await;
        }
        let product = match &self.product {
            Some(product) => Some(product.get(mem, pixel).await),
            None => None,
        };
        *held = light(core(&mut keys), count, tail, product, V::OPACITY);
    }

    /// A fault is held to what the right form gives.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        let (near, far) = generated.split_at(generated.len().min(self.k as usize));
        let mut keys: Vec<u64> = near.iter().map(|f| f.key()).collect();
        if V::TAIL == Tail::Blended {
            let mut ray = core(&mut keys);
            let mut tail = Ray::default();
            far.iter().for_each(|f| tail = tail.behind(f.data));
            ray.through(tail);
            let kept = near.len() as u32;
            return (far.len() < 2).then(|| Light { kept, ..ray.light() });
        }
        let mut tail = [0; 4];
        for fragment in far {
            let terms = terms(fragment.data);
            tail.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let product = self.product.as_ref().map(|p| p.of(far.iter().map(|f| alpha(f.data))));
        Some(light(core(&mut keys), near.len() as u32, tail, product, true))
    }

    /// The core is the same for all; a tail may be blended in every order.
    fn possible(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Vec<Light> {
        let (near, far) = generated.split_at(generated.len().min(self.k as usize));
        if V::TAIL != Tail::Blended || far.is_empty() {
            return Vec::new();
        }
        let mut keys: Vec<u64> = near.iter().map(|f| f.key()).collect();
        let core = core(&mut keys);
        let of = |order: Vec<Fragment>| {
            let mut ray = core;
            ray.through(order.iter().fold(Ray::default(), |tail, f| tail.behind(f.data)));
            Light { kept: near.len() as u32, ..ray.light() }
        };
        arrivals(far).map(of).collect()
    }
}

/// Put a fragment over a tail.
async fn blend<M: Memory>(mem: &M, tail: At<Pixel, Atomic, u64>, data: u32) {
    let _tries = mem.block();
    let mark = mem.mark();
    loop {
        let attempt = mem.block();
        let old = mem.load(tail, Order::Relaxed).await;
        let new = Ray::of_word(old).behind(data).to_word();
        if mem.compare_exchange(tail, old, new, Order::Relaxed).await == old {
            return;
        }
        mem.merge(attempt).await;
        mem.spin(mark).await;
    }
}

const CONTRACT: Contract = Contract {
    title: "hybrid transparency: the k nearest exactly, the average of the rest",
    paper: "Maule, Comba, Torchelsen, Bastos 2013",
    section: "3, equations 3 to 6",
    words: "2k + 10",
    published_words: Some("2k + 6"),
    exact_when: "k >= f(p)",
    ties: "canonical: the smaller data word is nearer",
    needs: "acquire and release on a 32-bit word; forward progress of the lock's holder; 64-bit atomic add",
    wgsl: lock::WGSL,
    source: include_str!("hybrid.rs"),
    ..approximate("hybrid", Limit::EnoughK)
};

/// The method.
#[derive(Debug)]
pub struct Average;

/// With the exact product.
#[derive(Debug)]
pub struct Product;

/// Blended by arrival.
#[derive(Debug)]
pub struct ByArrival;

impl Variant for ByArrival {
    const CONTRACT: Contract = Contract {
        name: "kplus-array+tail",
        title: "k+-buffer, what has no room blended behind in the order of arrival",
        paper: "Vasilakis, Fudos 2014; nvpro-samples",
        section: "the samples' tail blending",
        words: "2k + 4",
        published_words: None,
        dependence: Dependence::Arrival,
        needs: "acquire and release on a 32-bit word; forward progress of the lock's holder; 64-bit compare-exchange",
        ..CONTRACT
    };
    const TAIL: Tail = Tail::Blended;
}

/// The tail's colour is not multiplied by its opacity.
#[derive(Debug)]
pub struct TailAlpha;

impl Variant for Average {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Product {
    const CONTRACT: Contract = Contract {
        name: "hybrid@product",
        title: "hybrid transparency, the tail's transmittance as the exact product",
        words: "2k + 12",
        published_words: None,
        ..CONTRACT
    };
    const TAIL: Tail = Tail::Product;
}

impl Variant for TailAlpha {
    const CONTRACT: Contract = Contract {
        name: "hybrid@tail-alpha",
        title: "Fault tail-alpha: the tail's colour is not multiplied by its opacity",
        form: Form::Mutation,
        ..CONTRACT
    };
    const OPACITY: bool = false;
}
