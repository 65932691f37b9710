//! Litmus pixels: small programs made from a method's contract.
//!
//! An instance is one to three pixels, n fragments, k, and the room that the method is told of. Fragments matter to a
//! scheme only through the order of their (depth, data), so inputs are enumerated up to order: sorted neighbours differ
//! in depth, only in data, or not at all, which makes 3^(n-1) patterns. The first depth is 0 and the last of several
//! the far plane's, so that the ends of the range are always among them.

use serde::{Deserialize, Serialize};

use super::shader::Task;
use crate::fragment::{Fragment, key};
use crate::num::depth::{FARTHEST, Format};
use crate::scheme::contract::{Demand, Keeps};
use crate::scheme::{Config, Contract};

/// A small program: one store invocation per fragment.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Litmus {
    /// Pixels, 1 to 3 when generated.
    pub pixels: u32,
    /// `-k`, for a method that takes one.
    pub k: Option<u32>,
    /// What the method is told of the scene: fragments in all, and at a pixel.
    pub room: u32,
    /// (pixel, depth, data) of every fragment, in submission order.
    pub fragments: Vec<(u32, u32, u32)>,
    /// How many of the first fragments have a helper invocation beside them.
    pub helpers: u32,
}

/// How many fragments have all patterns of neighbours; more have distinct depths.
pub const ALL_PATTERNS: u32 = 5;

/// How a fragment relates to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Farther,
    OtherData,
    Same,
}

impl Litmus {
    /// What the method is configured with.
    #[must_use]
    pub fn config(&self) -> Config {
        Config { k: self.k, generated: u64::from(self.room), max_depth_complexity: self.room }
    }

    /// The fragments.
    pub fn fragments(&self) -> impl Iterator<Item = Fragment> + '_ {
        self.fragments.iter().map(|&(pixel, depth, data)| Fragment { pixel, depth, data })
    }

    /// The keys generated at a pixel, sorted.
    #[must_use]
    pub fn generated(&self, pixel: u32) -> Vec<u64> {
        let own = self.fragments().filter(|f| f.pixel == pixel);
        let mut keys: Vec<u64> = own.map(Fragment::key).collect();
        keys.sort_unstable();
        keys
    }

    /// The passes before the concurrent one, the concurrent invocations, and the passes after it.
    pub(super) fn passes(&self, contract: &Contract) -> [Vec<Task>; 3] {
        let pixels = 0..self.pixels;
        let clear = std::iter::once(Task::ClearFrame).chain(pixels.clone().map(Task::Clear));
        let mut passes: [Vec<Task>; 3] = [
            clear.collect(),
            self.fragments().map(Task::Store).collect(),
            pixels.map(Task::Resolve).collect(),
        ];
        let helpers = self.fragments().take(self.helpers as usize).map(Task::Store);
        passes[1].extend(helpers);
        if !contract.barriers.before_store {
            let clear = std::mem::take(&mut passes[0]);
            passes[1].extend(clear);
        }
        if !contract.barriers.before_resolve {
            let resolve = std::mem::take(&mut passes[2]);
            passes[1].extend(resolve);
        }
        passes
    }

    /// Whether an invocation of the concurrent pass is a helper.
    pub(super) fn is_helper(&self, invocation: usize) -> bool {
        let first = self.fragments.len();
        (first..first + self.helpers as usize).contains(&invocation)
    }

    /// Values for words that nobody wrote: the ends of the range, and what could be mistaken for a fragment. A method
    /// that never reads such a word is explored only once, so these stand for arbitrary memory; one that does is
    /// explored with each of them, at each such word.
    pub(super) fn candidates(&self) -> [u64; 3] {
        let middle = self.fragments().nth(self.fragments.len() / 2).map_or(1, Fragment::key);
        [0, middle, u64::MAX]
    }

    /// One line: n, k, room where it is short, and the fragments.
    #[must_use]
    pub fn describe(&self) -> String {
        use std::fmt::Write;
        let mut text = format!("n={}", self.fragments.len());
        if let Some(k) = self.k {
            let _ = write!(text, " k={k}");
        }
        if (self.room as usize) < self.fragments.len() {
            let _ = write!(text, " room={}", self.room);
        }
        if self.pixels > 1 {
            let _ = write!(text, " pixels={}", self.pixels);
        }
        if self.helpers > 0 {
            let _ = write!(text, " helpers={}", self.helpers);
        }
        for &(pixel, depth, data) in &self.fragments {
            let place = if self.pixels > 1 { format!("p{pixel}:") } else { String::new() };
            let _ = write!(text, " {place}{depth:x}/{data:x}");
        }
        text
    }
}

/// Which instances to make.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    /// Fragments, from 1 up to this.
    pub fragments: u32,
    /// The k to try, for methods that take one.
    pub ks: Vec<u32>,
    /// Helper invocations beside the first fragments.
    pub helpers: u32,
}

/// All instances of a contract, smallest first: by n, then k, then room and pixels, then pattern.
#[must_use]
pub fn instances(contract: &Contract, family: &Family) -> Vec<Litmus> {
    (1..=family.fragments).flat_map(|n| of_size(contract, family, n)).collect()
}

/// The instances with exactly `n` fragments.
#[must_use]
pub fn of_size(contract: &Contract, family: &Family, n: u32) -> Vec<Litmus> {
    let takes_k = contract.keeps == Keeps::Nearest && contract.default_k.is_some();
    let ks: Vec<Option<u32>> = if takes_k {
        family.ks.iter().copied().filter(|&k| k <= contract.max_k).map(Some).collect()
    } else {
        vec![None]
    };
    let short = contract.demand != Demand::Nothing && n > 1;
    let rooms = if short { vec![n, n - 1] } else { vec![n] };
    let spread: u32 = if (2..=3).contains(&n) { n } else { 1 };
    let mut all = Vec::new();
    for &k in &ks {
        for &room in &rooms {
            for pixels in 1..=spread {
                for relations in patterns(n, pixels) {
                    let fragments = fragments(&relations, pixels, contract);
                    let helpers = family.helpers.min(n);
                    all.push(Litmus { pixels, k, room, fragments, helpers });
                }
            }
        }
    }
    all
}

/// The relations of n sorted fragments, all of them up to [`ALL_PATTERNS`] fragments of one pixel.
fn patterns(n: u32, pixels: u32) -> Vec<Vec<Relation>> {
    if n > ALL_PATTERNS || pixels > 1 {
        return vec![vec![Relation::Farther; n as usize - 1]];
    }
    let mut all = vec![Vec::new()];
    for _ in 1..n {
        let longer = |head: &Vec<Relation>| {
            [Relation::Farther, Relation::OtherData, Relation::Same].map(|r| {
                let mut next = head.clone();
                next.push(r);
                next
            })
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

fn fragments(relations: &[Relation], pixels: u32, contract: &Contract) -> Vec<(u32, u32, u32)> {
    let format = contract.depth_format.unwrap_or(Format::D32);
    let levels = 1 + relations.iter().filter(|&&r| r == Relation::Farther).count() as u32;
    // Data words fall with depth, so that nothing sorted by one is sorted by the other.
    let first_data = |level: u32| (levels - level) * 0x10;
    let (mut level, mut data) = (0, first_data(0));
    let mut all = Vec::new();
    for i in 0..=relations.len() {
        match i.checked_sub(1).map(|before| relations[before]) {
            Some(Relation::Farther) => {
                level += 1;
                data = first_data(level);
            }
            Some(Relation::OtherData) => data += 1,
            _ => {}
        }
        let code = if level + 1 == levels { FARTHEST } else { level * 0x1000_0000 };
        all.push((i as u32 % pixels, format.encode(code), data));
    }
    all.sort_by_key(|&(_, depth, data)| key(depth, data));
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::scheme::catalogue;

    fn sized(method: &str, n: u32) -> Vec<Litmus> {
        let family = Family { fragments: n, ks: vec![1, 2, 3], helpers: 0 };
        of_size(catalogue::contract(method).expect("known"), &family, n)
    }

    #[test]
    fn patterns_are_all_and_distinct() {
        for n in 1..=5u32 {
            let one_pixel = sized("kplus-array", n).into_iter().filter(|l| l.pixels == 1);
            let distinct: BTreeSet<Litmus> = one_pixel.collect();
            assert_eq!(distinct.len(), 3 * 3usize.pow(n - 1), "three k, n = {n}");
        }
        assert_eq!(sized("kplus-array", 6).len(), 3, "beyond, distinct depths only");
    }

    #[test]
    fn the_ends_of_the_range_are_among_them() {
        for litmus in sized("kplus-array", 3) {
            let keys: Vec<u32> = litmus.fragments.iter().map(|f| f.1).collect();
            assert!(keys.contains(&FARTHEST));
            assert!(keys.is_sorted());
            let levels: BTreeSet<u32> = keys.iter().copied().collect();
            assert!(levels.len() == 1 || keys.contains(&0));
        }
    }

    #[test]
    fn pools_and_slots_are_also_tried_too_small() {
        for method in ["ab-ll", "ab-array"] {
            let rooms: BTreeSet<u32> = sized(method, 3).iter().map(|l| l.room).collect();
            assert_eq!(rooms, BTreeSet::from([2, 3]), "{method}");
        }
    }
}
