//! Figure 17: ambient occlusion and depth of field over merged layers.

use super::{DFB, FOCUS, How, Measured, columns, load};
use crate::effect::screen::Screen;
use crate::effect::screen::focus::Focus;
use crate::effect::screen::occlusion::Occlusion;
use crate::error::Result;
use crate::image::{Image, row};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::Thickness;

/// Thicker than the ten P(z) from which the paper's layers have a front and a back.
const THICK: Thickness = Thickness::Precision(100.0);

fn occlusion(radius: f64) -> Screen {
    let occlusion = Occlusion { radius: Some(radius), ..Occlusion::default() };
    Screen { occlusion: Some(occlusion), ..Screen::default() }
}

fn focus(aperture: f64) -> Screen {
    let focus = Focus { aperture: Some(aperture), distance: Some(5.2), ..Focus::default() };
    Screen { focus: Some(focus), ..Screen::default() }
}

/// Figure 17.
pub(in crate::reproduce) fn effects(scale: &Scale) -> Result<Outcome> {
    let scene = load(FOCUS, (scale.edge / 2).max(16))?;
    let (darker, blurred) = (occlusion(0.8), focus(0.35));
    let both = Screen { occlusion: darker.occlusion, focus: blurred.focus };
    // The degenerate cases come first: they must change nothing.
    let effects = [
        ("radius 0", Some(occlusion(0.0))),
        ("aperture 0", Some(focus(0.0))),
        ("none", None),
        ("occlusion", Some(darker)),
        ("depth of field", Some(blurred)),
        ("both", Some(both)),
    ];
    let hows = [DFB, How::merging("skb+ofm", THICK), How::merging("dfb+sfm", THICK)];
    let (mut rows, mut wrong) = (Vec::new(), Vec::new());
    let (mut shown, mut exact): (Vec<(&str, Image)>, Vec<Measured>) = (Vec::new(), Vec::new());
    for how in hows {
        let mut all = Vec::new();
        for (_, screen) in effects {
            all.push(How { screen, ..how }.once(&scene)?);
        }
        for (i, (measured, (effect, _))) in all.iter().zip(effects).enumerate() {
            let mut cells = vec![effect.to_owned()];
            cells.extend(measured.cells(exact.get(i).unwrap_or(measured).image())?);
            let seconds = measured.drawn.report.seconds.get("effect").copied();
            cells.push(format!("{:.3}", seconds.unwrap_or(0.0)));
            rows.push(cells);
            let unchanged = measured.image() == all[2].image();
            if unchanged != (i <= 2) {
                let changes = if unchanged { "changes nothing" } else { "changes the picture" };
                wrong.push(format!("{}: {effect} {changes}", how.method));
            }
        }
        if how.method == "dfb+sfm" {
            shown =
                effects.iter().zip(&all).skip(2).map(|(e, m)| (e.0, m.image().clone())).collect();
        }
        if exact.is_empty() {
            exact = all;
        }
    }
    let images: Vec<(&str, &Image)> = shown.iter().map(|(name, image)| (*name, image)).collect();
    let pictures = vec![("effects".to_owned(), row::compose("dfb+sfm at 100x", &images))];
    let summary = "effects over the layers that methods keep, beside the same over all fragments; with a radius or an \
                   aperture of 0, no bit of a picture may change"
        .to_owned();
    let columns = columns(&["effect"], &["effect (s)"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("merge-fig17", summary) })
}
