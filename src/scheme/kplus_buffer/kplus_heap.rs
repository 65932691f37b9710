//! k+-buffer with a max-heap (Vasilakis, Fudos 2014; K+B-Heap): as the max-array (`kplus_array`), with a structure
//! that finds the new farthest in O(log k) instead of O(k).
//!
//! The correct form guards the unlocked test in the same way: the counter is raised by a release store after the record
//! is in place, and the root goes from the old farthest record to the new one in one write
//! ([`max_heap`]). `kplus-heap@published` is Algorithms 1 to 3 as printed: the counter is raised first, records are
//! swapped up and down, the lock is released by a plain store, only depths are compared.

use std::marker::PhantomData;

use crate::fragment::{Fragment, pair_key};
use crate::memory::{Access, Atomic, Layout, Memory, Order, Pixel, Plain, Snapshot, Words};
use crate::scheme::contract::{Dependence, Form, Keeps};
use crate::scheme::parts::lock::reach::{Reach, Updated, updated};
use crate::scheme::parts::lock::{FREE, SpinLock};
use crate::scheme::parts::max_heap;
use crate::scheme::parts::max_heap::By;
use crate::scheme::parts::slots::{OfPixel, Slots, entry, settled};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The correct form, the published one, or a fault.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How the lock's holder reaches the records.
    type Reach: Reach;
    /// How the lock is taken.
    const LOCK: Order = <Self::Reach as Reach>::ACQUIRE;
    /// How it is released, if not as that way has it.
    const UNLOCK: Option<Access> = None;
    /// How counter and root are read before the lock, if not as that way has it.
    const TEST: Option<Access> = None;
    /// How the counter is raised, if not as that way has it.
    const RAISE: Option<Access> = None;
    /// Whether a record is in place before the counter is raised.
    const RECORD_FIRST: bool = true;
    /// Whether records make room for the new one, instead of being swapped with it.
    const BY_HOLE: bool = true;
    /// How records are compared.
    const COMPARED: By = By::Key;
    /// Whether a full heap takes what is nearer.
    const EVICTS: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// As in Algorithms 1 to 3.
#[derive(Debug)]
pub enum Published {}

/// M6: the counter is read before the lock without acquire.
#[derive(Debug)]
pub enum RelaxedCounter {}

/// The new record is swapped down from the root, where others are culled against it.
#[derive(Debug)]
pub enum RootFirst {}

/// M1: the lock is released by a plain store.
#[derive(Debug)]
pub enum PlainUnlock {}

/// M8: what arrives at a full heap is dropped.
#[derive(Debug)]
pub enum DropsByArrival {}

/// M9: equal depth is culled, so that the first to arrive stays.
#[derive(Debug)]
pub enum EqualDepthStops {}

/// The method.
#[derive(Debug)]
pub struct KPlusHeap<V: Variant = Correct> {
    k: u32,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    depth: Words<Pixel, Atomic, u32>,
    data: Words<Pixel, <V::Reach as Reach>::Kind, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "k+-buffer: spin lock and max-heap",
    section: "3.1, 3.2, Algorithms 1 to 3 (K+B-Heap)",
    published_words: Some("2k + 2"),
    source: include_str!("kplus_heap.rs"),
    ..super::locked("kplus-heap", Keeps::Nearest)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
    type Reach = Plain;
}

impl Variant for Atomic {
    const CONTRACT: Contract =
        CONTRACT.mended("kplus-heap@atomic", "k+-buffer: spin lock and max-heap, all words atomic");
    type Reach = Self;
}

impl Variant for Updated {
    const CONTRACT: Contract = updated(
        CONTRACT,
        "kplus-heap@rmw",
        "k+-buffer: spin lock and max-heap, all accesses updates",
    );
    type Reach = Self;
}

impl Variant for Published {
    const CONTRACT: Contract = Contract {
        name: "kplus-heap@published",
        title: "k+-buffer: spin lock and max-heap, as in Algorithms 2 and 3",
        form: Form::Published,
        exact_when: "no two invocations of a pixel overlap, and depths differ",
        ties: "the first to arrive stays",
        needs: "32-bit atomic exchange; forward progress of the lock's holder",
        wgsl: Some("storage buffers; a data race"),
        dependence: Dependence::ArrivalAndInterleaving,
        ..CONTRACT
    };
    const LOCK: Order = Order::Relaxed;
    const UNLOCK: Option<Access> = Some(Access::Plain);
    const TEST: Option<Access> = Some(Access::Plain);
    const RAISE: Option<Access> = Some(Access::Plain);
    const RECORD_FIRST: bool = false;
    const BY_HOLE: bool = false;
    const COMPARED: By = By::Depth;
    type Reach = Plain;
}

impl Variant for RelaxedCounter {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-heap@M6",
        "Fault M6: the counter is read before the lock without acquire",
        "under sequential consistency only",
    );
    const TEST: Option<Access> = Some(Access::Atomic(Order::Relaxed));
    type Reach = Plain;
}

impl Variant for RootFirst {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-heap@root-first",
        "Fault root-first: the new record is swapped down from the root",
        "no two invocations of a pixel overlap",
    );
    const BY_HOLE: bool = false;
    type Reach = Plain;
}

impl Variant for PlainUnlock {
    const CONTRACT: Contract = CONTRACT.fault(
        "kplus-heap@M1",
        "Fault M1: unlock by a plain store",
        "under sequential consistency only",
    );
    const UNLOCK: Option<Access> = Some(Access::Plain);
    type Reach = Plain;
}

impl Variant for DropsByArrival {
    const CONTRACT: Contract = Contract {
        dependence: Dependence::ArrivalAndInterleaving,
        ..CONTRACT.fault("kplus-heap@M8", "Fault M8: overflow drops by arrival", "f(p) <= k")
    };
    const EVICTS: bool = false;
    type Reach = Plain;
}

impl Variant for EqualDepthStops {
    const CONTRACT: Contract =
        CONTRACT.fault("kplus-heap@M9", "Fault M9: equal depth is culled", "depths differ");
    const COMPARED: By = By::Depth;
    type Reach = Plain;
}

impl<V: Variant> Scheme for KPlusHeap<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (pixel, new) = (fragment.pixel, fragment.key());
        let (heap, counter) = (self.heap(pixel), self.counter.at(pixel, 0));
        let test = mem.block();
        let seen = match V::TEST {
            None => mem.load(counter, V::Reach::ACQUIRE).await,
            Some(access) => mem.read(counter, access).await,
        };
        if seen == self.k {
            let root = match V::TEST {
                None => V::Reach::load(mem, heap.depth(0), V::Reach::ACQUIRE).await,
                Some(access) => mem.read(heap.depth(0), access).await,
            };
            // Among equal depths the data word decides, and only the lock's holder may read it.
            if fragment.depth > root || (V::COMPARED == By::Depth && fragment.depth == root) {
                return Outcome::Culled;
            }
        }
        mem.merge(test).await;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, V::LOCK).await == FREE {
                let count = V::Reach::load(mem, counter, Order::Relaxed).await;
                let mut outcome = Outcome::Culled;
                if count < self.k {
                    if !V::RECORD_FIRST {
                        match V::RAISE {
                            None => {
                                V::Reach::store(mem, counter, count + 1, Order::Release).await;
                            }
                            Some(access) => mem.write(counter, count + 1, access).await,
                        }
                    }
                    if V::BY_HOLE {
                        max_heap::append::<_, _, Self>(mem, heap, count, new).await;
                    } else {
                        max_heap::append_by_swaps(mem, heap, count, new, V::COMPARED).await;
                    }
                    if V::RECORD_FIRST {
                        match V::RAISE {
                            None => {
                                V::Reach::store(mem, counter, count + 1, Order::Release).await;
                            }
                            Some(access) => mem.write(counter, count + 1, access).await,
                        }
                    }
                    outcome = Outcome::Kept;
                } else {
                    let root = pair_key(entry(mem, heap, 0).await);
                    let nearer = V::COMPARED.of(new) < V::COMPARED.of(root);
                    if nearer && V::EVICTS {
                        if V::BY_HOLE {
                            max_heap::replace::<_, _, Self>(mem, heap, self.k, new).await;
                        } else {
                            max_heap::replace_by_swaps(mem, heap, self.k, new, V::COMPARED).await;
                        }
                        outcome = Outcome::Evicted;
                    }
                }
                match V::UNLOCK {
                    None => _ = V::Reach::release(mem, self.lock, pixel).await,
                    Some(access) => self.lock.release(mem, pixel, access).await,
                }
                return outcome;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    /// While the lock is free, no record is farther than its parent.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, _: Moment) -> Result<(), String> {
        if self.lock.is_held(words, pixel)? != Some(false) {
            return Ok(());
        }
        let heap = self.heap(pixel);
        let Some(count) = words.get(self.counter.at(pixel, 0)) else { return Ok(()) };
        if count > self.k {
            return Err(format!("the counter is {count}, of {}", self.k));
        }
        let record = |i| {
            let (depth, data) = (words.get(heap.depth(i))?, words.get(heap.data(i))?);
            Some(V::COMPARED.of(pair_key((depth, data))))
        };
        for i in 0..count {
            let Some(own) = record(i) else {
                return Err(format!("record {i} of {count} was never written"));
            };
            if i > 0 && Some(own) > record((i - 1) / 2) {
                return Err(format!("record {i} is farther than its parent"));
            }
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        for i in 0..count.min(self.k) {
            keys.push(pair_key(settled(mem, self.heap(pixel), i).await));
        }
    }
}

impl<V: Variant> KPlusHeap<V> {
    fn heap(&self, pixel: u32) -> OfPixel<V::Reach> {
        OfPixel { depth: self.depth, data: self.data, pixel }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fragment::{data_of, depth_of};
    use crate::scheme::parts::hand_made::HandMade;

    fn pixel(records: &[u64]) -> HandMade<KPlusHeap> {
        let mut pixel = HandMade::<KPlusHeap>::new(Some(4), 0);
        let (lock, counter) = (pixel.scheme.lock.word(0), pixel.scheme.counter.at(0, 0));
        pixel.set(lock, FREE);
        pixel.set(counter, records.len() as u32);
        for (i, &record) in (0..).zip(records) {
            let heap = pixel.scheme.heap(0);
            pixel.set(heap.depth(i), depth_of(record));
            pixel.set(heap.data(i), data_of(record));
        }
        pixel
    }

    #[test]
    fn heaps_pass() {
        for records in [&[][..], &[5], &[9, 9, 3, 9], &[9, 4, 8, 3]] {
            assert_eq!(pixel(records).check(Moment::Always), Ok(()));
        }
    }

    #[test]
    fn what_is_no_heap_is_found() {
        let message = pixel(&[5, 4, 9]).check(Moment::Always).unwrap_err();
        assert!(message.contains("record 2 is farther"), "{message}");
        let message = pixel(&[9, 4, 5, 6]).check(Moment::Always).unwrap_err();
        assert!(message.contains("record 3 is farther"), "{message}");
        let mut full = pixel(&[9, 8, 7, 6]);
        let counter = full.scheme.counter.at(0, 0);
        full.set(counter, 5);
        let message = full.check(Moment::Always).unwrap_err();
        assert!(message.contains("counter is 5"), "{message}");
    }
}
