//! `fragloom golden record`: scenes into a manifest.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::Jobs;
use super::line::{CommandLine, Line};
use super::words::{Look, Words};
use crate::catalogue::{self, Catalogue};
use crate::cli::Verdict;
use crate::cli::options::flags::Output;
use crate::cli::terminal::interrupt::Interrupt;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::golden::{self, Drawn, Entry, MANIFEST, Manifest, Plan, Work, relative};
use crate::report::text::{Align, columns, thousands};
use crate::report::{files, json};
use crate::scene::FileFormat;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The folder of the manifest, golden.toml; it is made if it is not there
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// What to draw: meshes, point sets, scene files or built-in scenes, as for render [default: all scene files in DIR,
    /// or, if it has none, all meshes and point sets in it]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,

    /// Methods, separated by commas; each draws all scenes
    #[arg(
        short,
        long = "method",
        value_name = "METHOD,...",
        value_delimiter = ',',
        default_value = "kplus-array"
    )]
    methods: Vec<String>,

    /// The entry's name, which names its picture; for one scene and one method [default: the scene's and the method's]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,

    /// Write no pictures: hashes alone say whether a picture is the same
    #[arg(long)]
    no_pictures: bool,

    #[command(flatten)]
    look: Words,

    #[command(flatten)]
    jobs: Jobs,

    #[command(flatten)]
    output: Output,
}

/// What was recorded, for `--json`.
#[derive(Serialize)]
struct Recorded<'a> {
    name: &'a str,
    scene: &'a str,
    options: &'a [String],
    generated: u64,
    kept: u64,
    fragments_hash: Option<&'a String>,
    image_hash: Option<&'a String>,
    picture: Option<&'a String>,
    warnings: &'a [String],
}

/// Draw all scenes with all methods, and add them to the manifest.
///
/// # Errors
/// Wrong options or scenes, names that are taken, or files that cannot be written: then nothing is.
pub(super) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    files::check_folder("DIR", &args.folder)?;
    let jobs = args.jobs.checked()?;
    let mut manifest = Manifest::in_folder(&args.folder)?;
    let plans = plans(catalogue, args)?;
    let pictures =
        !args.no_pictures && (manifest.entries().is_empty() || manifest.keeps_pictures());
    let interrupt = Interrupt::watch();
    let draw = CommandLine { catalogue };
    let found = wait::counting(args.output.quiet, "recording", plans.len(), |done| {
        let work = Work { jobs, cancelled: &|| interrupt.pressed(), done, shown: &|_, _| {} };
        golden::record(&mut manifest, &plans, &draw, pictures, &work)
    })?;
    let Some(found) = found else {
        return Err(Error::new("record", "interrupted: nothing was recorded"));
    };
    for (entry, drawn) in &found {
        drawn.warnings.iter().for_each(|text| say::warning(&format!("{}: {text}", entry.name)));
    }
    say::result(&match args.output.json {
        true => json::document(&found.iter().map(document).collect::<Vec<_>>())?,
        false => table(&manifest, &found),
    })?;
    Ok(Verdict::Clean)
}

fn document((entry, drawn): &(Entry, Drawn)) -> Recorded<'_> {
    let results = entry.results.as_ref();
    Recorded {
        name: &entry.name,
        scene: &entry.scene,
        options: &entry.options,
        generated: drawn.generated,
        kept: drawn.kept,
        fragments_hash: drawn.fragments_hash.as_ref(),
        image_hash: results.map(|results| &results.image_hash),
        picture: entry.picture.as_ref(),
        warnings: &drawn.warnings,
    }
}

fn table(manifest: &Manifest, found: &[(Entry, Drawn)]) -> String {
    let mut rows =
        vec![["name", "size", "generated", "kept", "picture"].map(str::to_owned).to_vec()];
    for (entry, drawn) in found {
        rows.push(vec![
            entry.name.clone(),
            format!("{}x{}", drawn.image.width, drawn.image.height),
            thousands(drawn.generated),
            thousands(drawn.kept),
            entry.picture.clone().unwrap_or_else(|| "not kept".to_owned()),
        ]);
    }
    let table =
        columns(&[Align::Left, Align::Right, Align::Right, Align::Right, Align::Left], &rows);
    format!("{table}\n{} recorded in {}\n", found.len(), manifest.path().display())
}

/// Every scene with every method.
fn plans(catalogue: &Catalogue, args: &Args) -> Result<Vec<Plan>> {
    let scenes = if args.scenes.is_empty() { within(&args.folder)? } else { args.scenes.clone() };
    if let Some(bad) = scenes.iter().find(|scene| *scene == "-") {
        return Err(Error::new("SCENE", format!("{bad} is stdin, which cannot be drawn again")));
    }
    let methods = catalogue.select("-m", &args.methods)?;
    if args.name.is_some() && scenes.len() * methods.len() != 1 {
        let problem = "is for one scene and one method; several have the names of their scenes";
        return Err(Error::new("--name", problem));
    }
    let rest = placed(&args.look, &args.folder);
    let default = methods == [catalogue::DEFAULT];
    let mut plans = Vec::new();
    for scene in &scenes {
        for method in &methods {
            let stem = stem(&args.look.look, scene);
            let name = match (&args.name, default) {
                (Some(name), _) => name.clone(),
                (None, true) => stem,
                (None, false) => format!("{stem}-{}", method.name()),
            };
            let scene = match Line::is_file(&args.look.look, scene) {
                true => relative(Path::new(scene), &args.folder),
                false => scene.clone(),
            };
            let mut options = vec!["-m".to_owned(), method.name().to_owned()];
            options.extend(rest.iter().cloned());
            Line::parse(&options)?;
            plans.push(Plan { name, scene, options });
        }
    }
    Ok(plans)
}

/// The words of the options, with paths relative to the manifest.
fn placed(words: &Words, folder: &Path) -> Vec<String> {
    let mut all = words.words.clone();
    for (before, path) in Line::paths(&words.look) {
        let [old, new] = [path.display().to_string(), relative(&path, folder)]
            .map(|path| format!("{before}{path}"));
        all.iter_mut().filter(|word| **word == old).for_each(|word| word.clone_from(&new));
    }
    all
}

/// The scene files in a folder, or, if there are none, its models, sorted by name.
fn within(folder: &Path) -> Result<Vec<String>> {
    let wrong = |problem: &str| Error::new("SCENE", format!("{} {problem}", folder.display()));
    let read = fs::read_dir(folder).map_err(|_| wrong("is not there: give the scenes"))?;
    let named = |path: &PathBuf| path.file_name().is_some_and(|name| name != MANIFEST);
    let files = read.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_file());
    let mut files: Vec<PathBuf> = files.filter(named).collect();
    files.sort();
    let of = |is_scene: bool| {
        let right = |path: &&PathBuf| match FileFormat::of(path) {
            Some(FileFormat::Toml) => is_scene,
            found => found.is_some() && !is_scene,
        };
        files.iter().filter(right).map(|path| path.display().to_string()).collect::<Vec<_>>()
    };
    match (of(true), of(false)) {
        (scenes, _) if !scenes.is_empty() => Ok(scenes),
        (_, models) if !models.is_empty() => Ok(models),
        _ => Err(wrong("has no scenes in it: give them")),
    }
}

/// A name for a scene: the file's without its ending, or the built-in scene's with its keys.
fn stem(look: &Look, scene: &str) -> String {
    let text = match Line::is_file(look, scene) {
        true => Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        false => scene.to_owned(),
    };
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_+@.".contains(c);
    let letters: String = text.chars().map(|c| if allowed(c) { c } else { '-' }).collect();
    letters.trim_matches(['-', '.']).to_owned()
}
