//! `fragloom report`: a scene drawn with several methods, as one page for browsers.

use std::path::PathBuf;

use super::inspect::of_methods;
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::page;
use crate::cli::options::settings::complete;
use crate::cli::terminal::{say, wait};
use crate::error::Result;
use crate::exec::Method;
use crate::report::grid::Syntax;
use crate::report::page::drawing::{Row, drawing, grid};
use crate::report::{files, json};
use crate::scene;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh or point set (.obj, .gltf, .glb, .ply, .stl, .pcd, .zip), a scene file (.toml), a built-in scene (see
    /// `fragloom scenes`), or - for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// Methods, separated by commas
    #[arg(
        short,
        long = "method",
        value_name = "METHOD,...",
        value_delimiter = ',',
        default_value = "kplus-array"
    )]
    methods: Vec<String>,

    /// The page to write, one file that needs no other [default: none; it must be given]
    #[arg(short = 'o', value_name = "FILE.html")]
    page: PathBuf,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    output: Output,
}

/// Draw with every method, write the page, and print the table.
///
/// # Errors
/// Wrong options or scene, or a file that cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let methods = catalogue.select("-m", &args.methods)?;
    let methods = args.drawing.approximation.with_tail(methods)?;
    let settings = complete(&args.drawing, Method::EXACT, false)?;
    page::check("-o", &args.page)?;
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &settings.overrides))?;
    files::check_apart(&[("-o", &args.page)], &scene.files)?;
    let all = of_methods(&settings, &methods);
    let message = format!("drawing {}", scene.name);
    let drawn = wait::during(quiet, &message, || drawing(&scene, &all))?;
    wait::during(quiet, "writing the page", || page::write(&args.page, &drawn.page))?;
    settings.warnings.iter().chain(&scene.warnings).for_each(|warning| say::warning(warning));
    say::result(&match args.output.json {
        true => json::document(&drawn.rows)?,
        false => grid(&drawn.rows, scene.size).write(Syntax::Text),
    })?;
    Ok(complain(&drawn.rows, &scene.warnings))
}

/// Report what concerns one method alone.
fn complain(rows: &[Row], known: &[String]) -> Verdict {
    let mut verdict = Verdict::Clean;
    for row in rows {
        for warning in row.warnings.iter().filter(|warning| !known.contains(warning)) {
            say::warning(&format!("{}: {warning}", row.method));
        }
        for violation in &row.violations {
            say::violation(&format!("{}: {violation}", row.method));
            verdict = Verdict::Found;
        }
    }
    verdict
}
