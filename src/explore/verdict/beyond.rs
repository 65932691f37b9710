//! What random runs say of a method beyond the bound of its instances.

use super::{Finding, Scope, Verdict};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::guard::guarded;
use crate::explore::program::subject::Subject;
use crate::explore::replay::minimise;
use crate::explore::replay::token::Token;
use crate::explore::search::explored::Limits;
use crate::explore::search::random::{MOST_FRAGMENTS, MOST_K, MOST_PIXELS, Sampled};

/// The row of random runs.
pub(super) const NAME: &str = "random-runs";

/// Random runs of a method, as a row: *sampled*, or violated with the smallest failure.
pub(super) fn row(subject: &Subject, seed: u64, sampled: &Sampled, limits: &Limits<'_>) -> Finding {
    let contract = subject.contract;
    let k = match contract.default_k {
        Some(_) => format!(", k up to {}", contract.max_k.min(MOST_K)),
        None => String::new(),
    };
    let mut row = Finding {
        method: contract.name.to_owned(),
        property: Some(NAME.to_owned()),
        found: None,
        claim: None,
        verdict: Verdict::Sampled,
        exhaustive: false,
        bound: format!(
            "{} random runs of random instances: up to {MOST_FRAGMENTS} fragments, up to {MOST_PIXELS} pixels{k}, \
             sequentially consistent, seeds from {seed}",
            sampled.ended
        ),
        scope: Scope {
            interleavings: "random",
            fragments: MOST_FRAGMENTS,
            pixels: MOST_PIXELS,
            ks: contract.default_k.map(|_| contract.max_k.min(MOST_K)).into_iter().collect(),
            initial: 3,
            random_runs: sampled.ended,
            ..Scope::default()
        },
        memory: MemoryModel::Sequential.name().to_owned(),
        profile: None,
        progress: None,
        instance: format!("{} runs", sampled.ended),
        initial: "arbitrary but for the clear pass".to_owned(),
        executions: Some(sampled.ended),
        states: 0,
        token: None,
        steps: None,
        message: String::new(),
        outcomes: Vec::new(),
    };
    if let Some(failing) = &sampled.failure {
        row.verdict = Verdict::Violated;
        row.found = Some(failing.property.name().to_owned());
        row.instance = failing.litmus.describe();
        row.message = format!(
            "{}: {}; {} of {} runs fail",
            failing.property.name(),
            failing.message,
            failing.count,
            sampled.runs
        );
        let token = guarded(|| minimise::of_live(subject, failing, limits));
        if let Some(token) = token.ok().flatten() {
            row.instance = token.litmus.describe();
            row.steps = Some(token.schedule().len() as u64);
            row.token = Some(Token::Litmus(token).to_string());
        }
    } else if sampled.ended < sampled.runs {
        row.verdict = Verdict::Unknown;
        row.message = format!(
            "{} of {} runs did not come to an end: they were interrupted, or an invocation waits for ever",
            sampled.runs - sampled.ended,
            sampled.runs
        );
    }
    row
}
