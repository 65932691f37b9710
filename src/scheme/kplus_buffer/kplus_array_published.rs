//! k+-buffer with a max-array exactly as published (Vasilakis, Fudos 2014, Algorithm 3 and section 3.2): K+B-Array.
//!
//! It differs from the correct form (`kplus_array`) in four ways, each of which may show: the cull test before the lock
//! reads counter and entry 0 as plain words; a fragment that replaces the farthest is written to entry 0 *before* the
//! new farthest is found and swapped there; the lock is released by a plain store; and comparisons are on depth alone,
//! so that of equal depths the first to arrive stays. The counter is raised before the element is in place
//! (`insert_empty(p.counter++)`).

use std::future::Future;
use std::marker::PhantomData;

use crate::fragment::{Fragment, data_of, depth_of, pair_key};
use crate::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Plain, Words, both};
use crate::scheme::contract::{Dependence, Form, Keeps};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// How the lock is taken and released.
pub trait Locking: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How it is taken.
    const LOCK: Order;
    /// How it is released.
    const UNLOCK: Access;
}

/// As published: nothing is ordered.
#[derive(Debug)]
pub enum PlainUnlock {}

/// Acquired and released, and nothing else mended: what then remains is the order of writes, and the unlocked test
/// on plain words.
#[derive(Debug)]
pub enum OrderedUnlock {}

/// The method.
#[derive(Debug)]
pub struct KPlusArrayPublished<L = PlainUnlock> {
    k: u32,
    semaphore: Words<Pixel, Atomic, u32>,
    counter: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
    locking: PhantomData<L>,
}

const CONTRACT: Contract = Contract {
    title: "k+-buffer: spin lock and max-array, as in Algorithm 3",
    section: "3.1, 3.2, Algorithms 1 and 3 (K+B-Array)",
    form: Form::Published,
    published_words: Some("2k + 2"),
    exact_when: "no two invocations of a pixel overlap, and depths differ",
    ties: "the first to arrive stays",
    needs: "32-bit atomic exchange; forward progress of the lock's holder",
    wgsl: Some("storage buffers; a data race"),
    source: include_str!("kplus_array_published.rs"),
    dependence: Dependence::ArrivalAndInterleaving,
    ..super::locked("kplus-array@published", Keeps::Nearest)
};

impl Locking for PlainUnlock {
    const CONTRACT: Contract = CONTRACT;
    const LOCK: Order = Order::Relaxed;
    const UNLOCK: Access = Access::Plain;
}

impl Locking for OrderedUnlock {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-array@published-fixed-unlock",
        "Fault published-fixed-unlock: as in Algorithm 3, but for an ordered lock",
        CONTRACT.exact_when,
    );
    const LOCK: Order = Order::Acquire;
    const UNLOCK: Access = Access::Atomic(Order::Release);
}

impl<L: Locking> Scheme for KPlusArrayPublished<L> {
    const CONTRACT: Contract = L::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            semaphore: layout.named("semaphore").lock(),
            counter: layout.named("counter").pixel(1),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            locking: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.plain_store(self.counter.at(pixel, 0), 0).await;
        mem.plain_store_to_atomic(self.semaphore.at(pixel, 0), 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let test = mem.block();
        if self.is_culled(mem, fragment).await {
            return Outcome::Culled;
        }
        mem.merge(test).await;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            let found = mem.exchange(self.semaphore.at(pixel, 0), 1, L::LOCK).await;
            if found == 0 {
                let count = mem.plain_load(self.counter.at(pixel, 0)).await;
                let outcome = if count < self.k {
                    self.insert_empty(mem, fragment, count).await
                } else if fragment.depth < mem.plain_load(self.depth.at(pixel, 0)).await {
                    self.insert_full(mem, fragment).await
                } else {
                    Outcome::Culled
                };
                mem.write(self.semaphore.at(pixel, 0), 0, L::UNLOCK).await;
                return outcome;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.plain_load(self.counter.at(pixel, 0)).await;
        for i in 0..count.min(self.k) {
            keys.push(pair_key(self.entry(mem, pixel, i).await));
        }
    }
}

impl<L> KPlusArrayPublished<L> {
    /// Algorithm 3, line 17.
    #[inline(always)]
    async fn is_culled<M: Memory>(&self, mem: &M, fragment: Fragment) -> bool {
        mem.plain_load(self.counter.at(fragment.pixel, 0)).await >= self.k
            && fragment.depth >= mem.plain_load(self.depth.at(fragment.pixel, 0)).await
    }

    #[inline(always)]
    async fn insert_empty<M: Memory>(&self, mem: &M, fragment: Fragment, count: u32) -> Outcome {
        let pixel = fragment.pixel;
        mem.plain_store(self.counter.at(pixel, 0), count + 1).await;
        self.put(mem, pixel, count, fragment.key()).await;
        if count > 0 {
            let first = pair_key(self.entry(mem, pixel, 0).await);
            if fragment.depth > depth_of(first) {
                self.put(mem, pixel, count, first).await;
                self.put(mem, pixel, 0, fragment.key()).await;
            }
        }
        Outcome::Kept
    }

    #[inline(always)]
    async fn insert_full<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        self.put(mem, pixel, 0, fragment.key()).await;
        let (mut place, mut farthest) = (0, fragment.depth);
        for i in 1..self.k {
            let depth = mem.plain_load(self.depth.at(pixel, i)).await;
            if depth > farthest {
                (place, farthest) = (i, depth);
            }
        }
        if place != 0 {
            let entry = pair_key(self.entry(mem, pixel, place).await);
            self.put(mem, pixel, place, fragment.key()).await;
            self.put(mem, pixel, 0, entry).await;
        }
        Outcome::Evicted
    }

    /// Depth and data word of an entry.
    #[inline(always)]
    #[track_caller]
    fn entry<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> impl Future<Output = (u32, u32)> {
        both(mem.plain_load(self.depth.at(pixel, i)), mem.plain_load(self.data.at(pixel, i)))
    }

    #[inline(always)]
    #[track_caller]
    fn put<M: Memory>(
        &self,
        mem: &M,
        pixel: u32,
        i: u32,
        entry: u64,
    ) -> impl Future<Output = ((), ())> {
        both(
            mem.plain_store(self.depth.at(pixel, i), depth_of(entry)),
            mem.plain_store(self.data.at(pixel, i), data_of(entry)),
        )
    }
}
