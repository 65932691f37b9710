//! `fragloom info`: what is in a scene.

use crate::cli::Verdict;
use crate::cli::options::flags::{Output, Shading};
use crate::cli::options::scene::Typed;
use crate::cli::options::values;
use crate::cli::terminal::{say, wait};
use crate::error::Result;
use crate::report::contents::{Contents, description};
use crate::report::json;
use crate::scene::{self, Overrides, PointSize};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh or point set (.obj, .gltf, .glb, .ply, .stl, .pcd, .zip), a scene file (.toml), a built-in scene (see
    /// `fragloom scenes`), or - for stdin, with --format
    #[arg(value_name = "SCENE")]
    scene: String,

    /// Image size in pixels, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long, value_name = "WxH")]
    size: Option<String>,

    /// Opacity of every material, 0 to 1 [default: the scene's, else 0.5]
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    alpha: Option<f32>,

    /// Shading of every material [default: the scene's, else lambert]
    #[arg(long, value_enum, value_name = "SHADING")]
    shading: Option<Shading>,

    /// Radius of every point of point sets, in units of their file [default: the points' own, else estimated]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    point_radius: Option<f32>,

    /// Multiplies the radii that points have or get by estimation [default: 1]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    point_scale: Option<f32>,

    #[command(flatten)]
    camera: Typed,

    #[command(flatten)]
    output: Output,
}

/// Load the scene, and print what is in it.
///
/// # Errors
/// Wrong options or scene.
pub(in crate::cli) fn run(args: &Args) -> Result<Verdict> {
    let overrides = Overrides {
        size: args.size.as_deref().map(values::size).transpose()?,
        alpha: args.alpha,
        shading: args.shading.map(scene::Shading::from),
        points: PointSize { radius: args.point_radius, scale: args.point_scale },
        viewpoint: args.camera.viewpoint()?,
        format: args.camera.format(),
    };
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &overrides))?;
    let message = format!("looking through {}", scene.name);
    let contents = wait::during(quiet, &message, || Contents::of(&scene));
    say::result(&if args.output.json {
        json::document(&contents)?
    } else {
        description::description(&contents)
    })?;
    Ok(Verdict::Clean)
}
