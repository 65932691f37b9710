//! An approximation with a limit: the nearest k fragments of a pixel are blended front to back, and what is behind them
//! is left out. A pixel holds a colour; with a k for all of its fragments, it is the exact one.

use fragloom::fragment::{Fragment, data_of};
use fragloom::memory::{Atomic, Inputs, Layout, Memory, Order, Pixel, Words};
use fragloom::render::Data;
use fragloom::resolve::composite::Ray;
use fragloom::scheme::contract::Limit;
use fragloom::scheme::{Config, Contract, Keeps, Light, Outcome, Scheme};

/// An entry that holds nothing.
const EMPTY: u64 = u64::MAX;

/// The method: entries in order by atomic minima, as `kb-mdt64` has them.
pub(crate) struct BlendNearest {
    k: u32,
    entries: Words<Pixel, Atomic, u64>,
}

/// The colour of these fragments, nearest first.
fn blend(keys: impl IntoIterator<Item = u64>) -> Light {
    let (mut ray, mut kept) = (Ray::default(), 0);
    for key in keys {
        ray.over(data_of(key));
        kept += 1;
    }
    Light { kept, ..ray.light() }
}

impl Scheme for BlendNearest {
    const CONTRACT: Contract = Contract {
        words: "2k",
        data: Some(Data::Color),
        source: include_str!("blend_nearest.rs"),
        ..Contract::new("blend-nearest", Keeps::Approximate(Limit::EnoughK))
    };

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self { k, entries: layout.pixel(k.into()) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.k {
            mem.store(self.entries.at(pixel, i), EMPTY, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let mut carried = fragment.key();
        for i in 0..self.k {
            let entry = self.entries.at(fragment.pixel, i);
            carried = carried.max(mem.min(entry, carried, Order::Relaxed).await);
            if carried == EMPTY {
                return Outcome::Kept;
            }
        }
        if carried == fragment.key() { Outcome::Culled } else { Outcome::Evicted }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, light: &mut Light) {
        let mut keys = Vec::new();
        for i in 0..self.k {
            keys.push(mem.load(self.entries.at(pixel, i), Order::Relaxed).await);
        }
        *light = blend(keys.into_iter().take_while(|&key| key != EMPTY));
    }

    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        Some(blend(generated.iter().map(|f| f.key()).take(self.k as usize)))
    }
}
