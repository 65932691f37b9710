//! `fragloom export`: a scene for other renderers, with what they should draw.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::cli::Verdict;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::settings::{Settings, complete};
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::png;
use crate::render::{Data, Options, render};
use crate::report::expected::{Expected, Files};
use crate::report::text::thousands;
use crate::report::{files, json, npz};
use crate::scene::export::{Exported, export};
use crate::scene::file::{self, Source};
use crate::scene::{self, Overrides, Scene, gltf};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh (.obj, .gltf, .glb, .ply, .stl, .zip), a scene file (.toml), a built-in scene (see `fragloom scenes`), or -
    /// for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// The scene as glTF. Beside it, with other endings: .toml, a scene file that draws it; .png, the exact picture;
    /// .npz, its fragments, as NumPy arrays; .json, hashes, the camera and tolerances [default: none; it must be given]
    #[arg(short = 'o', value_name = "FILE.glb", required = true)]
    to: PathBuf,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    output: Output,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    expected: &'a Expected,
    warnings: &'a [String],
}

/// Export the scene, draw both it and what was exported, and write everything.
///
/// # Errors
/// Wrong options or scene, what glTF cannot hold, or a file that cannot be written.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let Settings { overrides, options, warnings } = complete(&args.drawing, Method::EXACT, false)?;
    if options.data != Data::Color {
        return Err(Error::new(
            "--data",
            "must be color: that is what the fragments are compared by",
        ));
    }
    let paths = paths(&args.to)?;
    let outputs: Vec<(&str, &PathBuf)> = paths.iter().map(|path| ("-o", path)).collect();
    outputs.iter().try_for_each(|(option, path)| files::check_output(option, path))?;
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &overrides))?;
    files::check_apart(&outputs, &scene.files)?;
    let message = format!("drawing {}", scene.name);
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let [gltf, scene_file, picture, fragments, _] = [0, 1, 2, 3, 4].map(|i| name(&paths[i]));
    let exported = export(&scene, &gltf, options.sub_pixel_bits)?;
    let names = Files { gltf, scene: scene_file, picture, fragments };
    let (expected, drawn) = wait::during(quiet, &message, || {
        let drawn = render(&scene, &options)?;
        let again = render(&read_back(&exported)?, &options)?;
        Ok((Expected::of(&scene, (&exported, names), &options, &drawn, &again)?, drawn))
    })?;
    let [gltf, scene_file, picture, fragments, document] = &paths;
    let encoded = png::encode(&drawn.image);
    let encoded = encoded.map_err(|e| Error::new(picture.display().to_string(), e.to_string()))?;
    files::write_bytes(picture, &encoded)?;
    files::write(fragments, |file| {
        npz::write(file, drawn.lists().map_err(std::io::Error::other)?)
    })?;
    files::write_bytes(gltf, &exported.glb)?;
    files::write_bytes(scene_file, exported.scene.as_bytes())?;
    files::write_bytes(document, json::document(&expected)?.as_bytes())?;
    let warnings =
        [&warnings, &drawn.report.warnings, &exported.warnings].map(|list| &list[..]).concat();
    warnings.iter().for_each(|warning| say::warning(warning));
    say::result(&match args.output.json {
        true => json::document(&Document { expected: &expected, warnings: &warnings })?,
        false => table(&expected, &exported, &options),
    })?;
    Ok(Verdict::Clean)
}

/// The files, by their endings.
fn paths(to: &Path) -> Result<[PathBuf; 5]> {
    let is_glb = to.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("glb"));
    if !is_glb || to.file_stem().is_none() {
        return Err(Error::new("-o", format!("{} must end in .glb", to.display())));
    }
    let with = |ending| to.with_extension(ending);
    Ok([to.to_path_buf(), with("toml"), with("png"), with("npz"), with("json")])
}

/// The scene that the exported files are, without their being written.
fn read_back(exported: &Exported) -> Result<Scene> {
    let wrong = || Error::new("export", "the scene file names a file that was not exported");
    let description = file::parse(exported.scene.as_bytes(), "exported")?;
    let mut model = |source: Source<'_>| match source {
        Source::File(name) => gltf::parse(&exported.glb, name, &mut |_| Err(wrong())),
        _ => Err(wrong()),
    };
    description.build(&Overrides::default(), &mut model, &mut |_| Err(wrong()))
}

fn table(expected: &Expected, exported: &Exported, options: &Options) -> String {
    let Expected { size: [width, height], files, tolerances, .. } = expected;
    let pixels = |rows: &[[u32; 3]]| {
        thousands(rows.iter().map(|[_, first, past]| u64::from(past - first)).sum())
    };
    let back = match (expected.exact, exported.rounded) {
        (true, _) => "bit for bit the same".to_owned(),
        (false, 0) => "not the same: see the warnings".to_owned(),
        (false, rounded) => {
            format!("not the same: {} numbers are rounded to 32 bits", thousands(rounded))
        }
    };
    let Files { gltf, scene, picture, fragments } = files;
    format!(
        "{}: {width}x{height}, {} fragments, {} sub-pixel bits\n\n\
         written        {gltf}, {scene}, {picture}, {fragments}\n\
         read back      {back}\n\
         near an edge   {} pixels\n\
         nearly a tie   {} pixels\n\
         image_hash     {}\n",
        expected.scene,
        thousands(expected.generated),
        options.sub_pixel_bits,
        pixels(&tolerances.edges),
        pixels(&tolerances.ties),
        expected.image_hash,
    )
}
