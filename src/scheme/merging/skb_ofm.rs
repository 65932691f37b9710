//! Merging on arrival: a k+-buffer (Vasilakis, Fudos 2014) whose records are slabs ("Fragment merging with
//! z-thickness", sections 3.2.2, 4.1.2 and 4.2).
//!
//! Under its pixel's lock, a fragment is merged with every record that its slab overlaps; these become one. If there is
//! none, it becomes a record of its own. Of the k records the last is the tail: where the k - 1 others are taken, the
//! farthest goes into it, or the fragment itself, by the mix operator. No fragment is culled.
//!
//! What depends on arrival, and what does not:
//! * Sums are integers ([`super::sums`]), so that a record is the same whatever the order of its fragments.
//! * Records are disjoint, and a fragment joins all that it overlaps. So chains (a overlaps b overlaps c) come out as
//!   one record in every order, as long as no record had to go into the tail before.
//! * What is in the tail cannot be told apart again. Where more than k - 1 slabs lie apart, what a later slab would have
//!   joined may be in the tail, or not. No method can do better in one pass and bounded memory ([`super::components`]).
//!
//! The paper keeps its array with the farthest in front ("max array"); here its depth is a word of its own, 0xFFFFFFFF
//! while there is room, so that what is mixed into the tail need not look at the records. Where the paper's text is
//! silent, this is what we do: a slab joins all that it overlaps, not the first it finds; as long as the tail is not
//! empty, what lies behind the tail's near end goes into it.
//!
//! * `@published`: the recurrence (8) in single precision.
//! * `@released`, as in the authors' shaders: only the first record that overlaps is joined; visibilities are stored as
//!   four bytes; P(z) is that of a far plane at 100, whatever the camera's.

use std::future::Future;
use std::marker::PhantomData;

use super::components::{Merged, Stored, add, components, never_overflows, records, with_tail};
use super::dfb_merged::stored;
use super::merging;
use super::sums::{Bytes, Floats, Integers, Logarithms, Mix, logarithms};
use crate::fragment::Fragment;
use crate::memory::{Access, Inputs, Layout, Memory, Order, Pixel, Plain, Words, both};
use crate::num::planes::Distances;
use crate::scheme::contract::{Dependence, Form, Overflow};
use crate::scheme::parts::lock::{self, FREE, SpinLock};
use crate::scheme::{Config, Contract, Outcome, Records, Scale, Scheme};

/// What differs between the forms.
pub trait Kind: Send + Sync + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// How a record is kept.
    type Mix: Mix;
    /// Only the first record that overlaps is joined.
    const FIRST_ONLY: bool = false;
    /// Slabs that touch overlap.
    const CLOSED: bool = false;
    /// What becomes of a fragment that has no room.
    const TAIL: Tail = Tail::Inside;
    /// The distance of the far plane that P(z) is computed with, if it is not the camera's.
    const FAR: Option<f64> = None;
}

/// How the tail is mixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tail {
    /// Under the lock, after the farthest was found.
    Inside,
    /// After the lock was released.
    Outside,
    /// With the fragment that arrives, near or far: nothing is evicted.
    NotEvicting,
}

/// The method.
#[derive(Debug)]
pub struct SkbOfm<K = Exact> {
    k: u32,
    distances: Distances,
    logarithms: Box<Logarithms>,
    /// The share of a slab's thickness that counts.
    scale: f64,
    lock: SpinLock,
    count: Words<Pixel, Plain, u32>,
    /// The farthest depth of k - 1 records; all ones while there are fewer.
    bound: Words<Pixel, Plain, u32>,
    near: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    sums: Words<Pixel, Plain, u64>,
    kind: PhantomData<K>,
}

/// While there is room.
const NONE: u32 = u32::MAX;

impl<K: Kind> Scheme for SkbOfm<K> {
    const CONTRACT: Contract = K::CONTRACT;

    type Holds = Records;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            distances: config.distances,
            logarithms: logarithms(),
            scale: K::FAR.filter(|_| config.merging.relative).map_or(1.0, |far| {
                let planes = config.distances.planes;
                let b = |far: f64| planes.near * far / (far - planes.near);
                b(planes.far) / b(far)
            }),
            lock: SpinLock::new(layout),
            count: layout.named("count").pixel(1),
            bound: layout.named("bound").pixel(1),
            near: layout.named("near").pixel(u64::from(k)),
            depth: layout.named("depth").pixel(u64::from(k)),
            sums: layout.named("sums").pixel(3 * u64::from(k)),
            kind: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.plain_store(self.count.at(pixel, 0), 0).await;
        mem.plain_store(self.bound.at(pixel, 0), NONE).await;
        mem.plain_store(self.sums.at(pixel, 3 * self.k - 1), 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
                let left = self.insert(mem, fragment).await;
                if K::TAIL == Tail::Outside {
                    self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                }
                if let Some(left) = left {
                    let (place, mut tail) = (self.k - 1, left);
                    if self.is_there(mem, pixel, place).await != 0 {
                        tail = merged(self.get(mem, pixel, place).await).with::<K::Mix>(left);
                    }
                    self.put(mem, pixel, place, tail).await;
                }
                if K::TAIL != Tail::Outside {
                    self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                }
                return Outcome::Kept;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    /// Where arrival does not matter; if only rounding makes it matter, what the canonical order gives. A fault is held
    /// to what the right form gives.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Records> {
        if K::CONTRACT.form == Form::Mutation {
            return self.settled::<Integers>(&stored(generated));
        }
        let mut slabs = stored(generated);
        slabs.iter_mut().zip(generated).for_each(|(slab, f)| slab.near = self.near_end(*f));
        self.settled::<K::Mix>(&slabs)
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, out: &mut Records) {
        out.scale = Scale(self.distances);
        let count = mem.plain_load(self.count.at(pixel, 0)).await;
        for i in 0..count.min(self.k - 1) {
            let record = merged(self.get(mem, pixel, i).await);
            add::<K::Mix>(out, &record, &self.distances);
        }
        if self.is_there(mem, pixel, self.k - 1).await != 0 {
            let record = merged(self.get(mem, pixel, self.k - 1).await);
            add::<K::Mix>(out, &record, &self.distances);
        }
    }
}

impl<K: Kind> SkbOfm<K> {
    /// The records of slabs that may come in any order.
    fn settled<M: Mix>(&self, slabs: &[Stored]) -> Option<Records> {
        let all = components::<M>(slabs, &self.logarithms);
        let apart = all.len() == slabs.len();
        let settled = self.k == 1 || apart || never_overflows(slabs, self.k - 1);
        settled.then(|| records::<M>(&with_tail::<M>(all, self.k), &self.distances))
    }

    /// Under the lock: take a fragment in, and give what has to go into the tail.
    #[inline(always)]
    async fn insert<M: Memory>(&self, mem: &M, fragment: Fragment) -> Option<Merged> {
        let pixel = fragment.pixel;
        let sums = K::Mix::one(fragment.data, &self.logarithms);
        let own = Merged { near: self.near_end(fragment), depth: fragment.depth, sums };
        let bound = mem.plain_load(self.bound.at(pixel, 0)).await;
        if self.k == 1 || (own.near >= bound && own.depth > bound) {
            return Some(own);
        }
        let mut count = mem.plain_load(self.count.at(pixel, 0)).await;
        let (mut new, mut joined) = (own, None);
        // The farthest record and its depth, and the depth of the next but one.
        let (mut farthest, mut first, mut second) = (NONE, 0, 0);
        let mut i = 0;
        while i < count {
            let depth = mem.plain_load(self.depth.at(pixel, i)).await;
            let mut near = depth;
            if depth > own.near || (K::CLOSED && depth == own.near) {
                near = mem.plain_load(self.near.at(pixel, i)).await;
            }
            let (from, to) = (near.max(own.near), depth.min(own.depth));
            let overlaps = from < to || (K::CLOSED && from == to);
            if overlaps && !(K::FIRST_ONLY && joined.is_some()) {
                new = merged(self.get(mem, pixel, i).await).with::<K::Mix>(new);
                if joined.is_none() {
                    joined = Some(i);
                    i += 1;
                } else {
                    // Two records become one: the last takes the free place, and is looked at next.
                    count -= 1;
                    if i < count {
                        let last = merged(self.get(mem, pixel, count).await);
                        self.put(mem, pixel, i, last).await;
                    }
                }
                continue;
            }
            let mut farther = farthest == NONE || depth > first;
            if !farther && depth == first {
                let [one, other] = [i, farthest];
                let one = merged(self.get(mem, pixel, one).await);
                let other = merged(self.get(mem, pixel, other).await);
                farther = one.order::<K::Mix>(&other).is_gt();
            }
            if farther {
                (farthest, first, second) = (i, depth, first);
            } else {
                second = second.max(depth);
            }
            i += 1;
        }
        let room = self.k - 1;
        let (mut place, mut left) = (count, None);
        if let Some(joined) = joined {
            place = joined;
        } else if count < room {
            if self.is_there(mem, pixel, room).await != 0
                && own.depth > mem.plain_load(self.near.at(pixel, room)).await
            {
                return Some(own);
            }
            count += 1;
        } else {
            let record = merged(self.get(mem, pixel, farthest).await);
            let nearer = own.order::<K::Mix>(&record).is_lt();
            if K::TAIL == Tail::NotEvicting || !nearer {
                return Some(own);
            }
            (place, left, first) = (farthest, Some(record), second);
        }
        self.put(mem, pixel, place, new).await;
        mem.plain_store(self.count.at(pixel, 0), count).await;
        let bound = if count < room { NONE } else { first.max(new.depth) };
        mem.plain_store(self.bound.at(pixel, 0), bound).await;
        left
    }

    /// The near end of a fragment's slab.
    #[inline(always)]
    fn near_end(&self, fragment: Fragment) -> u32 {
        if K::FAR.is_none() {
            return fragment.extra;
        }
        let thickness = f64::from(fragment.depth - fragment.extra) * self.scale;
        fragment.depth.saturating_sub(thickness.round_ties_even() as u32)
    }

    /// Not 0 if the tail, record `i`, holds anything.
    #[inline(always)]
    #[track_caller]
    fn is_there<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> impl Future<Output = u64> {
        mem.plain_load(self.sums.at(pixel, 3 * i + 2))
    }

    /// A record's words.
    #[inline(always)]
    #[track_caller]
    fn get<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> impl Future<Output = Words5> {
        // No array of futures: `map` is not inlined.
        let ends =
            both(mem.plain_load(self.near.at(pixel, i)), mem.plain_load(self.depth.at(pixel, i)));
        let last = both(
            mem.plain_load(self.sums.at(pixel, 3 * i + 1)),
            mem.plain_load(self.sums.at(pixel, 3 * i + 2)),
        );
        both(ends, both(mem.plain_load(self.sums.at(pixel, 3 * i)), last))
    }

    #[inline(always)]
    #[track_caller]
    fn put<M: Memory>(
        &self,
        mem: &M,
        pixel: u32,
        i: u32,
        Merged { near, depth, sums }: Merged,
    ) -> impl Future<Output = Stores> {
        let [a, b, c] = sums;
        let ends = both(
            mem.plain_store(self.near.at(pixel, i), near),
            mem.plain_store(self.depth.at(pixel, i), depth),
        );
        let last = both(
            mem.plain_store(self.sums.at(pixel, 3 * i + 1), b),
            mem.plain_store(self.sums.at(pixel, 3 * i + 2), c),
        );
        both(ends, both(mem.plain_store(self.sums.at(pixel, 3 * i), a), last))
    }
}

/// What reading a record gives.
type Words5 = ((u32, u32), (u64, (u64, u64)));

/// What writing one gives.
type Stores = (((), ()), ((), ((), ())));

#[inline(always)]
fn merged(((near, depth), (a, (b, c))): Words5) -> Merged {
    Merged { near, depth, sums: [a, b, c] }
}

const CONTRACT: Contract = Contract {
    title: "k+-buffer that merges overlapping slabs on arrival, with a tail",
    section: "3.2.2, 3.3.2, 4.1.2, 4.2",
    words: "8k + 3",
    published_words: Some("4k + 1"),
    exact_when: "k >= f(p) and no slabs overlap",
    dependence: Dependence::Arrival,
    ties: "canonical among surfaces of equal depth; slabs of equal depth are merged",
    overflow: Overflow::Never("the farthest record is mixed into the tail, the last record"),
    needs: lock::NEEDS,
    wgsl: lock::WGSL,
    source: include_str!("skb_ofm.rs"),
    ..merging("skb+ofm")
};

const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract { name, title, form: Form::Mutation, ..CONTRACT }
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident: $mix:ty, $contract:expr $(, $const:ident: $type:ty = $value:expr)*;)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name;

        impl Kind for $name {
            const CONTRACT: Contract = $contract;
            type Mix = $mix;
            $(const $const: $type = $value;)*
        }
    )*};
}

kinds! {
    /// The method.
    Exact: Integers, CONTRACT;
    /// As published.
    Published: Floats, Contract {
        name: "skb+ofm@published",
        title: "as published: colour and opacity by the recurrence, in single precision",
        form: Form::Published,
        ..CONTRACT
    };
    /// As in the authors' shaders.
    Released: Bytes, Contract {
        name: "skb+ofm@released",
        title: "as the authors' shaders: one overlap, four bytes, a far plane at 100",
        section: "the authors' shaders",
        form: Form::Published,
        ..CONTRACT
    }, FIRST_ONLY: bool = true, FAR: Option<f64> = Some(100.0);
    /// The tail is mixed outside of the critical section.
    TailOutside: Integers, fault(
        "skb+ofm@M10", "Fault M10: the tail is mixed after the lock is released"
    ), TAIL: Tail = Tail::Outside;
    /// Nothing is evicted into the tail.
    NotEvicting: Integers, fault(
        "skb+ofm@M10-arrival", "Fault M10: what arrives is mixed into the tail, near or far"
    ), TAIL: Tail = Tail::NotEvicting;
    /// Four bytes in mid-stream.
    EightBits: Bytes, fault(
        "skb+ofm@M15", "Fault M15: colour and opacity are rounded to 8 bits at every merge"
    );
    /// Only the first record that overlaps is joined.
    FirstOnly: Integers, fault(
        "skb+ofm@first-overlap", "Fault first-overlap: only the first record that overlaps is joined"
    ), FIRST_ONLY: bool = true;
    /// Slabs that touch are merged.
    Closed: Integers, fault(
        "skb+ofm@closed", "Fault closed: slabs that only touch are merged"
    ), CLOSED: bool = true;
}
