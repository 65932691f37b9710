//! Effects on a frame's lists: options as given, checked and completed.

use std::path::PathBuf;

use clap::Args;

use super::flags::Data;
use crate::effect::csg::Expression;
use crate::error::{Error, Result};
use crate::render::{self, Effect, Options, Shadows};

/// Options about effects.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct Effects {
    /// What to make from the sorted lists: oit (surfaces composited over each other), media (absorption inside of
    /// closed objects, by thickness), csg=EXPRESSION over closed objects like csg='(a | b) - c' (~ - & ^ | from the
    /// tightest; names are those of the scene file, or a, b, c, ... in order), or ldi (layered depth image: what is
    /// solid, by parity)
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
            _ => {
                let right = "must be oit, media, ldi or csg=EXPRESSION, like csg='(a | b) - c'";
                Err(Error::new("--effect", format!("{:?} {right}", self.effect)))
            }
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
