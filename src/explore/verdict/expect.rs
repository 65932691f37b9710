//! Expected verdicts, for other people's continuous integration: a file lists the expected verdicts, and everything
//! else that is violated is a surprise.
//!
//! ```toml
//! [[expect]]
//! method = "kb"
//! property = "keeps"       # or: claim = "C4"
//! memory = "sc"            # left out: any
//! verdict = "violated"
//! ```

use serde::Deserialize;

use super::{Finding, Verdict};
use crate::error::{Error, Result};

/// One expectation. Fields that are left out match anything.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    method: Option<String>,
    property: Option<String>,
    claim: Option<String>,
    memory: Option<String>,
    profile: Option<String>,
    progress: Option<String>,
    verdict: Verdict,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    expect: Vec<Expectation>,
}

/// Read expectations; `place` is the file, for messages.
///
/// # Errors
/// Not TOML of that form, or no expectation at all.
pub fn parse(place: &str, text: &str) -> Result<Vec<Expectation>> {
    let file: File = toml::from_str(text).map_err(|error| {
        let message = error.message().to_owned();
        let line = error.span().map(|span| text[..span.start].lines().count().max(1));
        let line = line.map(|line| format!("line {line}: ")).unwrap_or_default();
        Error::new(place, format!("{line}{message}"))
    })?;
    if file.expect.is_empty() {
        return Err(Error::new(
            place,
            "expect: there is no expectation; give at least one [[expect]]",
        ));
    }
    Ok(file.expect)
}

impl Expectation {
    fn matches(&self, row: &Finding) -> bool {
        let same = |wanted: &Option<String>, found: Option<&str>| {
            wanted.as_deref().is_none_or(|wanted| Some(wanted) == found)
        };
        // It may also be a random run that shows the expected violation.
        let found = self.verdict == Verdict::Violated && row.found.is_some();
        same(&self.method, Some(&row.method))
            && (same(&self.property, row.property.as_deref())
                || (found && self.property == row.found))
            && same(&self.claim, row.claim.as_deref())
            && same(&self.memory, Some(&row.memory))
            && same(&self.profile, row.profile.as_deref())
            && same(&self.progress, row.progress.as_deref())
    }

    /// Whether a row is as expected. Random runs verify nothing: where they are not meant by name, it is enough that
    /// they find nothing.
    fn is_met(&self, row: &Finding) -> bool {
        let meant = self.property.is_some() || self.verdict != Verdict::Verified;
        self.verdict == row.verdict || (row.verdict == Verdict::Sampled && !meant)
    }

    fn describe(&self) -> String {
        let fields = [
            &self.method,
            &self.property,
            &self.claim,
            &self.memory,
            &self.profile,
            &self.progress,
        ];
        fields.into_iter().flatten().cloned().collect::<Vec<_>>().join(" ")
    }
}

/// What is not as expected: rows whose verdict differs from an expectation that matches them, expectations that match
/// nothing, and unexpected violations. The first expectation that matches a row counts.
#[must_use]
pub fn surprises(expected: &[Expectation], rows: &[Finding]) -> Vec<String> {
    let mut found = Vec::new();
    for row in rows {
        let what = row.property.iter().chain(&row.claim).cloned().collect::<Vec<_>>().join(" ");
        let under = [Some(row.memory.as_str()), row.profile.as_deref(), row.progress.as_deref()];
        let under: Vec<&str> = under.into_iter().flatten().collect();
        let place = format!("{} {what} ({})", row.method, under.join(", "));
        match expected.iter().find(|e| e.matches(row)) {
            Some(e) if !e.is_met(row) => {
                let (is, wanted) = (row.verdict.name(), e.verdict.name());
                found.push(format!("{place} is {is}, but {wanted} was expected"));
            }
            None if row.verdict == Verdict::Violated => {
                found.push(format!("{place} is violated, and nothing was expected of it"));
            }
            _ => {}
        }
    }
    for e in expected.iter().filter(|e| !rows.iter().any(|row| e.matches(row))) {
        found.push(format!("nothing was checked that fits the expectation '{}'", e.describe()));
    }
    found
}
