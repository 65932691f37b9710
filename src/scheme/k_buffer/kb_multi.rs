//! The multi-pass k-buffer (Liu, Wei, Xu, Wu, "Multi-layer depth peeling via fragment sort", 2009): rounds of a
//! k-buffer without synchronisation, made robust by looking afterwards at what became of it.
//!
//! *Reconstructed* from what the k+-buffer paper and surveys say of it: "robust rendering behaviour" by several passes
//! in spite of hazards of reading, modifying and writing. A round is two geometry passes. The first inserts as `kb`
//! does: it reads the k entries, inserts, and writes them back, and an overlapping invocation may undo it. The second
//! verifies: a fragment that finds its key counts there; one that does not, though fewer than k nearer keys are there,
//! is missing, and the nearest of those is remembered. Everything nearer than that is right, and is emitted; the next
//! round begins behind it, and counts it. So every round gains at least one layer, whatever happens, and the k nearest
//! come out exactly.
//!
//! Entries are atomic words of 64 bits, read and written relaxed: keys are lost and doubled, but never torn.

use std::iter::repeat_n;
use std::marker::PhantomData;

use super::kb::insert;
use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Accounting, Keeps};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// Registers for entries, as in `kb`.
const MAX_K: usize = 64;

/// No entry: the key of no fragment. A pixel that goes on from here has all its fragments.
const NONE: u64 = key(EMPTY, u32::MAX);

/// How many different keys nearer than `key` there are among entries in any order.
fn nearer(entries: &mut [u64], key: u64) -> usize {
    entries.sort_unstable();
    let is_first = |i: usize| i == 0 || entries[i - 1] != entries[i];
    (0..entries.len()).take_while(|&i| entries[i] < key).filter(|&i| is_first(i)).count()
}

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether what is missing is looked for.
    const VERIFIED: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// What the first pass lost stays lost.
#[derive(Debug)]
pub enum Unverified {}

/// The method.
#[derive(Debug)]
pub struct KBufferMulti<V = Correct> {
    k: u32,
    /// The smallest key of this round; behind the first round, the missing one's plus 1.
    from: Words<Pixel, Plain, u64>,
    /// Fragments of that missing key.
    equal: Words<Pixel, Atomic, u32>,
    /// Fragments still to be emitted.
    left: Words<Pixel, Plain, u32>,
    /// The nearest key that is missing.
    missing: Words<Pixel, Atomic, u64>,
    entries: Words<Pixel, Atomic, u64>,
    /// Fragments of each entry's key, at the first entry that has it.
    counts: Words<Pixel, Atomic, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "k-buffer without synchronisation, verified and repeated (reconstructed)",
    paper: "Liu, Wei, Xu, Wu 2009a",
    section: "k+-buffer paper, 2 (KB-Multi)",
    program: Program::repeated(&[
        Pass::new("insert", PassKind::Prepare, Barrier::Pixel),
        Pass::store(Barrier::Pixel),
    ]),
    words: "3k + 6",
    needs: "64-bit atomic load, store and min, 32-bit atomic add, relaxed; a query whether any pixel goes on",
    wgsl: Some("64-bit atomics where there are; atomicAdd"),
    max_k: MAX_K as u32,
    source: include_str!("kb_multi.rs"),
    accounting: Accounting::Judged,
    ..Contract::new("kb-multi", Keeps::Nearest)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Unverified {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-multi@unverified",
        "Fault unverified: one round, whatever it lost",
        "no two invocations of a pixel overlap",
    );
    const VERIFIED: bool = false;
}

impl<V: Variant> Scheme for KBufferMulti<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            from: layout.named("from").pixel(1),
            equal: layout.named("equal").pixel(1),
            left: layout.named("left").pixel(1),
            missing: layout.named("missing").pixel(1),
            entries: layout.named("entries").pixel(u64::from(k)),
            counts: layout.named("counts").pixel(u64::from(k)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.begin(mem, pixel, 0, self.k).await;
    }

    /// Insert.
    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let (pixel, key) = (fragment.pixel, fragment.key());
        if key < mem.plain_load(self.from.at(pixel, 0)).await {
            return;
        }
        let mut entries = [0; MAX_K];
        let entries = &mut entries[..self.k as usize];
        for (i, entry) in (0..).zip(entries.iter_mut()) {
            *entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
        }
        insert(entries, key);
        for (i, &entry) in (0..).zip(entries.iter()) {
            mem.store(self.entries.at(pixel, i), entry, Order::Relaxed).await;
        }
    }

    /// Verify.
    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (pixel, key) = (fragment.pixel, fragment.key());
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        if key + 1 == from {
            mem.add(self.equal.at(pixel, 0), 1, Order::Relaxed).await;
        }
        if key < from {
            return Outcome::Kept;
        }
        let mut entries = [0; MAX_K];
        let entries = &mut entries[..self.k as usize];
        for (i, entry) in (0..).zip(entries.iter_mut()) {
            *entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
        }
        if let Some(i) = entries.iter().position(|&entry| entry == key) {
            mem.add(self.counts.at(pixel, i as u32), 1, Order::Relaxed).await;
        } else if nearer(entries, key) < entries.len() {
            mem.min(self.missing.at(pixel, 0), key, Order::Relaxed).await;
        }
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        let equal = mem.load(self.equal.at(pixel, 0), Order::Relaxed).await;
        let missing = mem.load(self.missing.at(pixel, 0), Order::Relaxed).await;
        let missing = if V::VERIFIED { missing } else { NONE };
        let mut layers = vec![(from.wrapping_sub(1), equal)];
        for i in 0..self.k {
            let entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
            let count = mem.load(self.counts.at(pixel, i), Order::Relaxed).await;
            layers.push((entry, count));
        }
        layers[1..].sort_unstable();
        let mut left = mem.plain_load(self.left.at(pixel, 0)).await;
        for &(layer, count) in layers.iter().filter(|(layer, _)| *layer < missing) {
            let count = count.min(left);
            keys.extend(repeat_n(layer, count as usize));
            left -= count;
        }
        let ends = left == 0 || missing == NONE;
        self.begin(mem, pixel, if ends { NONE } else { missing + 1 }, left).await;
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        mem.plain_load(self.from.at(pixel, 0)).await != NONE
    }
}

impl<V: Variant> KBufferMulti<V> {
    /// Begin a round at a key, with so many fragments to be emitted.
    async fn begin<M: Memory>(&self, mem: &M, pixel: u32, from: u64, left: u32) {
        mem.plain_store(self.from.at(pixel, 0), from).await;
        mem.plain_store(self.left.at(pixel, 0), left).await;
        mem.store(self.equal.at(pixel, 0), 0, Order::Relaxed).await;
        mem.store(self.missing.at(pixel, 0), NONE, Order::Relaxed).await;
        for i in 0..self.k {
            mem.store(self.entries.at(pixel, i), NONE, Order::Relaxed).await;
            mem.store(self.counts.at(pixel, i), 0, Order::Relaxed).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_entries_count_once_and_none_is_not_nearer() {
        for (entries, key, expected) in [
            (&mut [5, 3, 5, NONE][..], 6, 2),
            (&mut [5, 3, 5, NONE], 5, 1),
            (&mut [NONE, NONE], 0, 0),
            (&mut [1, 2, 3], 9, 3),
        ] {
            assert_eq!(nearer(entries, key), expected);
        }
    }
}
