//! `fragloom inspect`: one pixel's fragments before and after each method.
//!
//! All methods store depths in one format, the coarsest that any of them fixes, as `compare` has it: so a fragment has
//! one depth word.

use std::path::{Path, PathBuf};

use super::compare::common_format;
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::settings::{Settings, complete};
use crate::cli::options::values;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::plot::Plot;
use crate::image::png;
use crate::inspect::{Inspection, inspect};
use crate::render::{Options, keeps_nearest};
use crate::report::inspection::inspection;
use crate::report::{files, json};
use crate::scene;

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh or point set (.obj, .gltf, .glb, .ply, .stl, .pcd, .zip), a scene file (.toml), a built-in scene (see
    /// `fragloom scenes`), or - for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// The pixel: column and row, counted from 0 at the top left [default: none; it must be given]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pixel: String,

    /// Methods, separated by commas
    #[arg(
        short,
        long = "method",
        value_name = "METHOD,...",
        value_delimiter = ',',
        default_value = "kplus-array"
    )]
    methods: Vec<String>,

    /// Write the plot of the absorbance along the ray, as PNG or SVG by the file's ending; may be given twice
    /// [default: not written]
    #[arg(short = 'o', value_name = "FILE.png|FILE.svg")]
    plots: Vec<PathBuf>,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    output: Output,
}

/// Draw with every method, write the plots, and print the pixel.
///
/// # Errors
/// Wrong options or scene, a pixel outside of the picture, or a file that cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let methods = catalogue.select("-m", &args.methods)?;
    let methods = args.drawing.approximation.with_tail(methods)?;
    let pixel = values::pixel(&args.pixel)?;
    let settings = complete(&args.drawing, Method::EXACT, false)?;
    check_outputs(&args.plots)?;
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &settings.overrides))?;
    let outputs: Vec<(&str, &PathBuf)> = args.plots.iter().map(|path| ("-o", path)).collect();
    files::check_apart(&outputs, &scene.files)?;
    let all = of_methods(&settings, &methods);
    let message = format!("drawing {}", scene.name);
    let found = wait::during(quiet, &message, || inspect(&scene, &all, pixel))?;
    for path in &args.plots {
        files::write_bytes(path, &plotted(&found.plot(), path)?)?;
    }
    settings.warnings.iter().for_each(|warning| say::warning(warning));
    scene.warnings.iter().for_each(|warning| say::warning(warning));
    let text = if args.output.json { json::document(&found)? } else { inspection(&found) };
    say::result(&text)?;
    Ok(complain(&found, &scene.warnings))
}

/// The given options for each of the methods, with one depth format.
pub(super) fn of_methods(settings: &Settings, methods: &[Method]) -> Vec<Options> {
    let fixed = methods.iter().map(|method| method.contract().depth_format);
    let format = settings.options.depth_format.unwrap_or_else(|| common_format(fixed));
    let options = |&method: &Method| Options {
        method,
        depth_format: Some(format),
        // What keeps more than the nearest fragments is drawn without culling.
        cull: settings.options.cull.filter(|_| keeps_nearest(method.contract())),
        ..settings.options.clone()
    };
    methods.iter().map(options).collect()
}

/// Report what concerns one method alone.
fn complain(found: &Inspection, known: &[String]) -> Verdict {
    let mut verdict = Verdict::Clean;
    for method in &found.methods {
        for warning in method.warnings.iter().filter(|warning| !known.contains(warning)) {
            say::warning(&format!("{}: {warning}", method.method));
        }
        for violation in &method.violations {
            say::violation(&format!("{}: {violation}", method.method));
            verdict = Verdict::Found;
        }
    }
    verdict
}

fn is_svg(path: &Path) -> Option<bool> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    match &ending[..] {
        "svg" => Some(true),
        "png" => Some(false),
        _ => None,
    }
}

fn check_outputs(plots: &[PathBuf]) -> Result<()> {
    for path in plots {
        if is_svg(path).is_none() {
            let problem = format!("{} must end in .png or .svg", path.display());
            return Err(Error::new("-o", problem));
        }
        files::check_output("-o", path)?;
    }
    files::check_distinct(&plots.iter().map(|path| ("-o", path)).collect::<Vec<_>>())
}

fn plotted(plot: &Plot, path: &Path) -> Result<Vec<u8>> {
    if is_svg(path) == Some(true) {
        return Ok(plot.svg().into_bytes());
    }
    let wrong =
        |error: ::png::EncodingError| Error::new(path.display().to_string(), error.to_string());
    png::encode(&plot.draw()).map_err(wrong)
}
