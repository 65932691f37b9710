//! The explorer: states and moves a second, and bytes a state.

use super::peak;
use super::plan::threads;
use super::stats::{median, timed};
use super::table::{Column, column, number, table};
use super::{Args, MOST_FRAGMENTS};
use crate::catalogue::Catalogue;
use crate::cli::terminal::wait;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::explore::program::instances::of_size;
use crate::explore::{Conditions, Family, Limits, MemoryModel, Profile, Subject, explore};
use crate::report::text::Align;

/// States after which a search is cut: its rates are those so far.
const MOST_STATES: usize = 20_000_000;

/// The search of one instance: fragments at one pixel, one behind the other, each another invocation.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct Search {
    method: String,
    /// Fragments.
    n: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    k: Option<u32>,
    memory: String,
    /// That worked on it.
    threads: usize,
    states: usize,
    moves: usize,
    /// Every state was visited.
    complete: bool,
    /// Median.
    seconds: f64,
    mstates_per_s: f64,
    mmoves_per_s: f64,
    /// Of states and moves, as far as the search keeps them; without the hash table's slots.
    bytes_per_state: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_mib: Option<f64>,
}

/// Time a search of each method under both memory models.
///
/// # Errors
/// A method is unknown or has no invocations, or a number is out of range.
pub(super) fn run(catalogue: &Catalogue, args: &Args) -> Result<Vec<Search>> {
    let methods = catalogue.select("--explore", &args.explore)?;
    if let Some(n) = args.n.filter(|n| !(1..=MOST_FRAGMENTS).contains(n)) {
        return Err(Error::new("-n", format!("is {n}, but must be 1 to {MOST_FRAGMENTS}")));
    }
    let cases = [(MemoryModel::Sequential, 4), (MemoryModel::Relaxed(Profile::Vulkan), 3)];
    let numbers = threads(args)?;
    let mut rows = Vec::new();
    for method in methods {
        for (memory, usual) in cases {
            for &threads in &numbers {
                let n = args.n.unwrap_or(usual);
                let message = format!("exploring {method} with {n} fragments");
                rows.extend(wait::during(args.output.quiet, &message, || {
                    search(method, n, args.k.unwrap_or(1), memory, threads, args.repeats)
                })?);
            }
        }
    }
    Ok(rows)
}

fn search(
    method: Method,
    n: u32,
    k: u32,
    memory: MemoryModel,
    threads: usize,
    repeats: u32,
) -> Result<Option<Search>> {
    let subject = Subject::new(method)?;
    let family = Family { fragments: n, ks: vec![k], helpers: 0 };
    let instances = of_size(&subject, &family, n);
    let Some(litmus) = instances.first() else {
        let (name, most) = (method.name(), method.contract().max_k);
        return Err(Error::new("-k", format!("is {k}, but {name} keeps 1 to {most} fragments")));
    };
    let limits = Limits { states: MOST_STATES, cancelled: &|| false };
    let conditions = Conditions { memory, warp: None };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new("--threads", format!("cannot start {threads}: {e}")))?;
    let explored = || pool.install(|| explore(&subject, litmus, conditions, &limits));
    let again = || timed(explored).0;
    let (explored, peak_mib) = peak::during(explored);
    let seconds = median((0..repeats).map(|_| again()).collect());
    let (states, moves) = (explored.states, explored.transitions);
    let rate = |count: usize| if seconds > 0.0 { count as f64 * 1e-6 / seconds } else { 0.0 };
    Ok(Some(Search {
        method: method.name().to_owned(),
        n,
        k: litmus.k,
        memory: memory.to_string(),
        threads,
        states,
        moves,
        complete: explored.complete,
        seconds,
        mstates_per_s: rate(states),
        mmoves_per_s: rate(moves),
        bytes_per_state: explored.bytes as f64 / states.max(1) as f64,
        peak_mib,
    }))
}

/// As a table for people.
pub(super) fn text(rows: &[Search]) -> String {
    table(
        &[
            column!("method", Left, |row: &Search| row.method.clone()),
            column!("n", Right, |row| row.n.to_string()),
            column!("k", Right, |row| row.k.map_or(String::new(), |k| k.to_string())),
            column!("memory", Left, |row| row.memory.clone()),
            column!("threads", Right, |row| row.threads.to_string()),
            column!("states", Right, |row| row.states.to_string()),
            column!("moves", Right, |row| row.moves.to_string()),
            column!("seconds", Right, |row| number(Some(row.seconds), 4)),
            column!("Mstates/s", Right, |row| number(Some(row.mstates_per_s), 2)),
            column!("Mmoves/s", Right, |row| number(Some(row.mmoves_per_s), 2)),
            column!("bytes/state", Right, |row| number(Some(row.bytes_per_state), 0)),
            column!("MiB", Right, |row| number(row.peak_mib, 0)),
            column!("", Left, |row| if row.complete { "" } else { "cut" }.to_owned()),
        ],
        rows,
    )
}
