//! Approximate transparency: every method on four scenes, with its errors, and what the papers say of who is better.
//!
//! A ranking of a paper is a statement "A is nearer to the exact picture than B". It holds on a scene if A's PSNR is
//! above B's.

use super::bundled::{Bundled, bundled};
use super::{Outcome, Scale, Verdict};
use crate::catalogue;
use crate::error::Result;
use crate::image::metrics::{Metrics, THRESHOLD};
use crate::image::{Image, flip, ramp, row};
use crate::render::{Options, Rendering, render};
use crate::scene::{self, Overrides, Scene};
use crate::scheme::approximate::Approximation;

const GLASS: Bundled = bundled!("glass.toml", "pane.obj", "table.obj");

/// The scenes, by name: glass is a file, the others are built in.
const SCENES: [(&str, &str); 4] = [
    ("glass", ""),
    ("hair", "hairball:strands=1500,radius=0.008,alpha=0.3"),
    ("smoke", "smoke"),
    ("bottles", "bottles"),
];

/// How a picture is drawn.
#[derive(Clone, Copy, Debug)]
struct How {
    /// What stands in tables and under pictures.
    caption: &'static str,
    method: &'static str,
    k: Option<u32>,
    moments: u32,
}

const fn how(caption: &'static str, method: &'static str) -> How {
    How { caption, method, k: None, moments: 4 }
}

/// All of them; nodes and core as by default, but for those whose memory is to be compared.
const HOWS: [How; 14] = [
    how("blend-unsorted", "blend-unsorted"),
    how("wboit", "wboit"),
    how("mbt, 4 moments", "mbt"),
    How { moments: 6, ..how("mbt, 6 moments", "mbt") },
    How { moments: 8, ..how("mbt, 8 moments", "mbt") },
    how("mlab, 4 nodes", "mlab"),
    how("adaptive, 8 nodes", "adaptive"),
    How { k: Some(4), ..how("hybrid, k = 4", "hybrid") },
    How { k: Some(4), ..how("hybrid@product, k = 4", "hybrid@product") },
    How { k: Some(4), ..how("kplus-array --tail, k = 4", "kplus-array+tail") },
    How { k: Some(4), ..how("kplus-array, k = 4", "kplus-array") },
    how("stochastic, 8 samples", "stochastic"),
    how("stochastic@plain, 8 samples", "stochastic@plain"),
    how("stochastic@depth, 8 samples", "stochastic@depth"),
];

/// What a paper says.
#[derive(Clone, Copy, Debug)]
struct Ranking {
    better: &'static str,
    worse: &'static str,
    paper: &'static str,
}

const RANKINGS: [Ranking; 9] = [
    Ranking {
        better: "mbt, 4 moments",
        worse: "wboit",
        paper: "Münstermann 2018, Figures 1 and 8",
    },
    Ranking {
        better: "mbt, 8 moments",
        worse: "mbt, 4 moments",
        paper: "Münstermann 2018, Figure 6",
    },
    Ranking { better: "mlab, 4 nodes", worse: "wboit", paper: "Salvi 2014, section 5" },
    Ranking {
        better: "mlab, 4 nodes",
        worse: "kplus-array, k = 4",
        paper: "Salvi 2014, section 5",
    },
    Ranking {
        better: "adaptive, 8 nodes",
        worse: "stochastic@plain, 8 samples",
        paper: "Salvi 2011, Figure 6",
    },
    Ranking { better: "hybrid, k = 4", worse: "wboit", paper: "Maule 2013, Figure 5" },
    Ranking { better: "hybrid, k = 4", worse: "kplus-array, k = 4", paper: "Maule 2013, Figure 5" },
    Ranking {
        better: "stochastic, 8 samples",
        worse: "stochastic@plain, 8 samples",
        paper: "Enderton 2010, section 3.1",
    },
    Ranking {
        better: "stochastic@depth, 8 samples",
        worse: "stochastic@plain, 8 samples",
        paper: "Enderton 2010, section 3.2",
    },
];

const COLUMNS: [&str; 14] = [
    "scene",
    "method",
    "fragments",
    "words per pixel",
    "bytes",
    "geometry passes",
    "seconds",
    "depends on arrival",
    "PSNR (dB)",
    "SSIM",
    "FLIP",
    "largest difference (of 255)",
    "pixels beyond 1 of 255 (%)",
    "worst pixel",
];

impl How {
    fn draw(&self, scene: &Scene) -> Result<Rendering> {
        let approximation = Approximation { moments: self.moments, ..Approximation::default() };
        let method = catalogue::method(self.method)?;
        let options =
            Options { method, k: self.k, approximation, counters: false, ..Options::default() };
        render(scene, &options)
    }
}

fn load(name: &str, source: &str, size: [u32; 2]) -> Result<Scene> {
    if name == "glass" {
        return GLASS.scene(size);
    }
    scene::load(source, &Overrides { size: Some(size), ..Overrides::default() })
}

/// The scene's pictures with all methods, their errors, and what the papers say.
pub(super) fn gallery(scale: &Scale) -> Result<Outcome> {
    let size = [scale.edge, (scale.edge * 9 / 16).max(1)];
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let mut holds = 0;
    for (name, source) in SCENES {
        let scene = load(name, source, size)?;
        let exact = how("exact", "exact").draw(&scene)?.image;
        let mut found = Vec::new();
        for how in HOWS {
            let drawn = how.draw(&scene)?;
            let mut seconds = Vec::new();
            for _ in 0..scale.repeats.max(1) {
                let timed = how.draw(&scene)?.report.seconds;
                seconds.push(timed.get("draw").copied().unwrap_or(0.0));
            }
            seconds.sort_by(f64::total_cmp);
            let metrics = Metrics::measure(&exact, &drawn.image, THRESHOLD)?;
            rows.push(cells(name, how, &drawn, seconds[seconds.len() / 2], &metrics));
            found.push((how.caption, drawn.image, metrics));
        }
        for ranking in RANKINGS {
            let psnr = |caption: &str| {
                let of = found.iter().find(|(name, ..)| *name == caption);
                of.map_or(0.0, |(.., metrics)| metrics.psnr.unwrap_or(f64::INFINITY))
            };
            let [better, worse] = [ranking.better, ranking.worse].map(psnr);
            if better > worse {
                holds += 1;
            } else {
                wrong.push(format!(
                    "{name}: {} {better:.2} dB, {} {worse:.2} ({})",
                    ranking.better, ranking.worse, ranking.paper
                ));
            }
        }
        let mut images = vec![("exact", &exact)];
        images.extend(found.iter().map(|(caption, image, _)| (*caption, image)));
        for (part, images) in images.chunks(5).enumerate() {
            pictures.push((format!("{name}-{}", part + 1), row::compose(name, images)));
        }
        let maps = found.iter().map(|(caption, image, _)| Ok((*caption, heat(&exact, image)?)));
        let maps: Vec<(&str, Image)> = maps.collect::<Result<_>>()?;
        let maps: Vec<(&str, &Image)> = maps.iter().map(|(name, map)| (*name, map)).collect();
        for (part, maps) in maps.chunks(5).enumerate() {
            let title = format!("{name}: FLIP, from 0 (gray) to 1");
            pictures.push((format!("{name}-errors-{}", part + 1), row::compose(&title, maps)));
        }
    }
    let summary = format!(
        "distance to the exact picture at {}x{}; {holds} of {} statements of the papers hold",
        size[0],
        size[1],
        RANKINGS.len() * SCENES.len()
    );
    let verdict = Some(Verdict::of(&wrong));
    let columns = COLUMNS.to_vec();
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("approximate", summary) })
}

/// A picture's errors on the whole scale of FLIP.
fn heat(exact: &Image, image: &Image) -> Result<Image> {
    let color = |error: f64| {
        let [r, g, b] = ramp::color((error * 255.0).round() as u8);
        [r, g, b, 255]
    };
    let pixels = flip::map(exact, image)?.into_iter().map(color).collect();
    Ok(Image { width: image.width, height: image.height, pixels })
}

fn cells(scene: &str, how: How, drawn: &Rendering, seconds: f64, metrics: &Metrics) -> Vec<String> {
    let report = &drawn.report;
    let pixels = f64::from(report.width) * f64::from(report.height);
    let depends =
        catalogue::method(how.method).map(|method| method.contract().is_arrival_dependent());
    vec![
        scene.to_owned(),
        how.caption.to_owned(),
        report.generated.to_string(),
        format!("{:.1}", report.bytes as f64 / 4.0 / pixels),
        report.bytes.to_string(),
        report.passes.to_string(),
        format!("{seconds:.3}"),
        if depends == Ok(true) { "yes" } else { "no" }.to_owned(),
        metrics.psnr.map_or_else(|| "equal".to_owned(), |psnr| format!("{psnr:.2}")),
        format!("{:.5}", metrics.ssim),
        format!("{:.5}", metrics.flip),
        metrics.max_difference.to_string(),
        format!("{:.2}", metrics.beyond),
        metrics.worst_pixel.map_or_else(|| "-".to_owned(), |[x, y]| format!("{x},{y}")),
    ]
}
