//! Observers of memory operations, and the one that counts them.

use std::cell::Cell;
use std::collections::BTreeMap;

use super::{Access, Event, Update, Word};

/// Sees every operation of one memory handle. The unit type sees nothing and costs nothing.
pub trait Observer {
    /// A load.
    #[inline(always)]
    fn read(&self, access: Access, bits: u32) {
        let _ = (access, bits);
    }

    /// A store.
    #[inline(always)]
    fn write(&self, access: Access, bits: u32) {
        let _ = (access, bits);
    }

    /// A read-modify-write and the value it found.
    #[inline(always)]
    fn update<W: Word>(&self, update: Update<W>, old: W) {
        let _ = (update, old);
    }

    /// A wait.
    #[inline(always)]
    fn spin(&self) {}

    /// An event that an invocation reports about itself.
    #[inline(always)]
    fn note(&self, event: Event) {
        let _ = event;
    }

    /// Its counters, if it counts.
    fn counters(&self) -> Option<&Counters> {
        None
    }
}

impl Observer for () {}

/// What is counted, in the order of [`NAMES`].
const KINDS: usize = 16;

/// The counters' names in reports.
pub const NAMES: [&str; KINDS] = [
    "plain_load",
    "plain_store",
    "atomic_load",
    "atomic_store",
    "exchange",
    "compare_exchange",
    "add",
    "and",
    "or",
    "min",
    "max",
    "failed_exchanges",
    "spins",
    "bytes",
    "probes",
    "evictions",
];

const FAILED: usize = 11;
const SPINS: usize = 12;
const BYTES: usize = 13;
const PROBES: usize = 14;
const EVICTIONS: usize = 15;

/// Counts operations by kind, exchanges that failed ([`Update::failed`]), waits, and the bytes of all words touched (a
/// read-modify-write counts its word twice).
#[derive(Clone, Debug, Default)]
pub struct Counters {
    counts: [Cell<u64>; KINDS],
}

impl Counters {
    /// Add another's counts to these.
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.counts.iter().zip(&other.counts) {
            a.set(a.get() + b.get());
        }
    }

    /// The counts by name, without those that are zero.
    #[must_use]
    pub fn by_name(&self) -> BTreeMap<String, u64> {
        let named = NAMES.iter().zip(&self.counts);
        named.filter(|(_, c)| c.get() > 0).map(|(n, c)| ((*n).to_owned(), c.get())).collect()
    }

    #[inline(always)]
    fn bump(&self, kind: usize, by: u64) {
        self.counts[kind].set(self.counts[kind].get() + by);
    }
}

impl Observer for Counters {
    #[inline(always)]
    fn read(&self, access: Access, bits: u32) {
        self.bump(if access == Access::Plain { 0 } else { 2 }, 1);
        self.bump(BYTES, u64::from(bits / 8));
    }

    #[inline(always)]
    fn write(&self, access: Access, bits: u32) {
        self.bump(if access == Access::Plain { 1 } else { 3 }, 1);
        self.bump(BYTES, u64::from(bits / 8));
    }

    #[inline(always)]
    fn update<W: Word>(&self, update: Update<W>, old: W) {
        let kind = match update {
            Update::Exchange(_) => 4,
            Update::CompareExchange { .. } => 5,
            Update::Add(_) => 6,
            Update::And(_) => 7,
            Update::Or(_) => 8,
            Update::Min(_) => 9,
            Update::Max(_) => 10,
        };
        self.bump(kind, 1);
        self.bump(FAILED, u64::from(update.failed(old)));
        self.bump(BYTES, u64::from(W::BITS / 4));
    }

    #[inline(always)]
    fn spin(&self) {
        self.bump(SPINS, 1);
    }

    #[inline(always)]
    fn note(&self, event: Event) {
        match event {
            Event::Probe => self.bump(PROBES, 1),
            Event::Eviction => self.bump(EVICTIONS, 1),
            Event::Input => self.read(Access::Plain, u32::BITS),
        }
    }

    fn counters(&self) -> Option<&Counters> {
        Some(self)
    }
}
