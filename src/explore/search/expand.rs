//! What follows from a state, and what is wrong with it: one machine's work, which several can do at once on states of
//! one search.

use std::collections::BTreeMap;
use std::ops::Range;

use super::explored::Stopped;
use super::property::{self, Property};
use super::space::{self, Offered, Space, StateId};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::forest::{NodeId, Step};
use crate::explore::program::guard::guarded;
use crate::explore::program::litmus::Stage;
use crate::explore::program::machine::{Conditions, Machine, Moved, Stop};
use crate::explore::program::schedule::Move;
use crate::scheme::task::Task;
use crate::scheme::{Held, Moment};

/// A machine, and which moves it makes.
#[derive(Clone)]
pub(super) struct Expander<'a> {
    pub(super) machine: Machine<'a>,
    /// By stage, runs of invocations with equal tasks; none if they are not to be put in order.
    pub(super) groups: Vec<Vec<Range<usize>>>,
    /// States have a bit for every invocation that has moved.
    pub(super) mark_movers: bool,
    /// One invocation after another.
    pub(super) one_by_one: bool,
}

/// How far a state was expanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expanded {
    /// All that follows was added.
    All,
    /// The machine has missed something in a table that it shares. What was found is right, what follows is not all.
    Missed,
    /// An invocation was cut off here: a loop without end. There is no point in going on.
    CutOff(NodeId),
}

/// The states that follow from some, one after another.
#[derive(Default)]
pub(super) struct Successors {
    words: Vec<u32>,
    all: Vec<Successor>,
    /// The one that is being made.
    next: Vec<u32>,
}

/// One of them.
#[derive(Clone, Copy)]
struct Successor {
    by: Move,
    hash: u64,
    /// Where it ends in the words.
    end: usize,
}

impl Successors {
    pub(super) fn clear(&mut self) {
        self.truncate(0);
    }

    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// Keep so many.
    fn truncate(&mut self, count: usize) {
        self.all.truncate(count);
        self.words.truncate(self.all.last().map_or(0, |last| last.end));
    }

    /// One of them, to be inserted.
    pub(super) fn offer(&self, index: usize, from: StateId) -> Offered<'_> {
        let begin = index.checked_sub(1).map_or(0, |before| self.all[before].end);
        let Successor { by, hash, end } = self.all[index];
        Offered { words: &self.words[begin..end], hash, from, by }
    }
}

/// What was found in some states: the first of each kind.
#[derive(Default)]
pub(super) struct Findings {
    pub(super) violations: BTreeMap<Property, (StateId, Option<Move>, String)>,
    /// Results, and the first state that ends with each.
    pub(super) outcomes: BTreeMap<Vec<Held>, StateId>,
    /// What ends the search early, or left something out.
    pub(super) stopped: Option<Stopped>,
}

impl Findings {
    /// The first state counts, and in one state the first message.
    fn violation(
        &mut self,
        property: Property,
        state: StateId,
        last: Option<Move>,
        message: impl FnOnce() -> String,
    ) {
        if self.violations.get(&property).is_none_or(|known| state < known.0) {
            self.violations.insert(property, (state, last, message()));
        }
    }

    fn outcome(&mut self, pixels: Vec<Held>, state: StateId) {
        let first = self.outcomes.entry(pixels).or_insert(state);
        *first = state.min(*first);
    }

    /// Add what was found elsewhere.
    pub(super) fn merge(&mut self, other: Self) {
        for (property, (state, last, message)) in other.violations {
            self.violation(property, state, last, || message);
        }
        other.outcomes.into_iter().for_each(|(pixels, state)| self.outcome(pixels, state));
        self.stopped = self.stopped.take().or(other.stopped);
    }
}

/// The part of a search that one machine did while others did theirs.
pub(super) struct Share {
    pub(super) successors: Successors,
    /// For every state, how many successors there are up to it; `None` for one that is still to be expanded.
    pub(super) upto: Vec<Option<usize>>,
    pub(super) findings: Findings,
    /// Some operation was left out for want of room.
    pub(super) full: bool,
}

impl<'a> Expander<'a> {
    pub(super) fn new(machine: Machine<'a>) -> Self {
        Self { machine, groups: Vec::new(), mark_movers: false, one_by_one: false }
    }

    /// The same, with invocations that do the same put in order, where nothing tells them apart.
    pub(super) fn symmetric(self) -> Self {
        let groups = match self.machine.conditions() {
            Conditions { memory: MemoryModel::Sequential, warp: None } => {
                self.machine.stages.iter().map(equals).collect()
            }
            _ => Vec::new(),
        };
        Self { groups, ..self }
    }

    /// Expand states that follow one another, as far as the machine's tables go.
    pub(super) fn share(&mut self, states: Range<usize>, space: &Space) -> Share {
        let mut share = Share {
            successors: Successors::default(),
            upto: Vec::new(),
            findings: Findings::default(),
            full: false,
        };
        for state in states {
            let id = state as StateId;
            let Share { successors, findings, .. } = &mut share;
            let before = successors.len();
            let expanded = guarded(|| self.expand(id, space.get(id), successors, findings));
            let is_done = expanded == Ok(Expanded::All);
            if !is_done {
                share.successors.truncate(before);
            }
            share.upto.push(is_done.then_some(share.successors.len()));
        }
        share.full = self.machine.is_full();
        share
    }

    /// Add what follows from a state, and what is wrong with it.
    pub(super) fn expand(
        &mut self,
        id: StateId,
        state: &[u32],
        into: &mut Successors,
        findings: &mut Findings,
    ) -> Expanded {
        let count = self.machine.width;
        self.machine.load(state);
        let nodes = &state[..count];
        let live = self.machine.live(nodes);
        if live == 0 {
            return self.ended(id, nodes, findings);
        }
        if self.machine.is_sequential()
            && self.machine.is_in_passes()
            && let Err(message) = self.machine.invariant(Moment::Always)
        {
            findings.violation(Property::Invariant, id, None, || message);
        }
        self.exclusion(id, nodes, findings);
        let movers = if self.one_by_one { self.begun(nodes, live) } else { live };
        for invocation in (0..count).filter(|i| movers & (1 << i) != 0) {
            let mut alternatives = 1;
            let mut alternative = 0;
            while alternative < alternatives {
                self.machine.load(state);
                if alternative == 0 {
                    alternatives = self.machine.alternatives(nodes, invocation);
                    if alternatives == 0 {
                        // It waits for other lanes, or it was cut off.
                        let node = nodes[invocation];
                        if self.machine.forest.node(node).step == Step::Endless {
                            return Expanded::CutOff(node);
                        }
                        break;
                    }
                }
                let by = Move { invocation: invocation as u8, alternative: alternative as u16 };
                let moved = self.machine.perform(nodes[invocation], by);
                if self.machine.take_missed() {
                    return Expanded::Missed;
                }
                if moved.stop != Some(Stop::NoRoom) {
                    self.judge_move(id, nodes[invocation], by, moved, findings);
                }
                if moved.stop.is_none()
                    && self.follow(id, state, by, moved, into, findings) == Expanded::Missed
                {
                    return Expanded::Missed;
                }
                alternative += 1;
            }
        }
        Expanded::All
    }

    /// The invocation that has begun and not ended; all live ones, if none has.
    fn begun(&mut self, nodes: &[NodeId], live: u32) -> u32 {
        let begun = (0..nodes.len()).find(|&i| {
            let task = self.machine.stage().tasks[i];
            live & (1 << i) != 0 && nodes[i] != self.machine.forest.root(task)
        });
        begun.map_or(live, |invocation| 1 << invocation)
    }

    /// Add the state after a move.
    #[inline]
    fn follow(
        &mut self,
        id: StateId,
        state: &[u32],
        by: Move,
        moved: Moved,
        into: &mut Successors,
        findings: &mut Findings,
    ) -> Expanded {
        let (count, head) = (self.machine.width, self.machine.head());
        let Successors { words, all, next } = into;
        next.clear();
        next.extend_from_slice(&state[..head]);
        self.machine.place(&mut next[..count], by, moved.node);
        if self.mark_movers {
            next[count] |= 1 << by.invocation;
        }
        let wrong = self.machine.settle(next);
        if self.machine.take_missed() {
            return Expanded::Missed;
        }
        if let Some(message) = wrong {
            findings.violation(Property::Invariant, id, Some(by), || message);
        }
        if let Some(groups) = self.groups.get(self.machine.stage_index()) {
            canonical(&mut next[..count], groups, &mut [0; 32]);
        }
        words.extend_from_slice(next);
        all.push(Successor { by, hash: space::hash(next), end: words.len() });
        Expanded::All
    }

    fn judge_move(
        &mut self,
        id: StateId,
        node: NodeId,
        by: Move,
        moved: Moved,
        findings: &mut Findings,
    ) {
        if let Some(fault) = moved.fault {
            let told = self.machine.told(node, fault);
            findings.violation(fault.property(), id, Some(by), || told);
        }
        if moved.stop == Some(Stop::Panic) {
            findings.stopped.get_or_insert(Stopped::Panics);
        }
        if moved.race.is_some() {
            findings.violation(Property::RaceFree, id, Some(by), || "a data race".to_owned());
        }
    }

    fn exclusion(&mut self, id: StateId, nodes: &[NodeId], findings: &mut Findings) {
        let mut held = 0;
        for invocation in 0..nodes.len() {
            let own = self.machine.held(nodes, invocation);
            if held & own != 0 {
                let message = || "two invocations hold the same lock".to_owned();
                findings.violation(Property::MutualExclusion, id, None, message);
            }
            held |= own;
        }
    }

    /// What is wrong with the end of a run.
    fn ended(&mut self, id: StateId, nodes: &[NodeId], findings: &mut Findings) -> Expanded {
        // Resolve must end, too.
        let end = self.machine.finish(nodes);
        if self.machine.take_missed() {
            return Expanded::Missed;
        }
        if self.mark_movers {
            return Expanded::All;
        }
        if self.machine.is_in_passes()
            && let Err(message) = self.machine.invariant(Moment::Quiet)
        {
            findings.violation(Property::Invariant, id, None, || message);
        }
        let Some(end) = end else { return Expanded::All };
        for (property, message) in property::judge(self.machine.case, &end) {
            findings.violation(property, id, None, || message);
        }
        findings.outcome(end.pixels, id);
        Expanded::All
    }
}

/// An invocation that was cut off at a node.
pub(super) fn endless(machine: &Machine<'_>, node: NodeId) -> Stopped {
    let site = machine.forest.node(node).site.map(ToString::to_string).unwrap_or_default();
    Stopped::Endless { site, operations: machine.litmus.most_operations() }
}

/// Runs of a stage's invocations with equal tasks; helpers separate.
fn equals(stage: &Stage) -> Vec<std::ops::Range<usize>> {
    let tasks = &stage.tasks;
    let same = |a: usize, b: usize| {
        tasks[a] == tasks[b] && stage.is_helper(a) == stage.is_helper(b) && tasks[a] != Task::Idle
    };
    let mut groups = Vec::new();
    let mut begin = 0;
    for end in 1..=tasks.len() {
        if end == tasks.len() || !same(begin, end) {
            if end - begin > 1 {
                groups.push(begin..end);
            }
            begin = end;
        }
    }
    groups
}

/// Put equal invocations in the order of their nodes. `who` follows: it holds the invocation in each place.
pub(super) fn canonical(nodes: &mut [NodeId], groups: &[std::ops::Range<usize>], who: &mut [u8]) {
    for group in groups {
        for i in group.start + 1..group.end {
            let mut j = i;
            while j > group.start && nodes[j - 1] > nodes[j] {
                nodes.swap(j - 1, j);
                who.swap(j - 1, j);
                j -= 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_invocations_are_put_in_order() {
        let (mut nodes, mut who) = ([5, 9, 3, 4, 2, 7], [0, 1, 2, 3, 4, 5]);
        canonical(&mut nodes, &[1..4, 4..6], &mut who);
        assert_eq!((nodes, who), ([5, 3, 4, 9, 2, 7], [0, 2, 3, 1, 4, 5]));
    }

    #[test]
    fn what_was_found_first_counts() {
        let found = |states: &[(StateId, &str)]| {
            let mut findings = Findings::default();
            for &(state, message) in states {
                findings.violation(Property::Keeps, state, None, || message.to_owned());
                findings.outcome(Vec::new(), state);
            }
            findings
        };
        for (one, other, first) in [
            (&[(7, "a"), (3, "b"), (3, "c")][..], &[(4, "d")][..], (3, "b")),
            (&[(4, "a")], &[(3, "b"), (5, "c")], (3, "b")),
            (&[(4, "a")], &[(4, "b")], (4, "a")),
        ] {
            let mut both = found(one);
            both.merge(found(other));
            let (state, _, message) = &both.violations[&Property::Keeps];
            assert_eq!(
                (*state, &**message, both.outcomes[&Vec::new()]),
                (first.0, first.1, first.0)
            );
        }
    }
}
