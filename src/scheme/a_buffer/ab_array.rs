//! A-buffer in fixed arrays (FreePipe): an atomic counter per pixel hands out slots.
//!
//! With n slots per pixel, the first n fragments to arrive stay; later ones are counted and dropped. Without `-k`, n is
//! the scene's largest depth complexity, so that all stay.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use crate::scheme::contract::{Demand, Dependence, Keeps, Overflow};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// How slots are handed out, and up to which.
pub trait Ticket: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether the counter is raised by one atomic operation.
    const ATOMIC: bool = true;
    /// Whether the slot number n, one beyond the pixel's own, is refused.
    const BOUNDED: bool = true;
}

/// `atomicAdd`, as published.
#[derive(Debug)]
pub enum AtomicAdd {}

/// A load and a store: two invocations may get the same slot.
#[derive(Debug)]
pub enum LoadStore {}

/// M14: the bound test lets slot n through, which is the next pixel's first.
#[derive(Debug)]
pub enum OneTooMany {}

/// The method.
#[derive(Debug)]
pub struct AbArray<T> {
    slots: u32,
    counter: Words<Pixel, Atomic, u32>,
    records: Words<Pixel, Plain, u64>,
    form: PhantomData<T>,
}

const CONTRACT: Contract = Contract {
    title: "A-buffer in fixed arrays of n slots",
    paper: "Liu, Huang, Liu, Wu 2010 (FreePipe); Crassin 2010a",
    section: "k+-buffer paper, 2",
    words: "2n + 1",
    exact_when: "n >= max f(p); n is -k, or measured",
    overflow: Overflow::Drops("drop by arrival, counted"),
    needs: "32-bit atomic add, relaxed",
    wgsl: Some("storage buffers; atomicAdd"),
    demand: Demand::MaxDepthComplexity,
    source: include_str!("ab_array.rs"),
    dependence: Dependence::Arrival,
    ..Contract::new("ab-array", Keeps::FirstArrivals)
};

impl Ticket for AtomicAdd {
    const CONTRACT: Contract = CONTRACT;
}

impl Ticket for LoadStore {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-array@plain-counter",
        "Fault plain-counter: the counter is raised by a load and a store",
        "no two invocations of a pixel overlap",
    );
    const ATOMIC: bool = false;
}

impl Ticket for OneTooMany {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-array@M14",
        "Fault M14: the bound test lets one slot too many through",
        CONTRACT.exact_when,
    );
    const BOUNDED: bool = false;
}

impl<T: Ticket> Scheme for AbArray<T> {
    const CONTRACT: Contract = T::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let slots = config.k.unwrap_or(config.max_depth_complexity);
        let counter = layout.named("counter").pixel(1);
        let records = layout.named("records").pixel(u64::from(slots));
        Self { slots, counter, records, form: PhantomData }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let counter = self.counter.at(fragment.pixel, 0);
        let slot = if T::ATOMIC {
            mem.add(counter, 1, Order::Relaxed).await
        } else {
            let slot = mem.load(counter, Order::Relaxed).await;
            mem.store(counter, slot + 1, Order::Relaxed).await;
            slot
        };
        let beyond = if T::BOUNDED { slot >= self.slots } else { slot > self.slots };
        if beyond {
            return Outcome::Overflow;
        }
        mem.plain_store(self.records.at(fragment.pixel, slot), fragment.key()).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        for slot in 0..count.min(self.slots) {
            keys.push(mem.plain_load(self.records.at(pixel, slot)).await);
        }
    }
}
