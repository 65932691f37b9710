//! The kill matrix: which check catches which built-in fault.
//!
//! Checks are, in this order: results and invariants under sequential consistency, termination, the same results under
//! relaxed memory, data races. A fault that none of them catches and whose outcomes are, on every instance, exactly
//! those of the form without it is *equivalent*, within the bound; any other survives, and that is a defect of the
//! checks.

use serde::Serialize;

use super::Verdict;
use super::beyond;
use super::endings::termination;
use super::plan::Plan;
use super::survey::{Survey, properties};
use crate::catalogue::Catalogue;
use crate::catalogue::faults::{MUTATIONS, Mutation};
use crate::error::{Error, Result};
use crate::explore::memory::model::{MemoryModel, Profile};
use crate::explore::program::controls;
use crate::explore::program::instances::Family;
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::Conditions;
use crate::explore::program::subject::Subject;
use crate::explore::search::explored::{Explored, Limits};
use crate::explore::search::property::Property;
use crate::explore::search::random;
use crate::scheme::contract::Form;

/// States of an instance that are looked at first, and the most that are looked at once a fault has shown: it may have no
/// end of them, since a list that leads in circles beyond its pool is an endless walk with alternatives at every step.
/// With 500,000 states, no built-in fault shows in another check.
const FIRST_LOOK: usize = 300_000;

fn first_look<'a>(limits: &Limits<'a>) -> Limits<'a> {
    Limits { states: limits.states.min(FIRST_LOOK), ..*limits }
}

/// The result of a check on a variant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Kill {
    /// The check: `sc`, `progress`, `simt`, `relaxed`, `race` or `random`.
    pub check: &'static str,
    /// The property that fails.
    pub property: &'static str,
    /// The smallest instance that shows it.
    pub instance: String,
    /// Steps of its schedule.
    pub steps: u64,
    /// Complete interleavings of that instance, if they can be counted.
    pub executions: Option<u64>,
    /// Distinct states of that instance.
    pub states: u64,
    /// The schedule.
    pub token: Option<String>,
}

/// The fate of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fate {
    /// A form without fault, and no check complains.
    Green,
    /// A form without fault, and a check complains.
    Accused,
    /// A fault that a check caught.
    Killed,
    /// A fault that changes no outcome, adds no race, and ends.
    Equivalent,
    /// A fault that nothing caught, and that is not equivalent.
    Survives,
    /// A bound was hit.
    Unknown,
}

impl Fate {
    /// The word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Green => "green",
            Self::Accused => "accused",
            Self::Killed => "killed",
            Self::Equivalent => "equivalent",
            Self::Survives => "survives",
            Self::Unknown => "unknown",
        }
    }

    /// Whether it is as it should be.
    #[must_use]
    pub fn is_right(self) -> bool {
        matches!(self, Self::Green | Self::Killed | Self::Equivalent)
    }
}

/// A variant's row.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Line {
    /// The fault's id, or `control`.
    pub mutation: String,
    /// The variant.
    pub method: String,
    /// Its fate.
    pub fate: Fate,
    /// The checks that caught it.
    pub kills: Vec<Kill>,
    /// What was explored.
    pub bound: String,
}

/// The whole matrix: every fault of the catalogue and every form that promises to be correct; or only the faults of one
/// id.
///
/// # Errors
/// There is no such fault, or it is not built in.
pub fn matrix(
    catalogue: &Catalogue,
    only: Option<&str>,
    plan: &Plan,
    limits: &Limits<'_>,
) -> Result<Vec<Line>> {
    let mut lines = Vec::new();
    if let Some(id) = only {
        built_in(id)?;
    }
    if only.is_none() {
        for method in catalogue.promised().filter(|m| m.contract().form == Form::Correct) {
            lines.push(control(&Subject::new(method)?, plan, limits));
        }
        for name in controls::GREEN {
            lines.push(control(&controls::find(catalogue, "METHOD", name)?, plan, limits));
        }
    }
    let chosen = faults().filter(|m| only.is_none_or(|id| m.id.eq_ignore_ascii_case(id)));
    for mutation in chosen {
        for variant in mutation.variants {
            let subject = controls::find(catalogue, "METHOD", variant)?;
            lines.push(fault(catalogue, mutation.id, &subject, plan, limits)?);
        }
    }
    Ok(lines)
}

/// All faults, of the catalogue and of the controls.
fn faults() -> impl Iterator<Item = &'static Mutation> {
    MUTATIONS.iter().chain(controls::CONTROLS)
}

/// Whether a method has the fault of that id.
fn built_in(id: &str) -> Result<()> {
    let known = faults().find(|m| m.id.eq_ignore_ascii_case(id));
    match known.map(|mutation| mutation.absent) {
        Some(None) => Ok(()),
        Some(Some(why)) => Err(Error::new("--mutation", format!("no method has {id}: {why}"))),
        None => {
            let ids: Vec<&str> = faults().map(|m| m.id).collect();
            let problem = format!("no fault is called {id:?}; there are {}", ids.join(", "));
            Err(Error::new("--mutation", problem))
        }
    }
}

/// A form without fault.
fn control(subject: &Subject, plan: &Plan, limits: &Limits<'_>) -> Line {
    let examined = Examined::new(subject, plan, limits);
    let fate = match (examined.complete, examined.kills.is_empty()) {
        (_, false) => Fate::Accused,
        (true, true) => Fate::Green,
        (false, true) => Fate::Unknown,
    };
    examined.line("control", fate)
}

/// A fault, compared with the form that it was put into.
fn fault(
    catalogue: &Catalogue,
    id: &str,
    subject: &Subject,
    plan: &Plan,
    limits: &Limits<'_>,
) -> Result<Line> {
    let examined = Examined::new(subject, plan, limits);
    if !examined.kills.is_empty() {
        return Ok(examined.line(id, Fate::Killed));
    }
    let base = controls::find(catalogue, "METHOD", subject.contract.base_name())?;
    let without = Examined::new(&base, plan, limits);
    let fate = match (examined.complete && without.complete, examined.equals(&without)) {
        (true, true) => Fate::Equivalent,
        (true, false) => Fate::Survives,
        (false, _) => Fate::Unknown,
    };
    Ok(examined.line(id, fate))
}

/// A variant with the results of all checks.
struct Examined {
    subject: Subject,
    surveys: Vec<Survey>,
    kills: Vec<Kill>,
    complete: bool,
}

impl Examined {
    fn new(subject: &Subject, plan: &Plan, limits: &Limits<'_>) -> Self {
        let mut examined =
            Self { subject: *subject, surveys: Vec::new(), kills: Vec::new(), complete: true };
        examined.results("sc", MemoryModel::Sequential, plan, limits);
        let few = first_look(limits);
        let limits = if examined.kills.is_empty() { limits } else { &few };
        examined.endings(plan, limits);
        examined.results("relaxed", MemoryModel::Relaxed(Profile::Vulkan), plan, limits);
        examined.random(plan, limits);
        examined
    }

    /// What random runs find: of a fault that nothing else has caught.
    fn random(&mut self, plan: &Plan, limits: &Limits<'_>) {
        if plan.runs == 0 || !self.kills.is_empty() {
            return;
        }
        let sampled = random::sample(&self.subject, plan.seed, plan.runs, limits);
        let row = beyond::row(&self.subject, plan.seed, &sampled, limits);
        match row.verdict {
            Verdict::Violated => self.kills.push(Kill {
                check: "random",
                property: Property::ALL
                    .into_iter()
                    .map(Property::name)
                    .find(|name| row.found.as_deref() == Some(name))
                    .unwrap_or(beyond::NAME),
                instance: row.instance,
                steps: row.steps.unwrap_or(0),
                executions: row.executions,
                states: 0,
                token: row.token,
            }),
            Verdict::Unknown => self.complete = false,
            Verdict::Verified | Verdict::Sampled => {}
        }
    }

    fn results(
        &mut self,
        check: &'static str,
        memory: MemoryModel,
        plan: &Plan,
        limits: &Limits<'_>,
    ) {
        let family = Family {
            fragments: plan.fragments_under(self.subject.contract, memory).min(4),
            ks: plan.ks.iter().copied().filter(|&k| k <= 2).collect(),
            helpers: 0,
        };
        let conditions = Conditions { memory, warp: None };
        let survey = |limits: &Limits<'_>| Survey::new(&self.subject, &family, conditions, limits);
        let first = survey(&first_look(limits));
        let more = limits.states > FIRST_LOOK && !first.is_wrong() && first.has_more_states();
        let survey = if more { survey(limits) } else { first };
        self.complete &= survey.is_complete();
        let asked = properties(&self.subject, memory).into_iter().chain(Property::CONDITIONS);
        let is_race = |p: Property| p == Property::RaceFree;
        let first = asked
            .filter_map(|p| Some((p, survey.violation(p)?)))
            .filter(|(p, _)| !is_race(*p))
            .min_by_key(|(_, (l, _, f))| (l.fragments.len(), f.schedule.len()));
        let race = survey.violation(Property::RaceFree).map(|v| (Property::RaceFree, v));
        for (property, (litmus, explored, found)) in first.into_iter().chain(race) {
            self.kills.push(Kill {
                check: if is_race(property) { "race" } else { check },
                property: property.name(),
                instance: litmus.describe(),
                steps: found.schedule.len() as u64,
                executions: explored.executions.and_then(|n| u64::try_from(n).ok()),
                states: explored.states as u64,
                token: survey.row(property).token,
            });
        }
        // An invocation that does not end has no schedule to show: the search says where it gave up.
        if let Some((litmus, explored)) = survey.endless() {
            self.kills.push(Kill {
                check,
                property: "endless",
                instance: litmus.describe(),
                steps: 0,
                executions: None,
                states: explored.states as u64,
                token: None,
            });
        }
        self.surveys.push(survey);
    }

    fn endings(&mut self, plan: &Plan, limits: &Limits<'_>) {
        let ks = plan.ks.iter().copied().filter(|&k| k <= 2).collect();
        let plan = Plan { ks, fragments: Some(2), progress: None, simt: true, ..plan.clone() };
        for row in termination(&self.subject, &plan, limits) {
            let simt = row.progress.as_deref() == Some("simt");
            match row.verdict {
                Verdict::Violated => self.kills.push(Kill {
                    check: if simt { "simt" } else { "progress" },
                    property: Property::Termination.name(),
                    instance: row.instance,
                    steps: row.steps.unwrap_or(0),
                    executions: None,
                    states: row.states,
                    token: row.token,
                }),
                Verdict::Unknown => self.complete = false,
                Verdict::Verified | Verdict::Sampled => {}
            }
        }
    }

    /// Whether both have the same outcomes on every instance, under every memory model.
    fn equals(&self, other: &Self) -> bool {
        type All = [(Litmus, Explored)];
        let same = |a: &All, b: &All| {
            let pairs = a.iter().zip(b);
            let equal = |((la, ea), (lb, eb)): (&(Litmus, Explored), &(Litmus, Explored))| {
                la == lb && ea.outcomes.keys().eq(eb.outcomes.keys())
            };
            a.len() == b.len() && pairs.into_iter().all(equal)
        };
        let surveys = self.surveys.iter().zip(&other.surveys);
        self.surveys.len() == other.surveys.len()
            && surveys
                .into_iter()
                .all(|(a, b)| same(&a.explored, &b.explored) && same(&a.ordered, &b.ordered))
    }

    fn line(self, mutation: &str, fate: Fate) -> Line {
        let bounds = self.surveys.iter().map(|s| s.row(Property::Keeps).bound);
        Line {
            mutation: mutation.to_owned(),
            method: self.subject.contract.name.to_owned(),
            fate,
            bound: bounds.collect::<Vec<_>>().join("; "),
            kills: self.kills,
        }
    }
}
