//! A timeline from a token.

use super::super::run::{Event, OUTSIDE, Run, run_watched};
use super::super::token::{LitmusToken, Token};
use super::super::watch::{self, Memory, Seen};
use super::super::words::label;
use super::super::{Replay, name, replay_of, told, word_name};
use super::causes::fault;
use super::{
    Change, Fences, Fragment, Lane, Locking, Operation, Ordering, Pixel, Source, Stage, Step, Task,
    Timeline, VERSION, Version, Word, Wrong,
};
use crate::catalogue::Catalogue;
use crate::error::{Error, Result};
use crate::explore::memory::model::{MemoryModel, order_of};
use crate::explore::program::case::Case;
use crate::explore::program::controls;
use crate::explore::program::litmus::Entry;
use crate::explore::program::subject::Subject;
use crate::explore::search::property::{Property, overflows};
use crate::fragment::Fragment as Stored;
use crate::memory::asked::Action;
use crate::memory::{Access, Address, Order, Update};
use crate::scheme::contract::Extra;
use crate::scheme::task::Task as Asked;

/// The most steps that a timeline has: nobody looks through more.
pub const MOST_STEPS: usize = 10_000;

/// The timeline of a token of a method of the catalogue.
///
/// # Errors
/// An unknown method, operations that are not the token's, or more than [`MOST_STEPS`] steps.
pub fn timeline(catalogue: &Catalogue, token: &LitmusToken) -> Result<Timeline> {
    timeline_of(&controls::find(catalogue, "TOKEN", &token.method)?, token)
}

/// The timeline of a token with this method, whatever name the token has.
///
/// # Errors
/// Operations that are not the token's, or more than [`MOST_STEPS`] steps.
pub fn timeline_of(subject: &Subject, token: &LitmusToken) -> Result<Timeline> {
    let schedule = token.schedule();
    if schedule.len() > MOST_STEPS {
        let steps = schedule.len();
        let problem = format!("has {steps} steps, and a timeline at most {MOST_STEPS}: --minimise");
        return Err(Error::new("TOKEN", problem));
    }
    let replayed = replay_of(subject, token)?;
    let case = subject.case(&token.litmus);
    let (run, memory) = run_watched(&case, token.conditions(), &schedule)?;
    let maker =
        Maker { case: &case, token, run: &run, memory: &memory, shown: shown(&memory, &run) };
    Ok(maker.timeline(&replayed))
}

/// The words that a timeline shows, by their places in the layout: those that are accessed, or do not keep their first
/// value.
fn shown(memory: &Memory, run: &Run) -> Vec<usize> {
    let accessed =
        |at: &Address| run.events.iter().any(|e| e.operation.is_some_and(|o| o.0 == *at));
    let changes = || memory.steps.iter().flat_map(|seen| &seen.changes);
    let newest = |change: &watch::Change| change.versions.last().and_then(|version| version.value);
    let changed = |word: usize, first: Option<u64>| {
        changes().any(|change| change.word == word && newest(change) != first)
    };
    let all = memory.initial.iter().enumerate();
    let shown = all.filter(|(i, (at, first))| accessed(at) || changed(*i, *first));
    shown.map(|(i, _)| i).collect()
}

/// Hexadecimal, as everywhere.
fn hex(value: u64) -> String {
    format!("{value:x}")
}

/// A run and what is known about it.
struct Maker<'a> {
    case: &'a Case,
    token: &'a LitmusToken,
    run: &'a Run,
    memory: &'a Memory,
    /// Places in the layout of the words that are shown.
    shown: Vec<usize>,
}

impl Maker<'_> {
    fn timeline(&self, replayed: &Replay) -> Timeline {
        let (token, conditions) = (self.token, self.token.conditions());
        let stages = self.stages();
        let stage = |i: usize| stages.partition_point(|stage| stage.first <= i + 1) - 1;
        let steps: Vec<Step> = (0..self.run.events.len()).map(|i| self.step(i, stage(i))).collect();
        let mut timeline = Timeline {
            version: VERSION,
            token: Token::Litmus(token.clone()).to_string(),
            method: token.method.clone(),
            title: self.case.contract.title.to_owned(),
            property: token.property.clone(),
            instance: token.litmus.describe(),
            pixels: token.litmus.pixels,
            k: token.litmus.k,
            memory: conditions.memory.name().to_owned(),
            profile: conditions.memory.profile().map(str::to_owned),
            warp: conditions.warp,
            lanes: self.run.stages.first().map_or(0, |stage| stage.tasks.len()),
            fragments: self.fragments(),
            stages,
            words: self.shown.iter().map(|&word| self.word(word)).collect(),
            steps,
            cycle: replayed.cycle,
            doomed_after: replayed.doomed_after,
            fault: None,
            result: (0..token.litmus.pixels).map(|pixel| self.pixel(pixel)).collect(),
        };
        timeline.fault = fault(&timeline, self.run);
        timeline
    }

    fn fragments(&self) -> Vec<Fragment> {
        let (litmus, extra) = (&self.token.litmus, self.case.contract.extra);
        let fates = self.run.events.iter().filter_map(|event| Some((event, event.ended.as_ref()?)));
        let fates: Vec<(Option<usize>, &String)> = fates
            .filter(|(event, _)| matches!(self.task(event), Asked::Store(_)))
            .map(|(event, told)| (self.fragment(event.stage, event.by.invocation.into()), told))
            .collect();
        let entry = |(i, entry): (usize, &Entry)| Fragment {
            name: label(i).to_string(),
            pixel: entry.0,
            depth: hex(entry.1.into()),
            data: hex(entry.2.into()),
            primitive: (extra == Extra::Primitive).then_some(entry.3),
            thickness: (extra == Extra::Near).then(|| hex(entry.3.into())),
            fate: fates.iter().rev().find(|fate| fate.0 == Some(i)).map(|fate| fate.1.clone()),
        };
        litmus.fragments.iter().enumerate().map(entry).collect()
    }

    /// What the invocation of a step does.
    fn task(&self, event: &Event) -> Asked {
        let stages = &self.run.stages;
        let stage = &stages[event.stage % stages.len()];
        let invocation = usize::from(event.by.invocation);
        // A helper's end says nothing of its fragment.
        if stage.is_helper(invocation) { Asked::Idle } else { stage.tasks[invocation] }
    }

    /// The fragment of an invocation: the one that it is equal to; of several, the one with its place among them.
    fn fragment(&self, stage: usize, invocation: usize) -> Option<usize> {
        let stage = &self.run.stages[stage % self.run.stages.len()];
        let of = |task: Asked| match task {
            Asked::Store(fragment) | Asked::Prepare(_, fragment) => Some(fragment),
            _ => None,
        };
        let own = of(stage.tasks[invocation])?;
        let helper = stage.is_helper(invocation);
        let same =
            |i: &usize| stage.tasks[*i] == stage.tasks[invocation] && stage.is_helper(*i) == helper;
        let before = (0..invocation).filter(same).count();
        let all: Vec<Stored> = self.token.litmus.fragments(self.case.contract).collect();
        all.iter().enumerate().filter(|(_, f)| **f == own).map(|(i, _)| i).nth(before)
    }

    fn stages(&self) -> Vec<Stage> {
        let mut stages: Vec<Stage> = Vec::new();
        let count = self.run.stages.len();
        for (i, event) in self.run.events.iter().enumerate() {
            if i > 0 && self.run.events[i - 1].stage == event.stage {
                continue;
            }
            let stage = &self.run.stages[event.stage % count];
            let lane = |(invocation, task): (usize, &Asked)| {
                let helper = stage.is_helper(invocation);
                let (kind, pixel) = match *task {
                    Asked::Idle => (Task::Idle, None),
                    Asked::ClearFrame => (Task::Clear, None),
                    Asked::Clear(pixel) => (Task::Clear, Some(pixel)),
                    Asked::Prepare(_, fragment) => (Task::Prepare, Some(fragment.pixel)),
                    Asked::Screen(_, pixel) => (Task::Screen, Some(pixel)),
                    Asked::Frame(..) => (Task::Frame, None),
                    Asked::Store(fragment) => (Task::Store, Some(fragment.pixel)),
                    Asked::Resolve(pixel) => (Task::Resolve, Some(pixel)),
                };
                Lane {
                    name: name(invocation, *task, helper),
                    task: kind,
                    pixel,
                    fragment: self.fragment(event.stage, invocation),
                    helper,
                }
            };
            stages.push(Stage {
                name: stage.name.to_owned(),
                round: event.stage / count,
                first: i + 1,
                lanes: stage.tasks.iter().enumerate().map(lane).collect(),
            });
        }
        stages
    }

    fn word(&self, word: usize) -> Word {
        let (address, initial) = &self.memory.initial[word];
        let name = self.case.instance.layout().name_of(*address);
        let several = self.token.litmus.pixels > 1;
        let place = address.pixel.filter(|_| several).map(|pixel| format!("p{pixel} "));
        let named = name.map(|name| place.unwrap_or_default() + &name);
        let address_name = word_name(address);
        Word {
            name: named.unwrap_or_else(|| address_name.clone()),
            address: address_name,
            pixel: address.pixel,
            bits: address.bits,
            lock: self.is_lock(address),
            initial: initial.map(hex),
        }
    }

    fn is_lock(&self, at: &Address) -> bool {
        let locks = self.case.instance.layout().locks();
        at.pixel.is_some() && at.bits == 32 && locks.contains(&at.word)
    }

    /// A word by its place among those that are shown.
    fn place(&self, at: &Address) -> Option<usize> {
        self.shown.iter().position(|&word| self.memory.initial[word].0 == *at)
    }

    fn step(&self, i: usize, stage: usize) -> Step {
        let (event, seen) = (&self.run.events[i], &self.memory.steps[i]);
        let action = event.operation.map(|(_, action)| action);
        let at = event.operation.map(|(at, _)| at).filter(|at| *at != OUTSIDE);
        let wrong = event.wrong.iter().map(|(property, told)| wrong(*property, told));
        let [operand, expected] = action.map_or([None; 2], operands);
        let reads = action.is_some_and(|action| !matches!(action, Action::Write(..)));
        let mut step = Step {
            number: i + 1,
            stage,
            lane: event.by.invocation.into(),
            operation: operation(event),
            order: action.map(ordering),
            fences: action.and_then(|action| self.fences(action)),
            word: at.and_then(|at| self.place(&at)),
            outside: event.wrong.iter().any(|(property, _)| *property == Property::Bounds),
            operand: operand.map(hex),
            expected: expected.map(hex),
            succeeded: expected.map(|expected| expected == event.result),
            read: reads.then(|| hex(event.result)),
            read_from: seen.read.as_ref().map(|source| Source {
                step: source.step.map(|step| step + 1),
                newer: source.newer.iter().map(|step| step + 1).collect(),
            }),
            before: seen.before.map(hex),
            written: seen.wrote.map(hex),
            lock: at.filter(|at| self.is_lock(at)).and_then(|_| locking(action?, event.result)),
            spins: event.spins,
            site: event.site.map(|site| site.to_string()),
            text: told(event),
            short: String::new(),
            ends: event.ended.clone(),
            changes: self.changes(seen),
            wrong: wrong.collect(),
        };
        step.short = self.short(&step);
        step
    }

    /// A step in few letters.
    fn short(&self, step: &Step) -> String {
        let name = match step.operation {
            Operation::Load => "load",
            Operation::Store => "store",
            Operation::Exchange => "exchange",
            Operation::CompareExchange => "cas",
            Operation::Add => "add",
            Operation::And => "and",
            Operation::Or => "or",
            Operation::Min => "min",
            Operation::Max => "max",
            Operation::Merge => "merge",
            Operation::Panic => "panic",
        };
        let order = match step.order {
            None | Some(Ordering::Plain | Ordering::Relaxed) => "",
            Some(Ordering::Acquire) => ".acquire",
            Some(Ordering::Release) => ".release",
            Some(Ordering::AcqRel) => ".acq-rel",
        };
        let word = match step.word {
            Some(word) => format!(" {}", self.word(self.shown[word]).name),
            None if step.outside => " outside".to_owned(),
            None => String::new(),
        };
        let value = match (&step.read, &step.written, &step.operand) {
            (Some(read), Some(written), _) => format!(" {read} -> {written}"),
            (Some(read), None, _) => format!(" = {read}"),
            (None, Some(written), _) => format!(" := {written}"),
            // A write that has no effect.
            (None, None, Some(operand)) => format!(" := {operand}, without effect"),
            (None, None, None) => String::new(),
        };
        let end = step.ends.as_ref().map_or_else(String::new, |ends| format!(", {ends}"));
        format!("{name}{order}{word}{value}{end}")
    }

    fn changes(&self, seen: &Seen) -> Vec<Change> {
        let relaxed = self.token.conditions().memory != MemoryModel::Sequential;
        let version = |version: &watch::Version| Version {
            value: version.value.map(hex),
            by: version.by.map(|step| step + 1),
        };
        let change = |change: &watch::Change| {
            let word = self.shown.iter().position(|&word| word == change.word)?;
            Some(Change {
                word,
                value: change.versions.last().and_then(|version| version.value).map(hex),
                versions: change.versions.iter().filter(|_| relaxed).map(version).collect(),
                oldest: change.oldest.clone(),
            })
        };
        seen.changes.iter().filter_map(change).collect()
    }

    fn fences(&self, action: Action) -> Option<Fences> {
        let MemoryModel::Relaxed(profile) = self.token.conditions().memory else { return None };
        let (_, fences) = profile.order(order_of(action)?);
        let [before, after] = [fences.before, fences.after];
        (before || after).then_some(Fences { before, after })
    }

    fn pixel(&self, pixel: u32) -> Pixel {
        let open = overflows(self.case.contract, &self.case.litmus);
        let expected = if open { None } else { self.case.expected(pixel) };
        let possible = if expected.is_some() { Vec::new() } else { self.case.possible(pixel) };
        let found = self.run.end.as_ref().and_then(|end| end.pixels.get(pixel as usize));
        Pixel {
            pixel,
            expected: expected.map(|held| held.to_string()),
            possible: possible.iter().map(ToString::to_string).collect(),
            found: found.map(ToString::to_string),
        }
    }
}

/// What is wrong, in words.
pub(super) fn wrong(property: Property, told: &str) -> Wrong {
    Wrong { property: property.name().to_owned(), message: told.to_owned() }
}

fn operation(event: &Event) -> Operation {
    let panics = event.wrong.iter().any(|(property, _)| *property == Property::Panics);
    match event.operation {
        None if panics => Operation::Panic,
        None => Operation::Merge,
        Some((_, Action::Read(_))) => Operation::Load,
        Some((_, Action::Write(..))) => Operation::Store,
        Some((_, Action::Update(update, _))) => match update {
            Update::Exchange(_) => Operation::Exchange,
            Update::CompareExchange { .. } => Operation::CompareExchange,
            Update::Add(_) => Operation::Add,
            Update::And(_) => Operation::And,
            Update::Or(_) => Operation::Or,
            Update::Min(_) => Operation::Min,
            Update::Max(_) => Operation::Max,
        },
    }
}

fn ordering(action: Action) -> Ordering {
    match order_of(action) {
        None => Ordering::Plain,
        Some(Order::Relaxed) => Ordering::Relaxed,
        Some(Order::Acquire) => Ordering::Acquire,
        Some(Order::Release) => Ordering::Release,
        Some(Order::AcqRel) => Ordering::AcqRel,
    }
}

/// What an action writes or computes with, and what it expects.
fn operands(action: Action) -> [Option<u64>; 2] {
    match action {
        Action::Read(Access::Plain | Access::Atomic(_)) => [None, None],
        Action::Write(value, _) => [Some(value), None],
        Action::Update(Update::CompareExchange { expected, new }, _) => [Some(new), Some(expected)],
        Action::Update(
            Update::Exchange(value)
            | Update::Add(value)
            | Update::And(value)
            | Update::Or(value)
            | Update::Min(value)
            | Update::Max(value),
            _,
        ) => [Some(value), None],
    }
}

/// What an action does to a lock: free at 0.
fn locking(action: Action, found: u64) -> Option<Locking> {
    match action {
        Action::Read(_) => None,
        Action::Write(0, _) => Some(Locking::Unlocks),
        Action::Write(..) => None,
        Action::Update(update, _) => match (found, update.apply(found)) {
            (0, 0) => None,
            (0, _) => Some(Locking::Locks),
            (_, 0) => Some(Locking::Unlocks),
            _ => Some(Locking::FindsLocked),
        },
    }
}
