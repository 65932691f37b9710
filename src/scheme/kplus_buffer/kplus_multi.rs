//! The memory-bounded A-buffer (Vasilakis, Fudos, "k+-buffer", 2014, section 3.4): every fragment is kept, by rounds of
//! a k+-buffer over what lies behind the farthest fragment of the round before. There are ceil(max f / k) of them, and
//! one more where k divides f.
//!
//! The paper has one sentence on it. Here a round is a max-array under a spin lock as in `kplus-array`; and fragments
//! identical to the farthest, of which a round may have room for only some, are counted in the next one, which emits
//! the rest.

use std::iter::repeat_n;
use std::marker::PhantomData;

use crate::fragment::{Fragment, pair_key};
use crate::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use crate::scheme::contract::{Accounting, Keeps, Overflow};
use crate::scheme::parts::lock::{FREE, SpinLock};
use crate::scheme::parts::max_array::{append, replace};
use crate::scheme::parts::slots::{OfPixel, entry};
use crate::scheme::program::{Barrier, Pass, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// Where a pixel that has all its fragments goes on: behind every key.
const DONE: u64 = u64::MAX;

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether what is identical to the farthest and found no room is emitted in the next round.
    const REST: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// Identical fragments at the cut between two rounds are lost.
#[derive(Debug)]
pub enum Cut {}

/// The method.
#[derive(Debug)]
pub struct KPlusMulti<V = Correct> {
    k: u32,
    /// The smallest key of this round; behind the first round, the last farthest key plus 1.
    from: Words<Pixel, Plain, u64>,
    /// How many fragments of the last farthest key are emitted, and how many there are.
    emitted: Words<Pixel, Plain, u32>,
    equal: Words<Pixel, Atomic, u32>,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    depth: Words<Pixel, Atomic, u32>,
    data: Words<Pixel, Plain, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "Memory-bounded A-buffer: rounds of a k+-buffer",
    section: "3.4",
    program: Program::repeated(&[Pass::store(Barrier::Pixel)]),
    words: "2k + 6",
    overflow: Overflow::Never("the farthest wait for the next round"),
    needs: "acquire and release on a 32-bit word; forward progress of the lock's holder; a query whether any pixel goes on",
    default_k: Some(8),
    max_k: u32::MAX / 4,
    source: include_str!("kplus_multi.rs"),
    accounting: Accounting::Judged,
    ..super::locked("kplus-multi", Keeps::All)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Cut {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-multi@cut",
        "Fault cut: fragments identical to the farthest of a round are lost where it has no room for all",
        "fragments of a pixel differ",
    );
    const REST: bool = false;
}

impl<V: Variant> Scheme for KPlusMulti<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            from: layout.named("from").pixel(1),
            emitted: layout.named("emitted").pixel(1),
            equal: layout.named("equal").pixel(1),
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        self.begin(mem, pixel, 0, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (pixel, key) = (fragment.pixel, fragment.key());
        let (slots, counter) = (self.slots(pixel), self.counter.at(pixel, 0));
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        let equals = mem.block();
        if key + 1 == from {
            mem.add(self.equal.at(pixel, 0), 1, Order::Relaxed).await;
        }
        mem.merge(equals).await;
        if key < from {
            return Outcome::Kept;
        }
        let test = mem.block();
        let full = mem.load(counter, Order::Acquire).await == self.k;
        if full && fragment.depth > mem.load(self.depth.at(pixel, 0), Order::Relaxed).await {
            return Outcome::Kept;
        }
        mem.merge(test).await;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
                let count = mem.load(counter, Order::Relaxed).await;
                if count < self.k {
                    append::<_, _, Self>(mem, slots, count, key).await;
                    mem.store(counter, count + 1, Order::Release).await;
                } else if key < pair_key(entry(mem, slots, 0).await) {
                    replace::<_, _, Self>(mem, slots, count, key).await;
                }
                self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                return Outcome::Kept;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        let equal = mem.load(self.equal.at(pixel, 0), Order::Relaxed).await;
        let emitted = mem.plain_load(self.emitted.at(pixel, 0)).await;
        let rest = if V::REST { equal.saturating_sub(emitted) } else { 0 };
        keys.extend(repeat_n(from.wrapping_sub(1), rest as usize));
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        let first = keys.len();
        for i in 0..count {
            keys.push(pair_key(entry(mem, self.slots(pixel), i).await));
        }
        // Only a full array has left anything out.
        let farthest = keys.get(first).copied().filter(|_| count == self.k);
        let from = farthest.map_or(DONE, |farthest| farthest + 1);
        let emitted = keys[first..].iter().filter(|&&key| Some(key) == farthest).count() as u32;
        self.begin(mem, pixel, from, emitted).await;
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        mem.plain_load(self.from.at(pixel, 0)).await != DONE
    }
}

impl<V> KPlusMulti<V> {
    fn slots(&self, pixel: u32) -> OfPixel {
        OfPixel { depth: self.depth, data: self.data, pixel }
    }
}

impl<V: Variant> KPlusMulti<V> {
    /// Begin a round at a key; of the one before, so many are emitted.
    async fn begin<M: Memory>(&self, mem: &M, pixel: u32, from: u64, emitted: u32) {
        mem.plain_store(self.from.at(pixel, 0), from).await;
        mem.plain_store(self.emitted.at(pixel, 0), emitted).await;
        mem.store(self.equal.at(pixel, 0), 0, Order::Relaxed).await;
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }
}
