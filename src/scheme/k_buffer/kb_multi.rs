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
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Plain, Words, both, each};
use crate::num::depth::EMPTY;
use crate::scheme::contract::{Accounting, Keeps};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// Registers for entries, as in `kb`.
const MAX_K: usize = 64;

/// No entry: the key of no fragment. A pixel that goes on from here has all its fragments.
const NONE: u64 = key(EMPTY, u32::MAX);

/// Whether fewer different keys than entries are nearer than `key`, which is none of them.
#[inline]
fn has_room<const MOST: usize>(entries: &[u64; MOST], k: usize, key: u64) -> bool {
    let own = &entries[..k];
    // Where all are nearer, there is room if two are the same. One invocation after another leaves them in order.
    own.iter().any(|&entry| entry > key)
        || own.windows(2).any(|two| two[0] >= two[1]) && are_any_same(*entries, k)
}

#[cold]
#[inline(never)]
fn are_any_same<const MOST: usize>(mut entries: [u64; MOST], k: usize) -> bool {
    entries[..k].sort_unstable();
    entries[..k].windows(2).any(|two| two[0] == two[1])
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
        self.begin::<_, Self>(mem, pixel, 0, self.k).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        with_entries!(self.k, MOST => mem.part(self.insert::<_, MOST>(mem, fragment)).await);
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        with_entries!(self.k, MOST => mem.part(self.verify::<_, MOST>(mem, fragment)).await);
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        with_entries!(self.k, MOST => mem.part(self.emit::<_, MOST>(mem, pixel, keys)).await);
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        mem.plain_load(self.from.at(pixel, 0)).await != NONE
    }
}

/// Passes with room for `MOST` entries, as in `kb`.
impl<V: Variant> KBufferMulti<V> {
    fn k<const MOST: usize>(&self) -> usize {
        if MOST < MAX_K { MOST } else { self.k as usize }
    }

    async fn insert<M: Memory, const MOST: usize>(&self, mem: &M, fragment: Fragment) {
        let (pixel, key) = (fragment.pixel, fragment.key());
        if key < mem.plain_load(self.from.at(pixel, 0)).await {
            return;
        }
        let k = self.k::<MOST>();
        let words = self.entries;
        let at = move |i| words.at(pixel, i as u32);
        let mut entries = each::<MOST, _, _>(k, move |i| mem.load(at(i), Order::Relaxed)).await;
        insert(&mut entries[..k], key);
        each::<MOST, _, _>(k, move |i| mem.store(at(i), entries[i], Order::Relaxed)).await;
    }

    async fn verify<M: Memory, const MOST: usize>(&self, mem: &M, fragment: Fragment) {
        let (pixel, key) = (fragment.pixel, fragment.key());
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        if key + 1 == from {
            mem.add(self.equal.at(pixel, 0), 1, Order::Relaxed).await;
        }
        if key < from {
            return;
        }
        let k = self.k::<MOST>();
        let words = self.entries;
        let at = move |i| words.at(pixel, i as u32);
        let entries = each::<MOST, _, _>(k, move |i| mem.load(at(i), Order::Relaxed)).await;
        if let Some(i) = entries[..k].iter().position(|&entry| entry == key) {
            mem.add(self.counts.at(pixel, i as u32), 1, Order::Relaxed).await;
        } else if has_room(&entries, k, key) {
            mem.min(self.missing.at(pixel, 0), key, Order::Relaxed).await;
        }
    }

    /// Emit what is right, and go on behind it.
    async fn emit<M: Memory, const MOST: usize>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let from = mem.plain_load(self.from.at(pixel, 0)).await;
        let equal = mem.load(self.equal.at(pixel, 0), Order::Relaxed).await;
        let missing = mem.load(self.missing.at(pixel, 0), Order::Relaxed).await;
        let missing = if V::VERIFIED { missing } else { NONE };
        let k = self.k::<MOST>();
        let (words, counts) = (self.entries, self.counts);
        let read = move |i| {
            let (entry, count) = (words.at(pixel, i as u32), counts.at(pixel, i as u32));
            both(mem.load(entry, Order::Relaxed), mem.load(count, Order::Relaxed))
        };
        let mut layers = each::<MOST, _, _>(k, read).await;
        let mut left = mem.plain_load(self.left.at(pixel, 0)).await;
        // The layer of the round before comes first, whatever is there now.
        layers[..k].sort_unstable();
        let before = (from.wrapping_sub(1), equal);
        for &(layer, count) in [before].iter().chain(&layers[..k]) {
            if layer < missing {
                let count = count.min(left);
                keys.extend(repeat_n(layer, count as usize));
                left -= count;
            }
        }
        let ends = left == 0 || missing == NONE;
        self.begin::<_, (Self,)>(mem, pixel, if ends { NONE } else { missing + 1 }, left).await;
    }

    /// Begin a round at a key, with so many fragments to be emitted.
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    async fn begin<M: Memory, Caller>(&self, mem: &M, pixel: u32, from: u64, left: u32) {
        mem.plain_store(self.from.at(pixel, 0), from).await;
        mem.plain_store(self.left.at(pixel, 0), left).await;
        mem.store(self.equal.at(pixel, 0), 0, Order::Relaxed).await;
        mem.store(self.missing.at(pixel, 0), NONE, Order::Relaxed).await;
        let (words, counts) = (self.entries, self.counts);
        let clear = move |i| {
            let (entry, count) = (words.at(pixel, i as u32), counts.at(pixel, i as u32));
            both(mem.store(entry, NONE, Order::Relaxed), mem.store(count, 0, Order::Relaxed))
        };
        each::<MAX_K, _, _>(self.k as usize, clear).await;
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn equal_entries_count_once_and_none_is_not_nearer() {
        for (entries, key, expected) in [
            ([5, 3, 5, NONE], 6, true),
            ([5, 3, 5, NONE], 4, true),
            ([NONE, NONE, NONE, NONE], 0, true),
            ([1, 2, 3, 4], 9, false),
            ([2, 1, 4, 3], 9, false),
            ([2, 1, 2, 3], 9, true),
            ([1, 2, 3, 3], 9, true),
        ] {
            assert_eq!(has_room(&entries, 4, key), expected, "{entries:?}");
        }
        assert!(!has_room(&[2, 1, 0, 0], 2, 9), "beyond k there are none");
    }

    proptest! {
        #[test]
        fn there_is_room_where_fewer_different_keys_are_nearer(
            entries in prop::array::uniform6(0u64..8), key in 0u64..8, k in 1usize..7,
        ) {
            let own = &entries[..k];
            prop_assume!(!own.contains(&key));
            let nearer: BTreeSet<_> = own.iter().filter(|&&entry| entry < key).collect();
            prop_assert_eq!(has_room(&entries, k, key), nearer.len() < k);
        }
    }
}
