//! Running a schedule, step by step, recording everything that happens.

use super::watch::{Memory, Watch};
use super::words::{describe, label};
use crate::error::{Error, Result};
use crate::explore::memory::model::{self, Race};
use crate::explore::program::case::Case;
use crate::explore::program::forest::{NodeId, Step};
use crate::explore::program::litmus::Stage;
use crate::explore::program::machine::{Conditions, Final, Machine, Stop};
use crate::explore::program::schedule::Move;
use crate::explore::search::explored::Limits;
use crate::explore::search::property::{self, Property};
use crate::explore::search::space::Space;
use crate::memory::asked::{Action, Site};
use crate::memory::{Address, Numbering};
use crate::scheme::Moment;
use crate::scheme::course;
use crate::scheme::task::{Ended, Task};

/// The word of an access outside of the method's words that is dropped.
pub(super) const OUTSIDE: Address = Address { pixel: None, word: u64::MAX, bits: 0 };

/// One step of a run.
#[derive(Clone, Debug)]
pub struct Event {
    /// Stages before this step, over all rounds.
    pub stage: usize,
    /// Which invocation moved, and how.
    pub by: Move,
    /// What it did, and to which word: of an access outside of a buffer the last one, if it is clamped to that.
    /// `None` for leaving a block.
    pub operation: Option<(Address, Action)>,
    /// The value read, or 0.
    pub result: u64,
    /// The place in the source.
    pub site: Option<Site>,
    /// How the invocation ended, if it did.
    pub ended: Option<String>,
    /// It goes back to try again.
    pub spins: bool,
    /// The step that it races with, counted from 0.
    pub races_with: Option<usize>,
    /// What is wrong with this step or the state after it.
    pub wrong: Vec<(Property, String)>,
}

/// A run of a schedule.
#[derive(Clone, Debug)]
pub struct Run {
    /// The steps.
    pub events: Vec<Event>,
    /// The invocations of every stage between two barriers, the same number in each.
    pub stages: Vec<Stage>,
    /// How it ended, if every invocation did.
    pub end: Option<Final>,
    /// What is wrong with the end.
    pub wrong: Vec<(Property, String)>,
}

impl Run {
    /// Everything that went wrong, in order.
    pub fn violations(&self) -> impl Iterator<Item = &(Property, String)> {
        self.events.iter().flat_map(|event| &event.wrong).chain(&self.wrong)
    }
}

/// Runs one instance, move by move.
pub(in crate::explore) struct Runner<'a> {
    machine: Machine<'a>,
    nodes: Vec<NodeId>,
    state: Vec<u32>,
    events: Vec<Event>,
    /// Follows memory, where that is asked for.
    watch: Option<Watch>,
    /// An invocation has panicked: nothing follows.
    is_over: bool,
}

impl<'a> Runner<'a> {
    pub(in crate::explore) fn new(case: &'a Case, conditions: Conditions) -> Self {
        let machine = Machine::new(case, conditions, false);
        let state = machine.initial().to_vec();
        let nodes = state[..machine.width].to_vec();
        Self { machine, nodes, state, events: Vec::new(), watch: None, is_over: false }
    }

    /// The same, with an eye on memory.
    fn watched(case: &'a Case, conditions: Conditions) -> Self {
        let mut runner = Self::new(case, conditions);
        runner.machine.load(&runner.state);
        runner.watch = Some(Watch::new(&runner.machine, &runner.nodes));
        runner
    }

    /// Bits of the invocations that can go on.
    pub(in crate::explore) fn live(&self) -> u32 {
        if self.is_over { 0 } else { self.machine.live(&self.nodes) }
    }

    /// The number of the present stage, over all rounds.
    pub(in crate::explore) fn stage(&self) -> usize {
        self.machine.stage_number()
    }

    /// The number of a stage of the method's course, if it is one of those that are explored.
    pub(in crate::explore) fn number_of(&self, at: course::At) -> Option<usize> {
        self.machine.number_of(at)
    }

    /// In how many ways an invocation can move.
    pub(in crate::explore) fn alternatives(&mut self, invocation: usize) -> usize {
        self.machine.load(&self.state);
        self.machine.alternatives(&self.nodes, invocation)
    }

    /// Whether the node where an invocation is repeats an attempt.
    pub(in crate::explore) fn waits(&self, invocation: usize) -> bool {
        self.machine.forest.node(self.nodes[invocation]).waits
    }

    /// Move; `None` if the invocation cannot make this move.
    pub(in crate::explore) fn step(&mut self, by: Move) -> Option<&Event> {
        let invocation = usize::from(by.invocation);
        let node = *self.nodes.get(invocation)?;
        if usize::from(by.alternative) >= self.alternatives(invocation) {
            return None;
        }
        let (step, site) = {
            let node = self.machine.forest.node(node);
            (node.step, node.site)
        };
        if self.is_over {
            return None;
        }
        if let Some(watch) = &mut self.watch {
            watch.before(&self.machine, step, by);
        }
        let moved = self.machine.perform(node, by);
        if moved.stop == Some(Stop::NoRoom) {
            return None;
        }
        if let Some(watch) = &mut self.watch {
            watch.performed(&self.machine, step, by, moved.result);
        }
        self.is_over = moved.stop == Some(Stop::Panic);
        let races_with = moved.race.and_then(|race| self.racing(race));
        let mut wrong: Vec<(Property, String)> =
            moved.fault.into_iter().map(|f| (f.property(), self.machine.told(node, f))).collect();
        let race = moved.race.map(|race| self.race(by, race, races_with));
        wrong.extend(race.map(|told| (Property::RaceFree, told)));
        let mut event = Event {
            stage: self.machine.stage_number(),
            by,
            operation: self.operation(step, by),
            result: moved.result,
            site,
            ended: self.ended(moved.node),
            spins: moved.stop.is_none() && self.machine.forest.goes_back(node, moved.result),
            races_with,
            wrong,
        };
        let width = self.nodes.len();
        self.machine.place(&mut self.state[..width], by, moved.node);
        self.state.truncate(self.machine.head());
        let at_barrier = self.machine.settle(&mut self.state);
        event.wrong.extend(at_barrier.map(|told| (Property::Invariant, told)));
        self.nodes.copy_from_slice(&self.state[..width]);
        self.look(&mut event.wrong);
        if let Some(watch) = &mut self.watch {
            watch.settled(&self.machine, &self.nodes);
        }
        self.events.push(event);
        self.events.last()
    }

    /// Make these moves.
    fn follow(&mut self, schedule: &[Move]) -> Result<()> {
        for (i, &by) in schedule.iter().enumerate() {
            if self.step(by).is_none() {
                let problem =
                    format!("step {} is impossible: the schedule belongs to something else", i + 1);
                return Err(Error::new("schedule", problem));
            }
        }
        Ok(())
    }

    /// The word that a step accesses, and how. A helper's update has alternatives of its own, and no word if it is
    /// outside.
    fn operation(&self, step: Step, by: Move) -> Option<(Address, Action)> {
        let Step::Operation(cell, action) = step else { return None };
        let helps = self.machine.is_helper(by.invocation.into())
            && !matches!(action, Action::Read(_))
            && Numbering::is_outside(cell);
        let accessed = self.machine.accessed(cell, by.alternative).filter(|_| !helps);
        let address = accessed.map(|(cell, _)| self.machine.numbering().address(cell));
        Some((address.unwrap_or(OUTSIDE), action))
    }

    fn ended(&self, node: NodeId) -> Option<String> {
        let Step::Ended(end) = self.machine.forest.node(node).step else { return None };
        Some(match self.machine.forest.ended(end) {
            Ended::Done => "done".to_owned(),
            Ended::Stored(outcome) => format!("{outcome:?}").to_lowercase(),
            Ended::Resolved(_, held, _) => held.to_string(),
        })
    }

    /// The earlier step of a race.
    fn racing(&self, race: Race) -> Option<usize> {
        let name = self.machine.numbering().address(race.cell);
        let matches = |event: &Event| {
            let Some((at, action)) = event.operation else { return false };
            let writes = model::writes(action, event.result);
            let plain = model::order_of(action).is_none();
            usize::from(event.by.invocation) == race.other
                && at == name
                && writes == race.other_writes
                && plain == race.other_plain
        };
        self.events.iter().rposition(matches)
    }

    /// Both accesses of a race, in words.
    fn race(&self, by: Move, race: Race, with: Option<usize>) -> String {
        let name = self.machine.numbering().address(race.cell);
        let earlier = with.map(|step| &self.events[step]);
        let place = match name.pixel {
            Some(pixel) => format!("pixel {pixel}, word {}", name.word),
            None => format!("frame word {}", name.word),
        };
        let site = |site: Option<Site>| site.map_or_else(String::new, |s| format!(" at {s}"));
        let own = self.machine.forest.node(self.nodes[usize::from(by.invocation)]);
        let own_action = match own.step {
            Step::Operation(_, action) => describe(action),
            _ => String::new(),
        };
        format!(
            "data race in {}, {place}: {} of {}{} and {} of {}{} are not ordered",
            self.machine.contract.name,
            earlier.and_then(|e| e.operation).map_or_else(String::new, |o| describe(o.1)),
            self.name(race.other),
            site(earlier.and_then(|e| e.site)),
            own_action,
            self.name(usize::from(by.invocation)),
            site(own.site),
        )
    }

    /// An invocation in words.
    fn name(&self, invocation: usize) -> String {
        let stage = self.machine.stage();
        let helper = if stage.is_helper(invocation) { "helper " } else { "" };
        match stage.tasks[invocation] {
            Task::Store(f) | Task::Prepare(_, f) => {
                format!("{helper}fragment {} ({:x}/{:x})", label(invocation), f.depth, f.data)
            }
            Task::Clear(p) => format!("the clear of pixel {p}"),
            Task::ClearFrame => "the clear of the frame".to_owned(),
            Task::Screen(_, p) => format!("'{}' of pixel {p}", stage.name),
            Task::Frame(_, i) => format!("'{}' number {i}", stage.name),
            Task::Resolve(p) => format!("the resolve of pixel {p}"),
            Task::Idle => "no invocation".to_owned(),
        }
    }

    /// Check the state after a step.
    fn look(&mut self, wrong: &mut Vec<(Property, String)>) {
        self.machine.load(&self.state);
        let mut all = 0;
        for own in (0..self.nodes.len()).map(|i| self.machine.held(&self.nodes, i)) {
            if all & own != 0 {
                let message = "two invocations hold the same lock".to_owned();
                wrong.push((Property::MutualExclusion, message));
            }
            all |= own;
        }
        if self.machine.is_sequential()
            && self.machine.is_in_passes()
            && let Err(message) = self.machine.invariant(Moment::Always)
        {
            wrong.push((Property::Invariant, message));
        }
    }

    /// The whole run, whether or not all invocations have ended.
    pub(in crate::explore) fn finish(mut self) -> Run {
        let (mut end, mut wrong) = (None, Vec::new());
        if !self.is_over && self.live() == 0 {
            self.machine.load(&self.state);
            if self.machine.is_in_passes()
                && let Err(message) = self.machine.invariant(Moment::Quiet)
            {
                wrong.push((Property::Invariant, message));
            }
            end = self.machine.finish(&self.nodes);
            let judged = end.iter().flat_map(|end| property::judge(self.machine.case, end));
            wrong.extend(judged);
        }
        Run { events: self.events, stages: self.machine.stages, end, wrong }
    }

    /// Whether some continuation from the present state ends with nothing wrong: with the expected lists, and with none
    /// of the faults that the explorer knows. `None` beyond the limit of states, or of what memory has room for.
    pub(in crate::explore) fn can_still_be_right(&mut self, limits: &Limits<'_>) -> Option<bool> {
        let mut space = Space::new();
        let start = self.state.clone();
        let count = self.nodes.len();
        space.insert(&start, 0, Move { invocation: 0, alternative: 0 });
        let (mut at, mut lost) = (0, false);
        while at < space.len() {
            if space.len() > limits.states {
                return None;
            }
            let state = space.get(at as u32).to_vec();
            let nodes = state[..count].to_vec();
            self.machine.load(&state);
            if self.machine.live(&nodes) == 0 {
                let end = self.machine.finish(&nodes);
                if end.is_some_and(|end| property::judge(self.machine.case, &end).is_empty()) {
                    return Some(true);
                }
            }
            for invocation in 0..count {
                self.machine.load(&state);
                for alternative in 0..self.machine.alternatives(&nodes, invocation) {
                    self.machine.load(&state);
                    let by = Move { invocation: invocation as u8, alternative: alternative as u16 };
                    let moved = self.machine.perform(nodes[invocation], by);
                    lost |= moved.stop == Some(Stop::NoRoom);
                    if moved.stop.is_some() {
                        continue;
                    }
                    let mut next = state[..self.machine.head()].to_vec();
                    self.machine.place(&mut next[..count], by, moved.node);
                    self.machine.settle(&mut next);
                    space.insert(&next, at as u32, by);
                }
            }
            at += 1;
        }
        (!lost).then_some(false)
    }
}

/// Run a schedule.
///
/// # Errors
/// A move that is impossible: the schedule belongs to something else.
pub(in crate::explore) fn run(
    case: &Case,
    conditions: Conditions,
    schedule: &[Move],
) -> Result<Run> {
    let mut runner = Runner::new(case, conditions);
    runner.follow(schedule)?;
    Ok(runner.finish())
}

/// The same, with what memory held before the first step, and what every step found and left there. It takes time for
/// every word at every step.
pub(super) fn run_watched(
    case: &Case,
    conditions: Conditions,
    schedule: &[Move],
) -> Result<(Run, Memory)> {
    let mut runner = Runner::watched(case, conditions);
    runner.follow(schedule)?;
    let memory = runner.watch.take().map(Watch::memory).unwrap_or_default();
    Ok((runner.finish(), memory))
}
