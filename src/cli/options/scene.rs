//! What is said of the scene's file and of the camera.

use clap::{Args, ValueEnum};

use crate::error::{Error, Result};
use crate::scene::{FileFormat, Parallel, Side, Viewpoint};

/// As typed.
#[derive(Clone, Debug, Default, Args)]
#[group(id = "scene_and_camera")]
pub(in crate::cli) struct Typed {
    /// What SCENE is, whatever its name ends in; needed where it comes in on stdin, as SCENE - [default: by the ending]
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,

    /// Where the camera is, in world units [default: the scene's, else where all is seen from the upper right]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "view")]
    eye: Option<String>,

    /// The point in the middle of the picture, in world units [default: the scene's, else the middle of all]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "view")]
    target: Option<String>,

    /// Which way is up: x, y, z, -x, -y, -z, or a vector X,Y,Z. No format's own axis is guessed [default: the scene's,
    /// else y]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    up: Option<String>,

    /// Show all of the scene from one side; its front is at positive z, or with --up z at negative y [default: the
    /// scene's camera, else from the upper right]
    #[arg(long, value_enum, value_name = "SIDE")]
    view: Option<View>,

    /// Vertical field of view in degrees, above 0 and below 180 [default: the scene's, else 40]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, conflicts_with = "ortho")]
    fov: Option<f64>,

    /// Parallel rays, with a visible box of this height in world units [default: a perspective; without HEIGHT, as much
    /// as the perspective shows at the target]
    #[arg(long, value_name = "HEIGHT", num_args = 0..=1, allow_negative_numbers = true)]
    #[allow(clippy::option_option, reason = "clap's type of an option with an optional value")]
    ortho: Option<Option<f64>>,

    /// Distance of the near plane in world units [default: the scene's, else close in front of all]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    near: Option<f64>,

    /// Distance of the far plane in world units [default: the scene's, else close behind all]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    far: Option<f64>,

    /// A camera of a glTF file, by its name, its node's name or its number from 0 [default: none of them]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["view", "eye"])]
    camera: Option<String>,
}

/// `--format`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Obj,
    Gltf,
    Glb,
    Ply,
    Stl,
    Pcd,
    Zip,
    Toml,
}

/// `--view`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum View {
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
    Iso,
}

impl Typed {
    /// `--format`.
    pub(in crate::cli) fn format(&self) -> Option<FileFormat> {
        self.format.map(|format| match format {
            Format::Obj => FileFormat::Obj,
            Format::Gltf | Format::Glb => FileFormat::Gltf,
            Format::Ply => FileFormat::Ply,
            Format::Stl => FileFormat::Stl,
            Format::Pcd => FileFormat::Pcd,
            Format::Zip => FileFormat::Zip,
            Format::Toml => FileFormat::Toml,
        })
    }

    /// What is said of the camera.
    ///
    /// # Errors
    /// The option that is wrong, and what would be right.
    pub(in crate::cli) fn viewpoint(&self) -> Result<Viewpoint> {
        let place = |option, text: &Option<String>| {
            text.as_deref().map(|text| vector(option, text)).transpose()
        };
        for (option, value) in [("--near", self.near), ("--far", self.far), ("--fov", self.fov)] {
            if value.is_some_and(|value| !value.is_finite()) {
                return Err(Error::new(option, "must be a finite number"));
            }
        }
        Ok(Viewpoint {
            eye: place("--eye", &self.eye)?,
            target: place("--target", &self.target)?,
            up: self.up.as_deref().map(up).transpose()?,
            side: self.view.map(Side::from),
            fov_y: self.fov,
            parallel: self.ortho.map(|height| height.map_or(Parallel::Fitting, Parallel::Height)),
            near: self.near,
            far: self.far,
            camera: self.camera.clone(),
        })
    }
}

/// Three finite numbers.
fn vector(option: &str, text: &str) -> Result<[f64; 3]> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    let numbers: Option<[f64; 3]> = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.filter(|numbers| numbers.iter().all(|n| n.is_finite())).ok_or_else(|| {
        Error::new(option, format!("{text:?} must be three finite numbers, like 0,1.5,4"))
    })
}

fn up(text: &str) -> Result<[f64; 3]> {
    let (sign, axis) = match text.strip_prefix('-') {
        Some(axis) => (-1.0, axis),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let unit = match axis.to_ascii_lowercase().as_str() {
        "x" => [sign, 0.0, 0.0],
        "y" => [0.0, sign, 0.0],
        "z" => [0.0, 0.0, sign],
        _ => {
            let wrong = |_| {
                let problem = "must be x, y, z, -x, -y, -z or a vector like 0,0,1";
                Error::new("--up", format!("{text:?} {problem}"))
            };
            return vector("--up", text).map_err(wrong).and_then(|up| match up {
                [0.0, 0.0, 0.0] => Err(Error::new("--up", "must not be zero")),
                up => Ok(up),
            });
        }
    };
    Ok(unit)
}

impl From<View> for Side {
    fn from(typed: View) -> Self {
        match typed {
            View::Front => Self::Front,
            View::Back => Self::Back,
            View::Left => Self::Left,
            View::Right => Self::Right,
            View::Top => Self::Top,
            View::Bottom => Self::Bottom,
            View::Iso => Self::Iso,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        typed: Typed,
    }

    fn viewpoint(line: &str) -> Result<Viewpoint> {
        let words = std::iter::once("test").chain(line.split_whitespace());
        Line::try_parse_from(words).unwrap().typed.viewpoint()
    }

    #[test]
    fn cameras_are_read() {
        assert_eq!(viewpoint("").unwrap(), Viewpoint::default());
        let found = viewpoint("--eye -1,2.5,3e1 --up -z --ortho 2 --near 0.5").unwrap();
        assert_eq!(found.eye, Some([-1.0, 2.5, 30.0]));
        assert_eq!((found.up, found.near), (Some([0.0, 0.0, -1.0]), Some(0.5)));
        assert_eq!(found.parallel, Some(Parallel::Height(2.0)));
        let found = viewpoint("--ortho --view top --up 0,1,1").unwrap();
        assert_eq!((found.parallel, found.side), (Some(Parallel::Fitting), Some(Side::Top)));
        assert_eq!(found.up, Some([0.0, 1.0, 1.0]));
    }

    #[test]
    fn wrong_values_name_their_option() {
        for (line, option) in [
            ("--eye 1,2", "--eye"),
            ("--target 1,2,x", "--target"),
            ("--up w", "--up"),
            ("--up 0,0,0", "--up"),
            ("--eye 1,2,inf", "--eye"),
            ("--fov NaN", "--fov"),
        ] {
            assert_eq!(viewpoint(line).unwrap_err().place(), option, "{line}");
        }
        for line in ["--eye 1,2,3 --view top", "--fov 3 --ortho", "--camera a --view top"] {
            let words = std::iter::once("test").chain(line.split_whitespace());
            assert!(Line::try_parse_from(words).is_err(), "{line}");
        }
    }
}
