//! Verdicts: what a check found, with its bound.

pub mod check;
pub mod claims;
pub mod expect;
pub mod matrix;
pub mod plan;
pub(super) mod sites;

use serde::{Deserialize, Serialize};

/// Three values, because a search that hit a bound has not verified anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Holds, within the stated bound.
    Verified,
    /// A bound was hit, or something was never reached.
    Unknown,
    /// Fails; there is a token.
    Violated,
}

impl Verdict {
    /// The word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Verified => "verified",
            Self::Unknown => "unknown",
            Self::Violated => "violated",
        }
    }
}

/// One row of a check's report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The method.
    pub method: String,
    /// The property, unless a claim is checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub property: Option<String>,
    /// The claim.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub claim: Option<String>,
    /// What was found.
    pub verdict: Verdict,
    /// Every interleaving within the bound was explored.
    pub exhaustive: bool,
    /// What was explored.
    pub bound: String,
    /// `sc` or `relaxed`.
    pub memory: String,
    /// The shading language's profile, under `relaxed`.
    pub profile: Option<String>,
    /// The progress model, for termination.
    pub progress: Option<String>,
    /// The smallest instance that fails, or how many were explored.
    pub instance: String,
    /// What memory holds before the clear pass.
    pub initial: String,
    /// Complete interleavings; `None` if there are cycles or too many to count.
    pub executions: Option<u64>,
    /// Distinct states.
    pub states: u64,
    /// The schedule that fails.
    pub token: Option<String>,
    /// Its steps.
    pub steps: Option<u64>,
    /// What is wrong, or why the verdict is not stronger.
    pub message: String,
    /// All results of the failing instance, where they differ: per pixel, depth/data.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outcomes: Vec<String>,
}
