//! Applying an effect to a frame, and what it adds to the frame's report.

pub(super) mod linear;

use super::{Effect, Options, Report, no_lists};
use crate::effect::layers::Layers;
use crate::effect::ldi::Voxels;
use crate::effect::{self, Made, Stage};
use crate::error::Result;
use crate::image::Image;
use crate::scene::Scene;
use crate::scheme::HeldKind;

/// Apply it to what a method kept, and its picture; the report is the method's own so far.
pub(super) fn make(
    options: &Options,
    layers: &Layers<'_>,
    composited: &Image,
    report: &mut Report,
) -> Result<Made> {
    let Layers { scene, front, format, kept, .. } = *layers;
    let effect = &options.effect;
    let mut made = match kept.fragments() {
        _ if effect.takes_layers() => {
            effect::make_of_layers(effect, layers, &options.volumes, options.beta, composited)
        }
        Some(lists) => {
            let mut made = effect::make(effect, &Stage { scene, front, format, lists })?;
            made.warnings.extend(effect::without_volumes(effect, scene));
            made
        }
        // Refused before anything was drawn.
        None => Made::default(),
    };
    report.effect = effect.name().to_owned();
    report.warnings.extend(incomplete(effect, report));
    report.warnings.append(&mut made.warnings);
    report.open_pixels = std::mem::take(&mut made.open);
    report.solid_voxels = made.voxels.as_ref().map(Voxels::solid);
    Ok(made)
}

/// Volumes are drawn between layers, and screen-space effects keep another copy of them.
pub(super) fn check(options: &Options, scene: &Scene) -> Result<()> {
    options.effect.check(scene)?;
    options.volumes.check(scene)?;
    linear::check(options, scene)?;
    let holds = options.method.holds();
    let layered = matches!(holds, HeldKind::Fragments | HeldKind::Records);
    if !scene.volumes.is_empty() && !layered {
        return Err(no_lists(options.method.name(), holds, "the scene's volumes"));
    }
    Ok(())
}

/// Warns that an effect that walks through solids has not seen all of their faces.
fn incomplete(effect: &Effect, report: &Report) -> Option<String> {
    let Report { method, generated, .. } = report;
    let missing = generated.saturating_sub(report.kept);
    (missing > 0 && effect.needs_solids()).then(|| {
        format!(
            "{}: {method} did not keep {missing} of {generated} fragments, so what lies behind them may be \
             wrong, and closed objects may seem open",
            effect.name()
        )
    })
}
