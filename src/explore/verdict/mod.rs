//! Verdicts: what a check found, with its bound.

mod beyond;
pub mod check;
pub mod claims;
pub mod endings;
pub mod expect;
mod laws;
pub mod matrix;
pub mod plan;
pub mod predict;
pub mod survey;

use serde::{Deserialize, Serialize};

use crate::explore::program::litmus::Litmus;

/// Three values, because a search that hit a bound has not verified anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Holds, within the stated bound.
    Verified,
    /// Random runs have found nothing. That verifies nothing.
    Sampled,
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
            Self::Sampled => "sampled",
            Self::Unknown => "unknown",
            Self::Violated => "violated",
        }
    }
}

/// What was varied for a verdict, and how far: its bound, as numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Scope {
    /// Which interleavings: `all` or `random`; empty where nothing was run.
    pub interleavings: &'static str,
    /// The most fragments of an instance.
    pub fragments: u32,
    /// The most pixels.
    pub pixels: u32,
    /// Every k.
    pub ks: Vec<u32>,
    /// Choices of values that every pattern was explored with, in all interleavings.
    pub values: u32,
    /// Further choices, in every order of arrival, one invocation after another.
    pub arrival_values: u32,
    /// Values that a word may have which no invocation wrote.
    pub initial: u32,
    /// Helper invocations, at most.
    pub helpers: u32,
    /// Random runs.
    pub random_runs: u64,
}

impl Scope {
    /// The scope of some instances that were explored in all interleavings.
    fn of<'a>(instances: impl Iterator<Item = &'a Litmus>) -> Self {
        let mut scope = Self { interleavings: "all", values: 1, initial: 3, ..Self::default() };
        let mut ks = std::collections::BTreeSet::new();
        for litmus in instances {
            scope.fragments = scope.fragments.max(litmus.fragments.len() as u32);
            scope.pixels = scope.pixels.max(litmus.pixels);
            scope.helpers = scope.helpers.max(litmus.helpers);
            ks.extend(litmus.k);
        }
        scope.ks = ks.into_iter().collect();
        scope
    }

    /// `, k in {1, 2}`, or nothing for a method without one.
    fn ks_told(&self) -> String {
        let ks: Vec<String> = self.ks.iter().map(ToString::to_string).collect();
        if ks.is_empty() { String::new() } else { format!(", k in {{{}}}", ks.join(", ")) }
    }

    /// Which values patterns were explored with.
    fn values_told(&self) -> String {
        match (self.values, self.arrival_values) {
            (0 | 1, 0) => String::new(),
            (values, 0) => format!(" with {values} choices of values"),
            (values, others) => {
                format!(
                    " with {values} choices of values, and {others} more in each order of arrival"
                )
            }
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
    /// The property that fails in a random run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<String>,
    /// The claim.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub claim: Option<String>,
    /// What was found.
    pub verdict: Verdict,
    /// Every interleaving within the bound was explored.
    pub exhaustive: bool,
    /// What was explored.
    pub bound: String,
    /// The same, as numbers.
    pub scope: Scope,
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
