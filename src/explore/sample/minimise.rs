//! Minimising a failure: from a scene to one pixel, and then as any other.

use super::pixel::litmus_of;
use crate::error::Result;
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::machine::{Conditions, MOST_INVOCATIONS};
use crate::explore::program::schedule::Move;
use crate::explore::program::subject::Subject;
pub use crate::explore::replay::minimise::minimise_litmus;
use crate::explore::replay::minimise::{Failure, follow, unfit};
use crate::explore::replay::token::LitmusToken;
use crate::explore::search::explored::Limits;
use crate::explore::search::property::Property;
use crate::render::{Exec, Options, Sim, reference, render};
use crate::resolve::Kept;
use crate::scene::Scene;

/// Minimise the failure of a scene on the simulated device to a pixel with the fewest fragments.
///
/// # Errors
/// Nothing fails, or it fails only in ways that one pixel does not show.
pub fn minimise_scene(
    scene: &Scene,
    options: &Options,
    limits: &Limits<'_>,
) -> Result<LitmusToken> {
    let subject = Subject::new(options.method)?;
    let reference = reference(scene, options)?;
    let found = render(scene, options)?;
    let found = found.lists()?;
    let Some(Kept::Fragments(expected)) = &reference.kept else {
        return Err(unfit("is of a method that gives no lists of fragments"));
    };
    let [width, height] = scene.size;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let wrong = pixels.filter(|&[x, y]| found.pixel(x, y) != expected.pixel(x, y));
    let mut wrong: Vec<(usize, [u32; 2])> =
        wrong.map(|[x, y]| (reference.all.pixel(x, y).len(), [x, y])).collect();
    wrong.sort_unstable();
    if wrong.is_empty() {
        return Err(unfit("shows no difference from the exact fragments"));
    }
    for &(_, pixel) in wrong.iter().take_while(|w| w.0 <= MOST_INVOCATIONS - 4).take(16) {
        if let Some(failure) = cut(&subject, scene, options, pixel)? {
            return failure.minimise(limits);
        }
    }
    Err(unfit("fails only on pixels that cannot be cut out"))
}

/// One pixel of a scene, with its part of the schedule, if that fails too.
fn cut(
    subject: &Subject,
    scene: &Scene,
    options: &Options,
    pixel: [u32; 2],
) -> Result<Option<Failure>> {
    let Exec::Sim(sim) = &options.exec else { return Ok(None) };
    let exec = Exec::Sim(Sim { watch: Some(pixel), ..sim.clone() });
    let watched = render(scene, &Options { exec, ..options.clone() })?.watched;
    let Some(watched) = watched else { return Ok(None) };
    let litmus =
        litmus_of(subject.contract, &watched.fragments, options.k.or(subject.contract.default_k));
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let moves = watched
        .staged()
        .map(|(stage, i)| (Some(stage), Move { invocation: i as u8, alternative: 0 }));
    let (schedule, run) = follow(&subject.case(&litmus), conditions, moves);
    let property = [Property::Keeps, Property::Intact]
        .into_iter()
        .find(|p| run.violations().any(|(found, _)| found == p));
    Ok(property.map(|property| Failure {
        subject: *subject,
        conditions,
        property,
        litmus,
        schedule,
    }))
}
