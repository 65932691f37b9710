//! Figure 13: how light is absorbed along a ray through many layers in ten groups.

use super::quality::HUNDREDFOLD;
use super::{DFB, How, MBT, Measured, SHEETS, SKB, columns, load, viewer};
use crate::error::Result;
use crate::fragment::{Fragment, data_of, depth_of};
use crate::num::planes::Distances;
use crate::render::{Kept, Rendering};
use crate::reproduce::plot::{Curve, Plot};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scheme::Record;
use crate::scheme::approximate::mbt::absorbed;

/// Layers farther apart than this are of different groups: sheets are 0.2 apart, and their discs at most 0.04.
const GROUP: f64 = 0.1;

/// How far absorbances may differ: opacities are products of the same factors, one of them by logarithms of 24 bits.
const ROUNDING: f64 = 1e-5;

/// The paper's ray.
const PRINTED: [u32; 2] = [52, 10];

/// Distances and absorbances behind them, of the middle pixel.
fn absorbances(drawn: &Rendering, distances: &Distances) -> Vec<[f64; 2]> {
    let middle = |width: u32, height: u32| (width / 2, height / 2);
    let steps: Vec<(u32, f64)> = match &drawn.kept {
        Kept::Fragments(lists) => {
            let (x, y) = middle(lists.width, lists.height);
            let opacity = |key: u64| Record::surface(0, data_of(key)).rgba[3];
            lists.pixel(x, y).iter().map(|&key| (depth_of(key), opacity(key))).collect()
        }
        Kept::Records(lists) => {
            let (x, y) = middle(lists.width, lists.height);
            lists.pixel(x, y).iter().map(|record| (record.depth, record.rgba[3])).collect()
        }
        Kept::Color(_) | Kept::Depths(_) | Kept::Gone(_) => Vec::new(),
    };
    let mut through = 1.0;
    let step = |(depth, opacity): (u32, f64)| {
        through *= 1.0 - opacity;
        [distances.along(depth), 1.0 - through]
    };
    steps.into_iter().map(step).collect()
}

/// The absorbance behind a distance.
fn behind(steps: &[[f64; 2]], distance: f64) -> f64 {
    steps.iter().take_while(|step| step[0] <= distance).last().map_or(0.0, |step| step[1])
}

/// The ends of groups.
fn groups(steps: &[[f64; 2]]) -> Vec<f64> {
    let last = steps.last().map(|step| step[0]);
    let ends = steps.windows(2).filter(|pair| pair[1][0] - pair[0][0] > GROUP);
    ends.map(|pair| pair[0][0]).chain(last).collect()
}

/// As a staircase from the front to the back.
fn staircase(name: &str, steps: &[[f64; 2]], [from, to]: [f64; 2]) -> Curve {
    let mut curve = Curve::new(name);
    let mut height = 0.0;
    curve.points.push([from, height]);
    for &[distance, absorbance] in steps {
        curve.points.extend([[distance, height], [distance, absorbance]]);
        height = absorbance;
    }
    curve.points.push([to, height]);
    curve
}

/// Places at which moments are reconstructed.
const PLACES: u32 = 400;

/// What moments of all fragments of the middle pixel say is absorbed, along the ray.
fn reconstructed(drawn: &Rendering, distances: Distances, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let Kept::Fragments(lists) = &drawn.kept else { return Vec::new() };
    let keys = lists.pixel(lists.width / 2, lists.height / 2);
    let fragments: Vec<Fragment> = keys.iter().map(|&key| Fragment::of_key(key)).collect();
    let place = |i: u32| from + (to - from) * f64::from(i) / f64::from(PLACES);
    let along: Vec<f64> = (0..=PLACES).map(place).collect();
    let absorbed = absorbed(&fragments, distances, MOMENTS, &along);
    along.into_iter().zip(absorbed).map(|(along, absorbed)| [along, absorbed]).collect()
}

/// Moments of `mbt`, as by default.
const MOMENTS: u32 = 4;

/// Figure 13.
pub(in crate::reproduce) fn staircases(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(SHEETS, scale.edge)?);
    let distances = Distances { planes: scene.camera.planes(), ..Distances::default() };
    let hows =
        [DFB, SKB, How::merging("skb+ofm", HUNDREDFOLD), How::merging("dfb+sfm", HUNDREDFOLD)];
    let mut all = Vec::new();
    for how in hows {
        all.push(how.measure(&scene, scale)?);
    }
    let steps: Vec<Vec<[f64; 2]>> =
        all.iter().map(|m: &Measured| absorbances(&m.drawn, &distances)).collect();
    let exact = &steps[0];
    let ends = groups(exact);
    let range = [exact.first(), exact.last()].map(|step| step.map_or(0.0, |step| step[0]));
    let range = [range[0] - 0.1, range[1] + 0.1];
    let last = |steps: &[[f64; 2]]| steps.last().copied().unwrap_or_default();
    let (mut rows, mut curves, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for (measured, steps) in all.iter().zip(&steps) {
        let mut cells = measured.cells(all[0].image())?;
        let [distance, absorbance] = last(steps);
        cells.extend([
            steps.len().to_string(),
            format!("{absorbance:.5}"),
            format!("{distance:.4}"),
        ]);
        rows.push(cells);
        curves.push(staircase(measured.how.method, steps, range));
    }
    let moments = MBT.measure(&scene, scale)?;
    let mut cells = moments.cells(all[0].image())?;
    let mut curve = Curve::new(MBT.method);
    curve.points = reconstructed(&all[0].drawn, distances, range);
    let absorbed = curve.points.last().map_or(0.0, |point| point[1]);
    cells.extend(["-".to_owned(), format!("{absorbed:.5}"), "-".to_owned()]);
    rows.push(cells);
    curves.push(curve);
    for (measured, steps) in all.iter().zip(&steps).skip(2) {
        let name = measured.how.method;
        let separate = measured.how.k.map_or(0, |k| k as usize - 1).min(ends.len());
        for end in &ends[..separate] {
            let (right, found) = (behind(exact, *end), behind(steps, *end));
            if (right - found).abs() > ROUNDING {
                wrong.push(format!("{name} absorbs {found:.5} up to {end:.3}, and not {right:.5}"));
            }
        }
        if (last(steps)[1] - last(exact)[1]).abs() > ROUNDING {
            wrong.push(format!("{name} absorbs {:.5} in all", last(steps)[1]));
        }
    }
    if last(&steps[1])[0] >= ends.get(ends.len().saturating_sub(2)).copied().unwrap_or(0.0) {
        wrong.push("the k+-buffer reaches the last group".to_owned());
    }
    let summary = format!(
        "the middle pixel: {} layers ({}) in {} groups ({}); the nearest 8 of them end at {:.3}, where {:.3} of {:.3} are \
         absorbed; with {} records or fewer, merging has the steps of the first {} groups, and the rest in its last",
        exact.len(),
        PRINTED[0],
        ends.len(),
        PRINTED[1],
        last(&steps[1])[0],
        last(&steps[1])[1],
        last(exact)[1],
        8,
        7.min(ends.len())
    );
    let plot = Plot {
        title: "Absorbance along a ray (z-thickness, Figure 13)".to_owned(),
        x: "distance (world units)",
        y: "absorbance",
        curves,
    };
    let columns = columns(&[], &["records of the pixel", "absorbance", "last distance"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, plot: Some(plot), verdict, ..Outcome::new("merge-fig13", summary) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_end_at_gaps() {
        let steps = [[1.0, 0.1], [1.05, 0.2], [1.2, 0.3], [1.25, 0.4]];
        assert_eq!(groups(&steps), [1.05, 1.25]);
        assert_eq!(groups(&[]), Vec::<f64>::new());
        assert_eq!(
            [behind(&steps, 0.5), behind(&steps, 1.05), behind(&steps, 9.0)],
            [0.0, 0.2, 0.4]
        );
    }
}
