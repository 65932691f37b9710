//! A survey: the instances of a method, explored in parallel under one memory model, and a row for each property.
//!
//! Instances are explored by size. A size at which a result is wrong is the last one: larger sizes would not show a
//! smaller violation. What was explored until then is the bound of every row.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::plan::Plan;
use super::{Finding, Scope, Verdict};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::guard::guarded;
use crate::explore::program::instances::{self, Family};
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::Conditions;
use crate::explore::program::schedule::Move;
use crate::explore::program::subject::Subject;
use crate::explore::program::values::{self, Values};
use crate::explore::replay::token::{LitmusToken, Token};
use crate::explore::replay::{run, words};
use crate::explore::search::explored::{Explored, Found, Limits, Stopped};
use crate::explore::search::property::Property;
use crate::explore::search::random::Sites;
use crate::explore::search::{explore, orders};
use crate::memory::asked::Action;
use crate::scheme::Held;

/// All results of exploring a method under one memory model.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The method.
    pub subject: Subject,
    /// How it was run.
    pub conditions: Conditions,
    /// The instances explored, smallest first, with their results.
    pub explored: Vec<(Litmus, Explored)>,
    /// The same with other values, in every order of arrival, one invocation after another.
    pub ordered: Vec<(Litmus, Explored)>,
    /// Sizes planned and sizes explored to their end.
    pub planned: u32,
    /// The largest size explored.
    pub size: u32,
    /// Instances have several choices of values.
    pub varies: bool,
    /// What was explored, if it was not a family of instances.
    pub given: Option<String>,
    /// Operations that no instance reached, by file, line and column: those that others make, once
    /// `compare` has been told of them.
    pub missed: BTreeMap<(&'static str, u32, u32), String>,
}

impl Survey {
    /// Explore all instances up to a size, or up to the first size at which a result is wrong; also with close values,
    /// and under sequential consistency with others in every order of arrival.
    #[must_use]
    pub fn new(
        subject: &Subject,
        family: &Family,
        conditions: Conditions,
        limits: &Limits<'_>,
    ) -> Self {
        Self::of(subject, family, conditions, true, limits)
    }

    /// The same; `varies` if values are varied.
    pub(super) fn of(
        subject: &Subject,
        family: &Family,
        conditions: Conditions,
        varies: bool,
        limits: &Limits<'_>,
    ) -> Self {
        let mut survey = Self {
            subject: *subject,
            conditions,
            explored: Vec::new(),
            ordered: Vec::new(),
            planned: family.fragments,
            size: 0,
            varies,
            given: None,
            missed: BTreeMap::new(),
        };
        for n in 0..=family.fragments {
            let mut instances = match guarded(|| instances::of_size(subject, family, n)) {
                Ok(instances) => instances,
                Err(told) => {
                    let litmus = Litmus::of_one(subject.contract);
                    survey.explored.push((litmus, Explored::panicked(told)));
                    break;
                }
            };
            let mut others = Vec::new();
            if varies {
                let of = |values: &Values| {
                    let other = |litmus| values.of(litmus, subject.contract);
                    instances.iter().filter_map(other).collect::<Vec<_>>()
                };
                if conditions.memory == MemoryModel::Sequential {
                    others = values::OTHERS.iter().flat_map(of).collect();
                }
                let close = of(&values::CLOSE);
                instances.extend(close);
            }
            let explore = |litmus: Litmus| {
                let explored = explore(subject, &litmus, conditions, limits);
                (litmus, explored)
            };
            let order = |litmus: Litmus| {
                let explored = orders(subject, &litmus, limits);
                (litmus, explored)
            };
            survey.explored.par_extend(instances.into_par_iter().map(explore));
            survey.ordered.par_extend(others.into_par_iter().map(order));
            survey.size = n;
            if survey.is_wrong() || !survey.is_complete() {
                break;
            }
        }
        survey
    }

    /// Compare what the instances reached with where others make operations; they are asked for only if that decides
    /// something. What is missing makes verdicts unknown.
    pub(super) fn compare<'s>(&mut self, sites: impl FnOnce() -> &'s Sites) {
        if self.is_wrong() || !self.is_complete() {
            return;
        }
        let reached = self.reached();
        // Without the value: `relaxed store`.
        let told = |action: &Action| {
            words::describe(*action).split(' ').take(2).collect::<Vec<_>>().join(" ")
        };
        let missed = sites().iter().filter(|(site, _)| !reached.contains(site));
        self.missed = missed.map(|(site, action)| (*site, told(action))).collect();
    }

    /// All results, of whole explorations and of orders of arrival.
    fn all(&self) -> impl Iterator<Item = &(Litmus, Explored)> {
        self.explored.iter().chain(&self.ordered)
    }

    /// Every state of every instance was visited.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.all().all(|(_, e)| e.complete)
    }

    /// A result, an invariant or a bound is violated; a race alone is not wrong.
    pub(super) fn is_wrong(&self) -> bool {
        self.all().any(|(_, e)| e.violations.keys().any(|&p| p != Property::RaceFree))
    }

    /// Distinct states in total.
    #[must_use]
    pub fn states(&self) -> u64 {
        self.all().map(|(_, e)| e.states as u64).sum()
    }

    /// Complete interleavings in total, if they could be counted.
    #[must_use]
    pub fn executions(&self) -> Option<u64> {
        let mut all = self.explored.iter().map(|(_, e)| e.executions);
        let sum = all.try_fold(0u128, |sum, executions| sum.checked_add(executions?));
        sum.and_then(|n| u64::try_from(n).ok())
    }

    /// The smallest instance that violates a property: by n, k, and then steps.
    #[must_use]
    pub fn violation(&self, property: Property) -> Option<(&Litmus, &Explored, &Found)> {
        let found = self.all().filter_map(|(l, e)| Some((l, e, e.violations.get(&property)?)));
        found.min_by_key(|(l, _, f)| (l.fragments.len(), l.k, f.schedule.len()))
    }

    /// Operations that the instances reached: file, line, column.
    #[must_use]
    pub fn reached(&self) -> BTreeSet<(&'static str, u32, u32)> {
        self.all().flat_map(|(_, e)| e.sites.iter().copied()).collect()
    }

    /// What a larger size costs, as far as the last one tells.
    fn growth(&self) -> String {
        let states = |n: u32| {
            let of_size = self.explored.iter().filter(|(l, _)| l.fragments.len() == n as usize);
            of_size.map(|(_, e)| e.states).sum::<usize>()
        };
        match (states(self.size), states(self.size.saturating_sub(1))) {
            (last, before) if before > 0 && last > before => {
                format!(" (the last fragment made {} times as many states)", last / before)
            }
            _ => String::new(),
        }
    }

    /// The first instance that was not explored to its end, and why.
    pub(super) fn stopped(&self) -> Option<(&Litmus, &Stopped)> {
        self.all().find_map(|(litmus, e)| Some((litmus, e.stopped.as_ref()?)))
    }

    /// An instance has more states than it was allowed.
    pub(super) fn has_more_states(&self) -> bool {
        self.all().any(|(_, e)| matches!(e.stopped, Some(Stopped::States { .. })))
    }

    /// The first instance on which an invocation was cut off.
    pub(super) fn endless(&self) -> Option<&(Litmus, Explored)> {
        let cut_off = |e: &Explored| matches!(e.stopped, Some(Stopped::Endless { .. }));
        self.all().find(|(_, e)| cut_off(e))
    }

    /// A row for every property that can be checked, and for the conditions of a check that are violated.
    #[must_use]
    pub fn rows(&self) -> Vec<Finding> {
        let violated = |p: &Property| self.violation(*p).is_some();
        let conditions = Property::CONDITIONS.into_iter().filter(violated);
        let asked = properties(&self.subject, self.conditions.memory);
        asked.into_iter().chain(conditions).map(|p| self.row(p)).collect()
    }

    /// The row of a property.
    #[must_use]
    pub fn row(&self, property: Property) -> Finding {
        let mut row = self.blank(Some(property));
        if let Some((litmus, explored, found)) = self.violation(property) {
            row.verdict = Verdict::Violated;
            row.instance = litmus.describe();
            row.executions = explored.executions.and_then(|n| u64::try_from(n).ok());
            row.states = explored.states as u64;
            row.steps = Some(found.schedule.len() as u64);
            (row.token, row.message) = self.witness(property, litmus, found);
            if property.is_of_all_results() {
                row.outcomes = outcomes(explored);
            }
            return row;
        }
        row.verdict = Verdict::Unknown;
        if let Some((_, _, found)) = self.violation(Property::Repeats) {
            row.message.clone_from(&found.message);
        } else if let Some((litmus, stopped)) = self.stopped() {
            row.message = format!("{stopped}; on {}", litmus.describe());
        } else if !self.missed.is_empty() {
            let missed = self.missed.iter();
            let told = missed
                .map(|((file, line, column), told)| format!("{told} at {file}:{line}:{column}"));
            let told: Vec<String> = told.collect();
            row.message = format!(
                "random runs make operations that these instances do not reach: raise -n or -k{}: {}",
                self.growth(),
                told.join(", ")
            );
        } else {
            row.verdict = Verdict::Verified;
        }
        row
    }

    /// Explore one given instance, for one row per property.
    #[must_use]
    pub fn given(
        subject: &Subject,
        litmus: &Litmus,
        conditions: Conditions,
        limits: &Limits<'_>,
    ) -> Self {
        let explored = explore(subject, litmus, conditions, limits);
        let n = litmus.fragments.len() as u32;
        let k = litmus.k.map(|k| format!(", k = {k}")).unwrap_or_default();
        let given = Some(format!("these {n} fragments{k}"));
        let explored = vec![(litmus.clone(), explored)];
        Self {
            subject: *subject,
            conditions,
            explored,
            ordered: Vec::new(),
            planned: n,
            size: n,
            varies: false,
            given,
            // One pixel need not show all of the method: its verdict concerns only these fragments.
            missed: BTreeMap::new(),
        }
    }

    /// Every result of the instances with exactly this many fragments, of distinct depths on one pixel, as one row
    /// each.
    #[must_use]
    pub fn outcomes(
        subject: &Subject,
        plan: &Plan,
        memory: MemoryModel,
        limits: &Limits<'_>,
    ) -> Vec<Finding> {
        let n = plan.fragments_under(subject.contract, memory);
        let family = Family { fragments: n, ks: plan.ks.clone(), helpers: plan.helpers };
        let distinct = |litmus: &Litmus| {
            let mut depths: Vec<u32> = litmus.fragments.iter().map(|f| f.1).collect();
            depths.dedup();
            depths.len() == n as usize && litmus.pixels == 1 && litmus.room >= n
        };
        let instances = instances::of_size(subject, &family, n);
        let conditions = Conditions { memory, warp: None };
        let row = |litmus: Litmus| {
            let survey = Self::given(subject, &litmus, conditions, limits);
            let explored = &survey.explored[0].1;
            let mut row = survey.blank(None);
            row.instance = litmus.describe();
            row.outcomes = outcomes(explored);
            row.verdict = if explored.complete { Verdict::Verified } else { Verdict::Unknown };
            row.message = format!(
                "{}{} results, {} states",
                if explored.complete { "" } else { "at least " },
                explored.outcomes.len(),
                explored.states
            );
            row
        };
        instances.into_iter().filter(distinct).map(row).collect()
    }

    pub(super) fn blank(&self, property: Option<Property>) -> Finding {
        let contract = self.subject.contract;
        let mut scope = Scope::of(self.explored.iter().map(|(litmus, _)| litmus));
        if self.varies {
            scope.values = 2;
            if !self.ordered.is_empty() {
                scope.arrival_values = values::OTHERS.len() as u32;
            }
        }
        let patterns = match self.size {
            n if n > instances::ALL_PATTERNS => {
                format!(" (all patterns up to {}, distinct depths beyond)", instances::ALL_PATTERNS)
            }
            _ => ", all patterns".to_owned(),
        };
        let what = match &self.given {
            Some(given) => given.clone(),
            None => {
                let (n, k, values) = (self.size, scope.ks_told(), scope.values_told());
                format!("n <= {n} on up to {} pixels{k}{patterns}{values}", scope.pixels)
            }
        };
        let tables = if contract.crosses() { ", some tables of 1 to 8 cells" } else { "" };
        let memory = self.conditions.memory.bound();
        let bound = format!("{what}{tables}, all interleavings, any initial memory, {memory}");
        Finding {
            method: contract.name.to_owned(),
            property: property.map(|p| p.name().to_owned()),
            found: None,
            claim: None,
            verdict: Verdict::Unknown,
            exhaustive: self.is_complete(),
            bound,
            scope,
            memory: self.conditions.memory.name().to_owned(),
            profile: self.conditions.memory.profile().map(str::to_owned),
            progress: None,
            instance: format!("{} instances", self.explored.len()),
            initial: "arbitrary but for the clear pass".to_owned(),
            executions: self.executions(),
            states: self.states(),
            token: None,
            steps: None,
            message: String::new(),
            outcomes: Vec::new(),
        }
    }

    /// The token of a violation, and what it shows, described in more detail than by the explorer.
    fn witness(
        &self,
        property: Property,
        litmus: &Litmus,
        found: &Found,
    ) -> (Option<String>, String) {
        let (subject, conditions) = (&self.subject, self.conditions);
        witness(subject, property, litmus, conditions, [&found.schedule, &[]], &found.message)
    }
}

/// The token of a violation, and what it shows.
pub(super) fn witness(
    subject: &Subject,
    property: Property,
    litmus: &Litmus,
    conditions: Conditions,
    schedule: [&[Move]; 2],
    message: &str,
) -> (Option<String>, String) {
    let moves = schedule.concat();
    let run = guarded(|| run::run(&subject.case(litmus), conditions, &moves));
    // A scheme that panics before it runs has no schedule, and one that does not repeat itself has none that counts.
    let Ok(Ok(run)) = run else { return (None, message.to_owned()) };
    if Property::CONDITIONS.contains(&property) && moves.is_empty() {
        return (None, message.to_owned());
    }
    let told = run.violations().find(|(p, _)| *p == property).map(|(_, told)| told.clone());
    let (method, name) = (subject.contract.name, property.name());
    let token = LitmusToken::new(method, name, litmus, conditions, schedule, &run);
    let message = match (property, told, &run.end) {
        (all, _, Some(end)) if all.is_of_all_results() => {
            format!("{message}; this schedule gives {}", pixels_told(&end.pixels))
        }
        (_, Some(told), _) => told,
        _ => message.to_owned(),
    };
    (Some(Token::Litmus(token).to_string()), message)
}

/// An instance's results, one line each.
fn outcomes(explored: &Explored) -> Vec<String> {
    explored.outcomes.keys().map(|pixels| pixels_told(pixels)).collect()
}

/// What the pixels hold.
fn pixels_told(pixels: &[Held]) -> String {
    pixels.iter().map(Held::to_string).collect::<Vec<_>>().join(" ")
}

/// The properties that can be checked for a method under a memory model.
#[must_use]
pub fn properties(subject: &Subject, memory: MemoryModel) -> Vec<Property> {
    let litmus = Litmus::of_one(subject.contract);
    let locks = guarded(|| !subject.case(&litmus).instance.layout().locks().is_empty());
    let locks = locks.unwrap_or(false);
    let races = matches!(memory, MemoryModel::Relaxed(profile) if profile.has_races());
    let asked = |p: &Property| match p {
        Property::MutualExclusion => locks,
        Property::RaceFree => races,
        Property::Termination | Property::Panics | Property::Repeats => false,
        Property::ArrivalFree => false,
        _ => true,
    };
    Property::ALL.into_iter().filter(asked).collect()
}
