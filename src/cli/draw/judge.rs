//! `fragloom judge`: another renderer's pictures, or its fragments, against the exact answer.

mod allowed;
mod page;
mod read;
mod table;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde::Serialize;

use self::allowed::{Allowed, Exceeded};
use self::read::{Input, read};
use crate::cli::Verdict as Found;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::page as output;
use crate::cli::options::settings::{Settings as Drawn, complete};
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::{Image, foreign, png, ramp};
use crate::judge::dump::{self, DumpVerdict};
use crate::judge::{Answer, Runs, Settings, Verdict, compare, judge, map};
use crate::render::Options;
use crate::report::{files, json};
use crate::scene::{self, Scene};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh or point set (.obj, .gltf, .glb, .ply, .stl, .pcd, .zip), a scene file (.toml), a built-in scene (see
    /// `fragloom scenes`), or - for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// A picture: PNG, OpenEXR, .npy or .npz with one array; or fragments: .npz as `render --fragments` writes it, or
    /// .csv. Several pictures are runs of one renderer: what differs between them is told, too
    #[arg(value_name = "PICTURE", required = true)]
    pictures: Vec<PathBuf>,

    /// Allow a class so many pixels, in each picture; may be given for several classes [default: rounding any number,
    /// all others 0]
    #[arg(long, value_name = "CLASS=PIXELS")]
    allow: Vec<String>,

    /// What rounding may do to a channel, steps of 1/255 in sRGB, 0 to 255
    #[arg(long, value_name = "STEPS", default_value_t = 1, allow_negative_numbers = true)]
    tolerance: u8,

    /// How near to a pixel's centre an edge passes that may leave it on either side, pixels, 0 to 1
    #[arg(long, value_name = "PIXELS", default_value_t = Settings::default().edge_distance, allow_negative_numbers = true)]
    edge_distance: f64,

    /// How near two depths are whose order may be either, 0 to 1
    #[arg(long, value_name = "DEPTH", default_value_t = Settings::default().depth_distance, allow_negative_numbers = true)]
    depth_distance: f64,

    /// How the opacity of the pictures is read [default: straight; premultiplied for OpenEXR]
    #[arg(long, value_enum, value_name = "READING")]
    opacity: Option<Opacity>,

    /// What the numbers of the pictures are [default: srgb; linear for OpenEXR and floating point]
    #[arg(long, value_enum, value_name = "SPACE")]
    space: Option<Space>,

    /// A folder, for maps: classes.png and difference.png; with several pictures classes-1.png and so on, in their order,
    /// runs.png and runs-difference.png [default: not written]
    #[arg(short = 'o', value_name = "DIR")]
    folder: Option<PathBuf>,

    /// Also write a page for browsers: the pictures, their classes, and the fragments of every pixel [default: none]
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    output: Output,
}

/// `--opacity`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Opacity {
    Ignored,
    Straight,
    Premultiplied,
}

/// `--space`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Space {
    Srgb,
    Linear,
}

/// What `--json` prints.
#[derive(Serialize)]
pub(super) struct Document {
    /// Of this document: 1.
    format: u32,
    /// The version of the program.
    program: &'static str,
    scene: String,
    width: u32,
    height: u32,
    /// Fragments kept per pixel; none is all.
    k: Option<u32>,
    sub_pixel_bits: u32,
    /// Fragments of the exact answer.
    fragments: u64,
    tolerance: u8,
    edge_distance: f64,
    depth_distance: f64,
    /// One for each picture.
    pictures: Vec<Verdict>,
    /// One for each file of fragments.
    dumps: Vec<DumpVerdict>,
    /// What differs between pictures, if there are several.
    runs: Option<Runs>,
    /// What is beyond `--allow`; nothing if the exit code is 0.
    exceeded: Vec<Exceeded>,
    warnings: Vec<String>,
}

/// Draw the exact answer, judge the files, write the maps, and print what was found.
///
/// # Errors
/// Wrong options or scene, a file that cannot be read or is of another size, or one that cannot be written.
pub(in crate::cli) fn run(args: &Args) -> Result<Found> {
    let Drawn { overrides, options, warnings } = complete(&args.drawing, Method::EXACT, false)?;
    let (settings, allowed) = (settings(args)?, Allowed::parse(&args.allow)?);
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &overrides))?;
    let outputs = outputs(args);
    let named: Vec<(&str, &PathBuf)> = outputs.iter().map(|path| ("-o", path)).collect();
    if let Some(folder) = &args.folder {
        files::check_folder("-o", folder)?;
        files::check_apart(&named, &[&scene.files[..], &args.pictures].concat())?;
    }
    if let Some(path) = &args.report {
        output::check("--report", path)?;
        let with_maps = [&named[..], &[("--report", path)]].concat();
        files::check_apart(&with_maps, &[&scene.files[..], &args.pictures].concat())?;
    }
    let inputs = args.pictures.iter().map(|path| read(path, &options));
    let inputs = inputs.collect::<Result<Vec<Input>>>()?;
    let several = inputs.len() > 1;
    if several && inputs.iter().any(|input| matches!(input, Input::Dump(_))) {
        let problem = "one file of fragments at a time, or several pictures";
        return Err(Error::new("PICTURE", problem));
    }
    let message = format!("judging {}", scene.name);
    let threads = options.worker_threads();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new("--threads", format!("cannot start {threads}: {e}")))?;
    let answer = wait::during(quiet, &message, || pool.install(|| Answer::new(&scene, &options)))?;
    let document = wait::during(quiet, &message, || {
        pool.install(|| judged(args, (&scene, &options), &answer, &settings, inputs, &allowed))
    })?;
    if let Some(path) = &args.report {
        wait::during(quiet, "writing the page", || {
            let page = page::page(&scene, &options.exact(options.k), answer.picture(), &document);
            output::write(path, &page?)
        })?;
    }
    if args.folder.is_some() {
        maps(&outputs, &scene, &document)?;
    }
    let warnings = [&warnings[..], &document.warnings].concat();
    let document = Document { warnings, ..document };
    document.warnings.iter().for_each(|warning| say::warning(warning));
    say::result(&match args.output.json {
        true => json::document(&document)?,
        false => table::table(&document),
    })?;
    Ok(if document.exceeded.is_empty() { Found::Clean } else { Found::Found })
}

fn settings(args: &Args) -> Result<Settings> {
    let part = |option: &str, value: f64| match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(Error::new(option, format!("{value} must be 0 to 1"))),
    };
    Ok(Settings {
        tolerance: args.tolerance,
        edge_distance: part("--edge-distance", args.edge_distance)?,
        depth_distance: part("--depth-distance", args.depth_distance)?,
    })
}

/// Judge all of them.
fn judged(
    args: &Args,
    (scene, options): (&Scene, &Options),
    answer: &Answer<'_>,
    settings: &Settings,
    inputs: Vec<Input>,
    allowed: &Allowed,
) -> Result<Document> {
    let (mut pictures, mut dumps) = (Vec::new(), Vec::new());
    for (path, input) in args.pictures.iter().zip(inputs) {
        let name = path.display().to_string();
        match input {
            Input::Dump(dump) => {
                dumps.push(dump::judge(answer, &dump, options.data, &name, settings)?);
            }
            Input::Picture(mut picture) => {
                picture.opacity = args.opacity.map_or(picture.opacity, Into::into);
                picture.space = args.space.map_or(picture.space, Into::into);
                pictures.push(judge(answer, &picture, &name, settings)?);
            }
        }
    }
    let runs = (pictures.len() > 1).then(|| compare(answer, &pictures, settings));
    let exceeded = allowed.exceeded(&pictures, &dumps, runs.as_ref());
    let own = pictures.iter().flat_map(|verdict: &Verdict| verdict.warnings.iter());
    let warnings = scene.warnings.iter().chain(own).cloned().collect();
    Ok(Document {
        format: 1,
        program: env!("CARGO_PKG_VERSION"),
        scene: scene.name.clone(),
        width: scene.size[0],
        height: scene.size[1],
        k: options.k,
        sub_pixel_bits: options.sub_pixel_bits,
        fragments: answer.lists().entries.len() as u64,
        tolerance: settings.tolerance,
        edge_distance: settings.edge_distance,
        depth_distance: settings.depth_distance,
        pictures,
        dumps,
        runs,
        exceeded,
        warnings,
    })
}

/// The maps that are written: two for each file, and two of what differs between runs.
fn outputs(args: &Args) -> Vec<PathBuf> {
    let Some(folder) = &args.folder else { return Vec::new() };
    let names: Vec<String> = match args.pictures.len() {
        1 => vec!["classes.png".to_owned(), "difference.png".to_owned()],
        several => (1..=several)
            .flat_map(|i| [format!("classes-{i}.png"), format!("difference-{i}.png")])
            .chain(["runs.png".to_owned(), "runs-difference.png".to_owned()])
            .collect(),
    };
    names.into_iter().map(|name| folder.join(name)).collect()
}

fn maps(outputs: &[PathBuf], scene: &Scene, document: &Document) -> Result<()> {
    let titled = |name: &str| format!("{} \u{b7} {name}", scene.name);
    let mut next = outputs.iter();
    let mut place = || next.next().map(PathBuf::as_path).unwrap_or(Path::new("classes.png"));
    for verdict in &document.pictures {
        write(place(), &map(&titled(&verdict.picture), scene.size, &verdict.map))?;
        write(place(), &heat_map(scene.size, &verdict.apart))?;
    }
    for verdict in &document.dumps {
        write(place(), &map(&titled(&verdict.dump), scene.size, &verdict.map))?;
    }
    if let Some(runs) = &document.runs {
        write(place(), &map(&titled("what differs between runs"), scene.size, &runs.map))?;
        write(place(), &heat_map(scene.size, &runs.apart))?;
    }
    Ok(())
}

fn write(path: &Path, picture: &Image) -> Result<()> {
    let bytes = png::encode(picture)
        .map_err(|error| Error::new(path.display().to_string(), error.to_string()))?;
    files::write_bytes(path, &bytes)
}

/// The largest difference of a channel of each pixel, in the colours of all heat maps.
fn heat_map([width, height]: [u32; 2], apart: &[u8]) -> Image {
    let color = |&apart: &u8| {
        let [r, g, b] = ramp::color(apart);
        [r, g, b, 255]
    };
    Image { width, height, pixels: apart.iter().map(color).collect() }
}

impl From<Opacity> for foreign::Opacity {
    fn from(typed: Opacity) -> Self {
        match typed {
            Opacity::Ignored => Self::Ignored,
            Opacity::Straight => Self::Straight,
            Opacity::Premultiplied => Self::Premultiplied,
        }
    }
}

impl From<Space> for foreign::Space {
    fn from(typed: Space) -> Self {
        match typed {
            Space::Srgb => Self::Srgb,
            Space::Linear => Self::Linear,
        }
    }
}
