//! The max-array of the k+-buffer with a record in one 64-bit word (`kplus-array@word64`): what becomes of K+B-Array
//! where one atomic operation compares and replaces a whole record.
//!
//! No lock is left, and no counter: an empty entry holds a record farther than any. A fragment looks at all k entries.
//! If it is nearer than the farthest, it takes that one's place by a compare-exchange; if another was there first, it
//! looks again.
//!
//! Nothing need be ordered: it is enough that each word alone is coherent. Entries only become nearer. So a value that
//! is read is at least as far as the entry is from then on, however stale. If the compare-exchange finds the farthest
//! value F that was read, all entries are at most F in the end, k of them, and F is rightly evicted. If all k values read
//! are at most the fragment's, so are all entries in the end, and it is rightly culled. A failed compare-exchange means
//! that an entry has become nearer, which happens finitely often: no invocation waits for another one.
//!
//! A fragment costs k loads and, if it is kept, a compare-exchange of 64 bits. `kb-mdt64` has the same words, and takes
//! up to k atomic minima instead; its entries are sorted.

use crate::fragment::Fragment;
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};
use crate::scheme::contract::{Form, Keeps};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// What an empty entry holds: farther than any record.
const EMPTY: u64 = u64::MAX;

/// The method.
#[derive(Debug)]
pub struct KPlusArrayWord64 {
    k: u32,
    entries: Words<Pixel, Atomic, u64>,
}

impl Scheme for KPlusArrayWord64 {
    const CONTRACT: Contract = Contract {
        title: "k+-buffer: max-array of 64-bit words, without a lock",
        paper: "Vasilakis, Fudos 2014",
        section: "3.2 (K+B-Array)",
        form: Form::Mended,
        words: "2k",
        needs: "64-bit atomic compare-exchange, relaxed",
        wgsl: Some("storage buffers; 64-bit atomicCompareExchange (not in the standard)"),
        source: include_str!("kplus_array_word64.rs"),
        ..Contract::new("kplus-array@word64", Keeps::Nearest)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self { k, entries: layout.named("entries").pixel(u64::from(k)) }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.k {
            mem.store(self.entries.at(pixel, i), EMPTY, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (pixel, new) = (fragment.pixel, fragment.key());
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            let (mut place, mut farthest) = (0, 0);
            let scan = mem.block();
            for i in 0..self.k {
                let entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
                if entry > farthest {
                    (place, farthest) = (i, entry);
                }
                // None is farther, and none is freed.
                if farthest == EMPTY {
                    break;
                }
            }
            mem.merge(scan).await;
            if farthest <= new {
                return Outcome::Culled;
            }
            let at = self.entries.at(pixel, place);
            if mem.compare_exchange(at, farthest, new, Order::Relaxed).await == farthest {
                return if farthest == EMPTY { Outcome::Kept } else { Outcome::Evicted };
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..self.k {
            let entry = mem.load(self.entries.at(pixel, i), Order::Relaxed).await;
            if entry != EMPTY {
                keys.push(entry);
            }
        }
    }
}
