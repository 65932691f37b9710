//! All interleavings of an instance: breadth-first over hashed states, so that the first way to a violation is a
//! shortest one. There is no partial-order reduction: it conflicts with hashing, with invariants in every state, and
//! with lassos. Under sequential consistency, invocations with equal tasks are put in order, since they are
//! indistinguishable.

use std::collections::BTreeMap;

use super::explored::{Explored, Found, Limits, Stopped};
use super::graph::{Graph, executions, is_cyclic};
use super::property::{self, Property};
use super::space::{Space, StateId};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::case::Case;
use crate::explore::program::forest::{NodeId, Step};
use crate::explore::program::litmus::Stage;
use crate::explore::program::machine::{Conditions, Final, Machine, Moved, Stop};
use crate::explore::program::schedule::{Move, Schedule};
use crate::scheme::Keeps;
use crate::scheme::task::Task;
use crate::scheme::{Held, Moment};

/// Explore one instance.
pub(in crate::explore) fn explore(
    case: &Case,
    conditions: Conditions,
    limits: &Limits<'_>,
) -> Explored {
    let machine = Machine::new(case, conditions, false);
    let groups = match conditions {
        Conditions { memory: MemoryModel::Sequential, warp: None } => groups(&machine),
        _ => Vec::new(),
    };
    Search::new(machine, groups).run(limits)
}

/// Explore the orders in which invocations of a stage may run one after another: one that has begun goes on until it
/// has ended, or waits from its beginning. It is the same search with fewer moves.
pub(in crate::explore) fn orders(case: &Case, limits: &Limits<'_>) -> Explored {
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let machine = Machine::new(case, conditions, false);
    let groups = groups(&machine);
    let mut search = Search::new(machine, groups);
    search.one_by_one = true;
    search.run(limits)
}

/// The graph with a bit in each state for every invocation that has moved, and the machine to read its states with.
pub(in crate::explore) fn graph<'a>(
    case: &'a Case,
    conditions: Conditions,
    limits: &Limits<'_>,
) -> Option<(Graph, Space, Machine<'a>)> {
    let machine = Machine::new(case, conditions, true);
    let mut search = Search::new(machine, Vec::new());
    search.mark_movers = true;
    search.expand_all(limits);
    search.stopped.is_none().then_some((search.graph, search.space, search.machine))
}

/// An invocation that was cut off at a node.
fn endless(machine: &Machine<'_>, node: NodeId) -> Stopped {
    let site = machine.forest.node(node).site.map(ToString::to_string).unwrap_or_default();
    Stopped::Endless { site, operations: machine.litmus.most_operations() }
}

/// Runs of invocations with equal tasks; helpers separate.
fn groups(machine: &Machine<'_>) -> Vec<Vec<std::ops::Range<usize>>> {
    machine.stages.iter().map(equals).collect()
}

/// The same for one stage.
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
fn canonical(nodes: &mut [NodeId], groups: &[std::ops::Range<usize>], who: &mut [u8]) {
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

struct Search<'a> {
    machine: Machine<'a>,
    /// By stage.
    groups: Vec<Vec<std::ops::Range<usize>>>,
    mark_movers: bool,
    /// One invocation after another.
    one_by_one: bool,
    space: Space,
    graph: Graph,
    finals: Vec<StateId>,
    violations: BTreeMap<Property, (StateId, Option<Move>, String)>,
    /// What ended the search early, or left something out.
    stopped: Option<Stopped>,
}

impl<'a> Search<'a> {
    fn new(machine: Machine<'a>, groups: Vec<Vec<std::ops::Range<usize>>>) -> Self {
        Self {
            machine,
            groups,
            mark_movers: false,
            one_by_one: false,
            space: Space::new(),
            graph: Graph::default(),
            finals: Vec::new(),
            violations: BTreeMap::new(),
            stopped: None,
        }
    }

    fn run(mut self, limits: &Limits<'_>) -> Explored {
        self.expand_all(limits);
        let complete = self.stopped.is_none();
        let mut outcomes: BTreeMap<Vec<Held>, StateId> = BTreeMap::new();
        for state in std::mem::take(&mut self.finals) {
            if let Some(end) = self.finish(state) {
                outcomes.entry(end.pixels).or_insert(state);
            }
        }
        let (contract, litmus) = (self.machine.contract, self.machine.litmus);
        let short = |pixels: &Vec<Held>| {
            pixels.iter().map(Held::len).sum::<usize>() < litmus.fragments.len()
        };
        // If a table is too small, which fragments find no room may depend on arrival.
        let open = contract.crosses() && !contract.settles_overflow() && outcomes.keys().any(short);
        let one = !open && !property::overflows(contract, litmus);
        if one && outcomes.len() > 1 {
            // The first one that is not the right one; or, if all are acceptable, the second.
            let expected = property::expected(self.machine.case);
            let is_right = |pixels: &Vec<Held>| expected.as_ref() == Some(pixels);
            let mut states: Vec<(bool, StateId)> =
                outcomes.iter().map(|(pixels, &state)| (is_right(pixels), state)).collect();
            states.sort_unstable();
            let has_right = states.iter().any(|s| s.0);
            let shown = if has_right { states[0].1 } else { states[1].1 };
            let message = format!("{} different results", outcomes.len());
            let blends = contract.keeps == Keeps::Merged || contract.keeps.is_approximate();
            let declared = contract.is_arrival_dependent() && blends;
            let property = if declared && expected.is_none() {
                Property::ArrivalFree
            } else {
                Property::OneOutcome
            };
            self.violations.insert(property, (shown, None, message));
        }
        let violations = std::mem::take(&mut self.violations).into_iter();
        let violations = violations.map(|(property, (state, last, message))| {
            (property, Found { message, schedule: self.schedule(state, last) })
        });
        let mut violations: BTreeMap<Property, Found> = violations.collect();
        let repeats = self.machine.forest.check_repeats();
        if let Err(message) = &repeats {
            let found = Found { message: message.clone(), schedule: Vec::new() };
            violations.insert(Property::Repeats, found);
        }
        // Without that, no claim is worth a comparison.
        let claims = repeats.map_or(Ok(0), |()| self.machine.forest.check_claims());
        if let Err(message) = &claims {
            let found = Found { message: message.clone(), schedule: Vec::new() };
            violations.insert(Property::Invariant, found);
        }
        let outcomes = outcomes.into_iter().map(|(pixels, s)| (pixels, self.schedule(s, None)));
        let outcomes = outcomes.collect();
        Explored {
            complete,
            stopped: self.stopped,
            states: self.space.len(),
            transitions: self.graph.targets.len(),
            bytes: self.space.bytes() + self.graph.bytes(),
            executions: if complete { executions(&self.graph) } else { None },
            cyclic: is_cyclic(&self.graph),
            outcomes,
            violations,
            sites: self.machine.forest.sites().clone(),
            bare_waits: self.machine.forest.bare_waits().len(),
            claims: claims.unwrap_or(0),
        }
    }

    /// Visit every state, or as many as may be.
    fn expand_all(&mut self, limits: &Limits<'_>) {
        let start = self.machine.initial().to_vec();
        self.space.insert(&start, 0, Move { invocation: 0, alternative: 0 });
        let (mut state, mut next) = (0, Vec::new());
        let mut current = Vec::new();
        self.graph.first.push(0);
        while state < self.space.len() {
            if self.space.len() > limits.states {
                let (limit, bytes) = (limits.states, self.space.bytes() / self.space.len());
                self.stopped = Some(Stopped::States { limit, bytes });
                return;
            }
            if state % 1_024 == 0 && (limits.cancelled)() {
                self.stopped = Some(Stopped::Cancelled);
                return;
            }
            current.clear();
            current.extend_from_slice(self.space.get(state as StateId));
            self.expand(state as StateId, &current, &mut next);
            if matches!(self.stopped, Some(Stopped::Endless { .. })) {
                return;
            }
            self.graph.first.push(self.graph.targets.len());
            state += 1;
        }
        if let Some(node) = self.machine.endless() {
            self.stopped.get_or_insert(endless(&self.machine, node));
        }
        if self.machine.is_full() {
            self.stopped.get_or_insert(Stopped::Full);
        }
    }

    fn expand(&mut self, id: StateId, state: &[u32], next: &mut Vec<u32>) {
        let count = self.machine.width;
        self.machine.load(state);
        let nodes = &state[..count];
        let live = self.machine.live(nodes);
        if live == 0 {
            self.ended(id, nodes);
            return;
        }
        if self.machine.is_sequential()
            && self.machine.is_in_passes()
            && let Err(message) = self.machine.invariant(Moment::Always)
        {
            self.violation(Property::Invariant, id, None, || message);
        }
        self.exclusion(id, nodes);
        let movers = if self.one_by_one { self.begun(nodes, live) } else { live };
        for invocation in (0..count).filter(|i| movers & (1 << i) != 0) {
            let mut alternatives = 1;
            let mut alternative = 0;
            while alternative < alternatives {
                self.machine.load(state);
                if alternative == 0 {
                    alternatives = self.machine.alternatives(nodes, invocation);
                    if alternatives == 0 {
                        self.look_for_end(nodes[invocation]);
                        break;
                    }
                }
                let by = Move { invocation: invocation as u8, alternative: alternative as u16 };
                let moved = self.machine.perform(nodes[invocation], by);
                if moved.stop != Some(Stop::NoRoom) {
                    self.judge_move(id, nodes[invocation], by, moved);
                }
                if moved.stop.is_none() {
                    self.follow(id, state, by, moved, next);
                }
                alternative += 1;
            }
        }
    }

    /// The invocation that has begun and not ended; all live ones, if none has.
    fn begun(&mut self, nodes: &[NodeId], live: u32) -> u32 {
        let begun = (0..nodes.len()).find(|&i| {
            let task = self.machine.stage().tasks[i];
            live & (1 << i) != 0 && nodes[i] != self.machine.forest.root(task)
        });
        begun.map_or(live, |invocation| 1 << invocation)
    }

    /// The state after a move.
    #[inline]
    fn follow(&mut self, id: StateId, state: &[u32], by: Move, moved: Moved, next: &mut Vec<u32>) {
        let (count, head) = (self.machine.width, self.machine.head());
        next.clear();
        next.extend_from_slice(&state[..head]);
        self.machine.place(&mut next[..count], by, moved.node);
        if self.mark_movers {
            next[count] |= 1 << by.invocation;
        }
        if let Some(message) = self.machine.settle(next) {
            self.violation(Property::Invariant, id, Some(by), || message);
        }
        if let Some(groups) = self.groups.get(self.machine.stage_index()) {
            canonical(&mut next[..count], groups, &mut [0; 32]);
        }
        let (target, _) = self.space.insert(next, id, by);
        self.graph.targets.push(target);
        self.graph.movers.push(by.invocation);
    }

    /// An invocation that cannot move: it waits for other lanes, or it was cut off.
    fn look_for_end(&mut self, node: NodeId) {
        if self.machine.forest.node(node).step == Step::Endless {
            self.stopped = Some(endless(&self.machine, node));
        }
    }

    fn judge_move(&mut self, id: StateId, node: NodeId, by: Move, moved: Moved) {
        if let Some(fault) = moved.fault {
            let told = self.machine.told(node, fault);
            self.violation(fault.property(), id, Some(by), || told);
        }
        if moved.stop == Some(Stop::Panic) {
            self.stopped.get_or_insert(Stopped::Panics);
        }
        if moved.race.is_some() {
            self.violation(Property::RaceFree, id, Some(by), || "a data race".to_owned());
        }
    }

    fn exclusion(&mut self, id: StateId, nodes: &[NodeId]) {
        let mut held = 0;
        for invocation in 0..nodes.len() {
            let own = self.machine.held(nodes, invocation);
            if held & own != 0 {
                let message = || "two invocations hold the same lock".to_owned();
                self.violation(Property::MutualExclusion, id, None, message);
            }
            held |= own;
        }
    }

    fn ended(&mut self, id: StateId, nodes: &[NodeId]) {
        if self.mark_movers {
            // Resolve must end, too.
            let _ = self.machine.finish(nodes);
            return;
        }
        self.finals.push(id);
        if self.machine.is_in_passes()
            && let Err(message) = self.machine.invariant(Moment::Quiet)
        {
            self.violation(Property::Invariant, id, None, || message);
        }
        let Some(end) = self.machine.finish(nodes) else { return };
        for (property, message) in property::judge(self.machine.case, &end) {
            self.violation(property, id, None, || message);
        }
    }

    fn violation(
        &mut self,
        property: Property,
        state: StateId,
        last: Option<Move>,
        message: impl FnOnce() -> String,
    ) {
        self.violations.entry(property).or_insert_with(|| (state, last, message()));
    }

    fn finish(&mut self, state: StateId) -> Option<Final> {
        let words = self.space.get(state).to_vec();
        self.machine.load(&words);
        self.machine.finish(&words[..self.machine.width])
    }

    /// The moves to a state and perhaps one more, by the invocations that actually make them.
    fn schedule(&mut self, state: StateId, last: Option<Move>) -> Schedule {
        let path: Vec<Move> = self.space.path(state).into_iter().chain(last).collect();
        if self.groups.is_empty() {
            return path;
        }
        let count = self.machine.width;
        let mut who: Vec<u8> = (0..count as u8).collect();
        let mut at = self.space.get(0).to_vec();
        let mut schedule = Vec::new();
        for by in path {
            let place = usize::from(by.invocation);
            schedule.push(Move { invocation: who[place], ..by });
            self.machine.load(&at);
            let moved = self.machine.perform(at[place], by);
            self.machine.place(&mut at[..count], by, moved.node);
            let (head, stage) = (self.machine.head(), self.machine.stage_number());
            at.truncate(head);
            self.machine.settle(&mut at);
            if self.machine.stage_number() != stage {
                who = (0..count as u8).collect();
            }
            canonical(&mut at[..count], &self.groups[self.machine.stage_index()], &mut who);
        }
        schedule
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::explore::memory::model::Profile;
    use crate::explore::program::instances::{Family, instances};
    use crate::explore::program::subject::Subject;
    use crate::scheme::contract::Form;

    /// Where clear and resolve are left out, exploring them too gives the same outcomes and violations.
    #[test]
    fn clear_and_resolve_may_be_left_out() {
        let limits = Limits { states: 100_000, cancelled: &|| false };
        let family = Family { fragments: 2, ks: vec![1], helpers: 0 };
        let mut compared = 0;
        let relaxed = MemoryModel::Relaxed(Profile::Vulkan);
        for method in Catalogue::default().promised().filter(|m| m.contract().form == Form::Correct)
        {
            let subject = Subject::new(method).expect("a scheme");
            for litmus in instances(&subject, &family).into_iter().take(6) {
                let case = subject.case(&litmus);
                for memory in [MemoryModel::Sequential, relaxed] {
                    let conditions = Conditions { memory, warp: None };
                    let part = explore(&case, conditions, &limits);
                    let whole =
                        Search::new(Machine::whole(&case, conditions), Vec::new()).run(&limits);
                    if !whole.complete {
                        continue;
                    }
                    compared += 1;
                    let name = method.name();
                    let outcomes = [&part, &whole].map(|e| e.outcomes.keys().collect::<Vec<_>>());
                    assert_eq!(outcomes[0], outcomes[1], "{name}, {}", litmus.describe());
                    let wrong = [&part, &whole].map(|e| e.violations.keys().collect::<Vec<_>>());
                    assert_eq!(wrong[0], wrong[1], "{name}, {}", litmus.describe());
                }
            }
        }
        println!("{compared} instances compared");
        assert!(compared > 100, "{compared}");
    }

    #[test]
    fn equal_invocations_are_put_in_order() {
        let (mut nodes, mut who) = ([5, 9, 3, 4, 2, 7], [0, 1, 2, 3, 4, 5]);
        canonical(&mut nodes, &[1..4, 4..6], &mut who);
        assert_eq!((nodes, who), ([5, 3, 4, 9, 2, 7], [0, 2, 3, 1, 4, 5]));
    }
}
