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
//! A record of one fragment needs its colour word alone: it stands in the last word of the sums, and the others are not
//! written.
//!
//! The paper keeps its array with the farthest in front ("max array"); here its depth is a word of its own, 0xFFFFFFFF
//! while there is room, so that what is mixed into the tail need not look at the records. Where the paper's text is
//! silent, this is what we do: a slab joins all that it overlaps, not the first it finds; as long as the tail is not
//! empty, what lies behind the tail's near end goes into it.
//!
//! * `@published`: the recurrence (8) in single precision.
//! * `@released`, as in the authors' shaders: only the first record that overlaps is joined; visibilities are stored as
//!   four bytes; P(z) is that of a far plane at 100, whatever the camera's.

pub mod forms;

use std::future::Future;
use std::marker::PhantomData;

use super::components::{Merged, Stored, components, never_overflows, put, records, with_tail};
use super::dfb_merged::stored;
use super::sums::{Integers, Logarithms, Mix, logarithms};
use crate::fragment::{Fragment, key};
use crate::memory::{Access, Inputs, Layout, Memory, Order, Pixel, Plain, Words, both};
use crate::num::planes::Distances;
use crate::scheme::contract::Form;
use crate::scheme::parts::lock::{FREE, SpinLock};
use crate::scheme::{Config, Contract, Outcome, Records, Scale, Scheme, Whole};

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
pub struct SkbOfm<K> {
    k: u32,
    distances: Distances,
    logarithms: Box<Logarithms>,
    /// The share of a slab's thickness that counts.
    scale: f64,
    lock: SpinLock,
    count: Words<Pixel, Plain, u32>,
    /// The farthest depth of k - 1 records; [`NONE`] or [`AGAIN`] while there are fewer.
    bound: Words<Pixel, Plain, u32>,
    near: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    /// The first two words of a record's sums.
    sums: Words<Pixel, Plain, u64>,
    /// The last one.
    last: Words<Pixel, Plain, u64>,
    kind: PhantomData<K>,
}

/// While there is room, and nothing in the tail.
const NONE: u32 = u32::MAX;

/// While there is room again: something may be in the tail. No fragment lies behind it.
const AGAIN: u32 = u32::MAX - 1;

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
            sums: layout.named("sums").pixel(2 * u64::from(k)),
            last: layout.named("last").pixel(u64::from(k)),
            kind: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.plain_store(self.count.at(pixel, 0), 0).await;
        mem.plain_store(self.bound.at(pixel, 0), NONE).await;
        mem.plain_store(self.last.at(pixel, self.k - 1), 0).await;
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
                    let last = self.last(mem, pixel, place).await;
                    if last != 0 {
                        tail = self
                            .merged(last, self.get(mem, pixel, place, last).await)
                            .with::<K::Mix>(left);
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
        let count = mem.plain_load(self.count.at(pixel, 0)).await.min(self.k - 1);
        // Records, and then the tail.
        let tail = self.k - 1;
        let first = out.spread(count as usize);
        let mut next = if count == 0 { tail } else { 0 };
        while next <= tail {
            let i = next;
            next = if i + 1 == count { tail } else { i + 1 };
            let last = mem.plain_load(self.last.at(pixel, i)).await;
            if i == tail && last == 0 {
                break;
            }
            let place = if i == tail { out.spread(1) } else { first + i as usize };
            let near = mem.plain_load(self.near.at(pixel, i)).await;
            let depth = mem.plain_load(self.depth.at(pixel, i)).await;
            if let Some(word) = K::Mix::single(last) {
                out.put(place, Whole { key: key(depth, word), near });
                continue;
            }
            let a = mem.plain_load(self.sums.at(pixel, 2 * i)).await;
            let b = mem.plain_load(self.sums.at(pixel, 2 * i + 1)).await;
            let merged = Merged { near, depth, sums: [a, b, last] };
            put::<K::Mix>(out, place, &merged, &self.distances);
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
        let (near, depth) = (self.near_end(fragment), fragment.depth);
        let bound = mem.plain_load(self.bound.at(pixel, 0)).await;
        if self.k == 1 || (near >= bound && depth > bound) {
            return Some(self.own(fragment));
        }
        let count = mem.plain_load(self.count.at(pixel, 0)).await;
        let room = self.k - 1;
        // The farthest counts only where there is no room left, now or after this fragment.
        let fills = count + 1 >= room;
        // Most fragments lie apart, and there is room: they take a short way.
        if count < room && bound == NONE && !self.overlaps(mem, fragment, near, count).await {
            mem.plain_store(self.near.at(pixel, count), near).await;
            mem.plain_store(self.depth.at(pixel, count), depth).await;
            match K::Mix::kept_single(fragment.data) {
                Some(last) => mem.plain_store(self.last.at(pixel, count), last).await,
                None => drop(self.put(mem, pixel, count, self.own(fragment)).await),
            }
            mem.plain_store(self.count.at(pixel, 0), count + 1).await;
            if fills {
                let (mut farthest, mut i) = (depth, 0);
                while i < count {
                    farthest = mem.plain_load(self.depth.at(pixel, i)).await.max(farthest);
                    i += 1;
                }
                mem.plain_store(self.bound.at(pixel, 0), farthest).await;
            }
            return None;
        }
        mem.part(self.join(mem, fragment, count, bound)).await
    }

    /// Where a fragment may overlap others, or there is no room: the long way. Apart from the short one, which is
    /// faster without its state.
    async fn join<M: Memory>(
        &self,
        mem: &M,
        fragment: Fragment,
        mut count: u32,
        bound: u32,
    ) -> Option<Merged> {
        let (pixel, room) = (fragment.pixel, self.k - 1);
        let fills = count + 1 >= room;
        let own = self.own(fragment);
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
                let last = self.last(mem, pixel, i).await;
                new = self.merged(last, self.get(mem, pixel, i, last).await).with::<K::Mix>(new);
                if joined.is_none() {
                    joined = Some(i);
                    i += 1;
                } else {
                    // Two records become one: the last takes the free place, and is looked at next.
                    count -= 1;
                    if i < count {
                        let last = self.last(mem, pixel, count).await;
                        let last = self.merged(last, self.get(mem, pixel, count, last).await);
                        self.put(mem, pixel, i, last).await;
                    }
                }
                continue;
            }
            if !fills {
                i += 1;
                continue;
            }
            let mut farther = farthest == NONE || depth > first;
            if !farther && depth == first {
                let [one, other] = [i, farthest];
                let last = self.last(mem, pixel, one).await;
                let one = self.merged(last, self.get(mem, pixel, one, last).await);
                let last = self.last(mem, pixel, other).await;
                let other = self.merged(last, self.get(mem, pixel, other, last).await);
                farther = one.order::<K::Mix>(&other).is_gt();
            }
            if farther {
                (farthest, first, second) = (i, depth, first);
            } else {
                second = second.max(depth);
            }
            i += 1;
        }
        let (mut place, mut left) = (count, None);
        if let Some(joined) = joined {
            place = joined;
        } else if count < room {
            if bound != NONE
                && self.last(mem, pixel, room).await != 0
                && own.depth > mem.plain_load(self.near.at(pixel, room)).await
            {
                return Some(own);
            }
            count += 1;
        } else {
            let last = self.last(mem, pixel, farthest).await;
            let record = self.merged(last, self.get(mem, pixel, farthest, last).await);
            let nearer = own.order::<K::Mix>(&record).is_lt();
            if K::TAIL == Tail::NotEvicting || !nearer {
                return Some(own);
            }
            (place, left, first) = (farthest, Some(record), second);
        }
        self.put(mem, pixel, place, new).await;
        mem.plain_store(self.count.at(pixel, 0), count).await;
        if fills {
            let bound = match bound {
                _ if count == room => first.max(new.depth),
                NONE => NONE,
                _ => AGAIN,
            };
            mem.plain_store(self.bound.at(pixel, 0), bound).await;
        }
        left
    }

    /// Whether a slab overlaps any of the first `count` records. A surface overlaps nothing.
    #[inline(always)]
    async fn overlaps<M: Memory>(
        &self,
        mem: &M,
        Fragment { pixel, depth, .. }: Fragment,
        near: u32,
        count: u32,
    ) -> bool {
        if near == depth && !K::CLOSED {
            return false;
        }
        let mut i = 0;
        while i < count {
            let far = mem.plain_load(self.depth.at(pixel, i)).await;
            if far > near || (K::CLOSED && far == near) {
                let from = mem.plain_load(self.near.at(pixel, i)).await.max(near);
                let to = far.min(depth);
                if from < to || (K::CLOSED && from == to) {
                    return true;
                }
            }
            i += 1;
        }
        false
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

    /// The last word of record `i`. That of the tail is 0 if it holds nothing.
    #[inline(always)]
    #[track_caller]
    fn last<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> impl Future<Output = u64> {
        mem.plain_load(self.last.at(pixel, i))
    }

    /// The other words of a record with that last word; what it has no use for is not read.
    #[inline(always)]
    #[track_caller]
    fn get<M: Memory>(
        &self,
        mem: &M,
        pixel: u32,
        i: u32,
        last: u64,
    ) -> impl Future<Output = Words4> {
        let sum = |n: u32| match K::Mix::single(last) {
            // In its place, what was read already: no word is read that was never written.
            Some(_) => self.last.at(pixel, i),
            None => self.sums.at(pixel, 2 * i + n),
        };
        // No array of futures: `map` is not inlined.
        let ends =
            both(mem.plain_load(self.near.at(pixel, i)), mem.plain_load(self.depth.at(pixel, i)));
        both(ends, both(mem.plain_load(sum(0)), mem.plain_load(sum(1))))
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
        let [a, b, _] = sums;
        let c = K::Mix::kept(sums);
        let ends = both(
            mem.plain_store(self.near.at(pixel, i), near),
            mem.plain_store(self.depth.at(pixel, i), depth),
        );
        let last = both(
            mem.plain_store(self.sums.at(pixel, 2 * i + 1), b),
            mem.plain_store(self.last.at(pixel, i), c),
        );
        both(ends, both(mem.plain_store(self.sums.at(pixel, 2 * i), a), last))
    }

    /// A fragment as a record.
    #[inline(always)]
    fn own(&self, fragment: Fragment) -> Merged {
        let sums = K::Mix::one(fragment.data, &self.logarithms);
        Merged { near: self.near_end(fragment), depth: fragment.depth, sums }
    }

    /// A record of its words.
    #[inline(always)]
    fn merged(&self, last: u64, ((near, depth), (a, b)): Words4) -> Merged {
        let sums = match K::Mix::single(last) {
            Some(word) => K::Mix::one(word, &self.logarithms),
            None => [a, b, last],
        };
        Merged { near, depth, sums }
    }
}

/// What reading a record gives, but for its last word.
type Words4 = ((u32, u32), (u64, u64));

/// What writing one gives.
type Stores = (((), ()), ((), ((), ())));
