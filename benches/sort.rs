//! Sorting a pixel's fragments: the default against the published choice (insertion sort up to 16, shell sort above),
//! by the number of fragments. Prints nanoseconds per list, and their ratio within the run.
#![allow(clippy::disallowed_methods, reason = "a benchmark reads the clock")]

use std::hint::black_box;
use std::time::Instant;

use fragloom::fragment::sort::Sort;
use fragloom::num::random::Random;

/// Lists of each length.
const LISTS: usize = 2_000;

/// Rounds; the fastest counts.
const ROUNDS: usize = 15;

fn time(sort: Sort, lists: &[Vec<u64>]) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let mut work = lists.to_vec();
        let start = Instant::now();
        for list in &mut work {
            sort.keys(black_box(list));
        }
        best = best.min(start.elapsed().as_secs_f64() / lists.len() as f64 * 1e9);
    }
    best
}

fn main() {
    let mut random = Random::new(1, 0);
    println!("{:>5} {:>12} {:>12} {:>7}", "n", "fastest/ns", "published/ns", "ratio");
    for n in [2, 4, 8, 12, 16, 17, 24, 32, 64, 128, 512] {
        let list = |_| (0..n).map(|_| random.bits()).collect();
        let lists: Vec<Vec<u64>> = (0..LISTS).map(list).collect();
        let [ours, theirs] = [Sort::Fastest, Sort::Published].map(|sort| time(sort, &lists));
        println!("{n:>5} {ours:>12.1} {theirs:>12.1} {:>7.2}", theirs / ours);
    }
}
