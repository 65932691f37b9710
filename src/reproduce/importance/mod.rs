//! The importance paper (2017): Tables 1 and 2, Figures 1 to 5.
//!
//! The paper's budget M is that of the records alone: 20 MB gave a fixed k of 1 at 1024 x 1024 pixels, 35 MB one of 2
//! or 3. Here every method has M = that k times the pixels as records; what their lists, counters and starts take
//! besides is in the bytes.

pub(super) mod losses;
pub(super) mod maps;
pub(super) mod overview;

use super::Scale;
use crate::catalogue;
use crate::error::Result;
use crate::image::{Image, similarity};
use crate::raster::{CullFace, FrontEnd, Grid};
use crate::render::{Options, Rendering, render};
use crate::scene::{self, Overrides, Scene};

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
    fn scene(&self, scale: &Scale) -> Result<Scene> {
        let size = Some([scale.edge; 2]);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dynamic_k_is_the_largest_that_fits() {
        let size = Some([32, 32]);
        let overrides = Overrides { size, ..Overrides::default() };
        let scene = scene::load("layers:count=9", &overrides).unwrap();
        assert_eq!(dynamic_k(&scene, 4 * 32 * 32), 4);
        assert_eq!(dynamic_k(&scene, 4 * 32 * 32 - 1), 3);
        assert_eq!(dynamic_k(&scene, 0), 1);
        assert!(dynamic_k(&scene, 1 << 40) >= 9);
    }
}
