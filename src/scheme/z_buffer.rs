//! The Z-buffer: the nearest fragment only, by one 64-bit atomic minimum on (depth, data), which also settles ties in
//! canonical order. Hardware does the same with its depth test.

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Barriers, Demand, Form, Keeps};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// Depth in the upper half of one word per pixel, data in the lower.
#[derive(Debug)]
pub struct ZBuffer {
    nearest: Words<Pixel, Atomic, u64>,
}

const CLEARED: u64 = (EMPTY as u64) << 32 | 0xFFFF_FFFF;

impl Scheme for ZBuffer {
    const CONTRACT: Contract = Contract {
        name: "z-buffer",
        title: "Nearest fragment only",
        paper: "Catmull 1974",
        section: "k+-buffer paper, 3.4 (k = 1)",
        form: Form::Correct,
        passes: 1,
        words: "2",
        keeps: Keeps::One,
        exact_when: "always (k = 1)",
        arrival_dependent: false,
        racy: false,
        ties: "canonical: the smaller data word stays",
        overflow: "none",
        needs: "64-bit atomic min, relaxed",
        wgsl: Some("the device's depth test, or 64-bit atomicMin where there is one"),
        depth_format: None,
        default_k: None,
        max_k: u32::MAX,
        demand: Demand::Nothing,
        barriers: Barriers::ALL,
        source: include_str!("z_buffer.rs"),
    };

    fn new(_: &Config, layout: &mut Layout) -> Self {
        Self { nearest: layout.pixel(1) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.nearest.at(pixel, 0), CLEARED, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let old = mem.min(self.nearest.at(fragment.pixel, 0), fragment.key(), Order::Relaxed).await;
        if old == CLEARED {
            Outcome::Kept
        } else if fragment.key() < old {
            Outcome::Evicted
        } else {
            Outcome::Culled
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let nearest = mem.load(self.nearest.at(pixel, 0), Order::Relaxed).await;
        if nearest < key(EMPTY, 0) {
            keys.push(nearest);
        }
    }
}
