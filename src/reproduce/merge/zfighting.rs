//! Figures 1 and 3: surfaces in one plane fight for the front, unless they are merged.
//!
//! Fighting must be told from motion, which changes pixels as well. The scene says which faces lie in one plane, so what
//! a pixel should show is known without depths ([`super::coplanar`]). A frame's *error* is what it shows less that. A
//! pixel flickers if, from one frame to the next, the same faces lie at it in the same order, and its error changes by
//! more than [`BOUND`]: then only the faces' order in their plane can have changed. Pixels are counted among those that
//! have such faces in both frames.

use std::f64::consts::TAU;

use super::coplanar::{Blended, blended};
use super::{COPLANAR, DFB, How, Measured, TWINS, apart, columns, load, percent, viewer};
use crate::error::Result;
use crate::image::{Image, row};
use crate::reproduce::plot::{Curve, Plot};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::{Scene, Thickness};

/// What is seen as another colour, of 255.
const BOUND: u8 = 8;

/// Frames of the orbit.
const FRAMES: u32 = 60;

/// Merged pictures may flicker at this many per cent of the pixels, at edges, where other faces come within reach too.
const STILL: f64 = 1.0;

/// The paper's thickness.
const TWICE: Thickness = Thickness::Precision(2.0);

/// What is thick beside the rounding of vertices.
const FIFTYFOLD: Thickness = Thickness::Precision(50.0);

/// The same where planes fit the scene.
const MYRIADFOLD: Thickness = Thickness::Precision(10_000.0);

/// The methods of both figures.
const HOWS: [How; 4] = [
    DFB,
    How::merging("dfb+sfm", TWICE),
    How::merging("dfb+ofm", TWICE),
    How::merging("skb+ofm", TWICE),
];

/// The scene seen from farther around it.
fn turned(scene: &Scene, frame: u32) -> Scene {
    let mut scene = scene.clone();
    let camera = &mut scene.camera;
    let (s, c) = libm::sincos(TAU * f64::from(frame) / f64::from(FRAMES));
    let away = camera.eye - camera.target;
    camera.eye.x = camera.target.x + (c * away.x + s * away.z);
    camera.eye.z = camera.target.z + (c * away.z - s * away.x);
    scene
}

type Errors = Vec<[i16; 3]>;

fn errors(shown: &Image, right: &Image) -> Errors {
    let of = |(p, q): (&[u8; 4], &[u8; 4])| [0, 1, 2].map(|c| i16::from(p[c]) - i16::from(q[c]));
    shown.pixels.iter().zip(&right.pixels).map(of).collect()
}

/// Pixels that flicker, and pixels that could, in per cent.
fn flickers(before: (&Blended, &Errors), now: (&Blended, &Errors)) -> f64 {
    let (mut some, mut all) = (0, 0);
    for i in 0..now.1.len() {
        let same = before.0.stacks[i] == now.0.stacks[i];
        if same && before.0.coplanar[i] && now.0.coplanar[i] {
            all += 1;
            let change = |c: usize| (before.1[i][c] - now.1[i][c]).unsigned_abs();
            some += usize::from((0..3).any(|c| change(c) > u16::from(BOUND)));
        }
    }
    percent(some, all)
}

/// Pixels with faces in one plane that are not as they should be, in per cent.
fn unlike(blended: &Blended, shown: &Image) -> f64 {
    let pairs = blended.image.pixels.iter().zip(&shown.pixels).zip(&blended.coplanar);
    let coplanar = || pairs.clone().filter(|(_, coplanar)| **coplanar);
    percent(coplanar().filter(|((p, q), _)| apart(**p, **q) > BOUND).count(), coplanar().count())
}

/// Figure 3: two cubes, on an orbit.
pub(in crate::reproduce) fn orbit(scale: &Scale) -> Result<Outcome> {
    let scene = load(TWINS, (scale.edge / 2).max(16))?;
    // Beside the viewer's planes, those that fit the scene.
    let fitted = load(TWINS, scene.size[0])?;
    let far = viewer(scene);
    let mut runs = HOWS.map(|how| ("viewer", &far, how)).to_vec();
    runs.push(("viewer", &far, How::merging("dfb+sfm", FIFTYFOLD)));
    runs.extend([TWICE, MYRIADFOLD].map(|t| ("fitted", &fitted, How::merging("dfb+sfm", t))));
    let name = |(planes, _, how): &(&str, &Scene, How)| match *planes {
        "viewer" => how.caption(),
        planes => format!("{}, {planes} planes", how.caption()),
    };
    let mut curves: Vec<Curve> = runs.iter().map(|run| Curve::new(&name(run))).collect();
    let mut last: Option<(Blended, Vec<Errors>)> = None;
    for frame in 0..FRAMES {
        let now = blended(&turned(&far, frame))?;
        let mut all = Vec::new();
        for (_, scene, how) in &runs {
            all.push(errors(&how.draw(&turned(scene, frame))?.image, &now.image));
        }
        if let Some((before, old)) = &last {
            for (i, curve) in curves.iter_mut().enumerate() {
                let share = flickers((before, &old[i]), (&now, &all[i]));
                curve.points.push([f64::from(frame), share]);
            }
        }
        last = Some((now, all));
    }
    let right = blended(&far)?;
    let (mut rows, mut drawn, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for ((planes, scene, how), curve) in runs.iter().zip(&curves) {
        let measured = how.measure(scene, scale)?;
        let shares = curve.points.iter().map(|point| point[1]);
        let mean = shares.clone().sum::<f64>() / curve.points.len().max(1) as f64;
        let worst = shares.fold(0.0, f64::max);
        let mut cells = vec![(*planes).to_owned()];
        cells.extend(measured.cells(&right.image)?);
        cells.extend([unlike(&right, measured.image()), mean, worst].map(|x| format!("{x:.2}")));
        rows.push(cells);
        if !how.merges() && mean < 10.0 * STILL {
            wrong.push(format!("{} flickers at {mean:.2} % of the pixels only", curve.name));
        }
        // Other planes than a viewer's are for comparison.
        if how.merges() && *planes == "viewer" && worst > STILL {
            wrong.push(format!("{} flickers at up to {worst:.2} % of the pixels", curve.name));
        }
        drawn.push(measured);
    }
    if !wrong.is_empty() {
        wrong.push(
            "vertices are snapped to 1/256 of a pixel, which moves a slope's depths by a part of the thickness; smooth \
             merging shows that part, merging by overlap does not"
                .to_owned(),
        );
    }
    let pictures =
        vec![("frame-0".to_owned(), side_by_side("two cubes", &right.image, &drawn[..4]))];
    let summary = format!(
        "flicker: pixels whose colour changes by more than {BOUND} of 255 against the mixed planes, while the same faces lie \
         there; of {FRAMES} frames of {0}x{0}; merged pictures may flicker at {STILL} %",
        far.size[0]
    );
    let plot = Plot {
        title: "Pixels that flicker on an orbit (z-thickness, Figure 3)".to_owned(),
        x: "frame",
        y: "flickering pixels (%)",
        curves,
    };
    let verdict = Some(Verdict::of(&wrong));
    let after = ["unlike the mix (%)", "mean flicker (%)", "largest flicker (%)"];
    let columns = columns(&["planes"], &after);
    Ok(Outcome {
        columns,
        rows,
        plot: Some(plot),
        pictures,
        verdict,
        ..Outcome::new("merge-fig3", summary)
    })
}

fn side_by_side(title: &str, right: &Image, drawn: &[Measured]) -> Image {
    let captions: Vec<String> = drawn.iter().map(|m| m.how.caption()).collect();
    let mut all: Vec<(&str, &Image)> =
        captions.iter().map(String::as_str).zip(drawn.iter().map(Measured::image)).collect();
    all.push(("planes mixed", right));
    row::compose(title, &all)
}

/// Figure 1: a ball and three cubes.
pub(in crate::reproduce) fn teaser(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(COPLANAR, scale.edge)?);
    let right = blended(&scene)?;
    let (mut rows, mut drawn, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let mut plain = 0.0;
    for how in HOWS {
        let measured = how.measure(&scene, scale)?;
        let share = unlike(&right, measured.image());
        let mut cells = measured.cells(&right.image)?;
        cells.push(format!("{share:.2}"));
        rows.push(cells);
        if !how.merges() {
            plain = share;
        } else if share > STILL.max(0.1 * plain) {
            wrong.push(format!(
                "{}: {share:.2} % of the pixels are unlike the mix, {plain:.2} % with all fragments",
                how.method
            ));
        }
        drawn.push(measured);
    }
    let pictures =
        vec![("methods".to_owned(), side_by_side("a ball and three cubes", &right.image, &drawn))];
    let summary = format!(
        "of the pixels with faces in one plane, those that differ by more than {BOUND} of 255 from the planes mixed; the \
         paper's (b), a parameterized transmittance, is not here"
    );
    let columns = columns(&[], &["unlike the mix (%)"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("merge-fig1", summary) })
}
