//! `fragloom check`: explore interleavings; verdicts with their bounds, failing schedules as tokens.

use std::fs;
use std::path::PathBuf;

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::Output;
use crate::cli::options::{page, values};
use crate::cli::terminal::interrupt::Interrupt;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::explore::program::controls;
use crate::explore::replay::timeline;
use crate::explore::verdict::claims::claim_by_id;
use crate::explore::verdict::expect::{self, Expectation};
use crate::explore::verdict::matrix;
use crate::explore::{
    Conditions, Executions, Finding, Limits, MemoryModel, Plan, Profile, Progress, Subject, Survey,
    Token, check, cut, inherit, sampled,
};
use crate::render::{Exec, Options, Policy, Sim};
use crate::report::page::verdicts as pages;
use crate::report::{files, json, verdicts};
use crate::scene::{self, Overrides, Scene};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// Methods of the catalogue (see `fragloom methods`); with --claim, instead of the claim's methods
    #[arg(value_name = "METHOD")]
    methods: Vec<String>,

    /// Check every method of the catalogue except the built-in faults
    #[arg(long, conflicts_with_all = ["claim", "mutation", "mutations"])]
    all: bool,

    /// Recompute the verdicts of a claim (see `fragloom claims`) [default: none]
    #[arg(long, value_name = "ID", conflicts_with_all = ["mutation", "mutations", "scene"])]
    claim: Option<String>,

    /// Check one built-in fault (see `fragloom mutations`) [default: none]
    #[arg(long, value_name = "ID", conflicts_with_all = ["mutations", "scene", "methods"])]
    mutation: Option<String>,

    /// Print the kill matrix: which check catches which built-in fault
    #[arg(long, conflicts_with_all = ["scene", "methods"])]
    mutations: bool,

    /// Check on a scene instead of litmus pixels: with --pixel that pixel's fragments, otherwise whole executions
    /// [default: litmus pixels made from the contract]
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,

    /// With --scene, the pixel to explore, column and row from the top left [default: the whole scene]
    #[arg(long, value_name = "X,Y", requires = "scene")]
    pixel: Option<String>,

    /// Fragments of litmus pixels, from 1 up to this [default: 4, and 3 under relaxed memory; relaxed memory is
    /// explored up to 4]
    #[arg(short, value_name = "FRAGMENTS", allow_negative_numbers = true)]
    n: Option<u32>,

    /// The k to explore [default: 1, 2 and 3; with --scene the method's own]
    #[arg(short, value_name = "K", allow_negative_numbers = true)]
    k: Option<u32>,

    /// With --scene, executions on the simulated device, with consecutive seeds; with --pixel, random runs if there are
    /// too many interleavings to explore
    #[arg(long, value_name = "N", default_value_t = 20, allow_negative_numbers = true)]
    executions: u64,

    /// sc, sequentially consistent, or relaxed [default: both]
    #[arg(long, value_name = "MODEL", value_parser = ["sc", "relaxed"])]
    memory_model: Option<String>,

    /// With relaxed memory, the shading language whose memory orders apply: vulkan, glsl, wgsl or all
    #[arg(long, value_name = "LANGUAGE", default_value = "vulkan",
          value_parser = ["vulkan", "glsl", "wgsl", "all"])]
    profile: String,

    /// Which invocations the device guarantees to schedule: unfair, hsa, obe, hsa+obe, lobe, fair, simt (fair, and the
    /// lanes of a warp wait for each other), all or none [default: obe, fair and simt]
    #[arg(long, value_name = "MODEL",
          value_parser = ["unfair", "hsa", "obe", "hsa+obe", "lobe", "fair", "simt", "all", "none"])]
    progress: Option<String>,

    /// Helper invocations next to the first fragments: their writes have no effect, their atomics return any value
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    helpers: u32,

    /// States of an instance above which its verdict is unknown
    #[arg(long, value_name = "N", default_value_t = 5_000_000, allow_negative_numbers = true)]
    max_states: usize,

    /// Print every result of the largest instances with exactly -n fragments of distinct depths, instead of verdicts
    #[arg(long, conflicts_with_all = ["claim", "mutation", "mutations", "scene"])]
    outcomes: bool,

    /// Expected verdicts, as TOML: exit with 0 if all are as expected and nothing else is violated [default: nothing
    /// may be violated]
    #[arg(long, value_name = "FILE")]
    expect: Option<String>,

    /// With --scene, image size in pixels, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long, value_name = "WxH", requires = "scene")]
    size: Option<String>,

    /// With --scene, which invocation goes next on the simulated device (see `fragloom render`)
    #[arg(long, value_name = "POLICY", default_value = "random")]
    schedule: String,

    /// Random runs of random instances with up to 200 fragments, beside the litmus pixels; 0 for none
    #[arg(long, value_name = "N", default_value_t = 400, allow_negative_numbers = true)]
    runs: u64,

    /// The seed of the first random run or, with --scene, of the first execution, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// With --scene, invocations in flight, at least 1
    #[arg(long, value_name = "N", default_value_t = 4_096, allow_negative_numbers = true)]
    resident: usize,

    /// Write a page for browsers as well: the verdicts, and for each that is violated its interleaving, step by step
    /// [default: not written]
    #[arg(long, value_name = "FILE.html", conflicts_with_all = ["mutation", "mutations", "outcomes"])]
    report: Option<PathBuf>,

    #[command(flatten)]
    output: Output,
}

/// Check, and print the verdicts.
///
/// # Errors
/// Wrong options, an unknown method, claim or fault, or a scene that cannot be drawn.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let plan = plan(args)?;
    if let Some(path) = &args.report {
        page::check("--report", path)?;
        let inputs: Vec<PathBuf> = args.expect.iter().map(PathBuf::from).collect();
        files::check_apart(&[("--report", path)], &inputs)?;
    }
    let expected = args.expect.as_deref().map(read_expectations).transpose()?;
    let interrupt = Interrupt::watch();
    let cancelled = || interrupt.pressed();
    let limits = Limits { states: args.max_states, cancelled: &cancelled };
    if args.mutations || args.mutation.is_some() {
        return mutations(catalogue, args, &plan, &limits);
    }
    if args.outcomes {
        return outcomes(catalogue, args, &plan, &limits);
    }
    let rows = rows(catalogue, args, &plan, &limits)?;
    if let Some(path) = &args.report {
        page::write(path, &pages::verdicts(&rows, &|token| timeline(catalogue, token))?)?;
    }
    let text = if args.output.json { json::document(&rows)? } else { verdicts::table(&rows) };
    say::result(&text)?;
    if interrupt.pressed() {
        say::warning("interrupted: what was not explored is unknown");
    }
    Ok(judge(&rows, expected.as_deref()))
}

/// The interleaving of a token; there is none of a whole scene's.
fn timeline(catalogue: &Catalogue, token: &str) -> Result<Option<serde_json::Value>> {
    let Token::Litmus(token) = token.parse()? else { return Ok(None) };
    let timeline = timeline::timeline(catalogue, &token)?;
    let wrong = |error: serde_json::Error| Error::new("--report", error.to_string());
    serde_json::to_value(timeline).map(Some).map_err(wrong)
}

fn judge(rows: &[Finding], expected: Option<&[Expectation]>) -> Verdict {
    let violated = |row: &Finding| row.verdict == crate::explore::Verdict::Violated;
    let wrong = match expected {
        None => rows.iter().any(violated),
        Some(expected) => {
            let surprises = expect::surprises(expected, rows);
            surprises.iter().for_each(|surprise| say::violation(surprise));
            !surprises.is_empty()
        }
    };
    if wrong { Verdict::Found } else { Verdict::Clean }
}

fn read_expectations(path: &str) -> Result<Vec<Expectation>> {
    let text = fs::read_to_string(path)
        .map_err(|error| Error::new(path, format!("cannot be read: {error}")))?;
    expect::parse(path, &text)
}

fn rows(
    catalogue: &Catalogue,
    args: &Args,
    plan: &Plan,
    limits: &Limits<'_>,
) -> Result<Vec<Finding>> {
    let quiet = args.output.quiet;
    if let Some(id) = &args.claim {
        let claim = claim_by_id(id)?;
        subjects(catalogue, args, false)?;
        let message = format!("checking {}", claim.id);
        return wait::during(quiet, &message, || {
            claim.check(catalogue, &args.methods, plan, limits)
        });
    }
    let subjects = subjects(catalogue, args, true)?;
    if let Some(name) = &args.scene {
        let overrides = Overrides {
            size: args.size.as_deref().map(values::size).transpose()?,
            ..Overrides::default()
        };
        let scene = wait::during(quiet, "loading", || scene::load(name, &overrides))?;
        if let Some(path) = &args.report {
            files::check_apart(&[("--report", path)], &scene.files)?;
        }
        let check = |s: &Subject| on_scene(args, plan, s, name, &scene, limits);
        let run = || subjects.iter().map(check).collect::<Result<Vec<Vec<Finding>>>>();
        return Ok(wait::during(quiet, "checking", run)?.concat());
    }
    let check = |s: &Subject| check(s, plan, limits);
    Ok(wait::during(quiet, "checking", || subjects.iter().flat_map(check).collect()))
}

/// The requested methods.
fn subjects(catalogue: &Catalogue, args: &Args, needed: bool) -> Result<Vec<Subject>> {
    if args.all {
        return catalogue.promised().map(Subject::new).collect();
    }
    if args.methods.is_empty() && needed {
        let problem = "is missing: name a method (see `fragloom methods`), or give --all, --claim or --mutations";
        return Err(Error::new("METHOD", problem));
    }
    args.methods.iter().map(|name| controls::find(catalogue, "METHOD", name)).collect()
}

fn on_scene(
    args: &Args,
    plan: &Plan,
    subject: &Subject,
    name: &str,
    scene: &Scene,
    limits: &Limits<'_>,
) -> Result<Vec<Finding>> {
    let policy = Policy::parse(&args.schedule)?;
    let sim = Sim { policy, seed: args.seed, resident: args.resident, ..Sim::default() };
    let options =
        Options { method: subject.method, k: args.k, exec: Exec::Sim(sim), ..Options::default() };
    options.check()?;
    if args.executions == 0 {
        return Err(Error::new("--executions", "is 0, but must be at least 1"));
    }
    let Some(pixel) = args.pixel.as_deref().map(values::pixel).transpose()? else {
        let executions = Executions {
            name: name.to_owned(),
            schedule: args.schedule.clone(),
            options,
            count: args.executions,
        };
        return executions.check(subject, scene, limits);
    };
    let litmus = cut(subject, scene, &options, pixel)?;
    let mut rows = Vec::new();
    for &memory in &plan.memory {
        let conditions = Conditions { memory, warp: None };
        let survey = sampled(subject, &litmus, conditions, args.executions, limits)?;
        rows.extend(survey.rows());
    }
    inherit(&mut rows);
    Ok(rows)
}

fn mutations(
    catalogue: &Catalogue,
    args: &Args,
    plan: &Plan,
    limits: &Limits<'_>,
) -> Result<Verdict> {
    let only = args.mutation.as_deref();
    let run = || matrix::matrix(catalogue, only, plan, limits);
    let lines = wait::during(args.output.quiet, "checking faults", run)?;
    let text = if args.output.json { json::document(&lines)? } else { verdicts::matrix(&lines) };
    say::result(&text)?;
    let right = lines.iter().all(|line| line.fate.is_right());
    Ok(if right { Verdict::Clean } else { Verdict::Found })
}

fn outcomes(
    catalogue: &Catalogue,
    args: &Args,
    plan: &Plan,
    limits: &Limits<'_>,
) -> Result<Verdict> {
    let mut rows = Vec::new();
    for subject in subjects(catalogue, args, true)? {
        let memories = plan.memory.iter();
        let of = |&memory: &MemoryModel| Survey::outcomes(&subject, plan, memory, limits);
        rows.extend(memories.flat_map(of));
    }
    let text = if args.output.json { json::document(&rows)? } else { verdicts::outcomes(&rows) };
    say::result(&text)?;
    Ok(Verdict::Clean)
}

fn plan(args: &Args) -> Result<Plan> {
    let zero = |option: &str, what: &str| Err(Error::new(option, format!("is 0, but {what}")));
    if args.n == Some(0) {
        return zero("-n", "a litmus pixel has at least 1 fragment");
    }
    if args.n.is_some_and(|n| n > MOST_FRAGMENTS) {
        let problem = format!("is above {MOST_FRAGMENTS}: states grow too fast");
        return Err(Error::new("-n", problem));
    }
    if args.k == Some(0) {
        return zero("-k", "a pixel keeps at least 1 fragment");
    }
    if args.k.is_some_and(|k| k > MOST_K) && args.scene.is_none() {
        return Err(Error::new("-k", format!("is above {MOST_K}, the most of a litmus pixel")));
    }
    if args.max_states == 0 {
        return zero("--max-states", "at least 1 state must be explored");
    }
    if args.helpers > MOST_FRAGMENTS {
        return Err(Error::new("--helpers", format!("is above {MOST_FRAGMENTS}")));
    }
    let profiles = match args.profile.as_str() {
        "all" => Profile::ALL.to_vec(),
        name => Profile::ALL.into_iter().filter(|p| p.name() == name).collect(),
    };
    let mut memory = Vec::new();
    if args.memory_model.as_deref() != Some("relaxed") {
        memory.push(MemoryModel::Sequential);
    }
    if args.memory_model.as_deref() != Some("sc") {
        memory.extend(profiles.into_iter().map(MemoryModel::Relaxed));
    }
    let mut plan = Plan {
        fragments: args.n,
        memory,
        helpers: args.helpers,
        runs: args.runs,
        seed: args.seed,
        ..Plan::default()
    };
    if let Some(k) = args.k {
        plan.ks = vec![k];
    }
    if let Some(name) = args.progress.as_deref() {
        plan.simt = matches!(name, "simt" | "all");
        plan.progress = match name {
            "all" => Some(Progress::ALL.to_vec()),
            name => Some(Progress::ALL.into_iter().filter(|p| p.name() == name).collect()),
        };
    }
    Ok(plan)
}

/// The most fragments of a litmus pixel.
const MOST_FRAGMENTS: u32 = 12;

/// The largest k of a litmus pixel.
const MOST_K: u32 = 64;
