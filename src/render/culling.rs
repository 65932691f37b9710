//! The frame before the frame: a depth for every pixel behind which nothing need be stored
//! ([`crate::scheme::culling`]). It runs on the same executor.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Executed, Options, Report, execute};
use crate::catalogue;
use crate::error::{Error, Result};
use crate::exec::frame::Column;
use crate::exec::{Job, Kit, Method, Tally};
use crate::fragment::sort::Sort;
use crate::memory::Inputs;
use crate::raster::FrontEnd;
use crate::render::{Exec, Policy, Sim};
use crate::scheme::bound::Bound;
use crate::scheme::contract::{Contract, Keeps};
use crate::scheme::course::Course;
use crate::scheme::culling::occupancy::{K, MOST_WORDS};
use crate::scheme::{Config, Depth};

/// Words of a mask, unless it is said otherwise: the paper's.
pub const DEFAULT_WORDS: u32 = 32;

/// Words of a pixel besides its mask: near, far and the bound.
const ENDS: u64 = 3;

/// What culling did, by the names that `--json` uses.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CullingReport {
    /// The culling method.
    pub method: String,
    /// Intervals of a pixel's depth range: 32 for each word of its mask.
    pub intervals: u32,
    /// Words of a pixel: near, far, mask and bound.
    pub words: u64,
    /// The same, where the mask takes words of a k-buffer with this k, which is not in use yet.
    pub words_reusing: Option<u64>,
    /// Bytes of those words for this image; they count in the run's bytes.
    pub bytes: u64,
    /// Fragments that did not reach the method.
    pub rejected_before: u64,
    /// Fragments that the method rejected itself.
    pub rejected_inside: u64,
    /// Memory operations of the culling passes, by kind.
    pub counters: BTreeMap<String, u64>,
}

/// What the frame gave.
pub(super) struct Culled {
    /// By storage pixel.
    pub(super) bounds: Vec<u32>,
    pub(super) report: CullingReport,
}

/// Whether a method keeps the nearest fragments, and those alone: nothing that it promises lies behind a bound.
#[must_use]
pub fn keeps_nearest(contract: &Contract) -> bool {
    match contract.keeps {
        Keeps::Nearest | Keeps::NearestBy(_) | Keeps::NearestChosen => true,
        Keeps::One | Keeps::Layers => true,
        Keeps::All | Keeps::FirstArrivals | Keeps::Visible | Keeps::Some => false,
        Keeps::Merged | Keeps::Bound | Keeps::Approximate(_) => false,
    }
}

/// Check the option against the method.
///
/// # Errors
/// Words out of range, or a method that keeps more than the nearest.
pub(super) fn check(options: &Options) -> Result<()> {
    let Some(words) = options.cull else { return Ok(()) };
    let (method, contract) = (options.method, options.method.contract());
    let wrong = |problem: String| Err(Error::new("--cull", problem));
    if !(1..=MOST_WORDS).contains(&words) {
        return wrong(format!("has {words} words a pixel, but must have 1 to {MOST_WORDS}"));
    }
    if method.is_exact() {
        return wrong(format!("{method} has no store pass that could be spared fragments"));
    }
    if contract.keeps != Keeps::Bound && !keeps_nearest(contract) {
        let problem = format!("{method} keeps more than the nearest fragments: none can be culled");
        return wrong(problem);
    }
    Ok(())
}

/// Bytes of the culling passes' words, bounds among them, for so many pixels.
pub(super) fn bytes(options: &Options, pixels: u64) -> u64 {
    match options.cull {
        Some(words) if options.method.contract().keeps != Keeps::Bound => {
            4 * (u64::from(words) + ENDS) * pixels
        }
        _ => 0,
    }
}

/// Run the passes for a method that is held to `nearest`, if the options ask for them.
pub(super) fn draw(
    options: &Options,
    front: &FrontEnd,
    nearest: &Bound,
    threads: usize,
) -> Result<Option<Culled>> {
    let own = options.method.contract().keeps == Keeps::Bound;
    let Some(words) = options.cull.filter(|_| !own) else { return Ok(None) };
    let method = catalogue::OCCUPANCY;
    let (grid, k) = (front.grid, uniform(nearest));
    let pixels = grid.storage_pixels() as u32;
    let config = Config { k, pixels, mask_words: words, grid, ..Config::default() };
    let Some(instance) = method.instance(&config) else { return Ok(None) };
    let options = passes(options, method);
    let mut inputs = Inputs::defaults(instance.layout());
    if let Bound::PerPixel(ks) = nearest
        && let Some(input) = instance.layout().inputs().iter().position(|i| i.name == K)
    {
        // A pixel that keeps nothing is treated as one that keeps its nearest.
        inputs.fill(input, ks.iter().map(|&k| k.max(1)).collect());
    }
    let contract = method.contract();
    let job = Job {
        front,
        record: options.record(),
        sort: Sort::default(),
        background: [0; 3],
        nearest: Bound::Same(0),
        contract,
        course: Course::of(&contract.program),
        holds: method.holds(),
        inputs,
        before_tile: Vec::new(),
        whole_pools: true,
        threads,
        opaque: 0,
        culling: Vec::new(),
        picture_only: false,
        kit: &Kit::default(),
    };
    let mut executed = execute(Some(&*instance), &job, k, &options)?;
    executed.frame.settle(&job);
    let report = report(method, &executed, words, nearest, &options, front);
    Ok(Some(Culled { bounds: bounds(&executed), report }))
}

/// The k of every pixel, if it is the same.
fn uniform(nearest: &Bound) -> Option<u32> {
    match nearest {
        Bound::Same(k) => Some(*k),
        Bound::All | Bound::PerPixel(_) => None,
    }
}

/// The options of the culling passes. A recorded schedule is one of the frame that follows.
fn passes(options: &Options, method: Method) -> Options {
    let exec = match &options.exec {
        Exec::Sim(sim) => {
            let policy = match &sim.policy {
                Policy::Recorded(_) => Policy::Random,
                other => other.clone(),
            };
            Exec::Sim(Sim { policy, record: false, watch: None, check: false, ..sim.clone() })
        }
        other => other.clone(),
    };
    Options {
        method,
        exec,
        depth_format: Some(options.record().depth),
        data: options.record().data,
        ..options.clone()
    }
}

fn bounds(executed: &Executed) -> Vec<u32> {
    let mut all = Vec::new();
    for tile in &executed.frame.tiles {
        if let Column::Depths(depths) = &tile.column {
            all.extend(depths.iter().map(|&Depth(depth)| depth));
        }
    }
    all
}

fn report(
    method: Method,
    executed: &Executed,
    words: u32,
    nearest: &Bound,
    options: &Options,
    front: &FrontEnd,
) -> CullingReport {
    let pixels = u64::from(front.grid.width) * u64::from(front.grid.height);
    let words = u64::from(words);
    CullingReport {
        method: method.name().to_owned(),
        intervals: 32 * words as u32,
        words: words + ENDS,
        words_reusing: uniform(nearest).map(|k| words.saturating_sub(k.into()) + ENDS),
        bytes: 4 * (words + ENDS) * pixels,
        counters: if options.counters {
            executed.frame.counters.by_name()
        } else {
            BTreeMap::new()
        },
        ..CullingReport::default()
    }
}

/// Whether no pixel can have a bound: there are no more intervals than fragments to be kept.
fn is_idle(words: u32, nearest: &Bound) -> bool {
    uniform(nearest).is_some_and(|k| 32 * u64::from(words) <= u64::from(k))
}

impl CullingReport {
    /// Complete it by what was rejected, and add it to the frame's.
    pub(super) fn add_to(
        mut self,
        report: &mut Report,
        tally: &Tally,
        options: &Options,
        nearest: &Bound,
    ) {
        self.rejected_before = tally.rejected;
        self.rejected_inside = tally.culled.saturating_sub(tally.rejected);
        report.bytes += self.bytes;
        if is_idle(options.cull.unwrap_or(DEFAULT_WORDS), nearest) {
            report.warnings.push(format!(
                "--cull: {} intervals cannot tell more fragments apart than are kept: nothing is culled",
                self.intervals
            ));
        }
        report.culling = Some(self);
    }
}
