//! All interleavings of an instance: breadth-first over hashed states, so that the first way to a violation is a
//! shortest one. There is no partial-order reduction: it conflicts with hashing, with invariants in every state, and
//! with lassos. Under sequential consistency, invocations with equal tasks are put in order, since they are
//! indistinguishable.
//!
//! Where many states wait, and threads have nothing else to do, a block of them is expanded by all. Each works with a
//! copy of the machine, on tables that do not grow meanwhile: a state that needs more than is there is left. Then one
//! thread goes through the block in its order, expands what was left, and gives each new state its number. So numbers,
//! and all that is found, are those of one thread.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::expand::{Expanded, Expander, Findings, Share, Successors, canonical, endless};
use super::explored::{Explored, Found, Limits, Stopped};
use super::graph::{Graph, executions, is_cyclic};
use super::property::{self, Property};
use super::space::{Offered, Space, StateId};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::case::Case;
use crate::explore::program::machine::{Conditions, Machine};
use crate::explore::program::schedule::{Move, Schedule};
use crate::scheme::Held;
use crate::scheme::Keeps;

/// Explore one instance.
pub(in crate::explore) fn explore(
    case: &Case,
    conditions: Conditions,
    limits: &Limits<'_>,
) -> Explored {
    let machine = Machine::new(case, conditions, false);
    Search::new(Expander::new(machine).symmetric()).run(limits)
}

/// Explore the orders in which invocations of a stage may run one after another: one that has begun goes on until it
/// has ended, or waits from its beginning. It is the same search with fewer moves.
pub(in crate::explore) fn orders(case: &Case, limits: &Limits<'_>) -> Explored {
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let expander = Expander::new(Machine::new(case, conditions, false)).symmetric();
    Search::new(Expander { one_by_one: true, ..expander }).run(limits)
}

/// The graph with a bit in each state for every invocation that has moved, and the machine to read its states with.
pub(in crate::explore) fn graph<'a>(
    case: &'a Case,
    conditions: Conditions,
    limits: &Limits<'_>,
) -> Option<(Graph, Space, Machine<'a>)> {
    let expander = Expander::new(Machine::new(case, conditions, true));
    let mut search = Search::new(Expander { mark_movers: true, ..expander });
    search.expand_all(limits);
    let complete = search.findings.stopped.is_none();
    complete.then_some((search.graph, search.space, search.expander.machine))
}

/// How many states are expanded by several threads at once.
#[derive(Clone, Copy)]
struct Sharing {
    /// States of a block: as many must wait. What follows from them should stay in the caches.
    block: usize,
    /// States that a thread takes at once.
    chunk: usize,
    /// Even where all threads have something else to do.
    always: bool,
}

/// More than follow from a state, as a rule: near the limit, states are expanded one by one.
const MOST_SUCCESSORS: usize = 1 << 7;

impl Sharing {
    /// Blocks that are worth it: measured, on two cores.
    fn new() -> Self {
        Self { block: rayon::current_num_threads() << 10, chunk: 1 << 6, always: false }
    }

    /// Whether to share a block now. Instances that nobody explores yet come first.
    fn pays(self, waiting: usize) -> bool {
        let others = || rayon_core::current_thread_has_pending_tasks() == Some(true);
        let free = || rayon::current_num_threads() > 1 && !others();
        waiting >= self.block && (self.always || free())
    }
}

struct Search<'a> {
    expander: Expander<'a>,
    sharing: Sharing,
    space: Space,
    graph: Graph,
    findings: Findings,
    /// Some operation was left out for want of room.
    full: bool,
}

impl<'a> Search<'a> {
    fn new(expander: Expander<'a>) -> Self {
        Self {
            expander,
            sharing: Sharing::new(),
            space: Space::new(),
            graph: Graph::default(),
            findings: Findings::default(),
            full: false,
        }
    }

    fn run(mut self, limits: &Limits<'_>) -> Explored {
        self.expand_all(limits);
        let complete = self.findings.stopped.is_none();
        let outcomes = std::mem::take(&mut self.findings.outcomes);
        let (contract, litmus) = (self.expander.machine.contract, self.expander.machine.litmus);
        let short = |pixels: &Vec<Held>| {
            pixels.iter().map(Held::len).sum::<usize>() < litmus.fragments.len()
        };
        // If a table is too small, which fragments find no room may depend on arrival.
        let open = contract.crosses() && !contract.settles_overflow() && outcomes.keys().any(short);
        let one = !open && !property::overflows(contract, litmus);
        if one && outcomes.len() > 1 {
            // The first one that is not the right one; or, if all are acceptable, the second.
            let expected = property::expected(self.expander.machine.case);
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
            self.findings.violations.insert(property, (shown, None, message));
        }
        let violations = std::mem::take(&mut self.findings.violations).into_iter();
        let violations = violations.map(|(property, (state, last, message))| {
            (property, Found { message, schedule: self.schedule(state, last) })
        });
        let mut violations: BTreeMap<Property, Found> = violations.collect();
        let repeats = self.expander.machine.forest.check_repeats();
        if let Err(message) = &repeats {
            let found = Found { message: message.clone(), schedule: Vec::new() };
            violations.insert(Property::Repeats, found);
        }
        // Without that, no claim is worth a comparison.
        let claims = repeats.map_or(Ok(0), |()| self.expander.machine.forest.check_claims());
        if let Err(message) = &claims {
            let found = Found { message: message.clone(), schedule: Vec::new() };
            violations.insert(Property::Invariant, found);
        }
        let outcomes = outcomes.into_iter().map(|(pixels, s)| (pixels, self.schedule(s, None)));
        let outcomes = outcomes.collect();
        Explored {
            complete,
            stopped: self.findings.stopped,
            states: self.space.len(),
            transitions: self.graph.targets.len(),
            bytes: self.space.bytes() + self.graph.bytes(),
            executions: if complete { executions(&self.graph) } else { None },
            cyclic: is_cyclic(&self.graph),
            outcomes,
            violations,
            sites: self.expander.machine.forest.sites().clone(),
            bare_waits: self.expander.machine.forest.bare_waits().len(),
            claims: claims.unwrap_or(0),
        }
    }

    /// Visit every state, or as many as may be.
    fn expand_all(&mut self, limits: &Limits<'_>) {
        let start = self.expander.machine.initial();
        self.space.insert(start, 0, Move { invocation: 0, alternative: 0 });
        self.graph.first.push(0);
        let mut successors = Successors::default();
        let mut state = 0;
        while state < self.space.len() {
            let goes_on = if self.sharing.pays(self.space.len() - state) {
                let block = state..state + self.sharing.block;
                state = block.end;
                self.expand_block(block, &mut successors, limits)
            } else {
                state += 1;
                self.may_expand(state - 1, limits) && self.expand(state - 1, &mut successors)
            };
            if !goes_on {
                return;
            }
        }
        let machine = &self.expander.machine;
        if let Some(node) = machine.endless() {
            self.findings.stopped.get_or_insert(endless(machine, node));
        }
        if machine.is_full() || self.full {
            self.findings.stopped.get_or_insert(Stopped::Full);
        }
    }

    /// Whether the limits let a state be expanded.
    fn may_expand(&mut self, state: usize, limits: &Limits<'_>) -> bool {
        if self.space.len() > limits.states {
            let (limit, bytes) = (limits.states, self.space.bytes() / self.space.len());
            self.findings.stopped = Some(Stopped::States { limit, bytes });
            return false;
        }
        if state.is_multiple_of(1_024) && (limits.cancelled)() {
            self.findings.stopped = Some(Stopped::Cancelled);
            return false;
        }
        true
    }

    /// Expand a state. Returns whether there is a point in going on.
    fn expand(&mut self, state: usize, successors: &mut Successors) -> bool {
        let id = state as StateId;
        successors.clear();
        match self.expander.expand(id, self.space.get(id), successors, &mut self.findings) {
            Expanded::All => {}
            Expanded::Missed => unreachable!("nobody else has its tables"),
            Expanded::CutOff(node) => {
                self.findings.stopped = Some(endless(&self.expander.machine, node));
                return false;
            }
        }
        for index in 0..successors.len() {
            let Offered { words, hash, from, by } = successors.offer(index, id);
            let (target, _) = self.space.insert_hashed(words, hash, from, by);
            self.graph.targets.push(target);
            self.graph.movers.push(by.invocation);
        }
        self.graph.first.push(self.graph.targets.len());
        true
    }

    /// Expand states that follow one another, by several threads.
    fn expand_block(
        &mut self,
        block: Range<usize>,
        successors: &mut Successors,
        limits: &Limits<'_>,
    ) -> bool {
        let (chunk, space, expander) = (self.sharing.chunk, &self.space, &self.expander);
        let chunks = block.clone().into_par_iter().step_by(chunk);
        let share = |expander: &mut Expander<'a>, begin: usize| {
            expander.share(begin..block.end.min(begin + chunk), space)
        };
        let shares: Vec<Share> = chunks.map_init(|| expander.clone(), share).collect();
        let count: usize = shares.iter().map(|share| share.successors.len()).sum();
        let left = shares.iter().flat_map(|share| &share.upto).filter(|upto| upto.is_none());
        let most = count + left.count() * MOST_SUCCESSORS;
        let rest =
            if self.space.len() + most > limits.states { None } else { self.rest(&block, &shares) };
        let Some(rest) = rest else {
            return block
                .into_iter()
                .all(|state| self.may_expand(state, limits) && self.expand(state, successors));
        };
        let mut rest = rest.iter();
        let mut offered = Vec::with_capacity(most);
        let mut ends = Vec::with_capacity(block.len());
        for (share, begin) in shares.iter().zip(block.clone().step_by(chunk)) {
            let mut before = 0;
            for (upto, from) in share.upto.iter().zip(begin as StateId..) {
                match *upto {
                    Some(upto) => {
                        offered.extend((before..upto).map(|i| share.successors.offer(i, from)));
                        before = upto;
                    }
                    None => {
                        let all = rest.next().into_iter();
                        offered
                            .extend(all.flat_map(|all| (0..all.len()).map(|i| all.offer(i, from))));
                    }
                }
                ends.push(self.graph.targets.len() + offered.len());
            }
        }
        let ids = self.space.insert_all(&offered);
        self.graph.movers.extend(offered.iter().map(|offered| offered.by.invocation));
        self.graph.targets.extend(ids);
        self.graph.first.extend(ends);
        for Share { findings, full, .. } in shares {
            self.findings.merge(findings);
            self.full |= full;
        }
        !(limits.cancelled)() || {
            self.findings.stopped = Some(Stopped::Cancelled);
            false
        }
    }

    /// What follows from the states that were left; `None` if an invocation is cut off.
    fn rest(&mut self, block: &Range<usize>, shares: &[Share]) -> Option<Vec<Successors>> {
        let all = shares.iter().flat_map(|share| &share.upto).zip(block.clone());
        let left = all.filter(|(upto, _)| upto.is_none());
        left.map(|(_, state)| {
            let mut successors = Successors::default();
            let id = state as StateId;
            let words = self.space.get(id);
            match self.expander.expand(id, words, &mut successors, &mut self.findings) {
                Expanded::All => Some(successors),
                Expanded::Missed => unreachable!("nobody else has its tables"),
                Expanded::CutOff(_) => None,
            }
        })
        .collect()
    }

    /// The moves to a state and perhaps one more, by the invocations that actually make them.
    fn schedule(&mut self, state: StateId, last: Option<Move>) -> Schedule {
        let path: Vec<Move> = self.space.path(state).into_iter().chain(last).collect();
        let Expander { machine, groups, .. } = &mut self.expander;
        if groups.is_empty() {
            return path;
        }
        let count = machine.width;
        let mut who: Vec<u8> = (0..count as u8).collect();
        let mut at = self.space.get(0).to_vec();
        let mut schedule = Vec::new();
        for by in path {
            let place = usize::from(by.invocation);
            schedule.push(Move { invocation: who[place], ..by });
            machine.load(&at);
            let moved = machine.perform(at[place], by);
            machine.place(&mut at[..count], by, moved.node);
            let (head, stage) = (machine.head(), machine.stage_number());
            at.truncate(head);
            machine.settle(&mut at);
            if machine.stage_number() != stage {
                who = (0..count as u8).collect();
            }
            canonical(&mut at[..count], &groups[machine.stage_index()], &mut who);
        }
        schedule
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::explore::memory::model::Profile;
    use crate::explore::program::guard::guarded;
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
                        Search::new(Expander::new(Machine::whole(&case, conditions))).run(&limits);
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

    /// Blocks of states that several threads expand give what one thread finds, down to the numbers of states: for
    /// every method, its faults too, and where limits end the search in the middle of a block.
    #[test]
    fn shared_states_are_expanded_as_by_one_thread() {
        let relaxed = MemoryModel::Relaxed(Profile::Vulkan);
        let sequential = MemoryModel::Sequential;
        let (mut compared, mut violated, mut shared) = (0, 0, 0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        for &method in Catalogue::default().methods() {
            let Ok(subject) = Subject::new(method) else { continue };
            let family = Family { fragments: 2, ks: vec![1], helpers: 1 };
            for (number, litmus) in instances(&subject, &family).into_iter().enumerate().take(5) {
                let case = subject.case(&litmus);
                for (memory, warp) in [(sequential, None), (relaxed, None), (sequential, Some(2))] {
                    let conditions = Conditions { memory, warp };
                    let states = [100_000, 40 + 7 * number][usize::from(number % 2 == 0)];
                    let limits = Limits { states, cancelled: &|| false };
                    let search = |sharing| {
                        let expander = Expander::new(Machine::new(&case, conditions, false));
                        let search = Search::new(expander.symmetric());
                        let search = Search { sharing, ..search };
                        guarded(|| search.run(&limits)).unwrap_or_else(Explored::panicked)
                    };
                    let one = search(Sharing { block: usize::MAX, ..Sharing::new() });
                    let sharing = Sharing { block: 37, chunk: 5, always: true };
                    let several = pool.install(|| search(sharing));
                    let name = format!("{}, {}, {memory}", method.name(), litmus.describe());
                    assert_eq!(format!("{one:?}"), format!("{several:?}"), "{name}");
                    compared += 1;
                    violated += usize::from(!one.violations.is_empty());
                    shared += usize::from(one.states > 100);
                }
            }
        }
        println!("{compared} searches compared, {violated} with violations, {shared} large");
        assert!(compared > 1_500 && violated > 200 && shared > 500);
    }
}
