//! The importance paper (2017): Tables 1 and 2, Figures 1 to 5.
//!
//! The paper's budget M is that of the records alone: 20 MB gave a fixed k of 1 at 1024 x 1024 pixels, 35 MB one of 2
//! or 3. Here every method has M = that k times the pixels as records; what their lists, counters and starts take
//! besides is in the bytes.

use super::plot::{Curve, Plot};
use super::{Outcome, Scale, Verdict, word};
use crate::catalogue;
use crate::error::Result;
use crate::image::heat::Map;
use crate::image::sheet::{self, Labels};
use crate::image::{Image, similarity};
use crate::raster::{CullFace, FrontEnd, Grid};
use crate::render::{Factors, Importance, Options, Rendering, fresnel, render, storage_bytes};
use crate::scene::{self, Overrides, Scene};
use crate::scheme::Config;
use crate::scheme::kplus_buffer::k_variable::ONE;

/// A scene of the paper, and ours of the same kind.
struct Setting {
    name: &'static str,
    ours: &'static str,
    /// The eye's distance from its target, as a share of the default.
    distance: f64,
    /// The largest depth complexity in the paper.
    depth: u32,
    /// The fixed k that its budget allows.
    k: u32,
    /// k and loss in per cent of the fixed, the dynamic and the variable k-buffer.
    printed: [(&'static str, u32); 3],
}

const SETTINGS: [Setting; 4] = [
    Setting {
        name: "beard",
        ours: "beard",
        distance: 1.0,
        depth: 92,
        k: 1,
        printed: [("1", 87), ("1-4", 60), ("1-7", 53)],
    },
    Setting {
        name: "smoke",
        ours: "smoke",
        distance: 0.6,
        depth: 16,
        k: 2,
        printed: [("2", 62), ("1-4", 47), ("1-5", 39)],
    },
    Setting {
        name: "bottles",
        ours: "bottles:rows=4",
        distance: 0.9,
        depth: 22,
        k: 2,
        printed: [("2", 70), ("1-3", 55), ("1-5", 46)],
    },
    Setting {
        name: "greenhouse",
        ours: "greenhouse",
        distance: 0.55,
        depth: 106,
        k: 3,
        printed: [("3", 80), ("1-4", 74), ("1-10", 72)],
    },
];

const METHODS: [&str; 3] = ["kplus-array", "kplus-sb", "k-variable"];

impl Setting {
    fn scene(&self, edge: u32) -> Result<Scene> {
        let size = Some([edge; 2]);
        let mut scene = scene::load(self.ours, &Overrides { size, ..Overrides::default() })?;
        let camera = &mut scene.camera;
        camera.eye = camera.target + (camera.eye - camera.target) * self.distance;
        camera.near *= self.distance * 0.2;
        Ok(scene)
    }
}

/// A method at a budget of records.
struct Measured {
    drawn: Rendering,
    k: String,
    psnr: Option<f64>,
    ssim: f64,
    seconds: f64,
}

/// Draw a scene with each method, given so many records.
fn measure(scene: &Scene, records: u64, repeats: u32) -> Result<(Image, Vec<Measured>)> {
    let draw = |options: &Options| render(scene, options);
    let exact = Options { counters: false, ..options("exact")? };
    let exact = draw(&exact)?;
    let [width, height] = scene.size;
    let pixels = u64::from(width) * u64::from(height);
    let mut all = Vec::new();
    for method in METHODS {
        let mut options = options(method)?;
        let k = match method {
            "k-variable" => {
                options.k_average = Some(records as f64 / pixels as f64);
                None
            }
            "kplus-sb" => Some(dynamic_k(scene, records)),
            _ => Some(((records / pixels) as u32).max(1)),
        };
        options.k = k;
        let drawn = draw(&options)?;
        let timed = Options { counters: false, ..options };
        let mut seconds = Vec::new();
        for _ in 0..repeats.max(1) {
            seconds.push(draw(&timed)?.report.seconds.get("draw").copied().unwrap_or(0.0));
        }
        seconds.sort_by(f64::total_cmp);
        let range = match (&drawn.report.importance, k) {
            (Some(i), _) => format!("{}-{}", i.smallest_k, i.largest_k),
            (None, Some(k)) if method == "kplus-sb" => format!("1-{k}"),
            (None, k) => k.map_or_else(|| "-".to_owned(), |k| k.to_string()),
        };
        all.push(Measured {
            psnr: similarity::psnr(&exact.image, &drawn.image)?,
            ssim: similarity::ssim(&exact.image, &drawn.image)?,
            k: range,
            seconds: seconds[seconds.len() / 2],
            drawn,
        });
    }
    Ok((exact.image, all))
}

fn options(method: &str) -> Result<Options> {
    Ok(Options { method: catalogue::method(method)?, ..Options::default() })
}

/// The largest k whose fragments all find a record: Σ min(f, k) <= M, from the histogram.
fn dynamic_k(scene: &Scene, records: u64) -> u32 {
    let grid = Grid { width: scene.size[0], height: scene.size[1], tile: 64 };
    let histogram = FrontEnd::new(scene, grid, 8, CullFace::None).depth_complexity();
    let stored =
        |k: u64| -> u64 { (0..).zip(&histogram).map(|(f, n): (u64, &u64)| f.min(k) * n).sum() };
    let most = histogram.len() as u64;
    (1..=most).take_while(|&k| k == 1 || stored(k) <= records).last().unwrap_or(1) as u32
}

impl Measured {
    /// In per cent.
    fn loss(&self) -> f64 {
        let report = &self.drawn.report;
        100.0 * (report.generated - report.kept) as f64 / report.generated.max(1) as f64
    }

    /// Memory operations of a fragment.
    fn operations(&self) -> f64 {
        let report = &self.drawn.report;
        let counted = ["bytes", "failed_exchanges", "spins"];
        let sum: u64 = report
            .counters
            .iter()
            .filter(|(n, _)| !counted.contains(&n.as_str()))
            .map(|(_, c)| c)
            .sum();
        sum as f64 / report.generated.max(1) as f64
    }

    fn decibels(&self) -> String {
        self.psnr.map_or_else(|| "equal".to_owned(), |psnr| format!("{psnr:.2}"))
    }
}

/// Table 2: k, stored fragments and loss of three methods in one budget.
pub(super) fn losses(scale: &Scale) -> Result<Outcome> {
    let columns = vec![
        "scene",
        "depth (paper)",
        "depth",
        "method",
        "k (paper)",
        "k",
        "stored",
        "loss % (paper)",
        "loss %",
        "records used %",
        "words per pixel",
        "bytes",
        "operations per fragment",
        "seconds",
        "PSNR (dB)",
        "SSIM",
    ];
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for setting in &SETTINGS {
        let scene = setting.scene(scale.edge)?;
        let pixels = u64::from(scale.edge) * u64::from(scale.edge);
        let records = u64::from(setting.k) * pixels;
        let (exact, all) = measure(&scene, records, scale.repeats)?;
        for ((method, measured), (k, loss)) in METHODS.iter().zip(&all).zip(setting.printed) {
            let report = &measured.drawn.report;
            rows.push(vec![
                setting.name.to_owned(),
                setting.depth.to_string(),
                report.max_depth_complexity.to_string(),
                (*method).to_owned(),
                k.to_owned(),
                measured.k.clone(),
                report.kept.to_string(),
                loss.to_string(),
                format!("{:.1}", measured.loss()),
                format!("{:.1}", 100.0 * report.kept as f64 / records as f64),
                format!("{:.2}", report.bytes as f64 / 4.0 / pixels as f64),
                report.bytes.to_string(),
                format!("{:.1}", measured.operations()),
                format!("{:.3}", measured.seconds),
                measured.decibels(),
                format!("{:.5}", measured.ssim),
            ]);
            let labels = Labels {
                title: format!("{method} \u{b7} {} \u{b7} k {}", setting.name, measured.k),
                facts: format!("loss {:.1} %, PSNR {}", measured.loss(), measured.decibels()),
                captions: ["all fragments".into(), (*method).into(), "difference".into()],
            };
            let picture = sheet::compose(&labels, &exact, &measured.drawn.image)?;
            pictures.push((format!("{}-{method}", setting.name), picture));
        }
        let [fixed, dynamic, variable] = [&all[0], &all[1], &all[2]].map(Measured::loss);
        if !(variable < dynamic && dynamic < fixed) {
            wrong.push(format!(
                "{}: {variable:.1} % with variable k, {dynamic:.1} % with dynamic, {fixed:.1} % with fixed: {}",
                setting.name,
                why(&all[2], records)
            ));
        }
    }
    let summary = format!(
        "losses of fixed, dynamic and variable k in one budget of records, at {0}x{0}",
        scale.edge
    );
    Ok(Outcome {
        columns,
        rows,
        pictures,
        verdict: Some(Verdict::of(&wrong)),
        ..Outcome::new("varik-table2", summary)
    })
}

/// Why the variable k-buffer stores less than its budget: what rounding down leaves over, and what is given to pixels
/// with fewer fragments than that.
fn why(variable: &Measured, records: u64) -> String {
    let report = &variable.drawn.report;
    let shared = report.importance.as_ref().map_or(0, |i| i.shared);
    let part = |n: u64| 100.0 * n as f64 / records.max(1) as f64;
    format!(
        "of M, {:.1} % are lost to rounding k(p) down, and {:.1} % are given to pixels with fewer fragments",
        part(records - shared.min(records)),
        part(shared.saturating_sub(report.kept))
    )
}

/// Figures 1 and 5: how near the picture comes to the exact one as the budget grows.
fn qualities(
    name: &'static str,
    title: &'static str,
    which: &[usize],
    scale: &Scale,
) -> Result<Outcome> {
    const AVERAGES: [u32; 5] = [1, 2, 3, 4, 6];
    let (mut rows, mut wrong, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    let mut curves = Vec::new();
    for setting in which.iter().map(|&i| &SETTINGS[i]) {
        let scene = setting.scene(scale.edge)?;
        let first = curves.len();
        curves.extend(METHODS.map(|method| Curve::new(&format!("{}, {method}", setting.name))));
        for average in AVERAGES {
            let records = u64::from(average) * u64::from(scale.edge) * u64::from(scale.edge);
            let (exact, all) = measure(&scene, records, 1)?;
            for (i, (method, measured)) in METHODS.iter().zip(&all).enumerate() {
                rows.push(vec![
                    setting.name.to_owned(),
                    average.to_string(),
                    (*method).to_owned(),
                    measured.k.clone(),
                    format!("{:.1}", measured.loss()),
                    measured.decibels(),
                    format!("{:.5}", measured.ssim),
                    measured.drawn.report.bytes.to_string(),
                ]);
                if let Some(psnr) = measured.psnr {
                    curves[first + i].points.push([f64::from(average), psnr]);
                }
                if average == setting.k {
                    let error = errors(&exact, &measured.drawn.image, setting.name, method);
                    pictures.push((format!("{}-{method}", setting.name), error));
                }
            }
            // Equal pictures are the best.
            let [fixed, dynamic, variable] =
                [0, 1, 2].map(|i| all[i].psnr.unwrap_or(f64::INFINITY));
            if !(variable >= dynamic && dynamic >= fixed) {
                wrong.push(format!(
                    "{} with {average} records a pixel: {} dB with variable k, {} with dynamic, {} with fixed; {}",
                    setting.name,
                    all[2].decibels(),
                    all[1].decibels(),
                    all[0].decibels(),
                    why(&all[2], records)
                ));
            }
        }
    }
    let plot = Plot { title, x: "records per pixel", y: "PSNR (dB)", curves };
    let columns =
        vec!["scene", "records per pixel", "method", "k", "loss %", "PSNR (dB)", "SSIM", "bytes"];
    let summary = "distance to the picture with all fragments, by budget".to_owned();
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome {
        columns,
        rows,
        plot: Some(plot),
        pictures,
        verdict,
        ..Outcome::new(name, summary)
    })
}

/// The largest difference of a channel at every pixel, as a map.
fn errors(exact: &Image, other: &Image, scene: &str, method: &str) -> Image {
    let apart = |(p, q): (&[u8; 4], &[u8; 4])| (0..4).map(|c| p[c].abs_diff(q[c])).fold(0, u8::max);
    let values: Vec<f64> =
        exact.pixels.iter().zip(&other.pixels).map(|pair| f64::from(apart(pair))).collect();
    let most = values.iter().copied().fold(1.0, f64::max);
    let title = format!("{method} \u{b7} {scene} \u{b7} error");
    let meaning = "largest difference of a channel to all fragments, of 255";
    Map { title: &title, meaning, size: [exact.width, exact.height], values: &values, most }.draw()
}

/// Figure 1: beard and smoke.
pub(super) fn teaser(scale: &Scale) -> Result<Outcome> {
    qualities("varik-fig1", "PSNR by budget (variable k, Figure 1)", &[0, 1], scale)
}

/// Figure 5: bottles and greenhouse.
pub(super) fn evaluation(scale: &Scale) -> Result<Outcome> {
    qualities("varik-fig5", "PSNR by budget (variable k, Figure 5)", &[2, 3], scale)
}

/// Figures 2 and 4: the factors as maps.
fn maps(name: &'static str, scale: &Scale) -> Result<Outcome> {
    let setting = &SETTINGS[2];
    let scene = setting.scene(scale.edge)?;
    let size = scene.size;
    let base = options("k-variable")?;
    let before = fresnel(&scene, &base);
    let all = Importance { fresnel: Some((size, before)), ..Importance::default() };
    let only = |factors: Factors| Importance { factors, ..all.clone() };
    let none = Factors { depth: false, periphery: false, fresnel: false, map: false, noise: false };
    let corner = f64::from(scale.edge) * 0.125;
    let gazing =
        Importance { gaze: Some([corner, corner]), ..only(Factors { periphery: true, ..none }) };
    let chosen = [
        ("depth", only(Factors { depth: true, ..none })),
        ("periphery", only(Factors { periphery: true, ..none })),
        ("periphery-gaze", gazing),
        ("fresnel", only(Factors { fresnel: true, ..none })),
        ("importance", all.clone()),
    ];
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let mut peaks = Vec::new();
    for (factor, importance) in chosen {
        let noisy = importance.factors.noise;
        let drawn = render(&scene, &Options { importance, k: Some(setting.k), ..base.clone() })?;
        let shares = drawn.shares.unwrap_or_default();
        let values: Vec<f64> =
            shares.importance.iter().map(|&q| f64::from(q) / f64::from(ONE)).collect();
        let (mut most, mut sum, mut peak) = (0.0f64, 0.0, 0);
        for (i, &value) in values.iter().enumerate() {
            sum += value;
            if value > most {
                (most, peak) = (value, i);
            }
        }
        peaks.push([peak as u32 % size[0], peak as u32 / size[0]]);
        let least = values.iter().copied().filter(|&v| v > 0.0).fold(1.0, f64::min);
        rows.push(vec![
            factor.to_owned(),
            format!("{least:.3}"),
            format!("{most:.3}"),
            format!("{:.3}", sum / values.len().max(1) as f64),
            format!("{},{}", peak as u32 % size[0], peak as u32 / size[0]),
        ]);
        // Noise is added to the product.
        let limit = if noisy { 1.05 } else { 1.0 };
        if most > limit {
            wrong.push(format!("{factor} reaches {most:.3}"));
        }
        let title = format!("{factor} \u{b7} {}", setting.name);
        let meaning = "pixels without fragments have none";
        let map = Map { title: &title, meaning, size, values: &values, most: 1.0 }.draw();
        pictures.push((factor.to_owned(), map));
    }
    let middle = f64::from(scale.edge) * 0.5;
    let apart = |[x, y]: [u32; 2], at: f64| {
        let (dx, dy) = (f64::from(x) - at, f64::from(y) - at);
        dx * dx + dy * dy
    };
    if apart(peaks[2], corner) >= apart(peaks[1], corner)
        || apart(peaks[1], middle) > apart(peaks[2], middle)
    {
        wrong.push("a gaze does not move the peak".to_owned());
    }
    let first = render(&scene, &base)?.report.importance;
    if first.is_none_or(|i| i.fresnel_known) {
        wrong.push("the Fresnel term of a first frame is known".to_owned());
    }
    let summary =
        "each factor alone and all together; the Fresnel term is the frame before's".to_owned();
    let columns = vec!["factor", "smallest above 0", "largest", "mean", "peak (x,y)"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new(name, summary) })
}

/// Figure 2: depth complexity, what a fixed k takes, and an importance map.
pub(super) fn allocation(scale: &Scale) -> Result<Outcome> {
    maps("varik-fig2", scale)
}

/// Figure 4: the three factors and their combination.
pub(super) fn factors(scale: &Scale) -> Result<Outcome> {
    maps("varik-fig4", scale)
}

/// Figure 3: the pipeline, from the method's program.
pub(super) fn pipeline(_: &Scale) -> Result<Outcome> {
    let program = catalogue::method("k-variable")?.contract().program;
    let rows: Vec<Vec<String>> = (0..)
        .zip(program.passes)
        .map(|(i, pass): (usize, _)| {
            vec![i.to_string(), pass.name.to_owned(), word(&pass.kind), word(&pass.before)]
        })
        .collect();
    let mut wrong = Vec::new();
    for stage in ["count", "importance", "k", "store"] {
        let times = program.passes.iter().filter(|pass| pass.name == stage).count();
        if times != 1 {
            wrong.push(format!("stage {stage} runs {times} times"));
        }
    }
    let summary = "the passes between clear and resolve, with the barrier before each; the sums stand for the paper's \
                   atomic total and for its contiguous ranges"
        .to_owned();
    let columns = vec!["pass", "name", "invocations", "behind a barrier of"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, verdict, ..Outcome::new("varik-fig3", summary) })
}

/// Table 1: how the three methods choose k and take memory.
pub(super) fn overview(scale: &Scale) -> Result<Outcome> {
    let grid = Grid { width: scale.edge, height: scale.edge, tile: 64 };
    let pixels = grid.storage_pixels() as u64;
    let (k, stored) = (4, 3 * pixels);
    let config = Config {
        k: Some(4),
        pixels: pixels as u32,
        bounded: stored,
        records: k * pixels,
        grid,
        ..Config::default()
    };
    let blocks = pixels.div_ceil(64);
    let groups = blocks.div_ceil(64);
    let printed = [
        ("fixed, by hand", "uniform", "fixed", 4 * (2 * k + 2) * pixels),
        (
            "fixed, by histogram",
            "uniform",
            "adaptive",
            4 * (3 * pixels + 2 * stored + blocks + groups),
        ),
        (
            "variable, by importance",
            "non-uniform",
            "adaptive",
            4 * (4 * pixels + 2 * k * pixels + 2 * blocks + 2 * groups + 2),
        ),
    ];
    let (mut rows, mut differences) = (Vec::new(), Vec::new());
    for (name, (selection, distribution, memory, formula)) in METHODS.into_iter().zip(printed) {
        let method = catalogue::method(name)?;
        let contract = method.contract();
        let measured = storage_bytes(method, &config);
        if measured != formula {
            differences.push(format!("{name}: {measured} bytes, {formula} by its formula"));
        }
        rows.push(vec![
            name.to_owned(),
            selection.to_owned(),
            distribution.to_owned(),
            memory.to_owned(),
            contract.words.to_owned(),
            contract.frame_words.to_owned(),
            formula.to_string(),
            measured.to_string(),
        ]);
    }
    let columns = vec![
        "method",
        "k (paper)",
        "distribution (paper)",
        "memory (paper)",
        "words per pixel",
        "words of the frame",
        "bytes by formula",
        "bytes",
    ];
    let summary =
        format!("bytes for {0}x{0} pixels, k = 4, and 3 fragments a pixel within it", scale.edge);
    let verdict = Some(Verdict::of(&differences));
    Ok(Outcome { columns, rows, verdict, differences, ..Outcome::new("varik-table1", summary) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Scale = Scale { edge: 64, repeats: 1 };

    #[test]
    fn formulas_are_what_is_measured() {
        assert_eq!(overview(&SMALL).unwrap().differences, Vec::<String>::new());
    }

    #[test]
    fn a_dynamic_k_is_the_largest_that_fits() {
        let size = Some([32, 32]);
        let scene =
            scene::load("layers:count=9", &Overrides { size, ..Overrides::default() }).unwrap();
        assert_eq!(dynamic_k(&scene, 4 * 32 * 32), 4);
        assert_eq!(dynamic_k(&scene, 4 * 32 * 32 - 1), 3);
        assert_eq!(dynamic_k(&scene, 0), 1);
        assert!(dynamic_k(&scene, 1 << 40) >= 9);
    }

    #[test]
    fn every_table_has_a_verdict_and_whole_rows() {
        for run in [losses, pipeline, factors] {
            let outcome = run(&SMALL).unwrap();
            assert!(outcome.verdict.is_some(), "{}", outcome.experiment);
            assert!(outcome.rows.iter().all(|row| row.len() == outcome.columns.len()));
        }
    }

    #[test]
    fn a_gaze_and_a_first_frame_are_as_said() {
        let outcome = factors(&SMALL).unwrap();
        assert!(outcome.verdict.unwrap().as_in_the_paper, "{:?}", outcome.rows);
    }
}
