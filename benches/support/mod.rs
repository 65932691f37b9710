//! Paired timings: two things run in turn, and the ratio is taken pair by pair, so that a machine whose speed drifts
//! cannot decide.

use std::time::Instant;

/// Seconds that `work` takes.
#[expect(clippy::disallowed_methods, reason = "a benchmark")]
pub(crate) fn time(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// The median; the list must not be empty.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Medians over `pairs` alternating runs, after one that is not counted: seconds of `a`, of `b`, and the ratio a / b.
#[allow(dead_code, reason = "each benchmark uses its own part")]
pub(crate) fn paired(pairs: usize, mut a: impl FnMut(), mut b: impl FnMut()) -> [f64; 3] {
    a();
    b();
    let runs: Vec<[f64; 2]> = (0..pairs).map(|_| [time(&mut a), time(&mut b)]).collect();
    [
        median(runs.iter().map(|r| r[0]).collect()),
        median(runs.iter().map(|r| r[1]).collect()),
        median(runs.iter().map(|r| r[0] / r[1]).collect()),
    ]
}
