//! `fragloom bench`: how fast methods are, by phase, next to the same schemes on devices.

use std::collections::BTreeMap;

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::Output;
use crate::cli::options::importance::culling;
use crate::cli::options::{settings, values};
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::{Kit, Method};
use crate::render::{Data, Exec, Options, render_with};
use crate::report::json;
use crate::report::text::{Align, columns};
use crate::scene::{self, Overrides, Scene, Shading, Thickness};

/// Scenes that are timed if none is named.
const SCENES: [&str; 3] = ["synthetic:n=16,density=80", "layers:count=8", "bottles"];

/// The size of `--quick`.
const QUICK: [u32; 2] = [256, 256];

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Meshes, scene files or built-in scenes [default: three of the built-in ones]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,

    /// Methods to time, separated by commas
    #[arg(
        short,
        long = "method",
        value_name = "METHOD,...",
        value_delimiter = ',',
        default_value = "ab-ll,kplus-array"
    )]
    methods: Vec<String>,

    /// Fragments kept per pixel, at least 1 [default: the method's own]
    #[arg(short, value_name = "N", allow_negative_numbers = true)]
    k: Option<u32>,

    /// For methods that merge, how thick surfaces are, as of `fragloom render` [default: 2x]
    #[arg(long, value_name = "Nx|UNITS", allow_hyphen_values = true)]
    thickness: Option<String>,

    /// Image size in pixels, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long, value_name = "WxH")]
    size: Option<String>,

    /// Small pictures: 256x256
    #[arg(long, conflicts_with = "size")]
    quick: bool,

    /// How often each is timed, 1 to 1000; the median is reported
    #[arg(long, value_name = "N", default_value_t = 5, allow_negative_numbers = true)]
    repeats: u32,

    /// Also time each method with culling before it, alternating: occupancy:D, as of `fragloom render` [default: no
    /// culling]
    #[arg(long, value_name = "occupancy[:D]")]
    cull: Option<String>,

    /// Also time the same scheme on every device, alternating with it
    #[cfg(feature = "gpu")]
    #[arg(long, conflicts_with = "cull")]
    gpu: bool,

    /// With `--gpu`, only adapters whose name or driver contains this [default: all]
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "NAME", requires = "gpu")]
    adapter: Option<String>,

    #[command(flatten)]
    output: Output,
}

/// One method on one scene, by one executor, and by a device if requested.
#[derive(Clone, Debug, Default, serde::Serialize)]
struct Timing {
    method: String,
    scene: String,
    exec: String,
    threads: usize,
    fragments: u64,
    /// Medians, by phase.
    seconds: BTreeMap<String, f64>,
    /// Of clear, store and resolve.
    mfrag_per_s: f64,
    /// The distance from the machine's own limit: not measured.
    limit_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    adapter: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gpu_seconds: Option<f64>,
    /// The device's time over ours, median of alternating runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    ratio: Option<f64>,
    /// The smallest and the largest.
    #[serde(skip_serializing_if = "Option::is_none")]
    ratio_spread: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    unsupported: Option<String>,
    /// Intervals of the culling passes, if there are any: the seconds of `culling` are theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    cull_intervals: Option<u32>,
    /// Time with culling over time without, median of alternating runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    cull_ratio: Option<f64>,
}

/// Time everything; print a row for each.
///
/// # Errors
/// Wrong options or scenes, or no device although one was requested.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    if !(1..=1_000).contains(&args.repeats) {
        let problem = format!("is {}, but must be 1 to 1000", args.repeats);
        return Err(Error::new("--repeats", problem));
    }
    let quick = args.quick.then_some(QUICK);
    let size = args.size.as_deref().map(values::size).transpose()?.or(quick);
    // One colour per triangle: float shading is not timed, and devices do not do it.
    let shading = Some(Shading::Flat);
    let overrides = Overrides { size, shading, ..Overrides::default() };
    let named: Vec<String> = match args.scenes.as_slice() {
        [] => SCENES.map(str::to_owned).to_vec(),
        named => named.to_vec(),
    };
    let methods = catalogue.select("-m", &args.methods)?;
    let scenes: Vec<Scene> =
        named.iter().map(|name| scene::load(name, &overrides)).collect::<Result<_>>()?;
    let thickness = settings::thickness(args.thickness.as_deref())?;
    let mut rows = Vec::new();
    #[cfg(feature = "gpu")]
    let devices = if args.gpu {
        crate::cli::verify::crosscheck::devices(args.adapter.as_deref())?
    } else {
        Vec::new()
    };
    for scene in &scenes {
        for &method in &methods {
            let message = format!("timing {method} on {}", scene.name);
            let timed = wait::during(args.output.quiet, &message, || {
                #[cfg(feature = "gpu")]
                if args.gpu {
                    return devices::rows(args, scene, method, thickness, &devices);
                }
                rows_of(args, scene, method, thickness)
            })?;
            rows.extend(timed);
        }
    }
    let text = if args.output.json { json::document(&rows)? } else { table(&rows) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

fn options(
    args: &Args,
    method: Method,
    exec: Exec,
    sub_pixel_bits: u32,
    thickness: Thickness,
) -> Options {
    Options {
        method,
        k: args.k,
        exec,
        sub_pixel_bits,
        thickness,
        data: Data::Color,
        counters: false,
        ..Options::default()
    }
}

fn rows_of(
    args: &Args,
    scene: &Scene,
    method: Method,
    thickness: Thickness,
) -> Result<Vec<Timing>> {
    let words = args.cull.as_deref().map(culling).transpose()?;
    let mut rows = Vec::new();
    for exec in [Exec::Tile, Exec::Threads] {
        let plain = options(args, method, exec, 8, thickness);
        let culled = words.map(|words| Options { cull: Some(words), ..plain.clone() });
        let (mut without, mut with) = (Vec::new(), Vec::new());
        // The first frame is not timed, as on devices: it makes the system hand out pages.
        let kits = [(); 2].map(|()| Kit::of_several());
        for run in 0..=args.repeats {
            let plain = once(scene, &plain, &kits[0])?;
            let culled =
                culled.as_ref().map(|options| once(scene, options, &kits[1])).transpose()?;
            if run > 0 {
                without.push(plain);
                with.extend(culled);
            }
        }
        rows.push(row(&without));
        if let Some(words) = words {
            let ratio = |(with, without): (&TimedFrame, &TimedFrame)| with.frame / without.frame;
            let ratios = with.iter().zip(&without).map(ratio).collect();
            let cull_ratio = Some(median(ratios));
            rows.push(Timing { cull_intervals: Some(32 * words), cull_ratio, ..row(&with) });
        }
    }
    Ok(rows)
}

/// A frame: what drew it, and its times.
#[derive(Clone, Debug)]
struct TimedFrame {
    row: Timing,
    seconds: BTreeMap<String, f64>,
    frame: f64,
}

fn once(scene: &Scene, options: &Options, kit: &Kit) -> Result<TimedFrame> {
    let report = render_with(scene, options, kit)?.report;
    let of = |phase: &str| report.seconds.get(phase).copied().unwrap_or_default();
    let frame = of("draw") + of("culling");
    let row = Timing {
        method: report.method,
        scene: report.scene,
        exec: report.exec,
        threads: report.threads,
        fragments: report.generated,
        ..Timing::default()
    };
    Ok(TimedFrame { row, seconds: report.seconds, frame })
}

fn row(runs: &[TimedFrame]) -> Timing {
    let first = &runs[0];
    let phase = |name: &String| {
        let times = runs.iter().filter_map(|run| run.seconds.get(name).copied()).collect();
        (name.clone(), median(times))
    };
    let frame = median(runs.iter().map(|run| run.frame).collect());
    let seconds = first.seconds.keys().map(phase).collect();
    Timing { seconds, mfrag_per_s: first.row.fragments as f64 / frame / 1e6, ..first.row.clone() }
}

/// The middle one, or the mean of both.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => f64::midpoint(values[n / 2 - 1], values[n / 2]),
    }
}

fn table(rows: &[Timing]) -> String {
    use Align::{Left, Right};
    let heading = [
        "method",
        "scene",
        "exec",
        "fragments",
        "draw s",
        "Mfrag/s",
        "adapter",
        "adapter s",
        "ratio",
        "spread",
        "culling",
    ];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(rows.iter().map(|row| {
        let number = |value: Option<f64>, digits: usize| {
            value.map_or(String::new(), |value| format!("{value:.digits$}"))
        };
        let spread = match (&row.unsupported, row.ratio_spread) {
            (Some(why), _) => format!("unsupported: {why}"),
            (_, Some([low, high])) => format!("{low:.2}-{high:.2}"),
            _ => String::new(),
        };
        vec![
            row.method.clone(),
            row.scene.clone(),
            row.exec.clone(),
            row.fragments.to_string(),
            number(row.seconds.get("draw").copied(), 4),
            number(Some(row.mfrag_per_s), 1),
            row.adapter.clone().unwrap_or_default(),
            number(row.gpu_seconds, 4),
            number(row.ratio, 2),
            spread,
            culled(row),
        ]
    }));
    let align = [Left, Left, Left, Right, Right, Right, Left, Right, Right, Left, Left];
    columns(&align, &lines)
}

/// What culling does to the time.
fn culled(row: &Timing) -> String {
    let (Some(intervals), Some(ratio)) = (row.cull_intervals, row.cull_ratio) else {
        return String::new();
    };
    let passes = row.seconds.get("culling").copied().unwrap_or_default();
    let verdict = if ratio > 1.0 { "costs more than it saves" } else { "saves" };
    format!("{intervals} intervals, {passes:.4} s: {ratio:.2} times as long, {verdict}")
}

#[cfg(feature = "gpu")]
mod devices {
    //! Alternating with devices.

    use super::{
        Args, Exec, Kit, Method, Result, Scene, Thickness, TimedFrame, Timing, median, once,
        options, row,
    };
    use crate::gpu::check::crosscheck::find;
    use crate::gpu::check::open::Opened;
    use crate::gpu::check::race::Contender;
    use crate::gpu::driver::failure::Failure;
    use crate::gpu::twin::picture::Picture;

    pub(in crate::cli) fn rows(
        args: &Args,
        scene: &Scene,
        method: Method,
        thickness: Thickness,
        devices: &[Opened],
    ) -> Result<Vec<Timing>> {
        let twin = find(method)?;
        let mut rows = Vec::new();
        for opened in devices {
            let picture = Picture::new(scene, opened.bits()).thick(scene, thickness);
            let contender = Contender::new(&opened.device, &picture, twin, args.k);
            for exec in [Exec::Tile, Exec::Threads] {
                let options = options(args, method, exec, opened.bits(), thickness);
                let (mut runs, kit) = (Vec::new(), Kit::of_several());
                // The first frame is not timed, on either side.
                once(scene, &options, &kit)?;
                let mut failed = None;
                let theirs = contender.as_ref().map_err(Clone::clone).and_then(|contender| {
                    contender.seconds(args.k, args.repeats, || match once(scene, &options, &kit) {
                        Ok(run) => runs.push(run),
                        Err(error) => failed = Some(error),
                    })
                });
                if let Some(error) = failed {
                    return Err(error);
                }
                if runs.is_empty() {
                    runs.push(once(scene, &options, &kit)?);
                }
                rows.push(beside(&runs, opened, theirs));
            }
        }
        Ok(rows)
    }

    fn beside(
        runs: &[TimedFrame],
        opened: &Opened,
        theirs: std::result::Result<Vec<f64>, Failure>,
    ) -> Timing {
        let adapter = Some(opened.device.name.name.clone());
        let row = Timing { adapter, ..row(runs) };
        match theirs {
            Err(failure) => Timing { unsupported: Some(failure.to_string()), ..row },
            Ok(seconds) => {
                let ratio = |(run, theirs): (&TimedFrame, &f64)| theirs / run.frame;
                let ratios: Vec<f64> = runs.iter().zip(&seconds).map(ratio).collect();
                let ends = ratios.iter().fold([f64::MAX, 0.0f64], |[low, high], &ratio| {
                    [low.min(ratio), high.max(ratio)]
                });
                Timing {
                    gpu_seconds: Some(median(seconds)),
                    ratio: Some(median(ratios)),
                    ratio_spread: Some(ends),
                    ..row
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_the_median() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]).to_bits(), 2.0f64.to_bits());
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]).to_bits(), 2.5f64.to_bits());
        assert_eq!(median(Vec::new()).to_bits(), 0);
    }
}
