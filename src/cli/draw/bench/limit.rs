//! The least time that the machine needs for what a method does: the largest of what each part alone would take.
//!
//! t >= max(emit, atomics x their time, bytes / bandwidth), with the time of `emit` (masks, depths and data words of
//! all fragments, nothing stored), and with atomics and bytes as the method's own run counted them. A method that
//! reaches the limit does everything else in the shadow of the slowest part.

use std::collections::BTreeMap;

use super::machine::Constants;

/// What a run counted.
#[derive(Clone, Debug, Default)]
pub(super) struct Counted {
    /// Memory operations by kind.
    pub(super) counters: BTreeMap<String, u64>,
    pub(super) fragments: u64,
    /// Whether its atomic operations are atomic on the machine: those of `threads` are.
    pub(super) is_shared: bool,
    /// Bytes of words that lie in memory between two passes of a frame. Where a tile goes through all passes at once,
    /// there are none.
    pub(super) stored: u64,
    /// Whether it takes indices of pools: those that a worker takes ahead are no atomic operations, although they are
    /// counted as some.
    pub(super) takes: bool,
}

/// The least time, and what takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    pub(super) seconds: f64,
    pub(super) by: &'static str,
}

impl Counted {
    fn of(&self, name: &str) -> u64 {
        self.counters.get(name).copied().unwrap_or_default()
    }

    /// Exchanges that are part of a lock: those that a store goes with. Then those without one, compare-exchanges of
    /// all kinds, and the other updates.
    fn atomics(&self) -> [u64; 4] {
        if !self.is_shared {
            return [0; 4];
        }
        let exchanges = self.of("exchange");
        let pairs = exchanges.min(self.of("atomic_store"));
        let compared = ["compare_exchange", "min", "max"].iter().map(|name| self.of(name)).sum();
        let ahead = if self.takes { self.fragments } else { 0 };
        let added = self.of("add").saturating_sub(ahead) + self.of("and") + self.of("or");
        [pairs, exchanges - pairs, compared, added]
    }

    /// Atomic operations of the machine, by fragment.
    pub(super) fn atomics_per_fragment(&self) -> f64 {
        self.per_fragment(self.atomics().iter().sum())
    }

    /// Bytes of words that were touched, by fragment.
    pub(super) fn bytes_per_fragment(&self) -> f64 {
        self.per_fragment(self.of("bytes"))
    }

    fn per_fragment(&self, count: u64) -> f64 {
        count as f64 / self.fragments.max(1) as f64
    }

    /// Bytes that leave the caches, and come back: what lies in memory, but no more than half of what was touched.
    fn out(&self) -> f64 {
        (self.stored as f64).min(self.of("bytes") as f64 / 2.0)
    }

    /// The least time; `emit` is its time in seconds.
    pub(super) fn limit(&self, emit: f64, machine: &Constants) -> Limit {
        let Constants { exchange_ns, locked_pair_ns, compare_exchange_max_ns, add_ns, .. } =
            *machine;
        let times = [locked_pair_ns, exchange_ns, compare_exchange_max_ns, add_ns];
        let nanoseconds: f64 =
            self.atomics().iter().zip(times).map(|(&count, time)| count as f64 * time).sum();
        let at = |bytes: f64, rate: f64| bytes / (rate * 1e9);
        let memory = at(self.out(), machine.write_gb_per_s) + at(self.out(), machine.read_gb_per_s);
        let parts = [
            ("emit", emit),
            ("atomics", nanoseconds * 1e-9 / machine.threads as f64),
            ("cache", at(self.of("bytes") as f64, machine.cache_gb_per_s)),
            ("memory", memory),
        ];
        let largest = parts
            .into_iter()
            .fold(parts[0], |largest, part| if part.1 > largest.1 { part } else { largest });
        Limit { by: largest.0, seconds: largest.1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MACHINE: Constants = Constants {
        threads: 2,
        exchange_ns: 8.0,
        locked_pair_ns: 10.0,
        compare_exchange_max_ns: 9.0,
        add_ns: 7.0,
        cache_gb_per_s: 100.0,
        read_gb_per_s: 20.0,
        write_gb_per_s: 10.0,
    };

    const MILLION: u64 = 1_000_000;

    fn counted(counters: &[(&str, u64)], is_shared: bool) -> Counted {
        let counters = counters.iter().map(|&(name, count)| (name.to_owned(), count * MILLION));
        let fragments = 100 * MILLION;
        Counted { counters: counters.collect(), fragments, is_shared, ..Counted::default() }
    }

    #[track_caller]
    fn is(limit: Limit, by: &str, seconds: f64) {
        assert!(
            limit.by == by && (limit.seconds - seconds).abs() < 1e-12,
            "{limit:?}, not {by} {seconds}"
        );
    }

    /// 100 million exchanges of 8 ns take two threads 0.4 s, and so on.
    #[test]
    fn atomics_take_their_time_on_all_threads() {
        let limit = |counters| counted(counters, true).limit(0.1, &MACHINE);
        is(limit(&[("exchange", 100)]), "atomics", 0.4);
        is(limit(&[("exchange", 100), ("atomic_store", 100)]), "atomics", 0.5);
        is(limit(&[("exchange", 100), ("atomic_store", 50)]), "atomics", 0.45);
        is(limit(&[("max", 50), ("min", 30), ("compare_exchange", 20)]), "atomics", 0.45);
        is(limit(&[("add", 60), ("and", 20), ("or", 20)]), "atomics", 0.35);
        is(limit(&[("exchange", 10)]), "emit", 0.1);
        is(
            limit(&[("plain_store", 999), ("atomic_load", 999), ("atomic_store", 999)]),
            "emit",
            0.1,
        );
        assert!(
            (counted(&[("exchange", 150), ("max", 50)], true).atomics_per_fragment() - 2.0).abs()
                < 1e-12
        );
    }

    /// In `tile`, a worker owns the words.
    #[test]
    fn what_one_worker_owns_is_not_atomic() {
        let own = counted(&[("exchange", 100), ("bytes", 1)], false);
        is(own.limit(0.1, &MACHINE), "emit", 0.1);
        assert_eq!(own.atomics_per_fragment().to_bits(), 0);
    }

    /// One of a fragment's adds takes an index that the worker has already.
    #[test]
    fn indices_taken_ahead_are_no_atomics() {
        let adds = counted(&[("add", 150)], true);
        is(adds.limit(0.1, &MACHINE), "atomics", 0.525);
        is(Counted { takes: true, ..adds }.limit(0.1, &MACHINE), "atomics", 0.175);
        let few = Counted { takes: true, ..counted(&[("add", 50)], true) };
        is(few.limit(0.1, &MACHINE), "emit", 0.1);
    }

    /// 40 bytes a fragment are 4 GB: 0.04 s in caches; 1 GB out and in again takes 0.1 s and 0.05 s.
    #[test]
    fn bytes_take_their_time() {
        let touched = counted(&[("bytes", 4_000)], true);
        is(touched.limit(0.03, &MACHINE), "cache", 0.04);
        assert!((touched.bytes_per_fragment() - 40.0).abs() < 1e-12);
        let stored = Counted { stored: 1_000 * MILLION, ..touched.clone() };
        is(stored.limit(0.03, &MACHINE), "memory", 0.15);
        is(stored.limit(0.2, &MACHINE), "emit", 0.2);
        // No more comes and goes than is touched.
        let large = Counted { stored: 1_000_000 * MILLION, ..touched };
        is(large.limit(0.03, &MACHINE), "memory", 0.3);
    }
}
