//! Replaying a token and showing it: one column per invocation, the words that change, and the step from which on every
//! continuation is wrong.

pub mod minimise;
pub mod run;
pub mod slabs;
pub mod timeline;
pub mod token;
pub mod watch;
pub mod words;

use self::run::{Event, OUTSIDE, Run, Runner, run};
use self::token::LitmusToken;
use self::words::{describe, label};
use super::program::case::Case;
use super::program::controls;
use super::program::litmus::Litmus;
use super::program::machine::Conditions;
use super::program::schedule::Move;
use super::program::subject::Subject;
use super::search::explored::Limits;
use super::search::property::Property;
use crate::catalogue::Catalogue;
use crate::error::{Error, Result};
use crate::memory::Address;
use crate::memory::asked::Action;
use crate::scheme::task::Task;

/// A token's run.
#[derive(Clone, Debug)]
pub struct Replay {
    /// What happened.
    pub run: Run,
    /// The number of steps from which on every continuation is wrong; `None` if it cannot be determined.
    pub doomed_after: Option<usize>,
    /// Steps at the end that repeat forever.
    pub cycle: usize,
}

/// The most states searched for each step in question.
const MOST_STATES: usize = 300_000;

/// The token of a schedule of a litmus pixel, for its outcome: it need not break any property.
///
/// # Errors
/// A move that is impossible: the schedule belongs to something else.
pub fn of_outcome(
    subject: &Subject,
    litmus: &Litmus,
    conditions: Conditions,
    schedule: &[Move],
) -> Result<LitmusToken> {
    let run = run(&subject.case(litmus), conditions, schedule)?;
    let (method, moves) = (subject.contract.name, [schedule, &[]]);
    Ok(LitmusToken::new(method, LitmusToken::OUTCOME, litmus, conditions, moves, &run))
}

/// Replay a token of a method of the catalogue.
///
/// # Errors
/// An unknown method, or operations that are not the token's: the method has changed since.
pub fn replay(catalogue: &Catalogue, token: &LitmusToken) -> Result<Replay> {
    replay_of(&controls::find(catalogue, "TOKEN", &token.method)?, token)
}

/// Replay a token with this method, whatever name the token has.
///
/// # Errors
/// Operations that are not the token's.
pub fn replay_of(subject: &Subject, token: &LitmusToken) -> Result<Replay> {
    let case = subject.case(&token.litmus);
    let schedule = token.schedule();
    let run = run(&case, token.conditions(), &schedule)
        .map_err(|e| Error::new("TOKEN", format!("the token's {e}")))?;
    token.verify(&run)?;
    let wrong_end = run.end.is_some() && run.wrong.iter().any(|(p, _)| is_of_result(*p));
    let doomed_after =
        wrong_end.then(|| doomed_after(&case, token.conditions(), &schedule)).flatten();
    Ok(Replay { run, doomed_after, cycle: token.cycle() })
}

fn is_of_result(property: Property) -> bool {
    matches!(property, Property::Keeps | Property::Intact | Property::Accounting)
}

/// The first number of steps after which every continuation is wrong: found by bisection, since a wrong state stays
/// wrong.
fn doomed_after(case: &Case, conditions: Conditions, schedule: &[Move]) -> Option<usize> {
    let limits = Limits { states: MOST_STATES, cancelled: &|| false };
    let right_after = |steps: usize| {
        let mut runner = Runner::new(case, conditions);
        schedule[..steps].iter().for_each(|&by| {
            runner.step(by);
        });
        runner.can_still_be_right(&limits)
    };
    if !right_after(0)? {
        return None;
    }
    let (mut right, mut doomed) = (0, schedule.len());
    while doomed - right > 1 {
        let middle = usize::midpoint(right, doomed);
        if right_after(middle)? {
            right = middle;
        } else {
            doomed = middle;
        }
    }
    Some(doomed)
}

impl Replay {
    /// The interleaving as rows of cells: step, one column per invocation, what the word then holds, and what is wrong.
    #[must_use]
    pub fn table(&self) -> Vec<Vec<String>> {
        let mut heading = vec!["step".to_owned()];
        let first = self.run.events.first().map_or(0, |event| event.stage);
        heading.extend(self.names(first));
        heading.push("word".to_owned());
        heading.push(String::new());
        let mut rows = vec![heading];
        let (steps, mut stage) = (self.run.events.len(), first);
        for (i, event) in self.run.events.iter().enumerate() {
            if event.stage != stage {
                stage = event.stage;
                let name = self.run.stages[stage % self.run.stages.len()].name;
                let mut row = vec![format!("{name}:")];
                row.extend(self.names(stage));
                rows.push(row);
            }
            if self.cycle > 0 && i + self.cycle == steps {
                rows.push(vec!["forever:".to_owned()]);
            }
            rows.push(self.row(i, event));
        }
        rows
    }

    /// The invocations of a stage.
    fn names(&self, stage: usize) -> Vec<String> {
        let Some(stage) = self.run.stages.get(stage % self.run.stages.len().max(1)) else {
            return Vec::new();
        };
        let all = stage.tasks.iter().enumerate();
        all.map(|(i, task)| name(i, *task, stage.is_helper(i))).collect()
    }

    fn row(&self, step: usize, event: &Event) -> Vec<String> {
        let mut row = vec![(step + 1).to_string()];
        let invocation = usize::from(event.by.invocation);
        row.resize(1 + invocation, String::new());
        row.push(told(event));
        let width = self.run.stages.first().map_or(0, |stage| stage.tasks.len());
        row.resize(1 + width, String::new());
        row.push(word(event));
        let mut remarks: Vec<String> = event.wrong.iter().map(|(_, told)| told.clone()).collect();
        if self.doomed_after == Some(step + 1) {
            remarks.insert(0, "<- from here on, every continuation is wrong".to_owned());
        }
        row.push(remarks.join("; "));
        row
    }

    /// How the run ended, and what was wrong with its end; one line each.
    #[must_use]
    pub fn ending(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(end) = &self.run.end {
            for (pixel, held) in end.pixels.iter().enumerate() {
                lines.push(format!("pixel {pixel} holds {held}"));
            }
        }
        let wrong = self.run.wrong.iter();
        lines.extend(wrong.map(|(property, told)| format!("{}: {told}", property.name())));
        lines
    }
}

fn name(invocation: usize, task: Task, helper: bool) -> String {
    let helper = if helper { " helper" } else { "" };
    match task {
        Task::Store(f) | Task::Prepare(_, f) => {
            format!("{} {:x}/{:x}{helper}", label(invocation), f.depth, f.data)
        }
        Task::Screen(_, pixel) => format!("pixel {pixel}"),
        Task::Frame(_, index) => format!("#{index}"),
        Task::Idle => String::new(),
        Task::Clear(pixel) => format!("clear {pixel}"),
        Task::ClearFrame => "clear frame".to_owned(),
        Task::Resolve(pixel) => format!("resolve {pixel}"),
    }
}

fn told(event: &Event) -> String {
    let ended = event.ended.as_ref().map(|how| format!(", {how}")).unwrap_or_default();
    match &event.operation {
        None if event.wrong.iter().any(|(property, _)| *property == Property::Panics) => {
            "panics".to_owned()
        }
        None => format!("merge{ended}"),
        Some((_, action)) => {
            let result = match action {
                Action::Write(..) => String::new(),
                _ => format!(" = {:x}", event.result),
            };
            format!("{}{result}{ended}", describe(*action))
        }
    }
}

/// The word, and what it holds now if it was written.
fn word(event: &Event) -> String {
    let Some((at, action)) = &event.operation else { return String::new() };
    let name = word_name(at);
    match action {
        Action::Read(_) => name,
        Action::Write(value, _) => format!("{name} := {value:x}"),
        Action::Update(update, _) if update.failed(event.result) => name,
        Action::Update(update, _) => {
            let mask = if at.bits == 32 { 0xFFFF_FFFF } else { u64::MAX };
            format!("{name} := {:x}", update.apply(event.result) & mask)
        }
    }
}

fn word_name(at: &Address) -> String {
    let width = if at.bits == 64 { "L" } else { "" };
    match at.pixel {
        _ if *at == OUTSIDE => "outside".to_owned(),
        Some(pixel) => format!("p{pixel}[{}]{width}", at.word),
        None => format!("frame[{}]{width}", at.word),
    }
}
