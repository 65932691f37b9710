//! Checking a method: its surveys under each memory model, whether it ends, and what random runs say.

use std::cell::LazyCell;
use std::collections::BTreeSet;

use super::beyond;
use super::endings::termination;
use super::plan::Plan;
use super::survey::Survey;
use super::{Finding, Verdict};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::instances::Family;
use crate::explore::program::machine::Conditions;
use crate::explore::program::subject::Subject;
use crate::explore::search::explored::Limits;
use crate::explore::search::property::Property;
use crate::explore::search::random;

/// Random runs that say where a method makes operations, at least.
const RUNS: u64 = 100;

/// Check a method: one row per property and memory model, then termination per progress model, then random runs.
#[must_use]
pub fn check(subject: &Subject, plan: &Plan, limits: &Limits<'_>) -> Vec<Finding> {
    let draw = || random::sample(subject, plan.seed, plan.runs.max(RUNS), limits);
    let sampled = LazyCell::new(draw);
    let mut rows = Vec::new();
    let mut reached = BTreeSet::new();
    for &memory in &plan.memory {
        let fragments = plan.fragments_under(subject.contract, memory);
        let mut family = Family { fragments, ks: plan.ks.clone(), helpers: plan.helpers };
        let conditions = Conditions { memory, warp: None };
        let mut survey = Survey::new(subject, &family, conditions, limits);
        survey.compare(|| &sampled.sites);
        // One more fragment, if that reaches what fewer do not.
        if plan.fragments.is_none() && survey.missed.keys().any(|site| reached.contains(site)) {
            family.fragments += 1;
            survey = Survey::new(subject, &family, conditions, limits);
            survey.compare(|| &sampled.sites);
        }
        reached.append(&mut survey.reached());
        rows.extend(survey.rows());
    }
    inherit(&mut rows);
    rows.extend(termination(subject, plan, limits));
    if plan.runs > 0 {
        rows.push(beyond::row(subject, plan.seed, &sampled, limits));
    }
    doubt(&mut rows);
    rows
}

/// Of a scheme that panics, or that does not repeat itself, nothing is verified.
fn doubt(rows: &mut [Finding]) {
    let names = Property::CONDITIONS.map(Property::name);
    let broken =
        rows.iter().find(|row| row.property.as_deref().is_some_and(|p| names.contains(&p)));
    let Some(message) = broken.map(|row| row.message.clone()) else { return };
    let trusted = |row: &&mut Finding| matches!(row.verdict, Verdict::Verified | Verdict::Sampled);
    for row in rows.iter_mut().filter(trusted) {
        row.verdict = Verdict::Unknown;
        row.message.clone_from(&message);
    }
}

/// Every sequentially consistent execution is also one of relaxed memory: what is violated there is violated here, and
/// the same schedule shows it. The rows are those of one method.
pub fn inherit(rows: &mut [Finding]) {
    let violated = |row: &&Finding| row.verdict == Verdict::Violated;
    let sequential = MemoryModel::Sequential.name();
    let (strong, weak): (Vec<&mut Finding>, Vec<&mut Finding>) =
        rows.iter_mut().partition(|row| row.memory == sequential);
    let strong: Vec<&Finding> = strong.iter().map(|row| &**row).filter(violated).collect();
    for row in weak.into_iter().filter(|row| row.verdict != Verdict::Violated) {
        // A claim's row is the worst of several properties.
        let known = strong.iter().find(|known| {
            known.claim == row.claim && (row.claim.is_some() || known.property == row.property)
        });
        let Some(known) = known else { continue };
        *row = Finding {
            bound: std::mem::take(&mut row.bound),
            scope: std::mem::take(&mut row.scope),
            memory: std::mem::take(&mut row.memory),
            profile: row.profile.take(),
            message: format!("as under {sequential}: {}", known.message),
            ..(*known).clone()
        };
    }
}
