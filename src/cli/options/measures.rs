//! How far pictures are from a reference, and how that is printed.

use clap::{Args, ValueEnum};

use super::flags::Output;
use crate::error::{Error, Result};
use crate::image::metrics::THRESHOLD;
use crate::report::grid::Syntax;

/// Options of every command that measures errors.
#[derive(Clone, Copy, Debug, Args)]
pub(in crate::cli) struct Measures {
    /// Count the pixels with a channel that differs by more than this, 0 to 255 sRGB steps
    #[arg(long, value_name = "STEPS", default_value_t = THRESHOLD, allow_negative_numbers = true)]
    pub(in crate::cli) threshold: u8,

    /// Print the table of errors alone, in this format [default: all tables, for people]
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(in crate::cli) metrics: Option<Format>,
}

/// `--metrics`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Format {
    Csv,
    Json,
    Latex,
}

/// What is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum Printed {
    /// All tables.
    Tables,
    /// `--json`: everything.
    Document,
    /// The errors as a table.
    Errors(Syntax),
    /// The errors as JSON.
    ErrorDocument,
}

impl Measures {
    /// What these options and `--json` ask for.
    ///
    /// # Errors
    /// Both.
    pub(in crate::cli) fn printed(&self, output: &Output) -> Result<Printed> {
        match (self.metrics, output.json) {
            (Some(_), true) => {
                Err(Error::new("--metrics", "--json prints the errors too: give one of them"))
            }
            (Some(Format::Csv), _) => Ok(Printed::Errors(Syntax::Csv)),
            (Some(Format::Latex), _) => Ok(Printed::Errors(Syntax::Latex)),
            (Some(Format::Json), _) => Ok(Printed::ErrorDocument),
            (None, true) => Ok(Printed::Document),
            (None, false) => Ok(Printed::Tables),
        }
    }
}
