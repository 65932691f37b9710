//! Figure 14: points without speckle, and two meshes that show their distance by colour.
//!
//! *Speckle* are covered pixels that differ from all four neighbours.

use super::{COMPARED, DFB, How, Measured, apart, columns, load, percent, viewer};
use crate::error::Result;
use crate::fragment::{data_of, depth_of};
use crate::image::{Image, row};
use crate::num::planes::Distances;
use crate::render::{Data, Kept, Options, render};
use crate::reproduce::plot::{Curve, Plot};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::{self, Overrides, Scene, Thickness};

/// The largest distance that is shown, in world units: how far the second ball was moved.
const SHOWN: f64 = 0.1;

/// Slabs reach to a depth code, a few millionths of this: pixels nearer than that to the limit are left out.
const CODE: f64 = 1e-6;

/// What is seen as another colour, of 255.
const BOUND: u8 = 8;

/// Bins of the distance.
const BINS: usize = 20;

/// The most that the share of red may change where the surfaces cross, between bins: three times an even transition's.
const JUMP: f64 = 3.0 / BINS as f64;

/// Surfels: discs in one plane, of different brightness.
const SURFELS: &str = "surfels:shape=sheets,sheets=1,count=2500,radius=0.09,jitter=0,alpha=1";

/// What two balls have at a pixel.
struct Gap {
    pixel: usize,
    /// How far the second's front lies behind the first's.
    behind: f64,
    /// How far the second fragment, of whichever, lies behind the nearest.
    next: f64,
}

fn gaps(scene: &Scene) -> Result<Vec<Gap>> {
    let options =
        Options { data: Data::Primitive, counters: false, ..Options::default().exact(None) };
    let drawn = render(scene, &options)?;
    let lists = drawn.lists()?;
    let first = scene.objects.first().map_or(0, |object| object.mesh.primitives()) as u32;
    let distances = Distances { planes: scene.camera.planes(), ..Distances::default() };
    let mut gaps = Vec::new();
    for (pixel, ends) in lists.offsets.windows(2).enumerate() {
        let keys = &lists.entries[ends[0] as usize..ends[1] as usize];
        let along = |key: &u64| distances.along(depth_of(*key));
        let front = |of_first: bool| keys.iter().find(|key| (data_of(**key) < first) == of_first);
        if let (Some(a), Some(b)) = (front(true), front(false)) {
            let next = along(&keys[1]) - along(&keys[0]);
            gaps.push(Gap { pixel, behind: along(b) - along(a), next });
        }
    }
    Ok(gaps)
}

/// The share of the first's colour by distance: means of bins.
fn shares(gaps: &[Gap], drawn: &Measured) -> Curve {
    let mut bins = [(0.0, 0u32); BINS];
    if let Kept::Records(lists) = &drawn.drawn.kept {
        for gap in gaps.iter().filter(|gap| gap.behind.abs() < SHOWN) {
            let Some(record) = lists.entries.get(lists.offsets[gap.pixel] as usize) else {
                continue;
            };
            let bin = ((gap.behind / SHOWN + 1.0) * 0.5 * BINS as f64) as usize;
            let (sum, count) = &mut bins[bin.min(BINS - 1)];
            *sum += record.rgba[0] / (record.rgba[0] + record.rgba[2]).max(1e-9);
            *count += 1;
        }
    }
    let mut curve = Curve::new("share of red");
    for (bin, (sum, count)) in bins.iter().enumerate().filter(|(_, (_, count))| *count > 0) {
        let middle = ((bin as f64 + 0.5) / BINS as f64 * 2.0 - 1.0) * SHOWN;
        curve.points.push([middle, sum / f64::from(*count)]);
    }
    curve
}

/// Covered pixels unlike all four neighbours, in per cent.
fn speckle(image: &Image, covered: &[bool]) -> f64 {
    let (width, height) = (image.width, image.height);
    let (mut some, mut all) = (0, 0);
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            if covered[(y * width + x) as usize] {
                let own = image.pixel(x, y);
                let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
                all += 1;
                some +=
                    usize::from(around.iter().all(|&(x, y)| apart(own, image.pixel(x, y)) > BOUND));
            }
        }
    }
    percent(some, all)
}

/// Figure 14.
pub(in crate::reproduce) fn comparative(scale: &Scale) -> Result<Outcome> {
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let scene = load(COMPARED, scale.edge)?;
    let gaps = gaps(&scene)?;
    let plain = DFB.measure(&scene, scale)?;
    let smooth = How::merging("dfb+sfm", Thickness::World(SHOWN)).measure(&scene, scale)?;
    let differing = |far: bool| {
        let of = gaps.iter().filter(|gap| (gap.next >= SHOWN + CODE) == far);
        let other =
            of.clone().filter(|g| plain.image().pixels[g.pixel] != smooth.image().pixels[g.pixel]);
        (other.count(), of.count())
    };
    let (far, near) = (differing(true), differing(false));
    if far.0 > 0 || far.1 == 0 {
        wrong.push(format!("{} of {} pixels beyond the thickness differ", far.0, far.1));
    }
    if near.0 == 0 {
        wrong.push("nothing is blended".to_owned());
    }
    let curve = shares(&gaps, &smooth);
    if !curve.points.windows(2).all(|pair| pair[0][1] <= pair[1][1]) {
        wrong.push("the share of red does not rise with its lead".to_owned());
    }
    let (left, right) = curve.points.split_at(curve.points.partition_point(|point| point[0] < 0.0));
    if let (Some(before), Some(after)) = (left.last(), right.first())
        && after[1] - before[1] > JUMP
    {
        wrong.push(format!(
            "the share of red jumps from {:.2} to {:.2} where the surfaces cross",
            before[1], after[1]
        ));
    }
    let unlike = |(some, all): (usize, usize)| format!("{some} of {all}");
    for measured in [&plain, &smooth] {
        let mut cells = vec!["two balls".to_owned()];
        cells.extend(measured.cells(plain.image())?);
        let none = measured.how.merges();
        let count = |pair| if none { unlike(pair) } else { "-".to_owned() };
        cells.extend([count(far), count(near), "-".to_owned()]);
        rows.push(cells);
    }
    let images = [("dfb", plain.image()), ("dfb+sfm, 0.1", smooth.image())];
    pictures.push(("balls".to_owned(), row::compose("a ball, and the same moved by 0.1", &images)));
    let points = speckles(scale, &mut rows, &mut wrong)?;
    pictures.push(("surfels".to_owned(), points));
    let summary = format!(
        "colours of two balls by distance: beyond the thickness the picture is that without merging ({} pixels); speckle \
         are pixels that differ by more than {BOUND} of 255 from all four neighbours",
        far.1
    );
    let plot = Plot {
        title: "Colour by distance between two surfaces (z-thickness, Figure 14)".to_owned(),
        x: "how far red is in front of blue (world units)",
        y: "share of red",
        curves: vec![curve],
    };
    let after = ["unlike dfb, apart", "unlike dfb, close", "speckle (%)"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome {
        columns: columns(&["scene"], &after),
        rows,
        plot: Some(plot),
        pictures,
        verdict,
        ..Outcome::new("merge-fig14", summary)
    })
}

/// Surfels in one plane.
fn speckles(scale: &Scale, rows: &mut Vec<Vec<String>>, wrong: &mut Vec<String>) -> Result<Image> {
    let size = Some([scale.edge; 2]);
    let scene = viewer(scene::load(SURFELS, &Overrides { size, ..Overrides::default() })?);
    let tenfold = Thickness::Precision(10.0);
    let hows = [DFB, How::merging("dfb+sfm", tenfold), How::merging("dfb+ofm", tenfold)];
    let (mut all, mut found) = (Vec::new(), Vec::new());
    for how in hows {
        all.push(how.measure(&scene, scale)?);
    }
    let lists = all[0].drawn.lists()?;
    let covered: Vec<bool> = lists.offsets.windows(2).map(|o| o[0] < o[1]).collect();
    for measured in &all {
        let share = speckle(measured.image(), &covered);
        let mut cells = vec!["surfels".to_owned()];
        cells.extend(measured.cells(all[0].image())?);
        cells.extend(["-".to_owned(), "-".to_owned(), format!("{share:.3}")]);
        rows.push(cells);
        found.push(share);
    }
    if found[1] >= found[0] {
        wrong.push(format!("speckle: {:.3} % with merging, {:.3} without", found[1], found[0]));
    }
    let captions: Vec<String> = all.iter().map(|m| m.how.caption()).collect();
    let images: Vec<(&str, &Image)> =
        captions.iter().map(String::as_str).zip(all.iter().map(Measured::image)).collect();
    Ok(row::compose("surfels in one plane", &images))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speckle_is_what_differs_from_all_neighbours() {
        let mut image = Image::filled(9, 9, [100, 100, 100, 255]);
        image.pixels[4 * 9 + 4] = [200, 100, 100, 255];
        assert_eq!(speckle(&image, &[true; 81]), 100.0 / 49.0);
        // Two side by side are no speckle.
        image.pixels[4 * 9 + 5] = [200, 100, 100, 255];
        assert_eq!(speckle(&image, &[true; 81]), 0.0);
    }
}
