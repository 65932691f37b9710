//! `render -o`: the picture as a file.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::terminal::say;
use crate::error::{Error, Result};
use crate::render::{Options, Rendering};
use crate::report::files;
use crate::report::picture::{Drawn, Format};

/// Options about the picture.
#[derive(Clone, Debug, Args)]
pub(super) struct Picture {
    /// Write the picture: FILE.png (sRGB with opacity), FILE.ppm (sRGB, 8 bits), FILE.pfm or FILE.exr (linear, 32-bit
    /// floating point); - is stdout, as PNG and without any table [default: not written]
    #[arg(short = 'o', value_name = "FILE")]
    pub(super) image: Option<PathBuf>,

    /// Bits per channel of a PNG picture, 8 or 16 [default: 8]
    #[arg(long, value_name = "BITS", allow_negative_numbers = true)]
    bits: Option<u32>,

    /// Leave the background out: the picture keeps its opacity, 1 less the transmittance. Colours are not multiplied by
    /// opacity in PNG, as that format asks, and are in OpenEXR
    #[arg(long)]
    transparent: bool,
}

impl Picture {
    /// Check the options, and ask the run for what the picture's format needs.
    ///
    /// # Errors
    /// An ending that is no format's, or an option that does not fit the format.
    pub(super) fn complete(&self, options: &mut Options) -> Result<()> {
        options.transparent = self.transparent;
        let Some(path) = &self.image else {
            let needs = |_| Err(Error::new("--bits", "needs -o, a picture to write"));
            return self.bits.map_or(Ok(()), needs);
        };
        let format = Format::of("-o", path, self.bits)?;
        if self.transparent && !format.has_opacity() {
            let problem = format!("{} cannot hold opacity: write .png or .exr", path.display());
            return Err(Error::new("--transparent", problem));
        }
        options.linear = format.is_linear();
        Ok(())
    }

    /// Refuse to compare a picture that has no background.
    ///
    /// # Errors
    /// `--transparent` was given.
    pub(super) fn check_comparable(&self) -> Result<()> {
        if self.transparent {
            let problem = "compares colours before the background, which --transparent leaves out";
            return Err(Error::new("--reference", problem));
        }
        Ok(())
    }

    /// The picture goes to stdout, which then has nothing else.
    pub(super) fn is_stdout(&self) -> bool {
        self.image.as_deref() == Some(Path::new("-"))
    }

    /// Write a frame's picture to `path`, which is where `-o` says, or numbered.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(&self, rendering: &Rendering, path: &Path) -> Result<()> {
        let drawn = Drawn { image: &rendering.image, linear: rendering.linear.as_ref() };
        let bytes = Format::of("-o", path, self.bits)?.encode(drawn, path)?;
        if self.is_stdout() { say::bytes(&bytes) } else { files::write_bytes(path, &bytes) }
    }
}
