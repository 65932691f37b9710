//! `fragloom compare`: several methods against the exact reference.
//!
//! A method that keeps k fragments must give the same lists as the reference with the same k. The table also shows how
//! far its picture is from the one with all fragments, which is the cost of k. All methods and the reference store
//! depths in one format: the coarsest that any of them fixes. A second table has the errors against that picture, and
//! with a memory budget a third has the columns of Table 2 of the importance paper. `--sweep` draws with several values
//! of an option instead.

mod row;
mod session;
mod sweep;

use std::path::PathBuf;

use self::row::Compared;
use self::session::Session;
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::measures::{Measures, Printed};
use crate::cli::options::settings::complete;
use crate::cli::options::sweep::Sweep;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::num::depth::Format;
use crate::render::Options;
use crate::report::errors::{self, Errors};
use crate::report::{files, json};
use crate::scene;
use crate::scheme::{Form, Keeps};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh or point set (.obj, .gltf, .glb, .ply, .stl, .pcd, .zip), a scene file (.toml), a built-in scene (see
    /// `fragloom scenes`), or - for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// Methods to compare, separated by commas [default: all in their correct form]
    #[arg(short, long = "method", value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,

    /// The method that is right by definition
    #[arg(long, value_name = "METHOD", default_value = "exact")]
    reference: String,

    /// A folder that exists, for one picture per method, compare-METHOD.png: exact, method, differences; and for a method
    /// with k by importance, importance-METHOD.png and k-METHOD.png [default: not written]
    #[arg(short = 'o', value_name = "DIR")]
    folder: Option<PathBuf>,

    /// With -o, also write one map of errors per method, heat-METHOD.png: of FLIP, 0 to 1, or of the largest difference
    /// of a channel, 0 to 255. The scale is always the whole one, so that maps can be laid side by side [default: none]
    #[arg(long, value_enum, value_name = "MEASURE")]
    heat: Option<Heat>,

    /// Draw with several values of an option instead, NAME=VALUES like k=1..32 or k=1,2,4,8, and give a table of memory and
    /// errors; NAME is k, k-average, beta, moments, samples, load or age-limit. A method without that option is drawn
    /// once. With -o, write sweep.csv, and the errors against the memory as sweep.svg and sweep.png [default: no sweep]
    #[arg(long, value_name = "NAME=VALUES")]
    sweep: Option<String>,

    #[command(flatten)]
    measures: Measures,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    output: Output,
}

/// `--heat`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Heat {
    Flip,
    Difference,
}

/// Draw everything, write the sheets, and print a row per method.
///
/// # Errors
/// Wrong options or scene, or a file that cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let methods = args.drawing.approximation.with_tail(methods(catalogue, args)?)?;
    let reference = catalogue.find("--reference", &args.reference)?;
    let printed = args.measures.printed(&args.output)?;
    let sweep = args.sweep.as_deref().map(|text| Sweep::parse(text, &args.drawing)).transpose()?;
    let runs = sweep.as_ref().map(|sweep| sweep::runs(sweep, &methods, args)).transpose()?;
    check_folder(args)?;
    let mut session = session(args, &methods, reference)?;
    session.warnings.iter().for_each(|warning| say::warning(warning));
    if let (Some(sweep), Some(runs)) = (sweep, runs) {
        return sweep::run(&mut session, &sweep, &runs, printed, args.folder.as_deref());
    }
    let pictures = args.folder.as_deref().map(|folder| (folder, args.heat));
    let rows = methods.iter().map(|&method| session.compare(method, pictures));
    let rows: Vec<Compared> = rows.collect::<Result<_>>()?;
    let errors: Vec<Errors<'_>> = rows.iter().map(Compared::errors).collect();
    say::result(&match printed {
        Printed::Tables => row::table(&rows),
        Printed::Document => json::document(&rows)?,
        Printed::Errors(syntax) => errors::grid(&errors).write(syntax),
        Printed::ErrorDocument => json::document(&errors)?,
    })?;
    rows.iter().for_each(|row| complain(row, &session.warnings));
    Ok(if rows.iter().all(Compared::agrees) { Verdict::Clean } else { Verdict::Found })
}

/// The folder exists, and what needs it has it.
fn check_folder(args: &Args) -> Result<()> {
    match (&args.folder, args.heat) {
        (None, Some(_)) => Err(Error::new("--heat", "needs -o, a folder for the maps")),
        (Some(folder), _) => files::check_folder("-o", folder),
        (None, None) => Ok(()),
    }
}

/// The scene and the options that all share.
fn session(args: &Args, methods: &[Method], reference: Method) -> Result<Session> {
    let settings = complete(&args.drawing, reference, false)?;
    let depth_format = settings.options.depth_format.or_else(|| {
        let all = methods.iter().chain([&reference]);
        Some(common_format(all.map(|method| method.contract().depth_format)))
    });
    let options = Options { counters: false, depth_format, ..settings.options };
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &settings.overrides))?;
    let warnings = [settings.warnings, scene.warnings.clone()].concat();
    Ok(Session::new(scene, options, warnings, args.measures.threshold, quiet))
}

/// Report what concerns this method alone.
fn complain(row: &Compared, known: &[String]) {
    for warning in row.warnings.iter().filter(|warning| !known.contains(warning)) {
        say::warning(&format!("{}: {warning}", row.method));
    }
    for violation in &row.violations {
        say::violation(&format!("{}: {violation}", row.method));
    }
}

/// The given methods, or all correct ones but the reference.
fn methods(catalogue: &Catalogue, args: &Args) -> Result<Vec<Method>> {
    if !args.methods.is_empty() {
        return catalogue.select("-m", &args.methods);
    }
    let shows = |m: &Method| m.contract().keeps != Keeps::Bound && m.name() != args.reference;
    let wanted = |m: &Method| m.contract().form == Form::Correct && shows(m);
    Ok(catalogue.methods().iter().copied().filter(wanted).collect())
}

/// The coarsest format that any of them fixes.
pub(super) fn common_format(fixed: impl Iterator<Item = Option<Format>>) -> Format {
    let fixed = fixed.flatten();
    let coarseness = |format: &Format| Format::ALL.iter().position(|known| known == format);
    fixed.max_by_key(coarseness).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::options::sweep::names;

    #[test]
    fn the_help_names_all_that_can_be_swept() {
        let command = crate::cli::command();
        let compare = command.find_subcommand("compare").unwrap();
        let sweep = compare.get_arguments().find(|argument| argument.get_id() == "sweep").unwrap();
        let help = sweep.get_help().unwrap().to_string();
        let list = help.split("NAME is ").nth(1).unwrap().split('.').next().unwrap();
        let listed: Vec<&str> =
            list.split([',', ' ']).filter(|word| !["", "or"].contains(word)).collect();
        assert_eq!(listed, names().collect::<Vec<_>>());
    }

    #[test]
    fn the_coarsest_fixed_format_wins() {
        let [free, f32, d24] = [None, Some(Format::F32), Some(Format::D24)];
        let common = |fixed: [Option<Format>; 3]| common_format(fixed.into_iter());
        assert_eq!(common([free, free, free]), Format::D32);
        assert_eq!(common([free, f32, free]), Format::F32);
        assert_eq!(common([d24, f32, free]), Format::D24);
        assert_eq!(common([free, free, d24]), Format::D24);
    }
}
