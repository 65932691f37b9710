//! The z-thickness paper (2021): its figures.
//!
//! The paper says a thickness as a multiple of P(z), what 24 bits of depth can tell apart at z. That grows as the near
//! plane comes closer to the eye, and the paper does not say where it was. A camera that fits its planes to the scene has
//! a P(z) of a millionth of its size; an interactive viewer's planes enclose much more. So where the paper gives
//! multiples, scenes are seen with a [`viewer`]'s planes.
//!
//! Its other method is moment-based transparency, `mbt` with 4 moments.

pub(super) mod absorbance;
pub(super) mod comparison;
mod coplanar;
pub(super) mod cost;
pub(super) mod ghosts;
pub(super) mod hybrid;
pub(super) mod intersections;
pub(super) mod model;
pub(super) mod quality;
pub(super) mod screen;
pub(super) mod zfighting;

use super::Scale;
use super::bundled::{Bundled, bundled};
use crate::catalogue;
use crate::effect::Effect;
use crate::effect::screen::Screen;
use crate::effect::volume::UNTIL;
use crate::error::Result;
use crate::image::{Image, flip, similarity};
use crate::render::{Marching, Options, Rendering, render};
use crate::scene::{Scene, Thickness};

const BALLS: Bundled = bundled!("merging/balls.toml");
const COMPARED: Bundled = bundled!("merging/compared.toml");
const COPLANAR: Bundled = bundled!("merging/coplanar.toml");
const CROSSING: Bundled = bundled!("merging/crossing.toml");
const FOCUS: Bundled = bundled!("focus.toml");
const GHOSTED: Bundled = bundled!("merging/ghosted.toml");
const HYBRID: Bundled = bundled!("merging/hybrid.toml");
const MARKS: Bundled = bundled!("merging/marks.toml");
const SHEETS: Bundled = bundled!("merging/sheets.toml");
const SHELL: Bundled = bundled!("merging/shell.toml");
const SLICED: Bundled = bundled!("merging/sliced.toml");
const TWINS: Bundled = bundled!("merging/twins.toml");

/// The scene of a file, at a size.
fn load(bundled: Bundled, edge: u32) -> Result<Scene> {
    bundled.scene([edge; 2])
}

/// The planes of an interactive viewer: from a thousandth of the distance to what is looked at.
fn viewer(mut scene: Scene) -> Scene {
    let camera = &mut scene.camera;
    let distance = (camera.eye - camera.target).length();
    camera.near = camera.near.min(0.001 * distance);
    camera.far = camera.far.max(10.0 * distance);
    scene
}

/// How a scene is drawn.
#[derive(Clone, Copy, Debug)]
struct How {
    method: &'static str,
    k: Option<u32>,
    thickness: Thickness,
    beta: f64,
    volumes: Marching,
    screen: Option<Screen>,
}

/// All fragments.
const DFB: How = How {
    method: "dfb",
    k: None,
    thickness: Thickness::World(0.0),
    beta: 1.0,
    volumes: Marching { merge: true, until: UNTIL, step: None },
    screen: None,
};
/// The static k+-buffer, with the paper's k.
const SKB: How = How { method: "kplus-array", k: Some(8), ..DFB };

/// Moment-based transparency, which keeps no fragments.
const MBT: How = How { method: "mbt", ..DFB };

impl How {
    /// A method that merges, with the paper's M.
    const fn merging(method: &'static str, thickness: Thickness) -> Self {
        Self { method, k: Some(8), thickness, ..DFB }
    }

    fn merges(&self) -> bool {
        self.method.contains('+')
    }

    fn options(&self) -> Result<Options> {
        let method = catalogue::method(self.method)?;
        let Self { k, thickness, beta, volumes, .. } = *self;
        let effect = self.screen.map_or(Effect::Transparency, Effect::Screen);
        Ok(Options { method, k, thickness, beta, volumes, effect, ..Options::default() })
    }

    fn draw(&self, scene: &Scene) -> Result<Rendering> {
        render(scene, &Options { counters: false, ..self.options()? })
    }

    /// Draw, and count and time that.
    fn once(self, scene: &Scene) -> Result<Measured> {
        let drawn = render(scene, &self.options()?)?;
        let seconds = drawn.report.seconds.get("draw").copied().unwrap_or(0.0);
        Ok(Measured { how: self, drawn, seconds })
    }

    /// Draw, count, and time the drawing as often as the scale says, without counting.
    fn measure(self, scene: &Scene, scale: &Scale) -> Result<Measured> {
        let once = self.once(scene)?;
        let mut seconds = Vec::new();
        for _ in 0..scale.repeats.max(1) {
            let timed = self.draw(scene)?.report.seconds;
            seconds.push(timed.get("draw").copied().unwrap_or(0.0));
        }
        Ok(Measured { seconds: median(seconds), ..once })
    }

    /// Under a picture.
    fn caption(&self) -> String {
        if self.merges() {
            format!("{}, {}", self.method, self.thickness)
        } else {
            self.method.to_owned()
        }
    }
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).copied().unwrap_or(0.0)
}

/// What came out.
struct Measured {
    how: How,
    drawn: Rendering,
    seconds: f64,
}

/// The columns that all figures share.
const COLUMNS: [&str; 14] = [
    "method",
    "k",
    "thickness",
    "beta",
    "fragments",
    "kept",
    "merged",
    "words per pixel",
    "bytes",
    "operations per fragment",
    "seconds",
    "PSNR (dB)",
    "SSIM",
    "FLIP",
];

/// Columns before and after them.
fn columns(before: &[&'static str], after: &[&'static str]) -> Vec<&'static str> {
    [before, &COLUMNS, after].concat()
}

impl Measured {
    fn image(&self) -> &Image {
        &self.drawn.image
    }

    /// What belongs into [`COLUMNS`], with the likeness to a picture.
    fn cells(&self, like: &Image) -> Result<Vec<String>> {
        let (report, how) = (&self.drawn.report, &self.how);
        let none = || "-".to_owned();
        let merging = how.merges();
        let pixels = u64::from(report.width) * u64::from(report.height);
        let psnr = similarity::psnr(like, self.image())?;
        Ok(vec![
            how.method.to_owned(),
            how.k.map_or_else(
                || if how.method == DFB.method { "all".to_owned() } else { none() },
                |k| k.to_string(),
            ),
            if merging { how.thickness.to_string() } else { none() },
            if how.method.contains("+sfm") { how.beta.to_string() } else { none() },
            report.generated.to_string(),
            report.kept.to_string(),
            report.merged.to_string(),
            format!("{:.2}", report.bytes as f64 / 4.0 / pixels.max(1) as f64),
            report.bytes.to_string(),
            format!("{:.1}", operations(&self.drawn)),
            format!("{:.3}", self.seconds),
            psnr.map_or_else(|| "equal".to_owned(), |psnr| format!("{psnr:.2}")),
            format!("{:.5}", similarity::ssim(like, self.image())?),
            format!("{:.5}", flip::mean(&flip::map(like, self.image())?)),
        ])
    }

    /// In decibels; equal pictures are the best.
    fn psnr(&self, like: &Image) -> Result<f64> {
        Ok(similarity::psnr(like, self.image())?.unwrap_or(f64::INFINITY))
    }
}

/// Memory operations of a fragment.
fn operations(drawn: &Rendering) -> f64 {
    let no_operations = ["bytes", "failed_exchanges", "spins"];
    let all = drawn.report.counters.iter();
    let sum: u64 =
        all.filter(|(name, _)| !no_operations.contains(&name.as_str())).map(|(_, n)| n).sum();
    sum as f64 / drawn.report.generated.max(1) as f64
}

/// The largest difference of red, green and blue.
fn apart(p: [u8; 4], q: [u8; 4]) -> u8 {
    (0..3).map(|c| p[c].abs_diff(q[c])).fold(0, u8::max)
}

/// In per cent; 0 of nothing.
fn percent(part: usize, whole: usize) -> f64 {
    if whole == 0 { 0.0 } else { 100.0 * part as f64 / whole as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bundled_scenes_are_scenes() {
        for scene in [BALLS, COMPARED, COPLANAR, CROSSING, GHOSTED, MARKS, SHEETS, SHELL, TWINS] {
            assert!(load(scene, 16).unwrap().triangles() > 0, "{}", scene.name);
        }
    }
}
