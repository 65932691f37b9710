//! Stencil-routed k-buffer (Myers, Bavoil, "Stencil routed A-buffer", 2007; Bavoil, Myers 2008; KB-SR): the i-th
//! fragment to arrive goes to sample i of a multisampled target.
//!
//! Every sample has a stencil value, cleared to i + 2. A fragment covers all samples; a sample takes it if its stencil
//! is 2, and every stencil is then lowered by one, but not below 0. So each fragment is taken by one sample, and those
//! beyond the last sample by none: what overflows depends on arrival, not on depth. Stencil test, stencil update and
//! write of one fragment are fixed function, and ordered: that is what the interlock stands for.

use crate::fragment::Fragment;
use crate::fragment::key;
use crate::memory::{Layout, Memory, Pixel, Plain, Words};
use crate::scheme::contract::{Demand, Dependence, Extra, Form, Keeps, Overflow};
use crate::scheme::parts::interlock::Interlock;
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// The stencil value of the sample that takes the next fragment.
const TAKES: u32 = 2;

/// Samples of a pixel that any device has.
const MAX_SAMPLES: u32 = 32;

/// The method.
#[derive(Debug)]
pub struct KbStencilRouted {
    samples: u32,
    interlock: Interlock,
    stencil: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
}

impl Scheme for KbStencilRouted {
    const CONTRACT: Contract = Contract {
        title: "stencil-routed k-buffer: the first n fragments to arrive",
        paper: "Myers, Bavoil 2007; Bavoil, Myers 2008",
        section: "k+-buffer paper, 2 (KB-SR)",
        form: Form::Published,
        words: "3n",
        published_words: Some("3n"),
        exact_when: "f(p) <= n; n is -k, or measured, and at most 32",
        overflow: Overflow::Drops("drop by arrival, counted"),
        needs: "fixed-function stencil in API order (the ordered interlock here)",
        max_k: MAX_SAMPLES,
        demand: Demand::MaxDepthComplexity,
        source: include_str!("kb_sr.rs"),
        extra: Extra::Rank,
        dependence: Dependence::Arrival,
        ..Contract::new("kb-sr", Keeps::FirstArrivals)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let samples = config.k.unwrap_or(config.max_depth_complexity).min(MAX_SAMPLES);
        let count = u64::from(samples);
        Self {
            samples,
            interlock: Interlock::new(layout),
            stencil: layout.named("stencil").pixel(count),
            depth: layout.named("depth").pixel(count),
            data: layout.named("data").pixel(count),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.interlock.clear(mem, pixel).await;
        for i in 0..self.samples {
            mem.plain_store(self.stencil.at(pixel, i), i + TAKES).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let _turns = mem.block();
        let mark = mem.mark();
        loop {
            let turn = mem.block();
            if self.interlock.turn(mem, fragment).await == fragment.extra {
                let mut outcome = Outcome::Overflow;
                for i in 0..self.samples {
                    let stencil = mem.plain_load(self.stencil.at(pixel, i)).await;
                    if stencil == TAKES {
                        mem.plain_store(self.depth.at(pixel, i), fragment.depth).await;
                        mem.plain_store(self.data.at(pixel, i), fragment.data).await;
                        outcome = Outcome::Kept;
                    }
                    mem.plain_store(self.stencil.at(pixel, i), stencil.saturating_sub(1)).await;
                }
                self.interlock.leave(mem, fragment).await;
                return outcome;
            }
            mem.merge(turn).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..self.samples {
            if mem.plain_load(self.stencil.at(pixel, i)).await < TAKES {
                let depth = mem.plain_load(self.depth.at(pixel, i)).await;
                keys.push(key(depth, mem.plain_load(self.data.at(pixel, i)).await));
            }
        }
    }
}
