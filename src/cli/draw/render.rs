//! `fragloom render`: draw a scene with one method.

use std::path::PathBuf;

use super::frames::{self, Frames};
use super::picture::Picture;
use super::reference::{Against, Document, Reference};
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::effects::Effects;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::measures::{Measures, Printed};
use crate::cli::options::settings::{Settings, complete};
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::render::{Importance, Options, Rendering, Wanted, render};
use crate::report::errors::{self, Errors};
use crate::report::grid::Syntax;
use crate::report::{files, json, npz, table};
use crate::scene;
use crate::scheme::contract::Demand;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh or point set (.obj, .gltf, .glb, .ply, .stl, .pcd, .zip), a scene file (.toml), a built-in scene (see
    /// `fragloom scenes`), or - for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// A method of the catalogue (see `fragloom methods`)
    #[arg(short, long, value_name = "METHOD", default_value = "kplus-array")]
    method: String,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    effects: Effects,

    #[command(flatten)]
    frames: Frames,

    #[command(flatten)]
    picture: Picture,

    /// Write the kept fragments of every pixel, as NumPy arrays [default: not written]
    #[arg(long, value_name = "FILE.npz")]
    fragments: Option<PathBuf>,

    /// Do not hash the fragments: of methods that keep them, memory then holds the lists of the tiles in work alone
    /// [default: hashed]
    #[arg(long)]
    no_hash: bool,

    /// Write the JSON document of `--json` to a file as well [default: not written]
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,

    /// With `--exec sim`, write the schedule, for `--schedule recorded:FILE` [default: not written]
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,

    /// Compare the picture with another of the same size: a PNG file, or what a method draws that keeps all fragments,
    /// usually exact. Prints how far apart they are, which is no violation [default: none]
    #[arg(long, value_name = "FILE.png|METHOD")]
    reference: Option<String>,

    #[command(flatten)]
    measures: Measures,

    #[command(flatten)]
    output: Output,
}

/// Draw, write the requested files, and print the accounting.
///
/// # Errors
/// Wrong options or scene, or a file that cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let given = vec![catalogue.find("-m", &args.method)?];
    let method = args.drawing.approximation.with_tail(given)?[0];
    let mut settings = complete(&args.drawing, method, args.record.is_some())?;
    args.effects.complete(args.drawing.data, &mut settings.options)?;
    settings.warnings.extend(idle(&settings.options));
    args.picture.complete(&mut settings.options)?;
    settings.options.wanted = wanted(args);
    check_outputs(args)?;
    let printed = printed(args)?;
    args.reference.as_ref().map_or(Ok(()), |_| args.picture.check_comparable())?;
    let reference = args.reference.as_deref().map(|typed| Reference::read(catalogue, typed));
    let reference = reference.transpose()?;
    let single = outputs(args).into_iter().map(|(option, _)| option);
    let single: Vec<&str> = single
        .chain(args.reference.as_ref().map(|_| "--reference"))
        .filter(|option| !["-o", "--stats"].contains(option))
        .collect();
    if let Some(animation) = args.frames.complete(&single)? {
        if args.picture.is_stdout() {
            return Err(Error::new("-o", "- is one picture on stdout, but --frames draws several"));
        }
        let quiet = args.output.quiet;
        let load = || scene::load(&args.scene, &settings.overrides);
        let scene = wait::during(quiet, "loading", load)?;
        let (picture, stats) = (&args.picture, args.stats.as_deref());
        let output = [args.output.json, quiet];
        return frames::run(&scene, &settings, &animation, picture, stats, output);
    }
    let (rendering, against) = draw(args, settings, reference.as_ref())?;
    let report = &rendering.report;
    let document = json::document(&Document { report, errors: against.as_ref() })?;
    write_outputs(args, &rendering, &document)?;
    report.warnings.iter().for_each(|warning| say::warning(warning));
    let errors: Vec<Errors<'_>> = against.iter().map(|against| against.errors(report)).collect();
    say::result(&match printed {
        _ if args.picture.is_stdout() => String::new(),
        Printed::Document => document,
        Printed::Tables => table::accounting(report) + &titled(&errors),
        Printed::Errors(syntax) => errors::grid(&errors).write(syntax),
        Printed::ErrorDocument => json::document(&errors)?,
    })?;
    report.violations.iter().for_each(|violation| say::violation(violation));
    Ok(if report.violations.is_empty() { Verdict::Clean } else { Verdict::Found })
}

/// Lists are joined only for what is written of them, or compared.
fn wanted(args: &Args) -> Wanted {
    let compared = args.reference.is_some() || args.effects.ldi.is_some();
    match args.fragments.is_some() || compared {
        true => Wanted::Lists,
        false if args.no_hash => Wanted::Picture,
        false => Wanted::Hash,
    }
}

fn printed(args: &Args) -> Result<Printed> {
    if args.measures.metrics.is_some() && args.reference.is_none() {
        return Err(Error::new("--metrics", "needs --reference, what to compare with"));
    }
    args.measures.printed(&args.output)
}

/// The table of errors under a title, if there is one.
fn titled(errors: &[Errors<'_>]) -> String {
    let Some(first) = errors.first() else { return String::new() };
    let grid = errors::grid(errors).write(Syntax::Text);
    format!("\nerrors against {}\n\n{grid}", first.reference)
}

/// What divides records by importance does nothing for a method that does not.
fn idle(options: &Options) -> Option<String> {
    let given = options.k_average.is_some() || options.importance != Importance::default();
    let divides = options.method.contract().demand == Demand::Records;
    let what = "--k-average and what is said of importance have no effect with";
    (given && !divides).then(|| format!("{what} {}", options.method))
}

fn draw(
    args: &Args,
    settings: Settings,
    reference: Option<&Reference>,
) -> Result<(Rendering, Option<Against>)> {
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &settings.overrides))?;
    let given = reference.zip(args.reference.as_deref());
    let named =
        [&args.reference.as_ref().map(PathBuf::from), &args.drawing.importance.importance_map];
    let inputs: Vec<PathBuf> =
        scene.files.iter().chain(named.into_iter().flatten()).cloned().collect();
    files::check_apart(&files_among(args), &inputs)?;
    given.map_or(Ok(()), |(reference, typed)| reference.check_size(typed, scene.size))?;
    let message = format!("drawing {} with {}", scene.name, settings.options.method);
    let mut rendering = wait::during(quiet, &message, || render(&scene, &settings.options))?;
    let against = given.map(|(reference, typed)| {
        let how = (args.measures.threshold, quiet);
        reference.against(typed, &scene, &settings.options, &rendering, how)
    });
    let against = against.transpose()?;
    let warnings = &mut rendering.report.warnings;
    for warning in settings.warnings.into_iter().chain(scene.warnings) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    Ok((rendering, against))
}

/// The output files by their options.
fn outputs(args: &Args) -> Vec<(&'static str, &PathBuf)> {
    let all = [
        ("-o", &args.picture.image),
        ("--fragments", &args.fragments),
        ("--surfaces", &args.effects.surfaces),
        ("--ldi", &args.effects.ldi),
        ("--stats", &args.stats),
        ("--record", &args.record),
    ];
    all.into_iter().filter_map(|(option, path)| Some((option, path.as_ref()?))).collect()
}

/// The same without what goes to stdout.
fn files_among(args: &Args) -> Vec<(&'static str, &PathBuf)> {
    let mut outputs = outputs(args);
    outputs.retain(|(option, _)| !(*option == "-o" && args.picture.is_stdout()));
    outputs
}

fn check_outputs(args: &Args) -> Result<()> {
    if args.picture.is_stdout() && args.output.json {
        return Err(Error::new("--json", "is printed on stdout, and so is the picture of -o -"));
    }
    let outputs = files_among(args);
    outputs.iter().try_for_each(|(option, path)| files::check_output(option, path))?;
    files::check_distinct(&outputs)
}

fn write_outputs(args: &Args, rendering: &Rendering, document: &str) -> Result<()> {
    if let Some(path) = &args.picture.image {
        args.picture.write(rendering, path)?;
    }
    if let Some(path) = &args.fragments {
        let written = npz::Written::of(&rendering.kept, &rendering.report.method)?;
        files::write(path, |file| written.write(file))?;
    }
    if let (Some(path), Some(surfaces)) = (&args.effects.surfaces, &rendering.surfaces) {
        files::write(path, |file| npz::write(file, surfaces))?;
    }
    if let Some(path) = &args.effects.ldi {
        let (lists, voxels) = (rendering.lists()?, rendering.voxels.as_ref());
        files::write(path, |file| npz::write_ldi(file, lists, voxels))?;
    }
    if let Some(path) = &args.record {
        let schedule = rendering.schedule.as_ref();
        let schedule = schedule.ok_or_else(|| Error::new("--record", "nothing was scheduled"))?;
        files::write_bytes(path, schedule)?;
    }
    if let Some(path) = &args.stats {
        files::write_bytes(path, document.as_bytes())?;
    }
    Ok(())
}
