//! Effects on a frame's lists: options as given, checked and completed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::flags::Data;
use crate::effect::csg::Expression;
use crate::error::{Error, Result};
use crate::render::{self, Effect, Focus, Marching, Occlusion, Options, Screen, Shadows};

/// Options about effects.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct Effects {
    /// What to make from the sorted lists: oit (surfaces composited over each other), media (absorption inside of
    /// closed objects, by thickness), csg=EXPRESSION over closed objects like csg='(a | b) - c' (~ - & ^ | from the
    /// tightest; names are those of the scene file, or a, b, c, ... in order), ldi (layered depth image: what is
    /// solid, by parity), ao or ao=RADIUS (ambient occlusion over all layers), dof (depth of field over all layers),
    /// or both, like ao=0.2+dof
    #[arg(long, value_name = "EFFECT", default_value = "oit")]
    pub(in crate::cli) effect: String,

    /// With `--effect media`, multiply absorption by N, 0 or more; with 1, colour and opacity describe what one world
    /// unit of a material does to light [default: 1]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) density: Option<f64>,

    /// With `--effect csg`, write the surfaces of the combination, front to back, as NumPy arrays like those of
    /// `--fragments` [default: not written]
    #[arg(long, value_name = "FILE.npz")]
    pub(in crate::cli) surfaces: Option<PathBuf>,

    /// With `--effect ldi`, write offsets and depths of every pixel, and the voxels, as NumPy arrays
    /// [default: not written]
    #[arg(long, value_name = "FILE.npz")]
    pub(in crate::cli) ldi: Option<PathBuf>,

    /// With `--effect ldi`, cut the image into N slices of voxels, from the near to the far plane, 1 to 16384
    /// [default: none]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) voxels: Option<u32>,

    /// With `--effect ao`, directions that are searched from each layer, 1 to 64 [default: 8]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) ao_directions: Option<u32>,

    /// With `--effect ao`, steps in each direction, 1 to 256 [default: 8]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) ao_steps: Option<u32>,

    /// With `--effect ao`, seed of the directions' turns, 64 bits [default: 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) ao_seed: Option<u64>,

    /// With `--effect dof`, the diameter of the lens in world units, 0 or more [default: a fortieth of the distance in
    /// focus]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(in crate::cli) aperture: Option<f64>,

    /// With `--effect dof`, the distance in focus from the eye's plane, in world units, above 0 [default: that of the
    /// camera's target]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(in crate::cli) focus: Option<f64>,

    /// With `--effect dof`, rays through the lens for each pixel, 1 to 4096 [default: 64]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) dof_samples: Option<u32>,

    /// How samples of volumes meet surfaces: on, by smooth fragment merging, or off, one in front of the other
    #[arg(long, value_enum, value_name = "MERGE", default_value = "on")]
    pub(in crate::cli) volume_merge: Merge,

    /// The share of light, 0 to 1, below which rays through volumes end [default: 0.00000762939453125, 2^-17]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub(in crate::cli) volume_until: Option<f64>,

    /// World units between samples of volumes, above 0 [default: each volume's own]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(in crate::cli) volume_step: Option<f64>,

    /// Draw a second frame with the same method from the light, whose lists cast translucent, coloured shadows
    #[arg(long)]
    pub(in crate::cli) shadows: bool,

    /// With `--shadows`, the edge of the frame from the light in pixels, 1 to 16384 [default: the image's longer edge]
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true)]
    pub(in crate::cli) shadow_size: Option<u32>,

    /// With `--shadows`, how much nearer to the light a surface must be to cast a shadow, in world units, 0 or more
    /// [default: twice the width of a pixel of the frame from the light]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(in crate::cli) shadow_bias: Option<f64>,
}

/// `--volume-merge`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Merge {
    On,
    Off,
}

impl Effects {
    /// Complete a run's options; `data` is the value given for it.
    ///
    /// # Errors
    /// An effect of another form, or an option that belongs to another effect.
    pub(in crate::cli) fn complete(&self, data: Option<Data>, options: &mut Options) -> Result<()> {
        options.effect = self.effect()?;
        let goes_with = [
            ("--density", self.density.is_some(), "media"),
            ("--surfaces", self.surfaces.is_some(), "csg"),
            ("--ldi", self.ldi.is_some(), "ldi"),
            ("--voxels", self.voxels.is_some(), "ldi"),
        ];
        let takes = |part: &str| match options.effect {
            Effect::Screen(Screen { occlusion, focus }) => {
                (part == "ao" && occlusion.is_some()) || (part == "dof" && focus.is_some())
            }
            _ => false,
        };
        for (option, given, part) in [
            ("--ao-directions", self.ao_directions.is_some(), "ao"),
            ("--ao-steps", self.ao_steps.is_some(), "ao"),
            ("--ao-seed", self.ao_seed.is_some(), "ao"),
            ("--aperture", self.aperture.is_some(), "dof"),
            ("--focus", self.focus.is_some(), "dof"),
            ("--dof-samples", self.dof_samples.is_some(), "dof"),
        ] {
            if given && !takes(part) {
                return Err(Error::new(option, format!("needs --effect {part}")));
            }
        }
        for (option, given, effect) in goes_with {
            if given && options.effect.name() != effect {
                return Err(Error::new(option, format!("needs --effect {effect}")));
            }
        }
        for (option, given) in [
            ("--shadow-size", self.shadow_size.is_some()),
            ("--shadow-bias", self.shadow_bias.is_some()),
        ] {
            if given && !self.shadows {
                return Err(Error::new(option, "needs --shadows"));
            }
        }
        if data.is_none() && options.effect.needs_primitives() {
            options.data = render::Data::Primitive;
        }
        let default = Marching::default();
        options.volumes = Marching {
            merge: self.volume_merge == Merge::On,
            until: self.volume_until.unwrap_or(default.until),
            step: self.volume_step,
        };
        let (size, bias) = (self.shadow_size, self.shadow_bias);
        options.shadows = self.shadows.then_some(Shadows { size, bias });
        Ok(())
    }

    fn effect(&self) -> Result<Effect> {
        match self.effect.split_once('=') {
            None if self.effect == "oit" => Ok(Effect::Transparency),
            None if self.effect == "media" => {
                Ok(Effect::Media { density: self.density.unwrap_or(1.0) })
            }
            None if self.effect == "ldi" => Ok(Effect::Ldi { voxels: self.voxels }),
            Some(("csg", expression)) => Ok(Effect::Csg(Expression::parse(expression)?)),
            _ => self.screen().map(Effect::Screen).ok_or_else(|| {
                let right = "must be oit, media, ldi, ao, ao=RADIUS, dof, ao+dof or csg=EXPRESSION, like \
                             csg='(a | b) - c'";
                Error::new("--effect", format!("{:?} {right}", self.effect))
            }),
        }
    }

    /// `ao`, `dof` or both.
    fn screen(&self) -> Option<Screen> {
        let (ao, dof) = match self.effect.strip_suffix("dof") {
            Some("") => (None, true),
            Some(ao) => (Some(ao.strip_suffix('+')?), true),
            None => (Some(self.effect.as_str()), false),
        };
        let radius = match ao {
            None | Some("ao") => None,
            Some(text) => Some(text.strip_prefix("ao=")?.parse().ok()?),
        };
        let default = Occlusion::default();
        let occlusion = ao.map(|_| Occlusion {
            radius,
            directions: self.ao_directions.unwrap_or(default.directions),
            steps: self.ao_steps.unwrap_or(default.steps),
            seed: self.ao_seed.unwrap_or(default.seed),
        });
        let samples = self.dof_samples.unwrap_or(Focus::default().samples);
        let (aperture, distance) = (self.aperture, self.focus);
        let focus = dof.then_some(Focus { aperture, distance, samples });
        Some(Screen { occlusion, focus })
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        effects: Effects,
    }

    fn resolved(words: &[&str], data: Option<Data>) -> Result<Options> {
        let line = std::iter::once(&"test").chain(words);
        let mut options = Options::default();
        Line::try_parse_from(line).unwrap().effects.complete(data, &mut options)?;
        Ok(options)
    }

    #[test]
    fn effects_and_what_they_imply() {
        let options = resolved(&[], None).unwrap();
        assert_eq!((options.effect, options.shadows), (Effect::Transparency, None));
        let media = resolved(&["--effect", "media", "--density", "2.5"], None).unwrap();
        assert_eq!(media.effect, Effect::Media { density: 2.5 });
        assert_eq!(media.data, render::Data::Primitive);
        let csg = resolved(&["--effect", "csg=a-b"], None).unwrap();
        assert_eq!(csg.effect.name(), "csg");
        let typed = resolved(&["--effect", "csg=a"], Some(Data::Color)).unwrap();
        assert_eq!(typed.data, render::Data::Color, "a given value is not changed, but refused");
        let ldi = resolved(&["--effect", "ldi", "--voxels", "8"], None).unwrap();
        assert_eq!((ldi.effect, ldi.data), (Effect::Ldi { voxels: Some(8) }, Default::default()));
        for (text, radius, name) in [
            ("ao", None, "ao"),
            ("ao=0.25", Some(0.25), "ao"),
            ("ao+dof", None, "ao+dof"),
            ("ao=1e-3+dof", Some(1e-3), "ao+dof"),
            ("dof", None, "dof"),
        ] {
            let effect = resolved(&["--effect", text], None).unwrap().effect;
            let Effect::Screen(screen) = effect else { panic!("{text}") };
            assert_eq!(screen.name(), name);
            assert_eq!(screen.occlusion.and_then(|ao| ao.radius), radius, "{text}");
        }
        let volumes = resolved(&["--volume-merge", "off", "--volume-step", "0.5"], None).unwrap();
        let expected = Marching { merge: false, step: Some(0.5), ..Marching::default() };
        assert_eq!(volumes.volumes, expected);
        let shadows = resolved(&["--shadows", "--shadow-size", "64"], None).unwrap().shadows;
        assert_eq!(shadows, Some(Shadows { size: Some(64), bias: None }));
    }

    #[test]
    fn wrong_values_name_their_option() {
        for (words, place) in [
            (&["--effect", "fog"][..], "--effect"),
            (&["--effect", "csg"], "--effect"),
            (&["--effect", "csg="], "--effect"),
            (&["--effect", "media=2"], "--effect"),
            (&["--effect", "ao="], "--effect"),
            (&["--effect", "aodof"], "--effect"),
            (&["--effect", "dof+ao"], "--effect"),
            (&["--effect", "dof", "--ao-steps", "2"], "--ao-steps"),
            (&["--effect", "ao", "--aperture", "2"], "--aperture"),
            (&["--focus", "2"], "--focus"),
            (&["--density", "2"], "--density"),
            (&["--surfaces", "x.npz"], "--surfaces"),
            (&["--effect", "media", "--ldi", "x.npz"], "--ldi"),
            (&["--voxels", "4"], "--voxels"),
            (&["--shadow-size", "4"], "--shadow-size"),
            (&["--shadow-bias", "4"], "--shadow-bias"),
        ] {
            assert_eq!(resolved(words, None).unwrap_err().place(), place, "{words:?}");
        }
    }
}
