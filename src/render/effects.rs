//! Applying an effect to a frame, and what it adds to the frame's report.

use super::{Effect, Report};
use crate::effect::ldi::Voxels;
use crate::effect::{self, Made, Stage};
use crate::error::Result;

/// Apply it; the report is the method's own so far.
pub(super) fn make(effect: &Effect, stage: &Stage<'_>, report: &mut Report) -> Result<Made> {
    let mut made = effect::make(effect, stage)?;
    report.effect = effect.name().to_owned();
    report.warnings.extend(incomplete(effect, report));
    report.warnings.append(&mut made.warnings);
    report.open_pixels = std::mem::take(&mut made.open);
    report.solid_voxels = made.voxels.as_ref().map(Voxels::solid);
    Ok(made)
}

/// Without lists, there is only the picture that was composited.
pub(super) fn none(effect: &Effect, report: &mut Report) -> Made {
    report.effect = effect.name().to_owned();
    Made::default()
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
