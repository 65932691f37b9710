//! Figure 12: what merging costs beside sorting.
//!
//! Operations are comparisons and moves of fragments: of the sort as published (insertion up to 16 fragments, shell
//! above), in the order of arrival; and of smooth merging, one comparison for each fragment that is looked at, and one
//! move for each that is merged or put out. The sizes are a quarter and a half of the experiment's edge. Seconds are of our own code on one thread: the standard library's sort, and
//! Algorithm 1 in f64, with its slabs made from depth words.

use super::quality::{HUNDREDFOLD, SETTINGS};
use super::{DFB, How, MBT, Measured, SKB, columns, median, percent};
use crate::error::Result;
use crate::exec::clock::Stopwatch;
use crate::fragment::sort;
use crate::num::depth::Format;
use crate::num::planes::Distances;
use crate::raster::slab::Slabs;
use crate::raster::{Batch, CullFace, FrontEnd, Grid, Record};
use crate::render::{Data, Exec, Options, render};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::Scene;
use crate::scheme::merging::Blending;
use crate::scheme::merging::components::Stored;
use crate::scheme::merging::slab::{Slab, merge_sorted};

/// The most that merging may take of what sorting takes, in per cent.
const NEGLIGIBLE: f64 = 15.0;

/// The slabs of every pixel, as they arrive.
fn arrivals(scene: &Scene) -> Vec<Vec<Stored>> {
    let grid = Grid { width: scene.size[0], height: scene.size[1], tile: 64 };
    let front = FrontEnd::new(scene, grid, 8, CullFace::None).thick(Slabs::new(scene, HUNDREDFOLD));
    let mut pixels = vec![Vec::new(); grid.storage_pixels()];
    let (mut batch, record) = (Batch::default(), Record { depth: Format::D32, data: Data::Color });
    front.packets_in_order(|packet| {
        front.fragments(packet, record, grid.first_pixel(packet), &mut batch);
        for f in batch.iter() {
            let slab = Stored { depth: f.depth, data: f.data, near: f.extra };
            pixels[f.pixel as usize].push(slab);
        }
    });
    pixels
}

/// Sorting and merging of a whole frame.
#[derive(Debug, Default)]
struct Work {
    sorting: usize,
    merging: usize,
    seconds: [f64; 2],
}

fn work(scene: &Scene, repeats: u32) -> Work {
    let pixels = arrivals(scene);
    let distances = Distances { planes: scene.camera.planes(), ..Distances::default() };
    let blending = Blending { beta: 1.0, ..Blending::default() };
    let mut work = Work::default();
    for mut list in pixels.iter().cloned() {
        work.merging += if list.is_empty() { 0 } else { 2 * list.len() - 1 };
        sort::published(&mut list, || work.sorting += 1);
    }
    let (mut sorts, mut merges) = (Vec::new(), Vec::new());
    for _ in 0..repeats.max(1) {
        let mut lists = pixels.clone();
        let mut watch = Stopwatch::start();
        lists.iter_mut().for_each(|list| list.sort_unstable());
        watch.lap("sort");
        let mut out = Vec::new();
        for list in &lists {
            out.clear();
            let slabs = list.iter().map(|s| Slab::of(&distances, s.depth, s.near, s.data));
            merge_sorted(slabs, 8, &blending, &mut out);
        }
        watch.lap("merge");
        let seconds = watch.seconds();
        sorts.push(seconds.get("sort").copied().unwrap_or(0.0));
        merges.push(seconds.get("merge").copied().unwrap_or(0.0));
    }
    work.seconds = [median(sorts), median(merges)];
    work
}

/// Seconds of the count pass, the store pass and resolve, on contending threads.
fn passes(how: &How, scene: &Scene, repeats: u32) -> Result<[f64; 3]> {
    let options = Options { exec: Exec::Threads, counters: false, ..how.options()? };
    let mut all = [Vec::new(), Vec::new(), Vec::new()];
    for _ in 0..repeats.max(1) {
        let seconds = render(scene, &options)?.report.seconds;
        let mut own = [0.0; 3];
        for (phase, time) in seconds {
            match phase.as_str() {
                "draw.store" => own[1] += time,
                "draw.resolve" => own[2] += time,
                "draw.clear" => {}
                other => own[0] += if other.starts_with("draw.") { time } else { 0.0 },
            }
        }
        all.iter_mut().zip(own).for_each(|(all, own)| all.push(own));
    }
    Ok(all.map(median))
}

/// Figure 12.
pub(in crate::reproduce) fn passes_of_methods(scale: &Scale) -> Result<Outcome> {
    let smooth = How::merging("dfb+sfm", HUNDREDFOLD);
    let hows = [DFB, smooth, SKB, How::merging("skb+ofm", HUNDREDFOLD), MBT];
    let (mut rows, mut many, mut slow) = (Vec::new(), Vec::new(), Vec::new());
    for setting in &SETTINGS {
        for edge in [4, 2].map(|part| (scale.edge / part).max(16)) {
            let scene = setting.scene(edge)?;
            let mut exact: Option<Measured> = None;
            for how in hows {
                let measured = how.measure(&scene, scale)?;
                let mut cells = vec![setting.name.to_owned(), edge.to_string()];
                cells.extend(measured.cells(exact.as_ref().unwrap_or(&measured).image())?);
                let seconds = passes(&how, &scene, scale.repeats)?;
                cells.extend(seconds.map(|s| format!("{s:.4}")));
                if how.method == smooth.method {
                    let Work { sorting, merging, seconds } = work(&scene, scale.repeats);
                    let share = percent(merging, sorting);
                    let time = 100.0 * seconds[1] / seconds[0].max(1e-9);
                    if share >= NEGLIGIBLE {
                        many.push(format!("{} at {edge}: {share:.1} %", setting.name));
                    }
                    if time >= NEGLIGIBLE {
                        slow.push(format!("{} at {edge}: {time:.0} %", setting.name));
                    }
                    cells.extend([sorting.to_string(), merging.to_string(), format!("{share:.1}")]);
                    cells.extend(seconds.map(|s| format!("{s:.4}")));
                } else {
                    cells.extend(["-"; 5].map(str::to_owned));
                }
                rows.push(cells);
                exact.get_or_insert(measured);
            }
        }
    }
    let mut wrong = Vec::new();
    if !many.is_empty() {
        wrong.push(format!(
            "smooth merging takes {NEGLIGIBLE} % of the sort's comparisons and moves or more: {}",
            many.join(", ")
        ));
    }
    if !slow.is_empty() {
        wrong.push(format!(
            "and of its seconds: {}; here merging is arithmetic in f64, and sorting compares integers in a cache; the \
             paper's sort runs in a GPU's memory",
            slow.join(", ")
        ));
    }
    let summary = "operations of the sort as published and of Algorithm 1, and seconds by pass, as medians; the count \
                   pass makes the offsets too"
        .to_owned();
    let after = [
        "count (s)",
        "store (s)",
        "resolve (s)",
        "sort operations",
        "merge operations",
        "merge of sort (%)",
        "sort (s)",
        "merge (s)",
    ];
    let columns = columns(&["scene", "edge"], &after);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, verdict, ..Outcome::new("merge-fig12", summary) })
}
