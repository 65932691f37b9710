//! `fragloom crosscheck`: the same schemes on wgpu, against the expected results.
//!
//! Every (adapter, path, method) runs in a process of its own ([`worker`]), which the first process watches ([`parent`]).
//! Rows are printed and reported as they finish ([`rows`]).

mod asked;
mod litmus;
mod parent;
mod process;
mod report;
mod rows;
mod table;
mod tabulate;
mod tune;
mod worker;

use std::path::PathBuf;

use asked::{Settings, Subject};
use report::Report;
use rows::Rows;
use table::{Table, status};

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::gpu::check::crosscheck::{self, Agreement, Options, Path, blank, failed};
use crate::gpu::check::double::Double;
use crate::gpu::check::open;
use crate::gpu::driver::device::AdapterName;
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::picture::Picture;
use crate::gpu::twin::source::{Twin, twins};
use crate::report::{files, json};

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

    /// Seed of `--order shuffled`, or of `--tune`, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// Image sizes in pixels, separated by commas, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long = "size", value_name = "WxH,...", value_delimiter = ',')]
    sizes: Vec<String>,

    /// Run the litmus pixels instead: one invocation at a time, memory compared word for word with the simulator's;
    /// then thousands of copies at once, their outcomes counted against all that interleavings allow
    #[arg(long, conflicts_with_all = ["scenes", "path", "order", "sizes", "quick", "k", "thickness"])]
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

    /// With `--litmus`, how copies are put under contention, as `--tune` prints it: apart=A,group=G,hammer=H,burst=B
    /// [default: three fixed orders]
    #[arg(long, value_name = "SETTINGS", requires = "litmus")]
    stress: Option<String>,

    /// With `--litmus`, try N settings of `--stress` at random, by `--seed`, and say which make `kb` lose fragments most
    /// often [default: none]
    #[arg(
        long,
        value_name = "N",
        requires = "litmus",
        conflicts_with = "stress",
        allow_negative_numbers = true
    )]
    tune: Option<u32>,

    /// Small pictures: 157x101
    #[arg(long, conflicts_with = "sizes")]
    quick: bool,

    /// Run everything in this process, scene by scene, and not each method, path and adapter in a process of its own: a
    /// lost device or a crash then ends the run
    #[arg(long)]
    in_process: bool,

    /// Seconds after which a submission that has not come back has hung, 1 to 3600
    #[arg(long, value_name = "SECONDS", default_value_t = 60, allow_negative_numbers = true)]
    limit: u64,

    /// Write every row to this file as it finishes, as lines of JSON [default: none]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["litmus", "resume"])]
    report: Option<PathBuf>,

    /// Go on where the run that wrote this report was cut: rows that it has are not run again [default: none]
    #[arg(long, value_name = "FILE", conflicts_with = "litmus")]
    resume: Option<PathBuf>,

    /// Run nothing; print what these reports say, as a page in Markdown [default: none]
    #[arg(long, value_name = "FILE,...", value_delimiter = ',', exclusive = true)]
    tabulate: Vec<PathBuf>,

    /// Be the process that runs one method on one path of this adapter [default: none]
    #[arg(long, hide = true, value_name = "NAME")]
    worker: Option<String>,

    /// As a worker: begin with this picture
    #[arg(long, hide = true, value_name = "N", default_value_t = 0)]
    from: usize,

    /// Instead of adapters, a double that fails as it is told [default: none]
    #[arg(
        long,
        hide = true,
        conflicts_with = "in_process",
        value_name = "FAULT=METHOD/SCENE/PATH,..."
    )]
    test_double: Option<String>,

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

impl FormFlag {
    /// As it is typed.
    fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Vulkan => "vulkan",
        }
    }
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
    if !args.tabulate.is_empty() {
        return tabulate::run(&args.tabulate);
    }
    if !(1..=3600).contains(&args.limit) {
        return Err(Error::new("--limit", format!("is {}, and must be 1 to 3600", args.limit)));
    }
    let options = options(catalogue, args)?;
    if let Some(count) = args.tune {
        return tune::run(catalogue, args, count);
    }
    if args.litmus {
        return match &args.worker {
            Some(name) => litmus::work(args, &options, name),
            None => litmus::run(args, &options),
        };
    }
    asked::thickness(args)?;
    let subjects = asked::subjects(args)?;
    if let Some(name) = &args.worker {
        return worker::run(args, &options, &subjects, name);
    }
    let adapters = match &args.test_double {
        Some(_) => vec![Double::adapter()],
        None => open::names(args.adapter.as_deref())?,
    };
    let mut report = report(args, &subjects)?;
    let planned = adapters.len() * options.paths.len() * options.twins.len() * subjects.len();
    let table = Table::new(&adapters, &options, &subjects, planned);
    let table = (!args.output.json).then_some(table);
    let mut rows = Rows::new(planned, report.as_mut(), table, args.output.quiet)?;
    if args.in_process {
        here(args, &subjects, &options, &mut rows)?;
    } else {
        let units = parent::units(&adapters, &options);
        parent::run(args, &subjects, &units, &mut rows)?;
    }
    finish(catalogue, args, &rows)
}

/// The report that rows are written to.
fn report(args: &Args, subjects: &[Subject]) -> Result<Option<Report>> {
    let outputs = [("--report", &args.report), ("--resume", &args.resume)];
    let outputs: Vec<(&str, &PathBuf)> =
        outputs.into_iter().filter_map(|(option, path)| Some((option, path.as_ref()?))).collect();
    let inputs: Vec<PathBuf> = subjects.iter().flat_map(|one| one.files.clone()).collect();
    files::check_apart(&outputs, &inputs)?;
    let settings = Settings::of(args);
    match (&args.report, &args.resume) {
        (Some(path), _) => Report::new(path, settings).map(Some),
        (_, Some(path)) => Report::resume(path, settings).map(Some),
        _ => Ok(None),
    }
}

/// Say what was found.
fn finish(catalogue: &Catalogue, args: &Args, rows: &Rows<'_>) -> Result<Verdict> {
    let all = &rows.all;
    say::result(&if args.output.json {
        json::document(all)?
    } else {
        table::summary(catalogue, all) + &table::predictions(rows.expected())
    })?;
    for row in all.iter().filter(|row| row.is_finding) {
        let Agreement { adapter, method, asked, path, status, reason, .. } = row;
        let told = self::status(*status, reason);
        say::violation(&format!("{adapter}: {method} on {asked}, {path} path: {told}"));
    }
    // An unsupported row does not count as a pass.
    let compared = all.iter().any(Agreement::is_compared);
    if !compared {
        say::violation("nothing was compared");
    }
    let found = !compared || all.iter().any(|row| row.is_finding);
    Ok(if found { Verdict::Found } else { Verdict::Clean })
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

/// Everything in this process, picture by picture: devices of the same sub-pixel precision share its set-up.
fn here(args: &Args, subjects: &[Subject], options: &Options, rows: &mut Rows<'_>) -> Result<()> {
    let mut devices = devices(args.adapter.as_deref())?;
    devices.iter_mut().for_each(|opened| opened.device.patience = args.limit);
    options.twins.iter().try_for_each(|twin| rows.ask(*twin))?;
    let (quiet, thickness) = (args.output.quiet, asked::thickness(args)?);
    for subject in subjects {
        let scene = subject.load()?;
        for bits in [8, 4] {
            let own: Vec<&open::Opened> = devices.iter().filter(|d| d.bits() == bits).collect();
            if own.is_empty() {
                continue;
            }
            let message = format!("setting {} up", subject.asked);
            let picture = wait::during(quiet, &message, || {
                Picture::new(&scene, bits).thick(&scene, thickness)
            });
            for opened in own {
                let allowed = opened.paths(options);
                let message = format!("drawing {} on {}", subject.asked, opened.device.name.name);
                let draw = || crosscheck::run(&opened.device, &scene, &picture, bits, &allowed);
                let mut own = wait::during(quiet, &message, draw);
                if let Some(failure) = opened.no_raster(options) {
                    let options = Options { paths: vec![Path::Raster], ..options.clone() };
                    let name = &opened.device.name;
                    own.extend(row_without(name, &options, subject, &failure));
                }
                for row in own {
                    let row = Agreement { asked: subject.asked.clone(), ..row };
                    if !rows.take_known(&row) {
                        rows.add(row)?;
                    }
                }
            }
        }
    }
    Ok(())
}

/// Rows that the device cannot begin.
fn row_without(
    adapter: &AdapterName,
    options: &Options,
    subject: &Subject,
    failure: &Failure,
) -> Vec<Agreement> {
    let (status, is_finding, reason) = failed(failure);
    let all = options.paths.iter().flat_map(|&path| options.twins.iter().map(move |t| (path, t)));
    let row = |(path, twin): (Path, &Twin)| Agreement {
        asked: subject.asked.clone(),
        status,
        is_finding,
        reason: reason.clone(),
        ..blank(adapter, &twin.name(), &subject.name, path, subject.size)
    };
    all.map(row).collect()
}
