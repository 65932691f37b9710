//! `fragloom golden merge`: parts into a whole.

use std::path::PathBuf;

use super::Told;
use crate::cli::Verdict;
use crate::error::Result;
use crate::golden;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Reports that verify --json has printed, of parts of one manifest
    #[arg(value_name = "REPORT", required = true)]
    reports: Vec<PathBuf>,

    #[command(flatten)]
    told: Told,
}

/// Join the reports, and print what is not as recorded, or was not run.
///
/// # Errors
/// A file that is no report, reports of different manifests, or a file that cannot be written.
pub(super) fn run(args: &Args) -> Result<Verdict> {
    args.told.check(&args.reports)?;
    let named = args.reports.iter();
    let parts = named.map(|path| Ok((path.display().to_string(), golden::read(path)?)));
    let whole = golden::merge(&parts.collect::<Result<Vec<_>>>()?)?;
    args.told.tell(&whole)
}
