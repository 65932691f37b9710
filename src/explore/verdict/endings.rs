//! Whether every invocation ends: one row for each progress model, with a lasso where one does not.

use rayon::prelude::*;

use super::plan::{MOST_PROGRESS, Plan};
use super::survey::{Survey, witness};
use super::{Finding, Verdict};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::guard::guarded;
use crate::explore::program::instances::Family;
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::Conditions;
use crate::explore::program::schedule::Move;
use crate::explore::program::subject::Subject;
use crate::explore::replay::words;
use crate::explore::search::explored::Limits;
use crate::explore::search::progress::{self, Lasso, Progress, Progressed};
use crate::explore::search::property::Property;

/// Whether every invocation ends: one row per progress model, and one for a warp whose lanes reconverge.
///
/// A method under which no state is met twice ends under every model, and is not explored further.
#[must_use]
pub fn termination(subject: &Subject, plan: &Plan, limits: &Limits<'_>) -> Vec<Finding> {
    let simt = plan.simt.then_some("simt");
    let progress = plan.progress_of(subject.contract);
    let names: Vec<&str> = progress.iter().map(|p| p.name()).chain(simt).collect();
    if names.is_empty() {
        return Vec::new();
    }
    let n = plan.fragments.unwrap_or(MOST_PROGRESS).min(MOST_PROGRESS);
    let family = Family { fragments: n, ks: plan.ks.clone(), helpers: plan.helpers };
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let survey = Survey::of(subject, &family, conditions, false, limits);
    let instances = || survey.explored.iter().map(|(litmus, _)| litmus.clone()).collect();
    if survey.is_complete() && !survey.explored.iter().any(|(_, e)| e.cyclic) {
        return names.into_iter().map(|name| survey.ends(name)).collect();
    }
    let mut rows = Vec::new();
    if !progress.is_empty() {
        let endings = Endings::new(&survey, instances(), None, limits);
        rows.extend(progress.iter().map(|&p| endings.row(p, p.name())));
    }
    if plan.simt {
        let mut row =
            Endings::new(&survey, instances(), Some(32), limits).row(Progress::Fair, "simt");
        let waits = survey.explored.iter().map(|(_, e)| e.bare_waits).max().unwrap_or(0);
        if waits > 0 && row.verdict == Verdict::Verified {
            row.verdict = Verdict::Unknown;
            row.message =
                format!("{waits} waits stand in no block: where lanes come together is not known");
        }
        rows.push(row);
    }
    rows
}

impl Survey {
    /// The row of a method that never repeats a state.
    fn ends(&self, progress: &str) -> Finding {
        let mut row = self.blank(Some(Property::Termination));
        row.verdict = Verdict::Verified;
        row.progress = Some(progress.to_owned());
        "no state can be met twice".clone_into(&mut row.message);
        row
    }
}

/// How a survey's instances end.
struct Endings<'a> {
    survey: &'a Survey,
    warp: Option<u32>,
    all: Vec<(Litmus, Option<Progressed>)>,
}

impl<'a> Endings<'a> {
    fn new(
        survey: &'a Survey,
        instances: Vec<Litmus>,
        warp: Option<u32>,
        limits: &Limits<'_>,
    ) -> Self {
        let subject = &survey.subject;
        let explore = |litmus: Litmus| {
            let found = guarded(|| progress::explore(&subject.case(&litmus), warp, limits));
            (litmus, found.ok().flatten())
        };
        Self { survey, warp, all: instances.into_par_iter().map(explore).collect() }
    }

    fn row(&self, model: Progress, name: &str) -> Finding {
        let conditions = Conditions { memory: MemoryModel::Sequential, warp: self.warp };
        let mut row = self.survey.blank(Some(Property::Termination));
        let complete = self.all.iter().all(|(_, found)| found.is_some());
        row.exhaustive = complete;
        row.progress = Some(name.to_owned());
        row.executions = None;
        row.states = self.all.iter().flat_map(|(_, f)| f).map(|f| f.states as u64).sum();
        match self.lasso(model) {
            Some((litmus, lasso)) => {
                row.verdict = Verdict::Violated;
                row.instance = litmus.describe();
                row.steps = Some((lasso.stem.len() + lasso.cycle.len()) as u64);
                let message = lasso_told(lasso);
                let schedule = [lasso.stem.as_slice(), lasso.cycle.as_slice()];
                let (subject, property) = (&self.survey.subject, Property::Termination);
                (row.token, row.message) =
                    witness(subject, property, litmus, conditions, schedule, &message);
            }
            None if complete => row.verdict = Verdict::Verified,
            None => {
                row.message = match self.survey.stopped() {
                    Some((litmus, stopped)) => format!("{stopped}; on {}", litmus.describe()),
                    None => "there are more states than --max-states, which also count who has moved: raise it, or \
                             lower -n"
                        .to_owned(),
                }
            }
        }
        row
    }

    fn lasso(&self, model: Progress) -> Option<(&Litmus, &Lasso)> {
        let at = Progress::ALL.iter().position(|&p| p == model)?;
        let found = self.all.iter();
        let found = found.filter_map(|(l, f)| Some((l, f.as_ref()?.lassos[at].as_ref()?)));
        found
            .min_by_key(|(l, lasso)| (l.fragments.len(), l.k, lasso.stem.len() + lasso.cycle.len()))
    }
}

/// A lasso in words: A A B (A)^w.
fn lasso_told(lasso: &Lasso) -> String {
    let word = |moves: &[Move]| {
        moves.iter().map(|by| words::label(usize::from(by.invocation))).collect::<String>()
    };
    if lasso.cycle.is_empty() {
        return format!("after {} no invocation can move any more", word(&lasso.stem));
    }
    format!("never ends: {} ({})^w", word(&lasso.stem), word(&lasso.cycle))
}
