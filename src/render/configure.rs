//! From options and a scene to a method's configuration, the words of its inputs, and what it is held to.

use super::budget::{self, Budget};
use super::{Options, culling, inputs};
use crate::error::{Error, Result};
use crate::exec::{Instance, promise};
use crate::memory::Inputs;
use crate::num::planes::Distances;
use crate::raster::FrontEnd;
use crate::raster::slab::Slabs;
use crate::scene::Scene;
use crate::scheme::Config;
use crate::scheme::bound::Bound;
use crate::scheme::contract::{Demand, Extra, Keeps};
use crate::scheme::kplus_buffer::k_variable::MOST_RECORDS;

/// Fragments get the third word that the method asks for.
pub(super) fn third_word(front: FrontEnd, scene: &Scene, options: &Options) -> FrontEnd {
    match options.method.contract().extra {
        Extra::Near => front.thick(Slabs::new(scene, options.thickness)),
        Extra::Primitive => front.numbered(),
        Extra::Nothing | Extra::Rank => front,
    }
}

/// What the method must know of the scene, measured only if needed; the fragments before each tile, and in total; and
/// what a memory budget chose.
pub(super) fn configure(
    front: &FrontEnd,
    options: &Options,
    k: Option<u32>,
) -> Result<(Config, Vec<u64>, Option<Budget>)> {
    let (method, contract) = (options.method, options.method.contract());
    let grid = front.grid;
    let pixels = u64::from(grid.width) * u64::from(grid.height);
    let base = Config {
        k,
        pixels: grid.storage_pixels() as u32,
        weighting: options.importance.weighting(),
        mask_words: options.cull.unwrap_or(culling::DEFAULT_WORDS),
        grid,
        distances: Distances { planes: front.planes(), format: options.record().depth },
        merging: options.merging(),
        approximation: options.approximation,
        ..Config::default()
    };
    let (mut config, mut before_tile, mut chosen) = (base, Vec::new(), None);
    match contract.demand {
        Demand::Generated => {
            before_tile = front.count_fragments();
            for count in &mut before_tile {
                let before = config.generated;
                config.generated += *count;
                *count = before;
            }
            before_tile.push(config.generated);
        }
        Demand::MaxDepthComplexity if k.is_none() || contract.keeps == Keeps::Nearest => {
            config.max_depth_complexity = front.max_depth_complexity();
        }
        Demand::Bounded => config = budget::Scene::new(front, method, base).config(k),
        Demand::Records => config.records = records(options, k, pixels)?,
        Demand::MaxDepthComplexity | Demand::Nothing => {}
    }
    if let Some(bytes) = options.memory_budget {
        // The culling passes' words count, too.
        let culling = culling::bytes(options, u64::from(base.pixels));
        let left = bytes.checked_sub(culling).filter(|left| *left > 0).ok_or_else(|| {
            let problem = format!("{bytes} bytes: culling alone needs {culling} at this size");
            Error::new("--memory-budget", problem)
        })?;
        let scene = budget::Scene::new(front, method, base);
        let (within, budget) = scene.within(left, options.k)?;
        (config, chosen) = (within, Some(Budget { bytes, ..budget }));
    }
    if contract.crosses() {
        config.table = options.table.settings(config.generated, [grid.width, grid.height])?;
    }
    Ok((config, before_tile, chosen))
}

/// The records that a method may divide among so many pixels.
fn records(options: &Options, k: Option<u32>, pixels: u64) -> Result<u64> {
    let average = options.k_average.unwrap_or(f64::from(k.unwrap_or(8)));
    let records = (average * pixels as f64) as u64;
    if records > MOST_RECORDS {
        let option = if options.k_average.is_some() { "--k-average" } else { "-k" };
        let problem = format!("gives {pixels} pixels {records} records, at most {MOST_RECORDS}");
        return Err(Error::new(option, problem));
    }
    Ok(records)
}

/// What a method is held to on a scene.
pub(super) struct HeldTo {
    /// The words of its inputs.
    pub(super) inputs: Inputs,
    /// How many of each pixel's nearest fragments it must keep.
    pub(super) nearest: Bound,
    /// How many fragments each storage pixel has, if that decides it.
    pub(super) counts: Option<Vec<u32>>,
}

/// The words of a method's inputs, and how many of each pixel's nearest fragments it must keep.
pub(super) fn held_to(
    instance: Option<&dyn Instance>,
    scene: &Scene,
    options: &Options,
    front: &FrontEnd,
    k: Option<u32>,
) -> Result<HeldTo> {
    let contract = options.method.contract();
    let Some(instance) = instance else {
        let nearest = Bound::of(contract.reference_k(k));
        return Ok(HeldTo { inputs: Inputs::default(), nearest, counts: None });
    };
    let grid = &front.grid;
    let mut given = Vec::new();
    if contract.demand == Demand::Records {
        options.importance.check_for(scene.size)?;
        // What the caller gives comes last, and counts.
        given.extend(options.importance.inputs(scene.size));
    }
    given.extend(options.inputs.iter().cloned());
    let inputs = inputs::fill(&given, options.method, instance.layout(), scene, grid)?;
    let pixels = grid.storage_pixels() as u32;
    let counts = (contract.keeps == Keeps::NearestChosen).then(|| front.counts());
    let known = || counts.clone().unwrap_or_default();
    let nearest = promise::bound(options.method, Some(instance), k, &inputs, pixels, known);
    Ok(HeldTo { inputs, nearest, counts })
}
