//! Figure 16: volumes that thin surfaces intersect.
//!
//! A sample of a volume stands for a step of its ray. Where a surface lies within the step, one must be put in front of the
//! other, and what changes from one to the other between neighbouring pixels is seen as a *band*. The paper takes a hundred
//! times as many samples for the truth, without merging; so does this.

use super::{DFB, HYBRID, How, Measured, SLICED, columns, load};
use crate::error::Result;
use crate::image::{Image, row};
use crate::render::Marching;
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::{Scene, Thickness};

/// Samples of the truth for one of the others.
const SUPERSAMPLING: f64 = 100.0;

/// Surfaces as thin as depths allow, so that samples are cut where surfaces are.
const THIN: Thickness = Thickness::Precision(2.0);

/// The largest step of the scene's volumes.
fn step(scene: &Scene) -> f64 {
    scene.volumes.iter().map(|volume| volume.step).fold(0.0, f64::max)
}

/// Figure 16.
pub(in crate::reproduce) fn bands(scale: &Scale) -> Result<Outcome> {
    let (mut rows, mut pictures, mut wrong, mut gains) = (vec![], vec![], vec![], vec![]);
    for (name, file) in [("ellipsoids and cubes", HYBRID), ("a cloud and planes", SLICED)] {
        let scene = load(file, (scale.edge / 2).max(16))?;
        let marching = |merge, step| Marching { merge, step: Some(step), ..DFB.volumes };
        let step = step(&scene);
        let hows = [
            ("dfb", DFB, marching(false, step / SUPERSAMPLING)),
            ("dfb", DFB, marching(false, step)),
            ("dfb", DFB, marching(true, step)),
            ("dfb+sfm", How::merging("dfb+sfm", THIN), marching(true, step)),
            ("skb+ofm", How::merging("skb+ofm", THIN), marching(true, step)),
        ];
        let (mut all, mut psnr): (Vec<Measured>, Vec<f64>) = (vec![], vec![]);
        for (_, how, volumes) in hows {
            all.push(How { volumes, ..how }.once(&scene)?);
        }
        for measured in &all {
            let Marching { merge, step, .. } = measured.how.volumes;
            let truth = all[0].image();
            let mut cells = vec![
                name.to_owned(),
                step.map_or_else(String::new, |step| format!("{step}")),
                if merge { "yes" } else { "no" }.to_owned(),
            ];
            cells.extend(measured.cells(truth)?);
            let seconds = measured.drawn.report.seconds.get("effect").copied();
            cells.push(format!("{:.3}", seconds.unwrap_or(0.0)));
            rows.push(cells);
            psnr.push(measured.psnr(truth)?);
        }
        for (measured, own) in all.iter().zip(&psnr).skip(2) {
            if *own <= psnr[1] {
                wrong.push(format!(
                    "{name}: {own:.2} dB with samples merged ({}), {:.2} without",
                    measured.how.method, psnr[1]
                ));
            }
        }
        gains.push(format!("{name}: {:.2} dB without merging, {:.2} with", psnr[1], psnr[3]));
        let captions = ["100 times the samples", "no merging", "samples and surfaces merged"];
        let images: Vec<(&str, &Image)> =
            captions.into_iter().zip([0, 1, 3].map(|i: usize| all[i].image())).collect();
        let short = name.split(' ').next_back().unwrap_or(name);
        pictures.push((short.to_owned(), row::compose(name, &images)));
    }
    let summary = format!(
        "distance to the picture with a hundred times the samples, at {0}x{0}; {1}; effect (s) is the marching",
        (scale.edge / 2).max(16),
        gains.join("; ")
    );
    let columns = columns(&["scene", "step", "samples merge"], &["effect (s)"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("merge-fig16", summary) })
}
