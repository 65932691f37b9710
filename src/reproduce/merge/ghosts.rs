//! Figures 9 and 15: what is inside becomes visible where it overlaps its shell.
//!
//! The *contrast* of what is inside is how far its pixels are from the same pixels with the shell alone, drawn in the
//! same way: the mean over red, green and blue and over these pixels, of 255.
//!
//! Slabs end at the near plane, so it must not fit the scene: it would cut the shell's to nothing.

use super::intersections::pictures;
use super::{DFB, GHOSTED, How, Measured, SHELL, columns, load, viewer};
use crate::error::Result;
use crate::fragment::data_of;
use crate::render::{Data, Options, render};
use crate::reproduce::plot::{Curve, Plot};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::{Scene, Thickness};

/// Pixels at which there is anything but the shell.
fn interior(scene: &Scene) -> Result<Vec<bool>> {
    let options =
        Options { data: Data::Primitive, counters: false, ..Options::default().exact(None) };
    let drawn = render(scene, &options)?;
    let lists = drawn.lists()?;
    let inside: Vec<bool> = scene
        .objects
        .iter()
        .flat_map(|o| std::iter::repeat_n(o.name != "shell", o.mesh.primitives()))
        .collect();
    let is_inside = |key: &u64| inside.get(data_of(*key) as usize).copied().unwrap_or(false);
    let pixels = lists.offsets.windows(2);
    Ok(pixels.map(|o| lists.entries[o[0] as usize..o[1] as usize].iter().any(is_inside)).collect())
}

/// The scene without its interior.
fn shell(scene: &Scene) -> Scene {
    let mut shell = scene.clone();
    shell.objects.retain(|object| object.name == "shell");
    shell
}

fn contrast(measured: &Measured, shell: &Scene, interior: &[bool]) -> Result<f64> {
    let alone = measured.how.draw(shell)?.image;
    let (mut sum, mut count) = (0, 0);
    for ((p, q), _) in
        alone.pixels.iter().zip(&measured.image().pixels).zip(interior).filter(|(_, i)| **i)
    {
        sum += (0..3).map(|c| u64::from(p[c].abs_diff(q[c]))).sum::<u64>();
        count += 3;
    }
    Ok(sum as f64 / f64::from(count.max(1)))
}

/// Draw with each, and measure the contrasts.
fn contrasts(scene: &Scene, hows: &[How], scale: &Scale) -> Result<(Vec<Measured>, Vec<f64>)> {
    let (interior, shell) = (interior(scene)?, shell(scene));
    let (mut all, mut found) = (Vec::new(), Vec::new());
    for how in hows {
        let measured = how.measure(scene, scale)?;
        found.push(contrast(&measured, &shell, &interior)?);
        all.push(measured);
    }
    Ok((all, found))
}

/// The first of them is exact.
fn rows(all: &[Measured], contrasts: &[f64]) -> Result<Vec<Vec<String>>> {
    let row = |(measured, contrast): (&Measured, &f64)| {
        let mut cells = measured.cells(all[0].image())?;
        cells.push(format!("{contrast:.2}"));
        Ok(cells)
    };
    all.iter().zip(contrasts).map(row).collect()
}

/// Figure 9: three balls in a nearly opaque one, by β.
pub(in crate::reproduce) fn betas(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(SHELL, scale.edge)?);
    let smooth = |beta| How { beta, ..How::merging("dfb+sfm", Thickness::World(1.0)) };
    let betas = [0.0, 0.3, 0.6, 1.0];
    let hows: Vec<How> = std::iter::once(DFB).chain(betas.map(smooth)).collect();
    let (all, found) = contrasts(&scene, &hows, scale)?;
    let mut wrong = Vec::new();
    if !found[1..].windows(2).all(|pair| pair[0] < pair[1]) {
        wrong.push(format!("contrasts by beta: {:.2?}", &found[1..]));
    }
    let summary = format!(
        "contrast of the balls inside, of 255, rises from {:.2} with beta 0 to {:.2} with beta 1; {:.2} without merging",
        found[1], found[4], found[0]
    );
    let mut curve = Curve::new("dfb+sfm");
    curve.points =
        betas.iter().zip(&found[1..]).map(|(beta, contrast)| [*beta, *contrast]).collect();
    let plot = Plot {
        title: "Contrast of what is inside (z-thickness, Figure 9)".to_owned(),
        x: "beta",
        y: "contrast (of 255)",
        curves: vec![curve],
    };
    let picture = pictures("three balls in a ball of opacity 0.99", &all);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome {
        columns: columns(&[], &["contrast"]),
        rows: rows(&all, &found)?,
        plot: Some(plot),
        pictures: vec![("betas".to_owned(), picture)],
        verdict,
        ..Outcome::new("merge-fig9", summary)
    })
}

/// Figure 15: a ghosted illustration.
pub(in crate::reproduce) fn illustration(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(GHOSTED, scale.edge)?);
    let smooth = |thickness| How::merging("dfb+sfm", Thickness::World(thickness));
    let (all, found) = contrasts(&scene, &[DFB, smooth(0.3), smooth(1.1)], scale)?;
    let mut wrong = Vec::new();
    if found[2] <= found[0] {
        wrong
            .push(format!("the contrast is {:.2} with merging, {:.2} without", found[2], found[0]));
    }
    let summary = format!(
        "contrast of the gears inside, of 255: {:.2} without merging, {:.2} with a thickness of the shell's radius",
        found[0], found[2]
    );
    let verdict = Some(Verdict::of(&wrong));
    let captions = ["dfb", "dfb+sfm, 0.3", "dfb+sfm, 1.1"];
    let images = captions.into_iter().zip(all.iter().map(Measured::image)).collect::<Vec<_>>();
    let picture = crate::image::row::compose("gears in a ball, all of opacity 0.3", &images);
    Ok(Outcome {
        columns: columns(&[], &["contrast"]),
        rows: rows(&all, &found)?,
        pictures: vec![("thickness".to_owned(), picture)],
        verdict,
        ..Outcome::new("merge-fig15", summary)
    })
}
