//! A device's results against the expected ones, pixel by pixel.

use serde::{Deserialize, Serialize};

use crate::exec::account::Judgement;
use crate::fragment::{data_of, depth_of};
use crate::gpu::twin::bounds::may_be_another_arrival;
use crate::gpu::twin::expected::Expected;
use crate::gpu::twin::light::{Promised, Simulator};
use crate::gpu::twin::merged::{Pixel, as_one, held, merged};
use crate::gpu::twin::resolve::Downloaded;
use crate::num::planes::Distances;
use crate::scheme::contract::{Contract, Keeps};
use crate::scheme::merging::components::Merged;
use crate::scheme::merging::sums;

/// How a device's result differs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Differences {
    /// Fragments compared, as generated.
    pub fragments: u64,
    /// Fragments of triangles that must not be at their pixel, or are missing there.
    pub coverage_differences: u64,
    /// Fragments of the right triangle at another depth.
    pub depth_differences: u64,
    /// Pixels whose lists differ.
    pub list_differences: u64,
    /// Pixels whose colours differ.
    pub pixel_differences: u64,
    /// Of a method that may lose fragments: lost.
    pub lost: u64,
    /// Stored twice.
    pub duplicated: u64,
    /// Made of two fragments.
    pub torn: u64,
    /// Pixels with a result that the contract does not allow.
    pub not_allowed: u64,
    /// Pixels where arrival decides which records there are, of a method that merges; or which nodes, of one that
    /// approximates. Of these, only what does not depend on it was compared.
    pub unsettled: u64,
}

impl Differences {
    /// Add another's counts.
    pub fn add(&mut self, other: &Self) {
        self.fragments += other.fragments;
        self.coverage_differences += other.coverage_differences;
        self.depth_differences += other.depth_differences;
        self.list_differences += other.list_differences;
        self.pixel_differences += other.pixel_differences;
        self.lost += other.lost;
        self.duplicated += other.duplicated;
        self.torn += other.torn;
        self.not_allowed += other.not_allowed;
        self.unsettled += other.unsettled;
    }

    /// Whether nothing differs.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.coverage_differences
            + self.depth_differences
            + self.list_differences
            + self.pixel_differences
            == 0
    }
}

/// Compare everything. `k` is the method's k.
#[must_use]
pub fn compare(
    contract: &Contract,
    k: Option<u32>,
    expected: &Expected,
    got: &Downloaded,
) -> Differences {
    let mut sum =
        Differences { fragments: expected.generated.keys.len() as u64, ..Differences::default() };
    if let Some(promised) = &expected.merged {
        for (pixel, right) in promised.pixels.iter().enumerate() {
            records(&promised.distances, right, got, pixel, &mut sum);
        }
        return sum;
    }
    if let Some(promised) = &expected.light {
        if let Some(simulator) = promised.simulator() {
            lights(promised, &simulator, expected, got, &mut sum);
        }
        return sum;
    }
    for pixel in 0..expected.kept.pixels() {
        let (right, found) = (expected.kept.pixel(pixel), got.pixel(pixel));
        let more = got.counts[pixel] as usize > found.len();
        sum.pixel_differences += u64::from(expected.colors[pixel] != got.colors[pixel]);
        if right == found && !more {
            continue;
        }
        sum.list_differences += 1;
        let [missing, extra] = unmatched(right, found);
        let depths = same_data(&missing, &extra);
        let beyond = u64::from(got.counts[pixel]) - found.len() as u64;
        sum.depth_differences += depths;
        sum.coverage_differences += (missing.len() + extra.len()) as u64 - 2 * depths + beyond;
        let judged = judge(contract, k, expected.generated.pixel(pixel), found);
        sum.lost += judged.lost;
        sum.duplicated += judged.duplicated;
        sum.torn += judged.torn;
        sum.not_allowed += u64::from(more || !is_allowed(contract, &judged, right, found));
    }
    sum
}

/// Compare a pixel's merged records: what they are together, and the records themselves where arrival does not decide.
fn records(
    distances: &Distances,
    right: &Pixel,
    got: &Downloaded,
    pixel: usize,
    sum: &mut Differences,
) {
    let found = got.pixel(pixel);
    let whole = got.counts[pixel] as usize == found.len();
    let found = merged(found).filter(|_| whole).unwrap_or_default();
    let all = as_one(found.iter().copied());
    let weight = |all: Option<Merged>| all.map_or(0, |all| u64::from(sums::weight(all.sums)));
    sum.lost += weight(right.all).saturating_sub(weight(all));
    sum.duplicated += weight(all).saturating_sub(weight(right.all));
    let equal = match &right.records {
        Some(records) => held(&found, distances).into_list() == *records,
        None => true,
    };
    sum.unsettled += u64::from(right.records.is_none());
    if !(equal && all == right.all) {
        sum.list_differences += 1;
        sum.not_allowed += 1;
    }
}

/// Compare the words of pixels that hold colours, and the colours that the simulator makes of them.
fn lights(
    promised: &Promised,
    simulator: &Simulator,
    expected: &Expected,
    got: &Downloaded,
    sum: &mut Differences,
) {
    for pixel in 0..promised.pixels() {
        let (right, found) = (promised.words(pixel), got.pixel(pixel));
        let n = expected.generated.pixel(pixel).len() as u64;
        let place = pixel as u32;
        let whole = got.counts[pixel] as usize == right.len() && found.len() == right.len();
        let bounds = &promised.bounds;
        let (words, color) = match promised.light(pixel) {
            _ if !whole => (false, false),
            Some(promise) => (
                bounds.first_apart(right, found, n).is_none(),
                bounds.is_near(&promise, &simulator.light(place, found)),
            ),
            None => {
                sum.unsettled += 1;
                let [one, other] = [right, found].map(|words| simulator.light(place, words));
                (bounds.is_settled(right, found), may_be_another_arrival(&one, &other, n))
            }
        };
        sum.list_differences += u64::from(!words);
        sum.pixel_differences += u64::from(!color);
        sum.not_allowed += u64::from(!(words && color));
    }
}

fn judge(contract: &Contract, k: Option<u32>, generated: &[u64], found: &[u64]) -> Judgement {
    let mut judgement = Judgement::default();
    let mut found = found.to_vec();
    found.sort_unstable();
    judgement.pixel(generated, &found, contract.reference_k(k));
    judgement
}

/// Whether the contract allows a pixel that differs from the exact one: any kept set of the same number of real
/// fragments if the contract depends on arrival, other fragments of the same depths if only depth distinguishes them,
/// and any result of a race if the method races.
fn is_allowed(contract: &Contract, judged: &Judgement, right: &[u64], found: &[u64]) -> bool {
    if contract.has_right_depths() {
        let depths = |keys: &[u64]| keys.iter().copied().map(depth_of).collect::<Vec<_>>();
        return judged.torn == 0 && depths(found) == depths(right);
    }
    if contract.is_racy() {
        return found.len() <= right.len().max(1);
    }
    contract.is_arrival_dependent()
        && judged.torn + judged.duplicated == 0
        && contract.keeps == Keeps::FirstArrivals
        && found.len() == right.len()
}

/// The differences between two sorted lists.
fn unmatched(right: &[u64], found: &[u64]) -> [Vec<u64>; 2] {
    let mut found = found.to_vec();
    found.sort_unstable();
    let (mut missing, mut extra) = (Vec::new(), Vec::new());
    let (mut r, mut f) = (0, 0);
    while r < right.len() || f < found.len() {
        match (right.get(r), found.get(f)) {
            (Some(a), Some(b)) if a == b => (r, f) = (r + 1, f + 1),
            (Some(&a), b) if b.is_none_or(|&b| a < b) => {
                missing.push(a);
                r += 1;
            }
            (_, Some(&b)) => {
                extra.push(b);
                f += 1;
            }
            (_, None) => break,
        }
    }
    [missing, extra]
}

/// How many elements of both have the same data word.
fn same_data(missing: &[u64], extra: &[u64]) -> u64 {
    let words = |keys: &[u64]| {
        let mut words: Vec<u32> = keys.iter().map(|&key| data_of(key)).collect();
        words.sort_unstable();
        words
    };
    let (missing, extra) = (words(missing), words(extra));
    let (mut m, mut e, mut same) = (0, 0, 0);
    while let (Some(a), Some(b)) = (missing.get(m), extra.get(e)) {
        match a.cmp(b) {
            std::cmp::Ordering::Equal => (m, e, same) = (m + 1, e + 1, same + 1),
            std::cmp::Ordering::Less => m += 1,
            std::cmp::Ordering::Greater => e += 1,
        }
    }
    same
}
