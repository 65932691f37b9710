//! `fragloom golden`: pictures that must not change.

mod line;
mod merge;
mod record;
mod verify;
mod words;

use std::path::PathBuf;

pub use line::CommandLine;

use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::Output;
use crate::cli::terminal::say;
use crate::error::{Error, Result};
use crate::golden::{self, Report};
use crate::report::{files, json};

#[derive(Debug, clap::Args)]
#[command(arg_required_else_help = false, disable_help_subcommand = true)]
pub(in crate::cli) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Draw scenes; write their pictures, and what they were drawn from, into a manifest.
    Record(Box<record::Args>),
    /// Draw everything in a manifest again, and say what is not as recorded, and why.
    Verify(verify::Args),
    /// Join the reports of parts (verify --json), and say what no part has run.
    Merge(merge::Args),
}

/// Record, verify or merge.
///
/// # Errors
/// Wrong options, a manifest or scene that is wrong, or a file that cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    match &args.action {
        Action::Record(args) => record::run(catalogue, args),
        Action::Verify(args) => verify::run(catalogue, args),
        Action::Merge(args) => merge::run(args),
    }
}

/// Where a report goes.
#[derive(Clone, Debug, clap::Args)]
struct Told {
    /// Write the report in JUnit's XML as well, as CI services read it [default: not written]
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,

    #[command(flatten)]
    output: Output,
}

impl Told {
    /// Check that it can be written, before there is a report; it is none of `inputs`.
    fn check(&self, inputs: &[PathBuf]) -> Result<()> {
        let Some(path) = &self.junit else { return Ok(()) };
        files::check_output("--junit", path)?;
        files::check_apart(&[("--junit", path)], inputs)
    }

    /// Write and print it.
    fn tell(&self, report: &Report) -> Result<Verdict> {
        if let Some(path) = &self.junit {
            files::write_bytes(path, golden::junit(report)?.as_bytes())?;
        }
        say::result(&match self.output.json {
            true => json::document(report)?,
            false => golden::table(report),
        })?;
        let wrong = report.count(golden::Status::Error);
        match (wrong, report.is_clean()) {
            (0, true) => Ok(Verdict::Clean),
            (0, false) => Ok(Verdict::Found),
            _ => {
                let entries = if wrong == 1 { "entry" } else { "entries" };
                Err(Error::new(&report.manifest, format!("{wrong} {entries} cannot be drawn")))
            }
        }
    }
}

/// Pictures drawn at once.
#[derive(Clone, Copy, Debug, clap::Args)]
struct Jobs {
    /// Pictures drawn at once, 1 to 1024; 0 is one per core
    #[arg(short, long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    jobs: usize,
}

impl Jobs {
    fn checked(self) -> Result<usize> {
        match self.jobs {
            0..=1_024 => Ok(self.jobs),
            other => Err(Error::new("--jobs", format!("{other} at once: must be 0 to 1024"))),
        }
    }
}
