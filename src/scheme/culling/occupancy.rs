//! Occupancy-based fragment culling (Vasilakis, Fudos, occupancy-based fragment culling for the k+-buffer, 2014).
//!
//! ```text
//! range     per fragment   near = min(near, depth), far = max(far, depth)
//! mask      per fragment   the bit of the depth's interval, of 32 d uniform ones in [near, far]
//! resolve   per pixel      walk to the k-th set bit: the bound is the far end of its interval
//! ```
//!
//! The store pass of a method that keeps the k nearest then skips what lies behind the bound. None of the k nearest
//! does: k set bits are at least k fragments, none of which is behind the last one's far end. Where several fragments
//! share an interval, the walk ends farther away. A pixel with fewer than k set bits has no bound. With 32 d <= k
//! intervals, no bound is ever nearer than the farthest fragment: it is allowed, and in vain (the paper asks for
//! d > k / 32).
//!
//! Intervals are exact: depth z lies in interval floor((z - near) 32 d / (far - near + 1)), on whole depth words. The
//! paper says that "the bucket's depth is returned", which must be its far end (`@near-end` takes the other one).
//!
//! A pixel needs d + 3 words: near, far, the mask, and the bound, which here is an input of the store pass. Where the
//! mask takes words of the k-buffer, which is not in use yet, d - k + 3.

use std::collections::BTreeSet;
use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Declared, Input, Inputs, Layout, Memory, Order, Per, Pixel, Words};
use crate::scheme::contract::{Form, Keeps};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Depth, Outcome, Scheme};

/// The most words of a mask.
pub const MOST_WORDS: u32 = 256;

/// The input with the k of each pixel; 0 stands for `-k`.
pub const K: &str = "k";

/// What `near` is cleared to: no fragment is that far away.
const NOTHING: u32 = u32::MAX;

/// Uniform intervals between two depth words, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Intervals {
    near: u32,
    /// Depth words from near to far.
    range: u64,
    /// How many intervals; at least 1.
    count: u64,
}

impl Intervals {
    /// So many between near and far.
    #[inline]
    #[must_use]
    pub fn new(near: u32, far: u32, count: u32) -> Self {
        let range = u64::from(far.saturating_sub(near)) + 1;
        Self { near, range, count: u64::from(count.max(1)) }
    }

    /// The interval of a depth that is not nearer than the first and not farther than the last.
    #[inline]
    #[must_use]
    pub fn of(self, depth: u32) -> u32 {
        (u64::from(depth.saturating_sub(self.near)) * self.count / self.range) as u32
    }

    /// The first depth word of an interval.
    #[must_use]
    pub fn begin(self, interval: u32) -> u32 {
        self.near + (u64::from(interval) * self.range).div_ceil(self.count) as u32
    }

    /// The last depth word of an interval.
    #[inline]
    #[must_use]
    pub fn end(self, interval: u32) -> u32 {
        let next = (u64::from(interval) + 1) * self.range;
        // The far end is a word: at most far.
        self.near + (next.div_ceil(self.count) - 1) as u32
    }
}

/// What the walk gives of an interval and of the bits before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walk {
    /// The far end of the interval of the k-th set bit.
    FarEnd,
    /// Its near end.
    NearEnd,
    /// The far end of the interval before it.
    Before,
    /// The far end of the interval of the set bit before the k-th.
    Early,
}

/// The correct form, or another.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// What the walk gives.
    const WALK: Walk = Walk::FarEnd;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// The bound is the near end of its interval.
#[derive(Debug)]
pub enum NearEnd {}

/// The bound is one interval too near.
#[derive(Debug)]
pub enum OneTooNear {}

/// The walk ends a set bit too early.
#[derive(Debug)]
pub enum EndsEarly {}

const PASSES: &[Pass] = &[
    Pass::new("range", PassKind::Prepare, Barrier::Pixel),
    Pass { name: "mask", ..Pass::store(Barrier::Pixel) },
];

const CONTRACT: Contract = Contract {
    title: "a depth behind which none of the k nearest lies, from a mask of occupied intervals",
    section: "2, 3",
    paper: "Vasilakis, Fudos 2014 (culling)",
    program: Program::of(PASSES),
    words: "d + 2",
    needs: "32-bit atomic min, max, or; two geometry passes that generate the same fragments",
    wgsl: Some("storage buffers; atomicMin, atomicMax, atomicOr"),
    exact_when: "never: it keeps no fragments",
    ..Contract::new("occupancy", Keeps::Bound)
};

const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract { name, title, form: Form::Mutation, ..CONTRACT }
}

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for NearEnd {
    const CONTRACT: Contract =
        fault("occupancy@near-end", "Fault near-end: the bound is the near end of its interval");
    const WALK: Walk = Walk::NearEnd;
}

impl Variant for OneTooNear {
    const CONTRACT: Contract =
        fault("occupancy@one-too-near", "Fault one-too-near: the bound is one interval too near");
    const WALK: Walk = Walk::Before;
}

impl Variant for EndsEarly {
    const CONTRACT: Contract =
        fault("occupancy@ends-early", "Fault ends-early: the walk ends a set bit too early");
    const WALK: Walk = Walk::Early;
}

/// The passes.
#[derive(Debug)]
pub struct Occupancy<V = Correct> {
    k: u32,
    /// Words of the mask.
    words: u32,
    near: Words<Pixel, Atomic, u32>,
    far: Words<Pixel, Atomic, u32>,
    mask: Words<Pixel, Atomic, u32>,
    own_k: Input,
    variant: PhantomData<V>,
}

impl<V: Variant> Scheme for Occupancy<V> {
    const CONTRACT: Contract = Contract { source: include_str!("occupancy.rs"), ..V::CONTRACT };

    type Holds = Depth;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let words = config.mask_words.clamp(1, MOST_WORDS);
        let own_k = Declared { name: K, per: Per::Pixel, default: 0, tried: &[] };
        Self {
            k: config.k.unwrap_or(8),
            words,
            near: layout.named("near").pixel(1),
            far: layout.named("far").pixel(1),
            mask: layout.named("mask").pixel(words.into()),
            own_k: layout.input(own_k),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.near.at(pixel, 0), NOTHING, Order::Relaxed).await;
        mem.store(self.far.at(pixel, 0), 0, Order::Relaxed).await;
        for word in 0..self.words {
            mem.store(self.mask.at(pixel, word), 0, Order::Relaxed).await;
        }
    }

    /// The range pass.
    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        mem.min(self.near.at(fragment.pixel, 0), fragment.depth, Order::Relaxed).await;
        mem.max(self.far.at(fragment.pixel, 0), fragment.depth, Order::Relaxed).await;
    }

    /// The mask pass.
    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let near = mem.load(self.near.at(fragment.pixel, 0), Order::Relaxed).await;
        let far = mem.load(self.far.at(fragment.pixel, 0), Order::Relaxed).await;
        let interval = self.intervals(near, far).of(fragment.depth);
        let word = self.mask.at(fragment.pixel, interval / 32);
        mem.or(word, 1 << (interval % 32), Order::Relaxed).await;
        Outcome::Merged
    }

    fn expected(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Option<Depth> {
        let depths: Vec<u32> = generated.iter().map(|f| f.depth).collect();
        let (Some(&near), Some(&far)) = (depths.first(), depths.last()) else {
            return Some(Depth::default());
        };
        // Interval i holds depth z if i <= (z - near) count / range < i + 1.
        let (count, range) = (u128::from(self.words) * 32, u128::from(far - near) + 1);
        let place = |z: u32| u128::from(z - near) * count;
        let occupied: BTreeSet<u128> = depths.iter().map(|&z| place(z) / range).collect();
        let k = self.k(inputs.get(self.own_k.at(pixel)));
        let kth = occupied.iter().nth(k as usize - 1);
        let last = |&i: &u128| near + (((i + 1) * range - 1) / count) as u32;
        Some(kth.map_or_else(Depth::default, |i| Depth(last(i))))
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, bound: &mut Depth) {
        *bound = Depth::default();
        let near = mem.load(self.near.at(pixel, 0), Order::Relaxed).await;
        if near == NOTHING {
            return;
        }
        let far = mem.load(self.far.at(pixel, 0), Order::Relaxed).await;
        // Set bits still to be met, and the last one that was.
        let (mut left, mut met) = (self.k(mem.input(self.own_k.at(pixel))), 0);
        for word in 0..self.words {
            let mut bits = mem.load(self.mask.at(pixel, word), Order::Relaxed).await;
            while bits != 0 {
                let interval = 32 * word + bits.trailing_zeros();
                bits &= bits - 1;
                left -= 1;
                if left == 0 {
                    *bound = Depth(self.bound(self.intervals(near, far), interval, met));
                    return;
                }
                met = interval;
            }
        }
    }
}

impl<V: Variant> Occupancy<V> {
    /// From a pixel's own.
    fn k(&self, own: u32) -> u32 {
        if own == 0 { self.k.max(1) } else { own }
    }

    fn intervals(&self, near: u32, far: u32) -> Intervals {
        Intervals::new(near, far, 32 * self.words)
    }

    /// From the interval of the k-th set bit, and that of the set bit before it.
    fn bound(&self, intervals: Intervals, interval: u32, before: u32) -> u32 {
        match V::WALK {
            Walk::FarEnd => intervals.end(interval),
            Walk::NearEnd => intervals.begin(interval),
            Walk::Before => intervals.end(interval.saturating_sub(1)),
            Walk::Early => intervals.end(before),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::num::depth::FARTHEST;

    fn depths() -> impl Strategy<Value = Vec<u32>> {
        let depth = prop_oneof![
            0..=FARTHEST,
            (0..64u32).prop_map(|i| i << 26),
            0..40u32,
            (0..40u32).prop_map(|i| FARTHEST - i),
            (0..40u32).prop_map(|i| 0x7FFF_FFF0 + i),
        ];
        prop::collection::vec(depth, 1..40)
    }

    proptest! {
        /// Intervals follow one another without a gap, and each depth lies in its own.
        #[test]
        fn intervals_divide_the_range(a in 0..=FARTHEST, b in 0..=FARTHEST, z in 0..=FARTHEST, count in 1..300u32) {
            let (near, far) = (a.min(b), a.max(b));
            let intervals = Intervals::new(near, far, count);
            let z = z.clamp(near, far);
            let of = intervals.of(z);
            prop_assert!(of < count);
            prop_assert!(z <= intervals.end(of) && intervals.begin(of) <= z);
            prop_assert_eq!([intervals.begin(0), intervals.end(count - 1)], [near, far]);
            if of + 1 < count && intervals.end(of) < far {
                prop_assert_eq!(intervals.of(intervals.end(of) + 1) > of, true);
            }
        }

        /// No bound cuts one of the k nearest, and fragments at both ends of intervals are where they must be.
        #[test]
        fn a_bound_is_not_nearer_than_the_kth(mut depths in depths(), k in 1..70u32, words in 1..5u32, edges in any::<bool>()) {
            if edges {
                let (near, far) = (*depths.iter().min().unwrap(), *depths.iter().max().unwrap());
                let intervals = Intervals::new(near, far, 32 * words);
                let ends = depths.iter().map(|&z| intervals.end(intervals.of(z)));
                depths = ends.flat_map(|z| [z.saturating_sub(1).max(near), z, z.saturating_add(1).min(far)]).collect();
            }
            depths.sort_unstable();
            let config = Config { k: Some(k), pixels: 1, mask_words: words, ..Config::default() };
            let mut layout = Layout::default();
            let scheme = <Occupancy as Scheme>::new(&config, &mut layout);
            let inputs = Inputs::defaults(&layout);
            let keys: Vec<Fragment> =
                depths.iter().map(|&z| Fragment::of_key(u64::from(z) << 32)).collect();
            let Depth(bound) = scheme.expected(&inputs, 0, &keys).unwrap();
            let within = depths.iter().filter(|&&z| z <= bound).count();
            prop_assert!(within >= depths.len().min(k as usize), "{within} within {bound}");
        }
    }
}
