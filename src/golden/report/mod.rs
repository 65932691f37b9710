//! What was found of a manifest's entries: for people, for programs, and in parts.

mod junit;
mod merge;
mod page;
mod table;

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

pub use self::junit::junit;
pub use self::merge::merge;
pub use self::page::{Shown, page};
pub use self::table::table;
use super::PROGRAM;
use super::manifest::{Entry, Manifest};
use super::outcome::{Outcome, Status};
use crate::error::{Error, Result};

/// The format of reports.
const FORMAT: u32 = 1;

/// What was found: the document of `golden verify --json` and `golden merge --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Of this document: 1.
    pub format: u32,
    /// The version of the program that drew.
    pub program: String,
    /// The manifest, as it was given.
    pub manifest: String,
    /// SHA-256 of the manifest before anything was blessed, hexadecimal.
    pub manifest_sha256: String,
    /// The names of all its entries.
    pub entries: Vec<String>,
    /// `--filter`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter: Option<String>,
    /// The part, as `hash:I/N`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub partition: Option<String>,
    /// What was found of each, in the manifest's order.
    pub outcomes: Vec<Outcome>,
    /// The names of the entries that were to be verified, and of which nothing was found: it was interrupted, or, of
    /// merged reports, no part has run them.
    pub not_run: Vec<String>,
}

impl Report {
    /// Of a manifest, before anything is found of the entries that are `chosen`.
    pub(super) fn new(manifest: &Manifest, chosen: &[&Entry]) -> Self {
        let names = |entries: &mut dyn Iterator<Item = &Entry>| {
            entries.map(|entry| entry.name.clone()).collect()
        };
        Self {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            manifest: manifest.path().display().to_string(),
            manifest_sha256: manifest.sha256(),
            entries: names(&mut manifest.entries().iter()),
            filter: None,
            partition: None,
            outcomes: Vec::new(),
            not_run: names(&mut chosen.iter().copied()),
        }
    }

    /// Add what was found of an entry.
    pub(super) fn add(&mut self, outcome: Outcome) {
        self.not_run.retain(|name| *name != outcome.name);
        self.outcomes.push(outcome);
    }

    /// How many outcomes have this status.
    #[must_use]
    pub fn count(&self, status: Status) -> usize {
        self.outcomes.iter().filter(|outcome| outcome.status == status).count()
    }

    /// Whether all were run, and nothing is left to do.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.not_run.is_empty() && self.outcomes.iter().all(|outcome| outcome.status.is_clean())
    }
}

/// Read a report that `--json` printed.
///
/// # Errors
/// No such file, or no report of this format.
pub fn read(path: &Path) -> Result<Report> {
    let wrong = |problem: String| Error::new(path.display().to_string(), problem);
    let text =
        fs::read_to_string(path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let report: Report = serde_json::from_str(&text)
        .map_err(|error| wrong(format!("must be a report of golden verify --json ({error})")))?;
    match report.format {
        FORMAT => Ok(report),
        other => Err(wrong(format!("format: {other} is not known; this program reads {FORMAT}"))),
    }
}
