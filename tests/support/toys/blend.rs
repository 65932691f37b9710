//! A method without lists: blending by weighted average (Bavoil, Myers, "Order independent transparency with dual depth
//! peeling", 2008, section on single-pass approximations). A pixel holds sums of integers, which no order changes.

use fragloom::fragment::Fragment;
use fragloom::memory::{Atomic, Inputs, Layout, Memory, Order, Pixel, Words};
use fragloom::render::Data;
use fragloom::scheme::contract::{Form, Limit};
use fragloom::scheme::{Config, Contract, Keeps, Light, Outcome, Scheme};

/// The method; without `ATOMIC`, a sum is raised by a load and a store.
pub(crate) struct BlendAverage<const ATOMIC: bool> {
    /// Sums over fragments: red, green and blue by opacity, opacity, and 1.
    sums: Words<Pixel, Atomic, u32>,
}

/// What a fragment adds.
fn terms(color: u32) -> [u32; 5] {
    let [r, g, b, a] = color.to_le_bytes().map(u32::from);
    [r * a, g * a, b * a, a, 1]
}

/// What a pixel's sums stand for.
fn average(sums: [u32; 5]) -> Light {
    let [r, g, b, a, count] = sums.map(f64::from);
    if a == 0.0 {
        return Light::default();
    }
    let clear = 1.0 - a / (255.0 * count);
    let transmittance = (0..sums[4]).fold(1.0, |product, _| product * clear);
    let color = [r, g, b].map(|c| c / (255.0 * a) * (1.0 - transmittance));
    Light { color, transmittance, kept: 0 }
}

impl<const ATOMIC: bool> Scheme for BlendAverage<ATOMIC> {
    const CONTRACT: Contract = Contract {
        words: "5",
        data: Some(Data::Color),
        source: include_str!("blend.rs"),
        form: if ATOMIC { Form::Correct } else { Form::Mutation },
        ..Contract::new(
            if ATOMIC { "blend-average" } else { "blend-average@load-store" },
            Keeps::Approximate(Limit::Nowhere),
        )
    };

    type Holds = Light;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { sums: layout.pixel(5) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..5 {
            mem.store(self.sums.at(pixel, i), 0, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        for (i, term) in (0..).zip(terms(fragment.data)) {
            let sum = self.sums.at(fragment.pixel, i);
            if ATOMIC {
                mem.add(sum, term, Order::Relaxed).await;
            } else {
                let old = mem.load(sum, Order::Relaxed).await;
                mem.store(sum, old + term, Order::Relaxed).await;
            }
        }
        Outcome::Merged
    }

    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        let mut sums = [0; 5];
        for fragment in generated {
            let terms = terms(fragment.data);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        Some(average(sums))
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, light: &mut Light) {
        let mut sums = [0; 5];
        for (i, sum) in (0..).zip(&mut sums) {
            *sum = mem.load(self.sums.at(pixel, i), Order::Relaxed).await;
        }
        *light = average(sums);
    }
}
