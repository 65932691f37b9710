//! What the machine can do, measured in the same run and process as everything else: how long atomic operations take
//! on words in the cache, and how fast words are read and written.

use std::sync::Barrier;

use super::stats::timed;
use crate::error::{Error, Result};
use crate::memory::probe::{Operation, Probe, Stretch};

/// How often each is measured; the fastest counts, since whatever else a machine does only adds.
const TRIALS: u32 = 7;

/// Turns over the words of a probe.
const TURNS: u32 = 128;

/// Bytes that stay in a core's own caches, and how often they are read.
const CACHED: usize = 128 << 10;
const CACHED_TURNS: u32 = 64;

/// Bytes that no cache holds: of all threads together, and of each thread at least.
const MEMORY: usize = 256 << 20;
const MEMORY_EACH: usize = 16 << 20;

/// Constants of the machine with so many threads at work at once, each on words of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub(super) struct Constants {
    pub(super) threads: usize,
    /// Nanoseconds of an operation, of each thread.
    pub(super) exchange_ns: f64,
    pub(super) locked_pair_ns: f64,
    pub(super) compare_exchange_max_ns: f64,
    pub(super) add_ns: f64,
    /// 10^9 bytes a second, of all threads together: read from their caches; read from and written to memory.
    pub(super) cache_gb_per_s: f64,
    pub(super) read_gb_per_s: f64,
    pub(super) write_gb_per_s: f64,
}

impl Constants {
    /// Measure them. Takes about a second.
    ///
    /// # Errors
    /// So many threads cannot be started.
    pub(super) fn measure(threads: usize) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool =
            pool.map_err(|e| Error::new("--threads", format!("cannot start {threads}: {e}")))?;
        let atomic = |operation| {
            let each =
                together(&pool, threads, Probe::default, |probe| probe.perform(operation, TURNS));
            each * 1e9
        };
        let bytes = (MEMORY / threads).max(MEMORY_EACH);
        let rate = |seconds_each: f64| threads as f64 / seconds_each / 1e9;
        Ok(Self {
            threads,
            exchange_ns: atomic(Operation::Exchange),
            locked_pair_ns: atomic(Operation::LockedPair),
            compare_exchange_max_ns: atomic(Operation::CompareExchangeMax),
            add_ns: atomic(Operation::Add),
            cache_gb_per_s: rate(together(
                &pool,
                threads,
                || Stretch::new(CACHED),
                |stretch| {
                    (0..CACHED_TURNS).for_each(|_| {
                        std::hint::black_box(stretch.read());
                    });
                    u64::from(CACHED_TURNS) * stretch.bytes() as u64
                },
            )),
            read_gb_per_s: rate(together(
                &pool,
                threads,
                || Stretch::new(bytes),
                |stretch| {
                    std::hint::black_box(stretch.read());
                    stretch.bytes() as u64
                },
            )),
            write_gb_per_s: rate(together(
                &pool,
                threads,
                || Stretch::new(bytes),
                |stretch| {
                    stretch.write(2);
                    stretch.bytes() as u64
                },
            )),
        })
    }
}

/// Seconds that a thread takes for one of the things that `work` counts, with all threads at it at once.
fn together<T>(
    pool: &rayon::ThreadPool,
    threads: usize,
    make: impl Fn() -> T + Sync,
    work: impl Fn(&mut T) -> u64 + Sync,
) -> f64 {
    let barrier = Barrier::new(threads);
    let slowest = pool.broadcast(|_| {
        let mut own = make();
        // Pages are there, and the clock frequency is what it will be.
        work(&mut own);
        let trial = |_| {
            barrier.wait();
            let (seconds, count) = timed(|| work(&mut own));
            seconds / count as f64
        };
        (0..TRIALS).map(trial).collect::<Vec<f64>>()
    });
    fastest(&slowest)
}

/// The fastest trial, each as slow as the slowest thread was.
fn fastest(threads: &[Vec<f64>]) -> f64 {
    let trials = threads.first().map_or(0, Vec::len);
    let slowest = |trial: usize| threads.iter().map(|own| own[trial]).fold(0.0, f64::max);
    (0..trials).map(slowest).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_is_as_slow_as_its_slowest_thread_and_the_fastest_counts() {
        let trials = [vec![3.0, 1.0, 2.0], vec![1.0, 4.0, 2.5]];
        assert_eq!(fastest(&trials).to_bits(), 2.5f64.to_bits());
        assert_eq!(fastest(&trials[..1]).to_bits(), 1.0f64.to_bits());
    }

    #[test]
    fn every_thread_works_in_every_trial() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads");
        let done = std::sync::Mutex::new(0);
        together(
            &pool,
            2,
            || (),
            |()| {
                *done.lock().expect("no panic") += 1;
                1
            },
        );
        assert_eq!(done.into_inner().expect("no panic"), 2 * (TRIALS + 1));
    }
}
