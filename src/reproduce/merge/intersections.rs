//! Figures 6 and 7: where surfaces intersect.

use super::{BALLS, CROSSING, DFB, How, Measured, apart, columns, load, percent, viewer};
use crate::error::Result;
use crate::image::row;
use crate::reproduce::plot::{Curve, Plot};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::Thickness;

/// A fiftieth of the block's height, as of the paper's cylinder.
const FIFTIETH: Thickness = Thickness::World(0.02);

/// The colours along a row of the picture, between the edges of both blocks.
fn profile(measured: &Measured) -> Vec<[u8; 4]> {
    let image = measured.image();
    let (y, from, to) = (image.height / 2, image.width / 5, image.width * 4 / 5);
    (from..to).map(|x| image.pixel(x, y)).collect()
}

/// Figure 6: a smooth transition, and one in steps.
pub(in crate::reproduce) fn profiles(scale: &Scale) -> Result<Outcome> {
    let scene = load(CROSSING, scale.edge)?;
    let hows = ["dfb+sfm", "dfb+ofm", "skb+ofm"].map(|method| How::merging(method, FIFTIETH));
    let exact = DFB.measure(&scene, scale)?;
    let (mut rows, mut curves, mut steps) = (Vec::new(), Vec::new(), Vec::new());
    let mut all = vec![exact];
    for how in hows {
        all.push(how.measure(&scene, scale)?);
    }
    for measured in &all {
        let colors = profile(measured);
        let mut jumps: Vec<u8> = colors.windows(2).map(|pair| apart(pair[0], pair[1])).collect();
        jumps.sort_unstable();
        let [step, next] =
            [1, 2].map(|i| jumps.get(jumps.len().wrapping_sub(i)).copied().unwrap_or(0));
        let changes = colors.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let mut cells = measured.cells(all[0].image())?;
        cells.extend([step.to_string(), next.to_string(), changes.to_string()]);
        rows.push(cells);
        let mut curve = Curve::new(measured.how.method);
        let from = scene.size[0] / 5;
        curve.points =
            (from..).zip(&colors).map(|(x, c)| [f64::from(x), f64::from(c[0])]).collect();
        curves.push(curve);
        steps.push([step, next]);
    }
    let [plain, smooth, overlap] = [0, 1, 2].map(|i: usize| steps[i][0]);
    let mut wrong = Vec::new();
    for (measured, [step, _]) in all.iter().zip(&steps).skip(2) {
        if smooth >= *step {
            let method = measured.how.method;
            wrong.push(format!("smooth merging steps by {smooth} of 255, {method} by {step}"));
        }
    }
    if overlap >= plain {
        wrong.push(format!("merging by overlap steps by {overlap}, without by {plain}"));
    }
    let summary = format!(
        "largest step between neighbours of the middle row, of 255: {plain} without merging, {overlap} by overlap, {smooth} \
         smooth, where the fronts cross, and {} elsewhere",
        steps[1][1]
    );
    let plot = Plot {
        title: "Red along a row across an intersection (z-thickness, Figure 6)".to_owned(),
        x: "pixel",
        y: "red (of 255)",
        curves,
    };
    let pictures = vec![("methods".to_owned(), pictures("two blocks cross at 4 degrees", &all))];
    let columns = columns(&[], &["largest step", "next largest", "changes of colour"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome {
        columns,
        rows,
        plot: Some(plot),
        pictures,
        verdict,
        ..Outcome::new("merge-fig6", summary)
    })
}

/// Side by side.
pub(super) fn pictures(title: &str, all: &[Measured]) -> crate::image::Image {
    let captions: Vec<String> = all
        .iter()
        .map(|m| match m.how.beta {
            beta if m.how.method.contains("+sfm") => format!("{}, beta {beta}", m.how.method),
            _ => m.how.caption(),
        })
        .collect();
    let images = all.iter().map(Measured::image);
    row::compose(title, &captions.iter().map(String::as_str).zip(images).collect::<Vec<_>>())
}

/// What is seen as another colour, of 255.
const BOUND: u8 = 8;

/// Figure 7: β.
pub(in crate::reproduce) fn betas(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(BALLS, scale.edge)?);
    let exact = DFB.measure(&scene, scale)?;
    let mut all = Vec::new();
    for beta in [0.0, 0.5, 1.0] {
        let how = How { beta, ..How::merging("dfb+sfm", Thickness::World(0.05)) };
        all.push(how.measure(&scene, scale)?);
    }
    let mut rows = Vec::new();
    let mut shares = Vec::new();
    for measured in std::iter::once(&exact).chain(&all) {
        let pairs = exact.image().pixels.iter().zip(&measured.image().pixels);
        let other = pairs.filter(|(p, q)| apart(**p, **q) > BOUND).count();
        let share = percent(other, exact.image().pixels.len());
        let mut cells = measured.cells(exact.image())?;
        cells.push(format!("{share:.3}"));
        rows.push(cells);
        shares.push(share);
    }
    let mut wrong = Vec::new();
    if !(shares[1] < shares[2] && shares[2] < shares[3]) {
        wrong.push(format!(
            "transitions take {:.3}, {:.3} and {:.3} % of the pixels with beta 0, 0.5 and 1",
            shares[1], shares[2], shares[3]
        ));
    }
    let pictures = vec![("betas".to_owned(), pictures("three balls intersect", &all))];
    let summary = format!(
        "pixels that differ by more than {BOUND} of 255 from the picture without merging: the larger beta, the wider the \
         transition"
    );
    let columns = columns(&[], &["in transition (%)"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("merge-fig7", summary) })
}
