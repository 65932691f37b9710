//! One pixel of a scene as a litmus pixel, and random runs of one that is too large to explore.

use super::walk::walk;
use crate::error::{Error, Result};
use crate::exec::sim::policy::{self, Scheduling};
use crate::explore::program::litmus::{Entry, Litmus};
use crate::explore::program::machine::{Conditions, MOST_INVOCATIONS};
use crate::explore::program::subject::Subject;
use crate::explore::search::explored::{Found, Limits};
use crate::explore::verdict::survey::Survey;
use crate::fragment::Fragment;
use crate::raster::{FrontEnd, Grid};
use crate::render::Options;
use crate::scene::Scene;
use crate::scheme::Contract;
use crate::scheme::contract::Extra;
use rayon::prelude::*;

/// The fragments of one pixel in submission order, as a litmus pixel.
///
/// # Errors
/// The pixel is outside of the picture, has no fragments, or too many to be explored.
pub fn cut(
    subject: &Subject,
    scene: &Scene,
    options: &Options,
    [x, y]: [u32; 2],
) -> Result<Litmus> {
    let [width, height] = scene.size;
    let wrong = |problem: String| Error::new("--pixel", problem);
    if x >= width || y >= height {
        return Err(wrong(format!("{x},{y} is outside of the picture of {width}x{height}")));
    }
    let grid = Grid { width, height, tile: options.tile };
    let front = FrontEnd::new(scene, grid, options.sub_pixel_bits, options.cull_face);
    let mut fragments = Vec::new();
    front.fragments_of_pixel([x, y], options.record(), |_, fragment| fragments.push(fragment));
    let most = MOST_INVOCATIONS - 4;
    if fragments.is_empty() || fragments.len() > most {
        let n = fragments.len();
        let right = format!("1 to {most} can be explored; --executions samples the whole scene");
        return Err(wrong(format!("{x},{y} has {n} fragments: {right}")));
    }
    Ok(litmus_of(subject.contract, &fragments, options.k.or(subject.contract.default_k)))
}

/// A litmus pixel of some fragments.
#[must_use]
pub fn litmus_of(contract: &Contract, fragments: &[Fragment], k: Option<u32>) -> Litmus {
    let third = |f: &Fragment| match contract.extra {
        Extra::Near => f.depth - f.extra,
        Extra::Primitive => f.extra,
        Extra::Nothing | Extra::Rank => 0,
    };
    Litmus {
        pixels: 1,
        k,
        room: fragments.len() as u32,
        fragments: fragments.iter().map(|f| Entry(0, f.depth, f.data, third(f))).collect(),
        helpers: 0,
        table: None,
        inputs: Vec::new(),
    }
}

/// As [`Survey::given`]; if a bound prevents an answer, this many random runs look for a violation, which is then
/// minimised. What they do not find stays unknown.
///
/// # Errors
/// None with a random policy.
pub fn sampled(
    subject: &Subject,
    litmus: &Litmus,
    conditions: Conditions,
    runs: u64,
    limits: &Limits<'_>,
) -> Result<Survey> {
    let mut survey = Survey::given(subject, litmus, conditions, limits);
    let explored = &mut survey.explored[0].1;
    if explored.complete {
        return Ok(survey);
    }
    let case = subject.case(litmus);
    let one = |seed: u64| {
        let scheduling = Scheduling {
            policy: policy::Policy::Random,
            seed,
            resident: MOST_INVOCATIONS,
            record: false,
            fingerprint: 0,
            watch: None,
            check: false,
        };
        walk(&case, conditions, &scheduling, limits)
    };
    let all: Vec<_> = (0..runs).into_par_iter().map(one).collect::<Result<_>>()?;
    let mut ended = 0;
    for (schedule, run) in all.into_iter().flatten() {
        ended += 1;
        for (property, message) in run.violations() {
            let found = Found { message: message.clone(), schedule: schedule.clone() };
            explored.violations.entry(*property).or_insert(found);
        }
        if let Some(end) = &run.end {
            explored.outcomes.entry(end.pixels.clone()).or_insert(schedule);
        }
    }
    if let Some(given) = &mut survey.given {
        *given += &format!(", and {ended} random runs");
    }
    Ok(survey)
}
