//! `fragloom bench`: how fast methods are, by phase, next to the same schemes on devices, to what the machine can do,
//! and to themselves with more threads or more to draw.

#[cfg(feature = "gpu")]
mod devices;
mod explore;
mod front;
mod limit;
mod machine;
mod measure;
mod peak;
mod plan;
mod row;
mod scaling;
mod stats;
mod table;

use machine::Constants;
use measure::{First, Runs};
use plan::{Asked, Plan};
use row::Timing;
use scaling::{Scaling, Step};
use stats::{Mean, median};

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::{Exec, Output};
use crate::cli::terminal::{say, wait};
#[cfg(feature = "gpu")]
use crate::error::Error;
use crate::error::Result;
use crate::exec::Method;
use crate::render::Options;
use crate::report::json;

/// The most fragments of `--explore`.
const MOST_FRAGMENTS: u32 = 8;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Meshes, scene files or built-in scenes [default: three of the built-in ones]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,

    /// Methods to time, separated by commas [default: ab-ll and kplus-array; with --suite also z-buffer, kplus-heap,
    /// s-buffer, dfb and ha64]
    #[arg(short, long = "method", value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,

    /// Fragments kept per pixel, at least 1 [default: the method's own; 1 with --explore]
    #[arg(short, value_name = "N", allow_negative_numbers = true)]
    k: Option<u32>,

    /// For hash tables, the share of cells to be filled, 1 to 100 per cent, as of `fragloom render` [default: 50]
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    load: Option<u32>,

    /// For methods that merge, how thick surfaces are, as of `fragloom render` [default: 2x]
    #[arg(long, value_name = "Nx|UNITS", allow_hyphen_values = true)]
    thickness: Option<String>,

    /// Image size in pixels, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long, value_name = "WxH")]
    size: Option<String>,

    /// Small pictures: 256x256
    #[arg(long, conflicts_with = "size")]
    quick: bool,

    /// Time the scenes of the yardstick, each of about N million fragments, 1 to 300, and then those named: triangles of
    /// 8 and 128 pixels, layers in three orders, hair, a ball of hair, points [default: not; 10 if no N is given]
    #[arg(
        long,
        value_name = "N",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "10"
    )]
    suite: Option<u32>,

    /// Executors, separated by commas: parallel tiles, contending threads, a simulated device
    #[arg(
        long = "exec",
        value_enum,
        value_name = "EXECUTOR,...",
        value_delimiter = ',',
        default_value = "tile,threads"
    )]
    execs: Vec<Exec>,

    /// Numbers of worker threads, separated by commas, each of which is timed; 0 is one per core [default: one per core]
    #[arg(long, value_name = "N,...", value_delimiter = ',', allow_negative_numbers = true)]
    threads: Vec<usize>,

    /// Print how time grows instead: with threads, from 1 to one per core or those of --threads; or with the fragments,
    /// triangles or pixels of a scene, doubled --steps - 1 times [default: none]
    #[arg(long, value_enum, value_name = "WHAT", conflicts_with = "cull")]
    scaling: Option<Scaling>,

    /// With `--scaling`, how many sizes are timed, 2 to 12
    #[arg(long, value_name = "N", default_value_t = 4, allow_negative_numbers = true)]
    steps: u32,

    /// How often each is timed, 1 to 1000; the median is reported
    #[arg(long, value_name = "N", default_value_t = 5, allow_negative_numbers = true)]
    repeats: u32,

    /// Also time each method with culling before it, alternating: occupancy:D, as of `fragloom render` [default: no
    /// culling]
    #[arg(long, value_name = "occupancy[:D]")]
    cull: Option<String>,

    /// What is wanted of the fragments that pixels keep: their lists and a hash of them, the hash alone, or only the
    /// picture
    #[arg(long, value_enum, value_name = "WHAT", default_value = "lists")]
    wanted: Wanted,

    /// Refuse a run that needs more memory, in bytes; K, M, G and T are powers of 1024
    #[arg(long, value_name = "BYTES", default_value = "8G", allow_negative_numbers = true)]
    max_memory: String,

    /// Time the explorer on these methods instead, separated by commas: states a second, bytes a state [default: none]
    #[arg(
        long,
        value_name = "METHOD,...",
        value_delimiter = ',',
        conflicts_with_all = [
            "scenes", "methods", "load", "thickness", "size", "quick", "suite", "execs", "scaling", "cull", "wanted"
        ]
    )]
    explore: Vec<String>,

    /// With `--explore`, fragments of the instance, 1 to 8 [default: 4, and 3 under relaxed memory]
    #[arg(short, value_name = "FRAGMENTS", requires = "explore", allow_negative_numbers = true)]
    n: Option<u32>,

    /// Also time the same scheme on every device, alternating with it
    #[cfg(feature = "gpu")]
    #[arg(long, conflicts_with_all = ["cull", "scaling", "explore"])]
    gpu: bool,

    /// With `--gpu`, only adapters whose name or driver contains this [default: all]
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "NAME", requires = "gpu")]
    adapter: Option<String>,

    /// Print comma-separated values instead of the table: the rows alone
    #[arg(long, conflicts_with = "json")]
    csv: bool,

    #[command(flatten)]
    output: Output,
}

/// `--wanted`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Wanted {
    Lists,
    Hash,
    Picture,
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Document<'a, T> {
    machine: Machine<'a>,
    rows: &'a [T],
    #[serde(skip_serializing_if = "Option::is_none")]
    means: Option<&'a [Mean]>,
}

/// The machine, as it was measured.
#[derive(serde::Serialize)]
struct Machine<'a> {
    cores: usize,
    constants: &'a [Constants],
}

impl Machine<'_> {
    fn new(constants: &[Constants]) -> Machine<'_> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Machine { cores, constants }
    }
}

/// Time everything; print a row for each.
///
/// # Errors
/// Wrong options or scenes, or no device although one was requested.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let plan = Plan::new(catalogue, args)?;
    if !args.explore.is_empty() {
        let rows = explore::run(catalogue, args)?;
        print(args, &rows, &[], None, || explore::text(&rows))?;
        return Ok(Verdict::Clean);
    }
    if let Some(scaling) = args.scaling {
        let steps = scale(&plan, scaling, args.steps)?;
        print(args, &steps, &[], None, || scaling::text(&steps))?;
        return Ok(Verdict::Clean);
    }
    let scenes = plan.scenes()?;
    #[cfg(feature = "gpu")]
    let opened = devices(args)?;
    let machine = wait::during(plan.quiet, "measuring the machine", || constants(&plan))?;
    let mut rows = Vec::new();
    for asked in &scenes {
        for &method in &plan.methods {
            rows.extend(wait::during(plan.quiet, &message(asked, method), || {
                #[cfg(feature = "gpu")]
                if args.gpu {
                    let rows = devices::rows(&plan, asked, method, &machine, &opened)?;
                    return Ok(rows.into_iter().map(|row| named(row, asked)).collect());
                }
                rows_of(&plan, asked, method, &machine)
            })?);
        }
    }
    let means = stats::means(&rows);
    print(args, &rows, &machine, Some(&means), || table::tables(&rows, &machine, &means))?;
    Ok(Verdict::Clean)
}

fn message(asked: &Asked, method: Method) -> String {
    format!("timing {method} on {}", asked.scene.name)
}

#[cfg(feature = "gpu")]
fn devices(args: &Args) -> Result<Vec<crate::gpu::check::open::Opened>> {
    if !args.gpu {
        return Ok(Vec::new());
    }
    if args.execs.contains(&Exec::Sim) {
        let problem = "sim steps one operation at a time, and is not timed beside devices: leave it out, or --gpu";
        return Err(Error::new("--exec", problem));
    }
    crate::cli::verify::crosscheck::devices(args.adapter.as_deref())
}

/// The constants for one thread, and for every number of threads that is timed.
fn constants(plan: &Plan) -> Result<Vec<Constants>> {
    let mut threads: Vec<usize> = std::iter::once(1).chain(plan.threads.iter().copied()).collect();
    threads.sort_unstable();
    threads.dedup();
    threads.into_iter().map(Constants::measure).collect()
}

/// A method on a scene: a row for every executor and number of threads, and another with culling.
fn rows_of(
    plan: &Plan,
    asked: &Asked,
    method: Method,
    machine: &[Constants],
) -> Result<Vec<Timing>> {
    let scene = &asked.scene;
    let mut rows = Vec::new();
    for (exec, threads) in plan.executors() {
        let plain = plan.options(method, &exec, threads);
        let culled = plan.cull.map(|words| Options { cull: Some(words), ..plain.clone() });
        let first = First::new(scene, &plain)?;
        let first_culled = culled.as_ref().map(|options| First::new(scene, options)).transpose()?;
        let mut without = Runs::new(scene, &plain)?;
        let mut with = culled.as_ref().map(|options| Runs::new(scene, options)).transpose()?;
        for _ in 0..plan.repeats {
            without.once()?;
            with.as_mut().map_or(Ok(()), Runs::once)?;
        }
        rows.push(named(without.row(&first, machine), asked));
        if let (Some(words), Some(with), Some(first)) = (plan.cull, with, first_culled) {
            let ratio = |(with, without): (f64, f64)| with / without;
            let ratios = with.draws().into_iter().zip(without.draws()).map(ratio).collect();
            let (cull_intervals, cull_ratio) = (Some(32 * words), Some(median(ratios)));
            let row = named(with.row(&first, machine), asked);
            rows.push(Timing { cull_intervals, cull_ratio, ..row });
        }
    }
    Ok(rows)
}

/// A row with what is known of the scene that was asked for.
fn named(mut row: Timing, asked: &Asked) -> Timing {
    row.asked.clone_from(&asked.name);
    row.seconds.insert("load".to_owned(), asked.load);
    row
}

/// Every scene in every size, or with every number of threads.
fn scale(plan: &Plan, scaling: Scaling, count: u32) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    for family in scaling::families(plan, scaling, count)? {
        let (mut rows, mut pixels) = (Vec::new(), Vec::new());
        for larger in family {
            let asked = larger.load(plan)?;
            for &method in &plan.methods {
                let more = wait::during(plan.quiet, &message(&asked, method), || {
                    rows_of(plan, &asked, method, &[])
                })?;
                rows.extend(more);
            }
            pixels.resize(rows.len(), asked.scene.size.map(u64::from).iter().product());
        }
        steps.extend(scaling::steps(scaling, &rows, &pixels));
    }
    Ok(steps)
}

fn print<T: serde::Serialize>(
    args: &Args,
    rows: &[T],
    machine: &[Constants],
    means: Option<&[Mean]>,
    text: impl FnOnce() -> String,
) -> Result<()> {
    let text = match (args.output.json, args.csv) {
        (true, _) => json::document(&Document { machine: Machine::new(machine), rows, means })?,
        (_, true) => table::csv(rows)?,
        _ => text(),
    };
    say::result(&text)
}
