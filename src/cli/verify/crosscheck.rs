//! `fragloom crosscheck`: the same schemes on wgpu, against the expected results.

mod litmus;

use std::collections::BTreeMap;

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::settings;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::gpu::check::compare::Differences;
use crate::gpu::check::crosscheck::{self, Agreement, Options, Path, Status};
use crate::gpu::check::open;
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::picture::Picture;
use crate::gpu::twin::source::{Twin, twins};
use crate::report::json;
use crate::report::text::{Align, columns};
use crate::scene::{self, Overrides, Scene, Thickness};

/// Scenes that are compared if none is named.
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
pub(in crate::cli) struct Args {
    /// Meshes, scene files or built-in scenes [default: nine of the built-in ones]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,

    /// Methods to compare, separated by commas [default: all that have a twin in WGSL]
    #[arg(short, long = "method", value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,

    /// Fragments kept per pixel, at least 1 [default: the method's own]
    #[arg(short, value_name = "N", allow_negative_numbers = true)]
    k: Option<u32>,

    /// For methods that merge, how thick surfaces are that do not say so themselves: Nx, times the depth precision P(z),
    /// or world units [default: 2x]
    #[arg(long, value_name = "Nx|UNITS", allow_hyphen_values = true)]
    thickness: Option<String>,

    /// Only adapters whose name or driver contains this [default: all]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,

    /// How fragments reach the store pass [default: both ways]
    #[arg(long, value_enum, value_name = "PATH")]
    path: Option<PathFlag>,

    /// What twins become: WGSL, whose atomics are relaxed; or, of those that need acquire and release, SPIR-V that has them
    #[arg(long, value_enum, value_name = "FORM", default_value = "wgsl")]
    form: FormFlag,

    /// The order in which the compute path gets the fragments
    #[arg(long, value_enum, value_name = "ORDER", default_value = "shuffled")]
    order: FragmentOrder,

    /// Seed of `--order shuffled`, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// Image sizes in pixels, separated by commas, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long = "size", value_name = "WxH,...", value_delimiter = ',')]
    sizes: Vec<String>,

    /// Run the litmus pixels instead: one invocation at a time, memory compared word for word with the simulator's;
    /// then thousands of copies at once, their outcomes counted against all that interleavings allow
    #[arg(long, conflicts_with_all = ["scenes", "path", "order", "seed", "sizes", "quick", "k", "thickness"])]
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
    #[arg(long, conflicts_with = "sizes")]
    quick: bool,

    #[command(flatten)]
    output: crate::cli::options::flags::Output,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum PathFlag {
    Raster,
    Compute,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FormFlag {
    Wgsl,
    Vulkan,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FragmentOrder {
    Shuffled,
    Submission,
}

/// Compare every scene on every adapter, and print a row per method and path.
///
/// # Errors
/// Wrong options or scenes, or there is no adapter.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let options = options(catalogue, args)?;
    if args.litmus {
        return litmus::run(args, &options);
    }
    let sizes = sizes(args)?;
    let thickness = settings::thickness(args.thickness.as_deref())?;
    let named: Vec<String> = match args.scenes.as_slice() {
        [] => SCENES.map(str::to_owned).to_vec(),
        named => named.to_vec(),
    };
    let load = |name: &String, &size: &Option<[u32; 2]>| {
        scene::load(name, &Overrides { size, ..Overrides::default() })
    };
    // All are loaded first, so that unreadable files are reported before anything is drawn.
    let scenes: Vec<Scene> = wait::during(args.output.quiet, "loading", || {
        let all = named.iter().flat_map(|name| sizes.iter().map(move |size| (name, size)));
        all.map(|(name, size)| load(name, size)).collect::<Result<_>>()
    })?;
    let devices = devices(args.adapter.as_deref())?;
    let adapters: Vec<String> = devices.iter().map(|one| one.device.name.name.clone()).collect();
    let mut rows = Vec::new();
    for scene in &scenes {
        let own = compare(args, scene, &devices, &options, thickness)?;
        // Scene by scene: this can take a while.
        if !args.output.json {
            say::result(&lines(&own, &adapters))?;
        }
        rows.extend(own);
    }
    say::result(&if args.output.json {
        json::document(&rows)?
    } else {
        summary(catalogue, &rows)
    })?;
    for row in rows.iter().filter(|row| row.is_finding) {
        say::violation(&format!(
            "{}: {} on {}, {} path: {}",
            row.adapter, row.method, row.scene, row.path, row.reason
        ));
    }
    // An unsupported row does not count as a pass.
    let compared = rows.iter().any(Agreement::is_compared);
    if !compared {
        say::violation("nothing was compared");
    }
    let found = !compared || rows.iter().any(|row| row.is_finding);
    Ok(if found { Verdict::Found } else { Verdict::Clean })
}

/// The sizes to draw every scene in; its own if none is given.
fn sizes(args: &Args) -> Result<Vec<Option<[u32; 2]>>> {
    if args.quick {
        return Ok(vec![Some(QUICK)]);
    }
    if args.sizes.is_empty() {
        return Ok(vec![None]);
    }
    args.sizes.iter().map(|text| crate::cli::options::values::size(text).map(Some)).collect()
}

/// The devices that take part; a warning names those that cannot.
pub(in crate::cli) fn devices(wanted: Option<&str>) -> Result<Vec<open::Opened>> {
    let found = open::devices(wanted)?;
    found.refused.iter().for_each(|refused| say::warning(&format!("left out: {refused}")));
    Ok(found.opened)
}

fn no_order(method: Method) -> Error {
    let have = twins().into_iter().filter_map(Twin::vulkan);
    let have: Vec<&str> = have.map(|twin| twin.method.name()).collect();
    let problem = format!(
        "{method} orders nothing, so it has no Vulkan form; these have one: {}",
        have.join(", ")
    );
    Error::new("--form", problem)
}

fn options(catalogue: &Catalogue, args: &Args) -> Result<Options> {
    let mut options = Options { k: args.k, ..Options::default() };
    if args.k == Some(0) {
        return Err(Error::new("-k", "0 fragments per pixel: must be at least 1"));
    }
    if !args.methods.is_empty() {
        let twin = |name: &String| crosscheck::find(catalogue.find("-m", name)?);
        options.twins = args.methods.iter().map(twin).collect::<Result<_>>()?;
    }
    if args.form == FormFlag::Vulkan {
        let asked = std::mem::take(&mut options.twins);
        for twin in asked {
            match twin.vulkan() {
                Some(twin) => options.twins.push(twin),
                None if args.methods.is_empty() => {}
                None => return Err(no_order(twin.method)),
            }
        }
    }
    if let Some(path) = args.path {
        options.paths = vec![match path {
            PathFlag::Raster => Path::Raster,
            PathFlag::Compute => Path::Compute,
        }];
    }
    options.shuffle = (args.order == FragmentOrder::Shuffled).then_some(args.seed);
    for method in options.twins.iter().map(|twin| twin.method) {
        let most = method.contract().max_k;
        if let Some(k) = args.k.filter(|&k| k > most) {
            let problem = format!("is {k}, but {method} keeps at most {most} fragments");
            return Err(Error::new("-k", problem));
        }
    }
    Ok(options)
}

fn status(status: Status, reason: &str) -> String {
    let word = format!("{status:?}").to_lowercase();
    if reason.is_empty() { word } else { format!("{word}: {reason}") }
}

/// A scene on all devices. Devices with the same sub-pixel precision share its set-up.
fn compare(
    args: &Args,
    scene: &Scene,
    devices: &[open::Opened],
    options: &Options,
    thickness: Thickness,
) -> Result<Vec<Agreement>> {
    let mut rows: Vec<Agreement> = Vec::new();
    for bits in [8, 4] {
        let own: Vec<&open::Opened> = devices.iter().filter(|d| d.bits() == bits).collect();
        if own.is_empty() {
            continue;
        }
        let quiet = args.output.quiet;
        let message = format!("setting {} up", scene.name);
        let picture =
            wait::during(quiet, &message, || Picture::new(scene, bits).thick(scene, thickness));
        for opened in own {
            let message = format!("drawing {} on {}", scene.name, opened.device.name.name);
            let device: &Device = &opened.device;
            let allowed = opened.paths(options);
            let draw = || crosscheck::run(device, scene, &picture, bits, &allowed);
            rows.extend(wait::during(quiet, &message, draw));
            if let Some(failure) = opened.no_raster(options) {
                rows.extend(without_raster(scene, opened, options, bits, &failure));
            }
        }
    }
    Ok(rows)
}

/// Rows for methods on a path that the device does not support.
fn without_raster(
    scene: &Scene,
    opened: &open::Opened,
    options: &Options,
    bits: u32,
    failure: &Failure,
) -> Vec<Agreement> {
    let name = opened.device.name.clone();
    let (status, is_finding, reason) = crosscheck::failed(failure);
    let row = |twin: &Twin| Agreement {
        adapter: name.name.clone(),
        driver: name.driver.clone(),
        method: twin.name(),
        scene: scene.name.clone(),
        size: scene.size,
        path: Path::Raster,
        sub_pixel_bits: bits,
        differences: crate::gpu::check::compare::Differences::default(),
        by_compute: 0,
        repeated: 0,
        status,
        reason: reason.clone(),
        is_finding,
    };
    options.twins.iter().map(row).collect()
}

/// A summary of what was compared: by adapter and path, and whether the result may depend on the schedule.
fn summary(catalogue: &Catalogue, rows: &[Agreement]) -> String {
    use Align::{Left, Right};
    let heading = [
        "adapter",
        "driver",
        "bits",
        "path",
        "methods",
        "equal",
        "different",
        "unsupported",
        "failed",
        "fragments",
        "coverage",
        "depth",
        "lists",
        "pixels",
        "not allowed",
    ];
    let mut lines = vec![heading.map(str::to_owned).to_vec()];
    let group = |row: &Agreement| {
        let method = catalogue.find("-m", row.method.trim_end_matches("/vulkan"));
        let fixed = method.is_ok_and(|method| method.contract().order_independent());
        (row.adapter.clone(), row.driver.clone(), row.sub_pixel_bits, !fixed, row.path)
    };
    let mut groups: BTreeMap<_, Vec<&Agreement>> = BTreeMap::new();
    for row in rows {
        groups.entry(group(row)).or_default().push(row);
    }
    for ((adapter, driver, bits, varies, path), own) in groups {
        let mut sum = Differences::default();
        own.iter().for_each(|row| sum.add(&row.differences));
        let with = |status| own.iter().filter(|row| row.status == status).count().to_string();
        let methods = if varies { "that may vary" } else { "with one result" };
        let mut line =
            vec![adapter, driver, bits.to_string(), path.to_string(), methods.to_owned()];
        line.extend(
            [Status::Equal, Status::Different, Status::Unsupported, Status::Failed].map(with),
        );
        let compared = own.iter().any(|row| row.is_compared());
        let findings = own.iter().filter(|row| row.is_finding).count();
        let counts = [
            sum.fragments,
            sum.coverage_differences,
            sum.depth_differences,
            sum.list_differences,
            sum.pixel_differences,
        ];
        line.extend(counts.map(|n| n.to_string()));
        line.push(if compared { findings.to_string() } else { "nothing compared".to_owned() });
        lines.push(line);
    }
    let mut align = vec![Left, Left, Right, Left, Left];
    align.resize(heading.len(), Right);
    format!("\n{}", columns(&align, &lines))
}

/// The first words of an adapter's name that distinguish it from the others: full names are long, and the summary has
/// them.
fn short<'a>(name: &'a str, all: &[String]) -> &'a str {
    let ends = name.match_indices(' ').map(|(at, _)| at);
    let is_own = |start: &&str| all.iter().filter(|other| other.starts_with(*start)).count() < 2;
    ends.map(|end| &name[..end]).find(is_own).unwrap_or(name)
}

fn lines(rows: &[Agreement], adapters: &[String]) -> String {
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
            n => format!(" (invocations rerun after waiting for a lock: {n})"),
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
