//! k-buffer with a k for every pixel, by importance (Vasilakis et al., "Variable k-buffer using importance maps", 2017).
//!
//! The frame has M records. A pixel p gets k(p) of them, its share of the importance of all pixels, in one contiguous
//! range, and keeps its k(p) nearest fragments there, by the steps of the k+-buffer: a max-array, or a max-heap where
//! k(p) > 16 and the pixel has more fragments than that. (Small instances reach the heap in `kplus-sb@heap`, whose store
//! pass is this one's: [`locked_row`].)
//!
//! ```text
//! count         per fragment   N(p) fragments
//! importance    per pixel      q(p) = round(2^16 I(p)); block sum += q(p)
//! sum, twice    frame          Q = sum of all q(p)
//! k             per pixel      k(p) = floor(q(p) M / Q); block sum += k(p)
//! sum, twice    frame          where ranges begin
//! place         per pixel      where its own begins
//! store         per fragment   into the pixel's range
//! ```
//!
//! I(p) = max(0, F(p) D(p) + B(p)) with D(p) = α + (1 - α) min(1, N(p) / `N_limit`) (equations 3 and 6). The factor F
//! (periphery, Fresnel term, a map) and the bias B (noise) are inputs: nothing in them depends on this frame's
//! fragments. They and all that follows are integers in units of 2^-16, so that no order of addition matters, and
//! Σ k(p) <= M holds exactly: Σ floor(q M / Q) <= Σ q M / Q = M.
//!
//! What differs from the paper, and why:
//! * It divides floats. A float quotient over a sum that was rounded elsewhere can exceed M (`@float-quotient`).
//! * A pixel without fragments has no importance. Equation 3 gives it α, and records that nothing can fill.
//!
//! Ranges have at most 2^31 - 1 records, since a start and a flag share a word ([`Ranges`]).

pub mod faults;

use std::marker::PhantomData;

use super::kplus_sb::ARRAY_UP_TO;
use crate::fragment::{Fragment, pair_key};
use crate::memory::{
    Atomic, Declared, Global, Input, Inputs, Layout, Memory, Order, Per, Pixel, Plain, Snapshot,
    Words,
};
use crate::scheme::contract::{Demand, Keeps};
use crate::scheme::parts::lock::{self, SpinLock};
use crate::scheme::parts::locked_row::{self, Row};
use crate::scheme::parts::ranges::{self, Ranges};
use crate::scheme::parts::slots::{OfFrame, entry};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// An importance of 1.
pub const ONE: u32 = 1 << 16;

/// The largest `N_limit`.
pub const MOST_LAYERS: u32 = 65_535;

/// The most records of a frame.
pub const MOST_RECORDS: u64 = (1 << 31) - 1;

/// The input with the factors that this frame's fragments have no part in, 0 to [`ONE`] per pixel.
pub const FACTOR: &str = "importance";

/// The input with what is added at last, two's complement, at most [`ONE`] either way, per pixel.
pub const BIAS: &str = "importance-bias";

/// Their numbers among the method's inputs.
pub const FACTOR_INPUT: usize = 0;
/// See [`FACTOR_INPUT`].
pub const BIAS_INPUT: usize = 1;

/// Blocks of a group.
const RADIX: u64 = 64;

/// Numbers of the program's passes.
const IMPORTANCE: usize = 1;
const SUM_BLOCKS: usize = 2;
const SUM_GROUPS: usize = 3;
const SHARE: usize = 4;
const RANGE_BLOCKS: usize = 5;

const COUNT_PASS: Pass = Pass::new("count", PassKind::Prepare, Barrier::Pixel);
const IMPORTANCE_PASS: Pass = Pass::new("importance", PassKind::Screen, Barrier::Pixel);
const SUMS: [Pass; 2] = [
    Pass::new("sum blocks", PassKind::Frame, Barrier::Frame),
    Pass::new("sum groups", PassKind::Frame, Barrier::Frame),
];
const SHARE_PASS: Pass = Pass::new("k", PassKind::Screen, Barrier::Frame);
const PLACE_PASS: Pass = Pass::new("place", PassKind::Screen, Barrier::Frame);

/// The passes as published.
const PASSES: &[Pass] = &[
    COUNT_PASS,
    IMPORTANCE_PASS,
    SUMS[0],
    SUMS[1],
    SHARE_PASS,
    SUMS[0],
    SUMS[1],
    PLACE_PASS,
    Pass::store(Barrier::Pixel),
];

/// How a pixel's number of fragments becomes importance (equation 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Weighting {
    /// α, in units of 2^-16, up to [`ONE`]: the importance of a pixel with hardly any fragments. With [`ONE`], their
    /// number does not matter.
    pub alpha: u32,
    /// `N_limit`, 1 to [`MOST_LAYERS`]: more fragments make a pixel no more important.
    pub limit: u32,
}

impl Default for Weighting {
    /// The ends of the paper's ranges at which the number of fragments matters most.
    fn default() -> Self {
        Self { alpha: ONE / 4, limit: 30 }
    }
}

impl Weighting {
    /// q(p), at most twice [`ONE`].
    #[inline]
    #[must_use]
    pub fn weight(self, factor: u32, bias: u32, count: u32) -> u32 {
        if count == 0 {
            return 0;
        }
        let [factor, alpha] = [factor, self.alpha].map(|x| x.min(ONE));
        let limit = self.limit.clamp(1, MOST_LAYERS);
        // Neither product exceeds 32 bits.
        let layers = ((ONE - alpha) * count.min(limit) + limit / 2) / limit;
        let depth = alpha + layers;
        let product = if factor == ONE { depth } else { (factor * depth + ONE / 2) / ONE };
        let bias = (bias as i32).clamp(-(ONE as i32), ONE as i32);
        (product as i32 + bias).max(0) as u32
    }
}

/// How a share is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quotient {
    /// Rounded down, in integers.
    Floor,
    /// Rounded to the nearest.
    Nearest,
    /// As the paper's shader: in floats, over a sum of importances that were rounded to 1/50.
    Float,
}

/// The correct form, or another.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How k(p) is computed.
    const QUOTIENT: Quotient = Quotient::Floor;
    /// Whether this frame's fragments are counted; otherwise, what the last frame left is taken for their number.
    const COUNTS: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

const CONTRACT: Contract = Contract {
    title: "k+-buffer with k by importance: array or heap per pixel, in one budget",
    section: "3, equations 1 to 6",
    paper: "Vasilakis et al. 2017",
    program: Program::of(PASSES),
    words: "4",
    frame_words: "2M + 2G + 2H + 2",
    wgsl: lock::WGSL,
    needs: "acquire and release on a 32-bit word; forward progress of the lock's holder; two geometry passes that \
            generate the same fragments",
    demand: Demand::Records,
    exact_when: "k(p) >= f(p)",
    ..Contract::new("k-variable", Keeps::NearestChosen)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

/// The method.
#[derive(Debug)]
pub struct KVariable<V = Correct> {
    weighting: Weighting,
    records: u64,
    lock: SpinLock,
    counter: Words<Pixel, Atomic, u32>,
    /// q(p), then k(p).
    share: Words<Pixel, Plain, u32>,
    ranges: Ranges,
    blocks: Words<Global, Atomic, u32>,
    groups: Words<Global, Plain, u32>,
    total: Words<Global, Plain, u64>,
    depth: Words<Global, Atomic, u32>,
    data: Words<Global, Plain, u32>,
    factor: Input,
    bias: Input,
    variant: PhantomData<V>,
}

impl<V: Variant> Scheme for KVariable<V> {
    const CONTRACT: Contract = Contract { source: include_str!("k_variable.rs"), ..V::CONTRACT };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let records = config.records.min(MOST_RECORDS);
        let blocks = u64::from(config.pixels).div_ceil(RADIX);
        let input = |name, default, tried| Declared { name, per: Per::Pixel, default, tried };
        Self {
            weighting: config.weighting,
            records,
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            share: layout.named("share").pixel(1),
            ranges: Ranges::new(config, layout),
            blocks: layout.named("blocks").global(blocks),
            groups: layout.named("groups").global(blocks.div_ceil(RADIX)),
            total: layout.named("total").global(1),
            depth: layout.named("depth").global(records),
            data: layout.named("data").global(records),
            factor: layout.input(input(FACTOR, ONE, &[6_700, ONE])),
            bias: layout.input(input(BIAS, 0, &[])),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.ranges.clear_frame(mem).await;
        for block in 0..self.blocks.count() {
            mem.store(self.blocks.at(block), 0, Order::Relaxed).await;
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        if V::COUNTS {
            mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
        }
    }

    /// The count pass.
    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        if V::COUNTS {
            mem.add(self.counter.at(fragment.pixel, 0), 1, Order::Relaxed).await;
        }
    }

    fn counts(&self, _: usize) -> Option<Words<Pixel, Atomic, u32>> {
        V::COUNTS.then_some(self.counter)
    }

    async fn screen<M: Memory>(&self, mem: &M, pass: usize, pixel: u32) {
        match pass {
            IMPORTANCE => self.weigh(mem, pixel).await,
            SHARE => self.divide(mem, pixel).await,
            _ => self.place(mem, pixel).await,
        }
    }

    fn invocations(&self, pass: usize) -> u32 {
        match pass {
            SUM_BLOCKS => self.groups.count() as u32,
            SUM_GROUPS => 1,
            _ => self.ranges.invocations(of_ranges(pass)),
        }
    }

    async fn frame<M: Memory>(&self, mem: &M, pass: usize, index: u32) {
        match pass {
            SUM_BLOCKS => self.sum_blocks(mem, u64::from(index)).await,
            SUM_GROUPS => self.sum_groups(mem).await,
            _ => self.ranges.sum(mem, of_ranges(pass), index).await,
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let k = mem.plain_load(self.share.at(pixel, 0)).await;
        if k == 0 {
            return Outcome::Culled;
        }
        let (first, crowded) = self.ranges.placed::<_, Self>(mem, pixel).await;
        let slots: OfFrame = OfFrame { depth: self.depth, data: self.data, first };
        let heap = crowded && k > ARRAY_UP_TO;
        let counter = self.counter.at(pixel, 0);
        let row = Row { slots, k, heap, lock: self.lock, counter };
        let gone = mem.part(locked_row::insert::<_, _, Self>(mem, row, fragment)).await;
        locked_row::outcome(fragment, gone)
    }

    /// Ranges end where the records do.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        if moment != Moment::Quiet {
            return Ok(());
        }
        let k = words.get(self.share.at(pixel, 0)).unwrap_or(0);
        let Some(start) = self.ranges.seen(words, pixel).filter(|_| k > 0) else { return Ok(()) };
        let (end, records) = (start + u64::from(k), self.records);
        if end > records {
            return Err(format!(
                "the shares exceed the budget: a range ends at {end} of {records}"
            ));
        }
        Ok(())
    }

    fn chosen(&self, inputs: &Inputs, counts: &[u32]) -> Vec<u32> {
        let weight = |(pixel, &count): (u32, &u32)| {
            let [factor, bias] = [self.factor, self.bias].map(|i| inputs.get(i.at(pixel)));
            self.weighting.weight(factor, bias, count)
        };
        let weights: Vec<u32> = (0..).zip(counts).map(weight).collect();
        let total: u128 = weights.iter().map(|&q| u128::from(q)).sum();
        let share = |&q: &u32| {
            let exact = u128::from(q) * u128::from(self.records);
            exact.checked_div(total).unwrap_or(0) as u32
        };
        weights.iter().map(share).collect()
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        if count > 0 {
            let (first, _) = self.ranges.placed::<_, ()>(mem, pixel).await;
            let slots: OfFrame = OfFrame { depth: self.depth, data: self.data, first };
            for i in 0..count {
                keys.push(pair_key(entry(mem, slots, i).await));
            }
        }
    }
}

/// The pass of [`ranges::PASSES`] that one of ours is.
fn of_ranges(pass: usize) -> usize {
    pass.saturating_sub(RANGE_BLOCKS) + ranges::BLOCKS
}

impl<V: Variant> KVariable<V> {
    /// The importance pass.
    async fn weigh<M: Memory>(&self, mem: &M, pixel: u32) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        let factor = mem.input(self.factor.at(pixel));
        let bias = mem.input(self.bias.at(pixel));
        let weight = self.weighting.weight(factor, bias, count);
        mem.plain_store(self.share.at(pixel, 0), weight).await;
        if weight > 0 {
            let block = self.blocks.at(u64::from(pixel) / RADIX);
            let summed = if V::QUOTIENT == Quotient::Float { fiftieths(weight) } else { weight };
            mem.add(block, summed, Order::Relaxed).await;
        }
    }

    /// The pass that computes k(p). From here on, the counter counts what is stored.
    async fn divide<M: Memory>(&self, mem: &M, pixel: u32) {
        let weight = mem.plain_load(self.share.at(pixel, 0)).await;
        if weight > 0 {
            let total = mem.plain_load(self.total.at(0)).await;
            let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
            let k = self.share(weight, total);
            mem.plain_store(self.share.at(pixel, 0), k).await;
            if k > 0 {
                self.ranges.refer(mem, pixel, k, count > k).await;
            }
        }
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn place<M: Memory>(&self, mem: &M, pixel: u32) {
        if mem.plain_load(self.share.at(pixel, 0)).await > 0 {
            self.ranges.place(mem, pixel).await;
        }
    }

    fn share(&self, weight: u32, total: u64) -> u32 {
        let exact = u64::from(weight).wrapping_mul(self.records);
        match V::QUOTIENT {
            Quotient::Floor => exact.checked_div(total).unwrap_or(0) as u32,
            Quotient::Nearest => (exact + total / 2).checked_div(total).unwrap_or(0) as u32,
            Quotient::Float => {
                let part = weight as f32 / ONE as f32 * 50.0 / (total as f32).max(1.0);
                (part * self.records as f32) as u32
            }
        }
    }

    async fn sum_blocks<M: Memory>(&self, mem: &M, group: u64) {
        let (first, mut sum) = (group * RADIX, 0u32);
        for block in first..self.blocks.count().min(first + RADIX) {
            let more = mem.load(self.blocks.at(block), Order::Relaxed).await;
            sum = sum.wrapping_add(more);
        }
        mem.plain_store(self.groups.at(group), sum).await;
    }

    async fn sum_groups<M: Memory>(&self, mem: &M) {
        let mut sum = 0u64;
        for group in 0..self.groups.count() {
            sum += u64::from(mem.plain_load(self.groups.at(group)).await);
        }
        mem.plain_store(self.total.at(0), sum).await;
    }
}

/// An importance in units of 1/50, rounded to the nearest.
fn fiftieths(weight: u32) -> u32 {
    (weight * 50 + ONE / 2) / ONE
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The same in real numbers.
    fn real(weighting: Weighting, factor: u32, bias: u32, count: u32) -> f64 {
        let one = f64::from(ONE);
        let alpha = f64::from(weighting.alpha) / one;
        let layers = (f64::from(count) / f64::from(weighting.limit)).min(1.0);
        let depth = alpha + (1.0 - alpha) * layers;
        (f64::from(factor) / one * depth + f64::from(bias as i32) / one).max(0.0)
    }

    proptest! {
        /// Each of two roundings is by half a unit at most.
        #[test]
        fn weights_are_the_equations(
            alpha in 0..=ONE, limit in 1..=MOST_LAYERS, factor in 0..=ONE, bias in -3_300..=3_300i32,
            count in 1..200_000u32,
        ) {
            let weighting = Weighting { alpha, limit };
            let weight = weighting.weight(factor, bias as u32, count);
            let exact = real(weighting, factor, bias as u32, count) * f64::from(ONE);
            prop_assert!((f64::from(weight) - exact).abs() <= 1.0, "{weight} {exact}");
            prop_assert!(weight <= 2 * ONE);
        }

        /// No sum of shares exceeds the budget, and what is left is less than a record for each pixel.
        #[test]
        fn shares_stay_within_the_budget(
            factors in prop::collection::vec(prop_oneof![Just(0), Just(1), Just(ONE), 0..=ONE], 1..200),
            counts in prop::collection::vec(prop_oneof![Just(0u32), Just(1), 0..300u32], 200),
            records in prop_oneof![0..50u64, 0..=MOST_RECORDS],
        ) {
            let pixels = factors.len() as u32;
            let config = Config { pixels, records, ..Config::default() };
            let mut layout = Layout::default();
            let scheme = <KVariable as Scheme>::new(&config, &mut layout);
            let mut inputs = Inputs::defaults(&layout);
            inputs.fill(0, factors.clone());
            let counts = &counts[..factors.len()];
            let shares = scheme.chosen(&inputs, counts);
            let sum: u64 = shares.iter().map(|&k| u64::from(k)).sum();
            prop_assert!(sum <= records);
            let importance = |i: usize| config.weighting.weight(factors[i], 0, counts[i]);
            if (0..factors.len()).any(|i| importance(i) > 0) {
                prop_assert!(sum + factors.len() as u64 > records);
            } else {
                prop_assert_eq!(sum, 0);
            }
            prop_assert!((0..factors.len()).all(|i| importance(i) > 0 || shares[i] == 0));
        }
    }

    #[test]
    fn no_fragments_no_importance() {
        assert_eq!(Weighting::default().weight(ONE, 3_000, 0), 0);
        assert_eq!(Weighting { alpha: ONE, limit: 20 }.weight(ONE, 0, 1), ONE);
        assert_eq!(Weighting { alpha: 0, limit: 1 }.weight(ONE, ONE, 5), 2 * ONE, "the largest");
    }
}
