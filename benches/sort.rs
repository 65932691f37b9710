//! Sorting a pixel's fragments: the default against the published choice (insertion sort up to 16, shell sort above),
//! by the number of fragments, and of many pixels together. Prints nanoseconds per list, and ratios within the run.
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

/// All lists at once, as they lie in a tile.
fn time_together(lists: &[Vec<u64>]) -> f64 {
    let mut end = 0;
    let mut end_of = |list: &Vec<u64>| {
        end += list.len() as u32;
        end
    };
    let ends: Vec<u32> = lists.iter().map(&mut end_of).collect();
    let all = lists.concat();
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let mut work = all.clone();
        let start = Instant::now();
        Sort::Fastest.lists(black_box(&mut work), black_box(&ends));
        best = best.min(start.elapsed().as_secs_f64() / lists.len() as f64 * 1e9);
        black_box(work);
    }
    best
}

fn main() {
    let mut random = Random::new(1, 0);
    let names = ["n", "together/ns", "one/ns", "published/ns", "one", "published"];
    let [n, together, one, published, first, second] = names;
    println!("{n:>5} {together:>12} {one:>12} {published:>12} {first:>9} {second:>9}");
    for n in [2, 4, 8, 12, 16, 17, 24, 32, 64, 128, 512] {
        let list = |_| (0..n).map(|_| random.bits()).collect();
        let lists: Vec<Vec<u64>> = (0..LISTS).map(list).collect();
        let [ours, theirs] = [Sort::Fastest, Sort::Published].map(|sort| time(sort, &lists));
        let together = time_together(&lists);
        println!(
            "{n:>5} {together:>12.1} {ours:>12.1} {theirs:>12.1} {:>8.2}x {:>8.2}x",
            ours / together,
            theirs / together
        );
    }
}
