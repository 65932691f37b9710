//! Figures 2, 4 and 5: the slabs of a pixel, before and after they are merged. Figure 8: how opacity grows inside one.

use super::{COPLANAR, How, load, viewer};
use crate::error::Result;
use crate::fragment::{data_of, depth_of};
use crate::num::depth::code as depth_code;
use crate::num::planes::Distances;
use crate::render::{Kept, Options, Rendering, render};
use crate::reproduce::plot::{Curve, Plot};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::Thickness;
use crate::scheme::Record;
use crate::scheme::merging::slab::Visibility;

/// The thickness of Figure 5's slabs, in world units.
const THICK: f64 = 0.25;

/// What a pixel has between two distances.
#[derive(Clone, Copy, Debug)]
struct Interval {
    near: f64,
    far: f64,
    opacity: f64,
    weight: f64,
}

/// Intervals as far as they overlap, as one: two are taken together until none do.
fn together(all: &[Interval]) -> Vec<Interval> {
    let mut all = all.to_vec();
    all.sort_by(|a, b| a.far.total_cmp(&b.far));
    let pair = |all: &[Interval]| {
        let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        pairs.into_iter().find(|&(i, j)| all[i].near.max(all[j].near) < all[i].far.min(all[j].far))
    };
    while let Some((i, j)) = pair(&all) {
        let (a, b) = (all[i], all.remove(j));
        all[i] = Interval {
            near: a.near.min(b.near),
            far: a.far.max(b.far),
            opacity: 1.0 - (1.0 - a.opacity) * (1.0 - b.opacity),
            weight: a.weight + b.weight,
        };
    }
    all.sort_by(|a, b| a.far.total_cmp(&b.far));
    all
}

/// The merged records of the middle pixel.
fn records(drawn: &Rendering, distances: &Distances) -> Vec<Interval> {
    let Kept::Records(lists) = &drawn.kept else { return Vec::new() };
    let of = |record: &Record| {
        let far = distances.along(record.depth);
        let near = far - record.thickness;
        Interval { near, far, opacity: record.rgba[3], weight: record.weight }
    };
    lists.pixel(lists.width / 2, lists.height / 2).iter().map(of).collect()
}

/// Figure 5, with the model of Figure 2 and the cases of Figure 4: slabs of a real pixel.
pub(in crate::reproduce) fn slabs(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(COPLANAR, scale.edge)?);
    let distances = Distances { planes: scene.camera.planes(), ..Distances::default() };
    let exact = render(&scene, &Options::default().exact(None))?;
    let lists = exact.lists()?;
    let fragments: Vec<Interval> = lists
        .pixel(lists.width / 2, lists.height / 2)
        .iter()
        .map(|&key| {
            let far = distances.along(depth_of(key));
            let opacity = Record::surface(depth_of(key), data_of(key)).rgba[3];
            Interval { near: (far - THICK).max(scene.camera.near), far, opacity, weight: 1.0 }
        })
        .collect();
    let how = |method| How::merging(method, Thickness::World(THICK));
    let smooth = records(&how("dfb+sfm").draw(&scene)?, &distances);
    let overlapping = records(&how("dfb+ofm").draw(&scene)?, &distances);
    let expected = together(&fragments);
    let mut wrong = Vec::new();
    for (name, found) in [("dfb+sfm", &smooth), ("dfb+ofm", &overlapping)] {
        if !agree(found, &expected, &distances) {
            wrong.push(format!("{name} gives {found:.4?} instead of {expected:.4?}"));
        }
    }
    let stages = [("dfb+ofm", &overlapping), ("dfb+sfm", &smooth), ("fragments", &fragments)];
    let (mut rows, mut curves, mut lane) = (Vec::new(), Vec::new(), 0.0);
    for (name, intervals) in stages {
        let mut curve = Curve::new(name);
        for (i, interval) in intervals.iter().enumerate() {
            let Interval { near, far, opacity, weight } = *interval;
            let high = lane + 0.9 * opacity;
            curve.rectangle([near, far], [lane, high]);
            // Fragments overlap, records do not.
            lane += if name == "fragments" { 1.0 } else { 0.0 };
            rows.push(vec![
                name.to_owned(),
                (i + 1).to_string(),
                format!("{near:.5}"),
                format!("{far:.5}"),
                format!("{:.5}", far - near),
                format!("{opacity:.5}"),
                format!("{weight}"),
            ]);
        }
        curves.push(curve);
        lane += 1.0;
    }
    let summary = format!(
        "the middle pixel of {} at thickness {THICK}: {} slabs become {} records; a box's height is its opacity",
        scene.name,
        fragments.len(),
        overlapping.len()
    );
    let plot = Plot {
        title: "Slabs of a pixel (z-thickness, Figure 5)".to_owned(),
        x: "distance from the eye (world units)",
        y: "merged by overlap, smoothly, and each fragment",
        curves,
    };
    let columns = vec!["method", "record", "near", "far", "thickness", "opacity", "fragments"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, plot: Some(plot), verdict, ..Outcome::new("merge-fig5", summary) })
}

/// Whether both are the same intervals of the same opacity, up to two depth codes, and to eight bits of a product.
fn agree(found: &[Interval], expected: &[Interval], distances: &Distances) -> bool {
    let code = |far: f64| {
        let word = depth_code(distances.planes.depth(far));
        far - distances.along(word.saturating_sub(2))
    };
    let near = |a: f64, b: f64, bound: f64| (a - b).abs() <= bound;
    found.len() == expected.len()
        && found.iter().zip(expected).all(|(f, e)| {
            near(f.near, e.near, code(e.far))
                && near(f.far, e.far, code(e.far))
                && near(f.opacity, e.opacity, 1e-5)
                && near(f.weight, e.weight, 1e-9)
        })
}

/// Figure 8: equation (4).
pub(in crate::reproduce) fn opacities(_: &Scale) -> Result<Outcome> {
    const STEPS: u32 = 100;
    let (mut rows, mut curves, mut gaps) = (Vec::new(), Vec::new(), Vec::new());
    let mut wrong = Vec::new();
    for opacity in [0.1, 0.5, 0.99] {
        let visibility = Visibility { opacity, ..Visibility::default() };
        let mut gap = 0.0f64;
        for beta in [0.0, 0.5, 1.0] {
            let mut curve = Curve::new(&format!("A = {opacity}, beta {beta}"));
            for step in 0..=STEPS {
                let share = f64::from(step) / f64::from(STEPS);
                let grown = visibility.opacity_to(share, beta);
                curve.points.push([share, grown]);
                gap = gap.max((grown - visibility.opacity_to(share, 1.0)).abs());
            }
            let ends = [curve.points[0][1], curve.points[STEPS as usize][1]];
            if ends != [0.0, opacity] {
                wrong.push(format!("{} goes from {} to {}", curve.name, ends[0], ends[1]));
            }
            let middle = curve.points[STEPS as usize / 2][1];
            rows.push(vec![
                opacity.to_string(),
                beta.to_string(),
                format!("{}", ends[0]),
                format!("{middle:.4}"),
                format!("{}", ends[1]),
                format!("{gap:.4}"),
            ]);
            // As in the figure.
            curves.extend((opacity > 0.1).then_some(curve));
            if beta == 0.0 {
                gaps.push(gap);
            }
        }
    }
    if !(gaps[0] < 0.01 && gaps[0] < gaps[1] && gaps[1] < gaps[2]) {
        wrong.push(format!("beta changes opacities 0.1, 0.5 and 0.99 by {gaps:.4?}"));
    }
    let summary = format!(
        "opacity on the way through a slab: beta changes it by at most {:.4} of 0.1, {:.4} of 0.5 and {:.4} of 0.99",
        gaps[0], gaps[1], gaps[2]
    );
    let plot = Plot {
        title: "Opacity inside of a slab (z-thickness, Figure 8)".to_owned(),
        x: "share of the thickness",
        y: "opacity",
        curves,
    };
    let columns = vec![
        "opacity A",
        "beta",
        "in front",
        "in the middle",
        "behind",
        "largest distance to beta 1",
    ];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, plot: Some(plot), verdict, ..Outcome::new("merge-fig8", summary) })
}
