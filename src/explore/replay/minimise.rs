//! Minimising a failure: a pixel's fragments, the switches between invocations, the steps.
//!
//! Delta debugging with replays: a smaller candidate is kept if it still shows the same property violated. A candidate
//! schedule is followed as far as it goes; moves of invocations that have ended are left out, and the remaining
//! invocations run to their end in order.

use super::run::{Run, Runner, run};
use super::token::LitmusToken;
use crate::catalogue::Catalogue;
use crate::error::{Error, Result};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::case::Case;
use crate::explore::program::controls;
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::{Conditions, MOST_INVOCATIONS};
use crate::explore::program::schedule::{Move, Schedule, switches};
use crate::explore::program::subject::Subject;
use crate::explore::search::property::Property;
use crate::explore::search::random::Failing;
use crate::explore::search::{Limits, exhaustive};

/// Steps after which a candidate is given up.
const MOST_STEPS: usize = 20_000;

/// Fragments up to which all interleavings are searched for a shortest one.
const SEARCHED: usize = 4;

/// A failure of one pixel.
pub(in crate::explore) struct Failure {
    pub(in crate::explore) subject: Subject,
    pub(in crate::explore) conditions: Conditions,
    pub(in crate::explore) property: Property,
    pub(in crate::explore) litmus: Litmus,
    pub(in crate::explore) schedule: Schedule,
}

/// A failing random run as a token, cut down further. `None` if a machine has no room for it, or does not show it.
pub(in crate::explore) fn of_live(
    subject: &Subject,
    failing: &Failing,
    limits: &Limits<'_>,
) -> Option<LitmusToken> {
    let (litmus, property) = (failing.litmus.clone(), failing.property);
    let case = subject.case(&litmus);
    if case.width() > MOST_INVOCATIONS {
        return None;
    }
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let runner = Runner::new(&case, conditions);
    let moves = failing.live.moves.iter();
    let moves = moves.filter_map(|&(at, by)| Some((Some(runner.number_of(at)?), by)));
    let (schedule, run) = follow(&case, conditions, moves);
    let mut failure = Failure { subject: *subject, conditions, property, litmus, schedule };
    if !run.violations().any(|(found, _)| *found == property) {
        // Where passes that the machine leaves out interleave, the moves may be others.
        if failure.litmus.fragments.len() > SEARCHED {
            return None;
        }
        let explored = exhaustive::explore(&case, conditions, limits);
        failure.schedule.clone_from(&explored.violations.get(&property)?.schedule);
    }
    failure.minimise(limits).ok()
}

/// Minimise a litmus token.
///
/// # Errors
/// An unknown method, or a token that does not show its violation.
pub fn minimise_litmus(
    catalogue: &Catalogue,
    token: &LitmusToken,
    limits: &Limits<'_>,
) -> Result<LitmusToken> {
    let subject = controls::find(catalogue, "TOKEN", &token.method)?;
    // It shows no failure that a smaller pixel could keep.
    if token.property == LitmusToken::OUTCOME {
        return Ok(token.clone());
    }
    let property = Property::ALL.into_iter().find(|p| p.name() == token.property);
    let property = property.ok_or_else(|| unfit("names a property that fragloom does not know"))?;
    if property == Property::Termination {
        return Ok(token.clone());
    }
    // One run cannot show that there are other results; it can show that its own result is wrong.
    let property = if property.is_of_all_results() { Property::Keeps } else { property };
    let failure = Failure {
        subject,
        conditions: token.conditions(),
        property,
        litmus: token.litmus.clone(),
        schedule: token.schedule(),
    };
    failure.minimise(limits)
}

/// Follow moves as far as they go, then run the remaining invocations. A move may name its stage: the remaining
/// invocations of earlier stages then run first.
pub(in crate::explore) fn follow(
    case: &Case,
    conditions: Conditions,
    moves: impl Iterator<Item = (Option<usize>, Move)>,
) -> (Schedule, Run) {
    let mut runner = Runner::new(case, conditions);
    let mut schedule = Schedule::new();
    let mut take = |runner: &mut Runner<'_>, by: Move| {
        let ways = runner.alternatives(usize::from(by.invocation));
        let by = Move { alternative: by.alternative.min(ways.saturating_sub(1) as u16), ..by };
        let moved = ways > 0 && runner.step(by).is_some();
        if moved {
            schedule.push(by);
        }
        moved
    };
    let mut left = MOST_STEPS;
    // A waiting invocation goes last: it may wait for one of the others.
    let go_on = |runner: &mut Runner<'_>, take: &mut dyn FnMut(&mut Runner<'_>, Move) -> bool| {
        let live = runner.live();
        let order = (0..32).filter(|i| live & (1 << i) != 0);
        let ready = order.clone().find(|&i| !runner.waits(i)).or_else(|| order.clone().next());
        let by = |i| Move { invocation: i as u8, alternative: 0 };
        ready.is_some_and(|i| take(runner, by(i)))
    };
    for (stage, by) in moves.take(MOST_STEPS) {
        while stage.is_some_and(|stage| runner.stage() < stage) && left > 0 {
            left = if go_on(&mut runner, &mut take) { left - 1 } else { 0 };
        }
        let now = stage.is_none_or(|stage| runner.stage() == stage);
        if now && runner.live() & (1 << by.invocation) != 0 {
            take(&mut runner, by);
        }
    }
    while runner.live() != 0 && left > 0 {
        left = if go_on(&mut runner, &mut take) { left - 1 } else { 0 };
    }
    (schedule, runner.finish())
}

impl Failure {
    pub(in crate::explore) fn minimise(mut self, limits: &Limits<'_>) -> Result<LitmusToken> {
        self.drop_fragments(limits);
        self.drop_switches(limits);
        self.search(limits);
        self.token()
    }

    /// Whether a candidate shows the violation; its schedule if it does.
    fn shows(&self, litmus: &Litmus, moves: &[Move]) -> Option<Schedule> {
        let moves = moves.iter().map(|&by| (None, by));
        let (schedule, run) = follow(&self.subject.case(litmus), self.conditions, moves);
        run.violations().any(|(found, _)| *found == self.property).then_some(schedule)
    }

    /// Leave out one fragment after another, as long as any is unnecessary.
    fn drop_fragments(&mut self, limits: &Limits<'_>) {
        let mut at = 0;
        while at < self.litmus.fragments.len() && !(limits.cancelled)() {
            let mut litmus = self.litmus.clone();
            litmus.fragments.remove(at);
            litmus.room = litmus.room.min(litmus.fragments.len() as u32).max(1);
            litmus.helpers = litmus.helpers.min(litmus.fragments.len() as u32);
            let gone = at as u8;
            let moves = self.schedule.iter().filter(|by| by.invocation != gone);
            let moves: Schedule = moves
                .map(|by| Move {
                    invocation: by.invocation - u8::from(by.invocation > gone),
                    ..*by
                })
                .collect();
            let smaller = !litmus.fragments.is_empty();
            match smaller.then(|| self.shows(&litmus, &moves)).flatten() {
                Some(schedule) => {
                    (self.litmus, self.schedule) = (litmus, schedule);
                    at = 0;
                }
                None => at += 1,
            }
        }
    }

    /// Let an invocation continue where it was interrupted, as long as the violation remains.
    fn drop_switches(&mut self, limits: &Limits<'_>) {
        let mut at = 1;
        while at < self.schedule.len() && !(limits.cancelled)() {
            let before = self.schedule[at - 1].invocation;
            if self.schedule[at].invocation == before {
                at += 1;
                continue;
            }
            // Bring the next run of the interrupted invocation forward.
            let rest = &self.schedule[at..];
            let Some(begin) = rest.iter().position(|by| by.invocation == before) else {
                at += 1;
                continue;
            };
            let length = rest[begin..].iter().take_while(|by| by.invocation == before).count();
            let mut moves = self.schedule[..at].to_vec();
            moves.extend_from_slice(&rest[begin..begin + length]);
            moves.extend_from_slice(&rest[..begin]);
            moves.extend_from_slice(&rest[begin + length..]);
            let fewer = |schedule: &Schedule| switches(schedule) < switches(&self.schedule);
            match self.shows(&self.litmus, &moves).filter(fewer) {
                Some(schedule) => (self.schedule, at) = (schedule, 1),
                None => at += 1,
            }
        }
    }

    /// With few fragments left, find a shortest schedule of all.
    fn search(&mut self, limits: &Limits<'_>) {
        if self.litmus.fragments.len() > SEARCHED {
            return;
        }
        let case = self.subject.case(&self.litmus);
        let explored = exhaustive::explore(&case, self.conditions, limits);
        if let Some(found) = explored.violations.get(&self.property)
            && found.schedule.len() < self.schedule.len()
        {
            self.schedule.clone_from(&found.schedule);
        }
    }

    fn token(&self) -> Result<LitmusToken> {
        let run = run(&self.subject.case(&self.litmus), self.conditions, &self.schedule)?;
        let schedule: [&[Move]; 2] = [&self.schedule, &[]];
        let (name, property) = (self.subject.method.name(), self.property.name());
        Ok(LitmusToken::new(name, property, &self.litmus, self.conditions, schedule, &run))
    }
}

pub(in crate::explore) fn unfit(problem: &str) -> Error {
    Error::new("TOKEN", format!("the token {problem}"))
}
