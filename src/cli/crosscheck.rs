//! `fragloom crosscheck`: the same schemes on wgpu, against what must be there.

use super::{Verdict, say, wait};
use crate::error::{Error, Result};
use crate::gpu::band::Picture;
use crate::gpu::conform::{self, Conformance};
use crate::gpu::crosscheck::{self, Options, Path, Row, Status};
use crate::gpu::device::{self, Device};
use crate::gpu::failure::Failure;
use crate::gpu::stress::{self, Stressed};
use crate::gpu::{open, raster};
use crate::report::json;
use crate::report::text::{Align, columns};
use crate::scene::{self, Overrides, Scene};
use crate::scheme::catalogue;

/// Scenes that are compared where none is named.
const SCENES: [&str; 9] = [
    "synthetic:n=24",
    "synthetic:n=40,tessellation=9,density=80",
    "layers:count=12",
    "hairball:strands=300",
    "bottles",
    "gears",
    "cubes",
    "stack:count=48",
    "sphere:sides=96",
];

/// The size of `--quick`: not a multiple of anything.
const QUICK: [u32; 2] = [157, 101];

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Meshes, scene files or built-in scenes [default: nine of the built-in ones]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,

    /// Methods to compare, separated by commas [default: all that have a twin in WGSL]
    #[arg(short, long = "method", value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,

    /// Fragments kept per pixel, at least 1 [default: the method's own]
    #[arg(short, value_name = "N", allow_negative_numbers = true)]
    k: Option<u32>,

    /// Only adapters whose name or driver contains this [default: all]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,

    /// How fragments come to the store pass [default: both ways]
    #[arg(long, value_enum, value_name = "PATH")]
    path: Option<PathFlag>,

    /// In which order the compute path gets the fragments
    #[arg(long, value_enum, value_name = "ORDER", default_value = "shuffled")]
    order: Order,

    /// Seed of `--order shuffled`, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// Image size in pixels, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long, value_name = "WxH")]
    size: Option<String>,

    /// Run the litmus pixels instead: one invocation at a time, memory compared word for word with the simulator's; then
    /// thousands of copies at once, their outcomes counted against all that interleavings can give
    #[arg(long, conflicts_with_all = ["scenes", "path", "order", "seed", "size", "quick", "k"])]
    litmus: bool,

    /// With `--litmus`, how often each litmus pixel's copies are run, in each of three orders
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4,
        requires = "litmus",
        allow_negative_numbers = true
    )]
    repeats: u64,

    /// Small pictures: 157x101
    #[arg(long, conflicts_with = "size")]
    quick: bool,

    #[command(flatten)]
    output: super::flags::Output,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PathFlag {
    Raster,
    Compute,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Order {
    Shuffled,
    Submission,
}

/// Compare every scene on every adapter, print a row per method and path.
///
/// # Errors
/// Wrong options or scenes, or there is no adapter.
pub(super) fn run(args: &Args) -> Result<Verdict> {
    let options = options(args)?;
    if args.litmus {
        return litmus(args, &options);
    }
    let quick = args.quick.then_some(QUICK);
    let size = args.size.as_deref().map(super::values::size).transpose()?.or(quick);
    let overrides = Overrides { size, ..Overrides::default() };
    let named: Vec<String> = match args.scenes.as_slice() {
        [] => SCENES.map(str::to_owned).to_vec(),
        named => named.to_vec(),
    };
    let load = |name: &String| scene::load(name, &overrides);
    let scenes: Vec<Scene> = wait::during(args.output.quiet, "loading", || {
        named.iter().map(load).collect::<Result<_>>()
    })?;
    let devices = devices(args.adapter.as_deref())?;
    let adapters: Vec<String> = devices.iter().map(|one| one.device.name.name.clone()).collect();
    let mut rows = Vec::new();
    for scene in &scenes {
        let own = compare(args, scene, &devices, &options)?;
        // Scene by scene: this can take a while.
        if !args.output.json {
            say::result(&lines(&own, &adapters))?;
        }
        rows.extend(own);
    }
    say::result(&if args.output.json { json::document(&rows)? } else { summary(&rows) })?;
    for row in rows.iter().filter(|row| row.is_finding) {
        say::violation(&format!(
            "{}: {} on {}, {} path: {}",
            row.adapter, row.method, row.scene, row.path, row.reason
        ));
    }
    // What is unsupported is no pass.
    let compared = rows.iter().any(|row| matches!(row.status, Status::Equal | Status::Different));
    if !compared {
        say::violation("nothing was compared");
    }
    let found = !compared || rows.iter().any(|row| row.is_finding);
    Ok(if found { Verdict::Found } else { Verdict::Clean })
}

/// The devices that take part; who cannot is named in a warning.
pub(super) fn devices(wanted: Option<&str>) -> Result<Vec<open::Opened>> {
    let found = open::devices(wanted)?;
    found.refused.iter().for_each(|refused| say::warning(&format!("left out: {refused}")));
    Ok(found.opened)
}

fn options(args: &Args) -> Result<Options> {
    let mut options = Options { k: args.k, ..Options::default() };
    if args.k == Some(0) {
        return Err(Error::new("-k", "0 fragments per pixel: must be at least 1"));
    }
    if !args.methods.is_empty() {
        let name = |method: &String| {
            let contract = super::catalogue::find("-m", method)?;
            crosscheck::find(contract.name).map(|twin| twin.method)
        };
        options.methods = args.methods.iter().map(name).collect::<Result<_>>()?;
    }
    if let Some(path) = args.path {
        options.paths = vec![match path {
            PathFlag::Raster => Path::Raster,
            PathFlag::Compute => Path::Compute,
        }];
    }
    options.shuffle = (args.order == Order::Shuffled).then_some(args.seed);
    for method in &options.methods {
        let most = catalogue::contract(method)?.max_k;
        if let Some(k) = args.k.filter(|&k| k > most) {
            let problem = format!("is {k}, but {method} keeps at most {most} fragments");
            return Err(Error::new("-k", problem));
        }
    }
    Ok(options)
}

/// What `--litmus` prints.
#[derive(Debug, Default, serde::Serialize)]
struct Litmus {
    conformance: Vec<Conformance>,
    stress: Vec<Stressed>,
}

/// Litmus pixels on every device.
fn litmus(args: &Args, options: &Options) -> Result<Verdict> {
    if args.repeats == 0 {
        return Err(Error::new("--repeats", "is 0, but must be at least 1"));
    }
    let devices = devices(args.adapter.as_deref())?;
    let extent = stress::Extent { repeats: args.repeats, ..stress::Extent::default() };
    let mut all = Litmus::default();
    let mut failures = Vec::new();
    for opened in &devices {
        let device = &opened.device;
        for method in &options.methods {
            let twin = crosscheck::find(method)?;
            let message = format!("litmus pixels of {method} on {}", device.name.name);
            let both = wait::during(args.output.quiet, &message, || {
                let conformance = conform::conform(device, twin, conform::Extent::default())?;
                Ok((conformance, stress::stress(device, twin, extent)?))
            });
            match both {
                Ok((conformance, stressed)) => {
                    all.conformance.push(conformance);
                    all.stress.push(stressed);
                }
                Err(failure) => {
                    let failure: Failure = failure;
                    failures.push(format!("{}: {method}: {failure}", device.name.name));
                }
            }
        }
    }
    let text = if args.output.json { json::document(&all)? } else { litmus_table(&all) };
    say::result(&text)?;
    let differ = all.conformance.iter().filter_map(|row| {
        let difference = row.difference.as_ref()?;
        Some(format!("{}: {}: {difference}", row.adapter, row.method))
    });
    // A method that races on plain words may do anything, in WGSL as elsewhere.
    let races = |name: &str| catalogue::contract(name).is_ok_and(|contract| contract.racy);
    let outside = all.stress.iter().filter(|row| row.outside > 0 && !races(&row.method));
    let outside = outside.map(|row| format!("{}: {}: {}", row.adapter, row.method, row.reason));
    let found: Vec<String> = failures.into_iter().chain(differ).chain(outside).collect();
    found.iter().for_each(|line| say::violation(line));
    Ok(if found.is_empty() { Verdict::Clean } else { Verdict::Found })
}

fn litmus_table(all: &Litmus) -> String {
    use Align::{Left, Right};
    let heading =
        ["adapter", "method", "litmus", "orders", "steps", "words", "device and simulator"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(all.conformance.iter().map(|row| {
        let found = match (&row.unsupported, &row.difference) {
            (Some(why), _) => format!("unsupported: {why}"),
            (_, Some(_)) => "DIFFER".to_owned(),
            _ => "equal after every step".to_owned(),
        };
        let counts = [row.instances, row.orders, row.steps, row.words].map(|n| n.to_string());
        [vec![row.adapter.clone(), row.method.clone()], counts.to_vec(), vec![found]].concat()
    }));
    let mut text = "One invocation at a time\n".to_owned();
    text += &columns(&[Left, Left, Right, Right, Right, Right, Left], &lines);
    let heading =
        ["adapter", "method", "litmus", "runs", "possible", "seen", "relaxed", "outside", "status"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(all.stress.iter().map(|row| {
        let counts = [row.instances, row.runs, row.possible, row.seen, row.relaxed, row.outside];
        let counts = counts.map(|n| n.to_string());
        let status = status(row.status, &row.reason);
        [vec![row.adapter.clone(), row.method.clone()], counts.to_vec(), vec![status]].concat()
    }));
    text += "\nMany copies at once: outcomes that interleavings can give, and outcomes seen\n";
    text + &columns(&[Left, Left, Right, Right, Right, Right, Right, Right, Left], &lines)
}

fn status(status: Status, reason: &str) -> String {
    let word = format!("{status:?}").to_lowercase();
    if reason.is_empty() { word } else { format!("{word}: {reason}") }
}

/// A scene on all devices. Those of one sub-pixel precision share its set-up.
fn compare(
    args: &Args,
    scene: &Scene,
    devices: &[open::Opened],
    options: &Options,
) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for bits in [8, 4] {
        let own: Vec<&open::Opened> = devices.iter().filter(|d| d.bits() == bits).collect();
        if own.is_empty() {
            continue;
        }
        let quiet = args.output.quiet;
        let message = format!("setting {} up", scene.name);
        let picture = wait::during(quiet, &message, || Picture::new(scene, bits));
        for opened in own {
            let message = format!("drawing {} on {}", scene.name, opened.device.name.name);
            let device: &Device = &opened.device;
            let allowed = opened.paths(options);
            rows.extend(wait::during(quiet, &message, || {
                crosscheck::run(device, scene, &picture, bits, &allowed)
            })?);
            if let Some(failure) = opened.no_raster(options) {
                rows.extend(without_raster(scene, opened, options, bits, &failure));
            }
        }
    }
    Ok(rows)
}

/// Rows for methods on a path that the device cannot go.
fn without_raster(
    scene: &Scene,
    opened: &open::Opened,
    options: &Options,
    bits: u32,
    failure: &Failure,
) -> Vec<Row> {
    let name = opened.device.name.clone();
    let (status, is_finding, reason) = crosscheck::failed(failure);
    let row = |method: &&'static str| Row {
        adapter: name.name.clone(),
        driver: name.driver.clone(),
        method: (*method).to_owned(),
        scene: scene.name.clone(),
        size: scene.size,
        path: Path::Raster,
        sub_pixel_bits: bits,
        differences: crate::gpu::compare::Differences::default(),
        by_compute: 0,
        repeated: 0,
        status,
        reason: reason.clone(),
        is_finding,
    };
    options.methods.iter().map(row).collect()
}

/// What was compared on each adapter, in all.
fn summary(rows: &[Row]) -> String {
    use Align::{Left, Right};
    let heading = [
        "adapter",
        "driver",
        "sub-pixel bits",
        "equal",
        "different",
        "unsupported",
        "failed",
        "fragments",
        "differences",
    ];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    let mut adapters: Vec<(&str, &str, u32)> = rows
        .iter()
        .map(|row| (row.adapter.as_str(), row.driver.as_str(), row.sub_pixel_bits))
        .collect();
    adapters.sort_unstable();
    adapters.dedup();
    for adapter in adapters {
        let (name, driver, bits) = adapter;
        let own: Vec<&Row> = rows
            .iter()
            .filter(|row| {
                (row.adapter.as_str(), row.driver.as_str(), row.sub_pixel_bits) == adapter
            })
            .collect();
        let fragments: u64 = own.iter().map(|row| row.differences.fragments).sum();
        let with = |status| own.iter().filter(|row| row.status == status).count().to_string();
        let findings = own.iter().filter(|row| row.is_finding).count();
        let differences = if fragments == 0 {
            "nothing compared".to_owned()
        } else if findings == 0 {
            "none that a contract does not allow".to_owned()
        } else {
            format!("{findings} rows with some that no contract allows")
        };
        let mut line = vec![name.to_owned(), driver.to_owned(), bits.to_string()];
        line.extend(
            [Status::Equal, Status::Different, Status::Unsupported, Status::Failed].map(with),
        );
        line.extend([fragments.to_string(), differences]);
        lines.push(line);
    }
    let align = [Left, Left, Right, Right, Right, Right, Right, Right, Left];
    format!("\n{}", columns(&align, &lines))
}

/// As many of an adapter's first words as tell it from the others: names are long, and whole in the summary.
fn short<'a>(name: &'a str, all: &[String]) -> &'a str {
    let ends = name.match_indices(' ').map(|(at, _)| at);
    let is_own = |start: &&str| all.iter().filter(|other| other.starts_with(*start)).count() < 2;
    ends.map(|end| &name[..end]).find(is_own).unwrap_or(name)
}

fn lines(rows: &[Row], adapters: &[String]) -> String {
    let heading = [
        "adapter",
        "method",
        "scene",
        "size",
        "path",
        "fragments",
        "coverage",
        "depth",
        "lists",
        "pixels",
        "status",
    ];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    for row in rows {
        let sum = &row.differences;
        let by_compute = match row.by_compute {
            0 => String::new(),
            n => format!(" ({n} fragments by compute)"),
        };
        let repeated = match row.repeated {
            0 => String::new(),
            n => format!(" (waits for a lock begun again: {n})"),
        };
        lines.push(vec![
            short(&row.adapter, adapters).to_owned(),
            row.method.clone(),
            row.scene.clone(),
            format!("{}x{}", row.size[0], row.size[1]),
            row.path.to_string(),
            sum.fragments.to_string(),
            sum.coverage_differences.to_string(),
            sum.depth_differences.to_string(),
            sum.list_differences.to_string(),
            sum.pixel_differences.to_string(),
            status(row.status, &row.reason) + &by_compute + &repeated,
        ]);
    }
    use Align::{Left, Right};
    columns(&[Left, Left, Left, Right, Left, Right, Right, Right, Right, Right, Left], &lines)
}

/// `fragloom adapters`: which devices there are.
#[derive(Debug, clap::Args)]
pub(super) struct AdapterArgs {
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
}

/// What an adapter has, as far as it matters here.
#[derive(Debug, serde::Serialize)]
struct AdapterRow {
    #[serde(flatten)]
    name: device::AdapterName,
    /// Measured.
    sub_pixel_bits: Option<u32>,
    atomics64: bool,
    largest_buffer: u64,
    problem: Option<String>,
}

/// Print what adapters there are.
///
/// # Errors
/// There is none.
pub(super) fn adapters(args: &AdapterArgs) -> Result<Verdict> {
    let found = device::adapters();
    if found.is_empty() {
        return Err(open::none(None));
    }
    let rows: Vec<AdapterRow> = found.iter().map(adapter).collect();
    if args.json {
        say::result(&json::document(&rows)?)?;
        return Ok(Verdict::Clean);
    }
    let heading =
        ["adapter", "driver", "backend", "kind", "sub-pixel bits", "64-bit atomics", "problem"];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    lines.extend(rows.iter().map(|row| {
        let bits = row.sub_pixel_bits.map_or("?".to_owned(), |bits| bits.to_string());
        let atomics = if row.atomics64 { "yes" } else { "no" };
        let device::AdapterName { name, driver, backend, kind } = row.name.clone();
        let problem = row.problem.clone().unwrap_or_default();
        vec![name, driver, backend, kind, bits, atomics.to_owned(), problem]
    }));
    use Align::{Left, Right};
    say::result(&columns(&[Left, Left, Left, Left, Right, Left, Left], &lines))?;
    Ok(Verdict::Clean)
}

fn adapter(adapter: &wgpu::Adapter) -> AdapterRow {
    let measured: std::result::Result<(Device, u32), Failure> = Device::open(adapter)
        .and_then(|device| raster::sub_pixel_bits(&device).map(|bits| (device, bits)));
    let name = device::name(adapter);
    match measured {
        Ok((device, bits)) => AdapterRow {
            name,
            sub_pixel_bits: Some(bits),
            atomics64: device.atomics64,
            largest_buffer: device.largest(),
            problem: None,
        },
        Err(failure) => AdapterRow {
            name,
            sub_pixel_bits: None,
            atomics64: false,
            largest_buffer: 0,
            problem: Some(failure.to_string()),
        },
    }
}
