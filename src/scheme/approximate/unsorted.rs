//! No order at all: OVER in the order of submission, later fragments in front. What an engine without order-independent
//! transparency shows when its objects are not sorted.
//!
//! A blending unit is ordered: here by the ordered interlock. Colour and transmittance have 16 bits, as compositing has
//! them ([`Ray`]).

use super::{approximate, arrivals};
use crate::fragment::Fragment;
use crate::memory::{Inputs, Layout, Memory, Pixel, Plain, Words};
use crate::num::ray::Ray;
use crate::scheme::contract::{Dependence, Extra, Limit};
use crate::scheme::parts::interlock::Interlock;
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// The method.
#[derive(Debug)]
pub struct BlendUnsorted {
    interlock: Interlock,
    /// Red, green, blue and transmittance so far.
    words: Words<Pixel, Plain, u32>,
}

impl BlendUnsorted {
    async fn get<M: Memory>(&self, mem: &M, pixel: u32) -> Ray {
        let mut words = [0; 4];
        for (i, word) in (0..).zip(&mut words) {
            *word = mem.plain_load(self.words.at(pixel, i)).await;
        }
        let [r, g, b, transmittance] = words;
        Ray { color: [r, g, b], transmittance }
    }

    async fn put<M: Memory>(&self, mem: &M, pixel: u32, ray: Ray) {
        let [r, g, b] = ray.color;
        for (i, word) in (0..).zip([r, g, b, ray.transmittance]) {
            mem.plain_store(self.words.at(pixel, i), word).await;
        }
    }
}

impl Scheme for BlendUnsorted {
    const CONTRACT: Contract = Contract {
        title: "blending in the order of submission, without any sort",
        paper: "Porter, Duff 1984",
        section: "OVER",
        words: "4",
        published_words: Some("1"),
        exact_when: "fragments are submitted from back to front, within rounding",
        ties: "the later one is in front",
        dependence: Dependence::Arrival,
        needs: "ordered blending: the fixed-function unit, or the ordered interlock",
        extra: Extra::Rank,
        source: include_str!("unsorted.rs"),
        ..approximate("blend-unsorted", Limit::Nowhere)
    };

    type Holds = Light;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { interlock: Interlock::new(layout), words: layout.named("words").pixel(4) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.interlock.clear(mem, pixel).await;
        self.put(mem, pixel, Ray::default()).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let _turns = mem.block();
        let mark = mem.mark();
        loop {
            let turn = mem.block();
            if self.interlock.turn(mem, fragment).await == fragment.extra {
                let behind = self.get(mem, fragment.pixel).await;
                self.put(mem, fragment.pixel, behind.behind(fragment.data)).await;
                self.interlock.leave(mem, fragment).await;
                return Outcome::Merged;
            }
            mem.merge(turn).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        *held = self.get(mem, pixel).await.light();
    }

    /// One fragment has no order.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        match generated {
            [] => Some(Light::default()),
            [only] => Some(Ray::default().behind(only.data).light()),
            _ => None,
        }
    }

    fn possible(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Vec<Light> {
        let of = |order: Vec<Fragment>| {
            order.iter().fold(Ray::default(), |ray, f| ray.behind(f.data)).light()
        };
        arrivals(generated).map(of).collect()
    }
}
