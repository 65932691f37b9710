//! The same schemes on devices, by turns with ours.

use std::collections::{BTreeMap, BTreeSet};

use super::machine::Constants;
use super::measure::{First, Runs};
use super::plan::{Asked, Plan};
use super::row::Timing;
use super::stats::{median, spread};
use crate::error::Result;
use crate::exec::Method;
use crate::gpu::check::crosscheck::find;
use crate::gpu::check::open::Opened;
use crate::gpu::check::race::Contender;
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::picture::Picture;
use crate::render::{Exec, Options};

/// A method on a scene: a row for every device, executor and number of threads.
///
/// # Errors
/// The method has no twin, or drawing fails; what devices cannot do is in the row.
pub(super) fn rows(
    plan: &Plan,
    asked: &Asked,
    method: Method,
    machine: &[Constants],
    devices: &[Opened],
) -> Result<Vec<Timing>> {
    let twin = find(method)?;
    let all = plan.executors();
    let options = |exec: &(Exec, usize), sub_pixel_bits: u32| Options {
        sub_pixel_bits,
        ..plan.options(method, &exec.0, exec.1)
    };
    // First, while nothing of a device lies in this process's memory, which these measure.
    let bits: BTreeSet<u32> = devices.iter().map(Opened::bits).collect();
    let mut firsts: BTreeMap<u32, Vec<First>> = BTreeMap::new();
    for bits in bits {
        let first = |exec: &(Exec, usize)| First::new(&asked.scene, &options(exec, bits));
        firsts.insert(bits, all.iter().map(first).collect::<Result<_>>()?);
    }
    let mut rows = Vec::new();
    for opened in devices {
        let picture = Picture::new(&asked.scene, opened.bits()).thick(&asked.scene, plan.thickness);
        let picture = plan.load.into_iter().fold(picture, Picture::loaded);
        let contender = Contender::new(&opened.device, &picture, twin, plan.k);
        for (exec, first) in all.iter().zip(&firsts[&opened.bits()]) {
            let mut runs = Runs::new(&asked.scene, &options(exec, opened.bits()))?;
            let mut failed = None;
            let theirs = contender.as_ref().map_err(Clone::clone).and_then(|contender| {
                contender.seconds(plan.repeats, || failed = failed.take().or(runs.once().err()))
            });
            if let Some(error) = failed {
                return Err(error);
            }
            if theirs.is_err() && runs.draws().is_empty() {
                runs.once()?;
            }
            let row = runs.row(first, machine);
            let adapter = Some(opened.device.name.name.clone());
            let parts = contender.as_ref().ok().map(Contender::parts);
            rows.push(beside(Timing { adapter, parts, ..row }, &runs.draws(), theirs));
        }
    }
    Ok(rows)
}

/// A row with what a device took in the same turns, or why it did not.
fn beside(row: Timing, ours: &[f64], theirs: std::result::Result<Vec<f64>, Failure>) -> Timing {
    match theirs {
        Err(failure) => Timing { parts: None, unsupported: Some(failure.to_string()), ..row },
        Ok(seconds) => {
            let ratio = |(ours, theirs): (&f64, &f64)| theirs / ours;
            let ratios: Vec<f64> = ours.iter().zip(&seconds).map(ratio).collect();
            Timing {
                gpu_seconds: Some(median(seconds)),
                ratio_spread: Some(spread(&ratios)),
                ratio: Some(median(ratios)),
                ..row
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ratios are taken turn by turn: the ratio of the medians would be 3.
    #[test]
    fn a_ratio_is_the_median_of_the_turns() {
        let row = || Timing { parts: Some(2), ..Timing::default() };
        let found = beside(row(), &[1.0, 2.0, 4.0], Ok(vec![8.0, 6.0, 4.0]));
        assert_eq!(found.ratio, Some(3.0));
        let found = beside(row(), &[1.0, 2.0, 4.0], Ok(vec![8.0, 2.0, 6.0]));
        assert_eq!((found.ratio, found.gpu_seconds), (Some(1.5), Some(6.0)));
        assert_eq!((found.ratio_spread, found.parts), (Some([1.0, 8.0]), Some(2)));
        let refused = beside(row(), &[1.0], Err(Failure::Unsupported("no room".to_owned())));
        assert_eq!((refused.ratio, refused.parts), (None, None));
        assert_eq!(refused.unsupported.as_deref(), Some("no room"));
    }
}
