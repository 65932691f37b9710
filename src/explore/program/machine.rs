//! An instance made ready to run: its invocations' trees, its memory after the clear pass, and what one move does.
//!
//! The stages that are explored are those of the method's course. Clear and resolve are left out where nothing depends
//! on it: where no two of their invocations meet, and none reads a word that nobody wrote ([`alone`](super::alone)). Whether
//! clear is left out depends on the instance alone, and for resolve it is decided at every end. Stages have equally
//! many invocations: the missing ones have nothing to do. A move is one operation of one invocation (or leaving a
//! block), with the local computation after it. When all of a stage have ended, the next one begins in the same move.
//!
//! State: a slice of u32, the head and then the memory.
//!
//! ```text
//! nodes    `width` words: the node of every invocation in the forest
//! moved    for progress only: a bit for every invocation that has moved in this stage
//! stage    which stage, which round, which results so far
//! memory   what the model stores
//! ```
//!
//! The head of one machine's states has one length. Nodes and results are numbered for good, and equal ones have one
//! number. So slices are equal exactly if positions, progress, results and memory are.
//!
//! Invariants:
//!
//! 1. After `load`, what a move does depends on the slice and the move alone. Forest and results are tables that
//!    grow, and say nothing of the present state.
//! 2. A state that was settled has a live invocation, or nothing comes after it.
//! 3. An invocation that has ended does not move until the next stage. So memory may forget its views.
//! 4. What a helper does leaves words, locks, races and outcomes as they are, except that its read decides the value
//!    of an unwritten word.
//! 5. What a robust device makes of an access outside of a buffer are alternatives of its move: the first drops it (a
//!    read gives 0, a write has no effect); the others are those of the same access to the buffer's last word, to
//!    which it is clamped, if there is one.
//!
//! Why it is sound: by 1 a search may keep one of equal states. Other invocations see nothing of local computation,
//! so that no result is lost if it comes with the operation before it. A barrier comes after all of one stage and
//! before all of the next, so that it needs no move of its own. Why clear and resolve may be left out:
//! [`alone`](super::alone).
//!
//! Left out: a barrier for each pixel is explored as one for the frame: no pixel runs ahead of another.
//! Lanes come together after blocks; they are not in lockstep between. A helper's update returns one of four values.
//! A program that repeats is cut off after [`MOST_ROUNDS`], and `is_full` says so. An operation that memory has no room
//! for is not performed, and nothing follows from it; `is_full` says that, too. The method's invariant is looked at
//! while its passes run, and before resolve; not at other barriers within a round. If lanes leave a block together,
//! only the one that moves is asked for faults. Vulkan lets an access outside of a buffer hit any word of it; here it
//! hits the last one, or none. If that is a lock, it is not followed who holds it.
//!
//! Published: a state as a vector with an index for every process's own state: Holzmann, "State compression in SPIN"
//! (SPIN 1997). Local computation joined to an operation: Lipton, "Reduction" (CACM 1975). Helpers are those of the
//! OpenGL Shading Language (`gl_HelperInvocation`): no effect, undefined results. Lanes come together as at SPIR-V's
//! merge instructions; the rule for nested blocks is this file's own (`may_merge`).

mod stages;

use std::collections::BTreeMap;

use super::alone::Alone;
use super::case::Case;
use super::forest::{Fault, Forest, NodeId, Step};
use super::guard::guarded;
use super::litmus::{Litmus, Stage};
use super::schedule::Move;
use super::shared::Shared;
use crate::explore::memory;
use crate::explore::memory::model::{self, Initial, MemoryModel, Model, Race};
use crate::memory::asked::{Action, OpenBlock};
use crate::memory::{Access, Address, Growing, Layout, Numbering, Order, Snapshot};
use crate::scheme::course::{self, Course, Part};
use crate::scheme::task::{Ended, Task};
use crate::scheme::{Contract, Held, Moment, Outcome};

/// The most invocations that a machine runs at once: sets of them are bits of a u32.
pub(in crate::explore) const MOST_INVOCATIONS: usize = 32;

/// How invocations are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// What memory does.
    pub memory: MemoryModel,
    /// Lanes of a warp that come together after blocks; `None` if invocations are independent.
    pub warp: Option<u32>,
}

/// What a helper invocation's update may return instead of a value: 0, 1, all ones, or the word.
const HELPER_RESULTS: usize = 4;

/// Rounds after which a program that repeats is given up. A round has 6 bits in [`At::pack`].
const MOST_ROUNDS: u32 = 60;

/// An instance, ready to run. A clone goes its own way, on the same tables: while there are several machines, these do
/// not grow, and [`Machine::take_missed`] says so.
#[derive(Clone)]
pub(in crate::explore) struct Machine<'a> {
    pub(in crate::explore) case: &'a Case,
    pub(in crate::explore) litmus: &'a Litmus,
    pub(in crate::explore) contract: &'a Contract,
    pub(in crate::explore) forest: Shared<Forest<'a>>,
    /// The stages that are explored.
    pub(in crate::explore) stages: Vec<Stage>,
    /// Invocations of every stage.
    pub(in crate::explore) width: usize,
    course: Course,
    /// Stages of the course before the first that is explored: 1 if clear is left out.
    before: usize,
    /// The first stage that is explored clears, and does nothing else.
    clears: bool,
    /// Clear and resolve are left out where that may be.
    leaves_out: bool,
    conditions: Conditions,
    /// The memory of the loaded state.
    model: Box<dyn Model>,
    /// The last stage, if it resolves and does nothing else: it is left out where its invocations do not meet.
    resolves: Option<u32>,
    /// Words before the model's: the nodes, the word of the invocations that have moved, and that of the stage.
    head: usize,
    /// How far the loaded state has come.
    at: At,
    /// Results so far, all that were met. A state has an index.
    results: Shared<Vec<Final>>,
    /// Words that only grow while fragments are stored; empty where there are none.
    growing: Vec<bool>,
    /// By stage: it stores fragments, and does nothing else.
    storing: Vec<bool>,
    /// A bound of rounds was hit, in any state.
    full: bool,
    /// Where an invocation that ran alone was cut off, in any state.
    endless: Option<NodeId>,
    /// The first state.
    initial: Vec<u32>,
}

/// How far a program has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct At {
    stage: u32,
    round: u32,
    /// Index of the results so far: what every pixel holds from earlier rounds; and, during resolve, the reports.
    results: u32,
}

impl At {
    /// As one word: 4 bits of stage, 6 of round, the rest for results. It is not checked that stages fit: 16 do.
    fn pack(self) -> u32 {
        self.stage | self.round << 4 | self.results << 10
    }

    fn unpack(word: u32) -> Self {
        Self { stage: word & 0xF, round: word >> 4 & 0x3F, results: word >> 10 }
    }
}

/// What a move did.
#[derive(Clone, Copy, Debug)]
pub(in crate::explore) struct Moved {
    /// Where the invocation stands now.
    pub(in crate::explore) node: NodeId,
    /// The value read, or 0.
    pub(in crate::explore) result: u64,
    /// What was wrong with the step, or with the end that it led to.
    pub(in crate::explore) fault: Option<Fault>,
    /// An earlier access that the operation races with.
    pub(in crate::explore) race: Option<Race>,
    /// Why no state follows, if none does.
    pub(in crate::explore) stop: Option<Stop>,
}

/// Why no state follows a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::explore) enum Stop {
    /// The invocation has panicked.
    Panic,
    /// Memory had no room for the operation: it was not performed.
    NoRoom,
}

/// How a finished run ended.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Final {
    /// What every pixel holds, in canonical order.
    pub pixels: Vec<Held>,
    /// What became of each fragment, as far as its invocation knows; in the last round, where there are several.
    pub outcomes: Vec<Outcome>,
}

impl<'a> Machine<'a> {
    /// A machine in its first state. With `progress`, states say which invocations have moved.
    pub(in crate::explore) fn new(case: &'a Case, conditions: Conditions, progress: bool) -> Self {
        Self::with(case, conditions, progress, true)
    }

    /// A machine whose clear and resolve are explored even where their order cannot matter.
    #[cfg(test)]
    pub(in crate::explore) fn whole(case: &'a Case, conditions: Conditions) -> Self {
        Self::with(case, conditions, false, false)
    }

    fn with(case: &'a Case, conditions: Conditions, progress: bool, leaves_out: bool) -> Self {
        let Case { contract, instance, numbering, litmus, .. } = case;
        let course = Course::of(&contract.program);
        let mut stages = litmus.stages(contract, &course, |pass| instance.invocations(pass));
        // Clear and resolve may be left out only if nothing else runs with them.
        let is = |parts: Option<&Vec<Part>>, part| parts.is_some_and(|parts| *parts == [part]);
        let resolves = is(course.stages().last(), Part::Resolve);
        let mut clears = is(course.stages().first(), Part::Clear);
        let mut forest = Shared::new(Forest::new(case, conditions.warp.is_some()));
        let (mut cleared, mut cut_off) = (BTreeMap::new(), None);
        let mut before = 0;
        if leaves_out
            && clears
            && let Some(alone) = Alone::run(&mut forest, &stages[0].tasks, &|_| None, numbering)
        {
            (cleared, cut_off) = (alone.written, alone.endless);
            stages.remove(0);
            (clears, before) = (false, 1);
        }
        let width = stages.iter().map(|s| s.tasks.len()).max().unwrap_or(0);
        assert!(width <= MOST_INVOCATIONS, "a litmus pixel has few invocations");
        stages.iter_mut().for_each(|stage| stage.tasks.resize(width, Task::Idle));
        let stores = |stage: &Stage| {
            stage.tasks.iter().all(|task| matches!(task, Task::Store(_) | Task::Idle))
        };
        let storing = stages.iter().map(stores).collect();
        let initial = |cell: u32| match cleared.get(&cell) {
            Some(&value) => Initial::Written(value),
            None => Initial::Unwritten,
        };
        let initial: Vec<Initial> = (0..numbering.count() as u32).map(initial).collect();
        let candidates = litmus.candidates();
        let model = memory::make(conditions.memory, numbering, &initial, &candidates, width);
        let nothing = vec![case.method.holds().empty(); litmus.pixels as usize];
        let mut machine = Self {
            case,
            litmus,
            contract,
            forest,
            width,
            course,
            before,
            clears,
            leaves_out,
            conditions,
            model,
            resolves: resolves.then_some(stages.len() as u32 - 1),
            stages,
            head: width + usize::from(progress) + 1,
            at: At::default(),
            results: Shared::new(vec![Final { pixels: nothing, outcomes: Vec::new() }]),
            growing: growing(instance.layout(), numbering),
            storing,
            full: false,
            endless: cut_off,
            initial: Vec::new(),
        };
        // A first stage without anything to do is passed over.
        let mut initial = Vec::new();
        machine.begin(At::default(), &mut initial);
        machine.advance(&mut initial);
        machine.initial = initial;
        machine
    }

    /// The stage of the loaded state.
    pub(in crate::explore) fn stage(&self) -> &Stage {
        &self.stages[self.at.stage as usize]
    }

    /// Its number.
    #[inline]
    pub(in crate::explore) fn stage_index(&self) -> usize {
        self.at.stage as usize
    }

    /// The number of the stage of the loaded state, counted over all rounds.
    pub(in crate::explore) fn stage_number(&self) -> usize {
        self.at.round as usize * self.stages.len() + self.at.stage as usize
    }

    /// The number of a stage of the course in this count; `None` if it is not explored.
    pub(in crate::explore) fn number_of(&self, at: course::At) -> Option<usize> {
        let stage = at.stage.checked_sub(self.before)?;
        (stage < self.stages.len()).then_some(at.round as usize * self.stages.len() + stage)
    }

    /// Whether an invocation of the loaded state is a helper.
    pub(in crate::explore) fn is_helper(&self, invocation: usize) -> bool {
        self.stage().is_helper(invocation)
    }

    /// The first state.
    pub(in crate::explore) fn initial(&self) -> &[u32] {
        &self.initial
    }

    /// Whether the method's passes run in the loaded state: its invariant does not concern what clears or resolves.
    pub(in crate::explore) fn is_in_passes(&self) -> bool {
        let clears = self.clears && self.at.stage == 0;
        !clears && self.resolves != Some(self.at.stage)
    }

    /// How invocations are run.
    pub(in crate::explore) fn conditions(&self) -> Conditions {
        self.conditions
    }

    /// Words have one value at a time.
    pub(in crate::explore) fn is_sequential(&self) -> bool {
        self.conditions.memory == MemoryModel::Sequential
    }

    /// Whether something was not in a table that others have, too. Nothing then counts that was done since a state was
    /// loaded.
    #[inline]
    pub(in crate::explore) fn take_missed(&mut self) -> bool {
        let (forest, results) = (self.forest.take_missed(), self.results.take_missed());
        forest | results
    }

    /// Some operation was left out for want of room.
    pub(in crate::explore) fn is_full(&self) -> bool {
        self.full || self.model.full()
    }

    /// Words of a state before the model's.
    pub(in crate::explore) fn head(&self) -> usize {
        self.head
    }

    /// The memory of the loaded state.
    pub(in crate::explore) fn memory(&self) -> &dyn Model {
        &*self.model
    }

    /// The numbers of the words.
    pub(in crate::explore) fn numbering(&self) -> &Numbering {
        &self.case.numbering
    }

    /// Bits of the invocations that have not ended.
    pub(in crate::explore) fn live(&self, nodes: &[NodeId]) -> u32 {
        let ended = |&node: &NodeId| matches!(self.forest.node(node).step, Step::Ended(_));
        let live = nodes.iter().enumerate().filter(|(_, node)| !ended(node));
        live.fold(0, |bits, (i, _)| bits | 1 << i)
    }

    /// Take up a state: everything that a move depends on (1), but for the nodes, which the caller has.
    pub(in crate::explore) fn load(&mut self, state: &[u32]) {
        self.at = At::unpack(state[self.head - 1]);
        self.model.load(&state[self.head..]);
    }

    /// In how many ways the invocation can move from the loaded state; 0 if it cannot.
    pub(in crate::explore) fn alternatives(
        &mut self,
        nodes: &[NodeId],
        invocation: usize,
    ) -> usize {
        match self.forest.node(nodes[invocation]).step {
            Step::Ended(_) | Step::Endless => 0,
            Step::Panics(_) => 1,
            // The one step that can be disabled: a lane waits for others.
            Step::Merge => usize::from(self.may_merge(nodes, invocation)),
            Step::Operation(_, Action::Update(..)) if self.is_helper(invocation) => HELPER_RESULTS,
            Step::Operation(_, Action::Write(..)) if self.is_helper(invocation) => 1,
            Step::Operation(cell, action) if Numbering::is_outside(cell) => {
                let end = self.numbering().end(cell);
                1 + end.map_or(0, |end| self.model.alternatives(invocation, end, action))
            }
            Step::Operation(cell, action) => self.model.alternatives(invocation, cell, action),
        }
    }

    /// The word that an operation accesses in one of its alternatives, and that word's alternative; `None` if it is
    /// dropped (5).
    #[inline]
    pub(in crate::explore) fn accessed(&self, cell: u32, alternative: u16) -> Option<(u32, usize)> {
        let alternative = usize::from(alternative);
        if !Numbering::is_outside(cell) {
            return Some((cell, alternative));
        }
        Some((self.numbering().end(cell)?, alternative.checked_sub(1)?))
    }

    /// The locks that an invocation holds, one bit each. A helper holds none, whatever its updates returned.
    pub(in crate::explore) fn held(&self, nodes: &[NodeId], invocation: usize) -> u32 {
        let helps = self.is_helper(invocation);
        if helps { 0 } else { self.forest.node(nodes[invocation]).held }
    }

    /// Move an invocation that stands at `node`; the model's state changes with it. Its place in the nodes is for
    /// [`Self::place`] to change.
    pub(in crate::explore) fn perform(&mut self, node: NodeId, by: Move) -> Moved {
        let (fault, step) = (self.forest.node(node).fault, self.forest.node(node).step);
        let invocation = usize::from(by.invocation);
        let (mut result, mut race, mut shrunk) = (0, None, false);
        if let Step::Operation(cell, action) = step {
            if self.is_helper(invocation) {
                result = self.helper(invocation, cell, action, by.alternative);
            } else if let Some((cell, alternative)) = self.accessed(cell, by.alternative) {
                let grows = self.growing.get(cell as usize).is_some_and(|&grows| grows)
                    && self.storing[self.at.stage as usize]
                    && !matches!(action, Action::Read(_));
                // Under relaxed memory these are a word's last messages; a write may also come before others.
                let before = if grows { self.model.settled(cell) } else { None };
                result = self.model.perform(invocation, cell, action, alternative);
                shrunk = grows && (self.model.settled(cell) < before || self.model.descends());
                // What a helper reads has no effect, so that it is no race either. The model reports one race at a
                // time: a further one, with a higher invocation, is lost with it.
                race = self.model.race().filter(|race| !self.is_helper(race.other));
            }
        }
        if matches!(step, Step::Panics(_)) {
            return Moved { node, result, fault, race, stop: Some(Stop::Panic) };
        }
        if self.model.lost() {
            return Moved { node, result: 0, fault: None, race: None, stop: Some(Stop::NoRoom) };
        }
        let node = self.forest.child(node, result);
        // An end has no move of its own, so its fault belongs to the move that leads there.
        let fault = fault.or_else(|| match self.forest.node(node).step {
            Step::Ended(_) => self.forest.node(node).fault,
            _ => None,
        });
        let fault = fault.or(shrunk.then_some(Fault::Shrinks));
        // What a helper does to a lock has no effect, and what it believes to hold it does not.
        let fault = fault.filter(|f| *f == Fault::Outside || !self.is_helper(invocation));
        Moved { node, result, fault, race, stop: None }
    }

    /// A fault of an invocation that stands at `node` in words.
    pub(in crate::explore) fn told(&self, node: NodeId, fault: Fault) -> String {
        match self.forest.node(node).step {
            Step::Panics(panic) => self.forest.told(panic).to_owned(),
            _ => fault.message().to_owned(),
        }
    }

    /// Put an invocation where it stands after a move. Lanes that stand at the same merge leave it together: where
    /// leaving is allowed, all of them may.
    pub(in crate::explore) fn place(&mut self, nodes: &mut [NodeId], by: Move, node: NodeId) {
        let invocation = usize::from(by.invocation);
        let before = std::mem::replace(&mut nodes[invocation], node);
        let Some(warp) = self.conditions.warp else { return };
        if self.forest.node(before).step != Step::Merge {
            return;
        }
        let own = self.forest.stack(before).to_vec();
        let first = invocation / warp as usize * warp as usize;
        for other in first..(first + warp as usize).min(nodes.len()) {
            let stands = self.forest.node(nodes[other]).step == Step::Merge;
            if other != invocation && stands && self.forest.stack(nodes[other]) == own {
                nodes[other] = self.forest.child(nodes[other], 0);
            }
        }
    }

    /// A helper's writes have no effect, and its updates return anything.
    fn helper(&mut self, invocation: usize, cell: u32, action: Action, alternative: u16) -> u64 {
        if let Action::Read(_) = action {
            // As weak as can be: it and later reads find at least all that its own order allows.
            let read = Action::Read(Access::Atomic(Order::Relaxed));
            return self.accessed(cell, alternative).map_or(0, |(cell, alternative)| {
                self.model.perform(invocation, cell, read, alternative)
            });
        }
        if Numbering::is_outside(cell) {
            return 0;
        }
        let width = self.numbering().address(cell).bits;
        match (action, alternative) {
            (Action::Read(_) | Action::Write(..), _) | (Action::Update(..), 0) => 0,
            (Action::Update(..), 1) => 1,
            (Action::Update(..), 2) => model::cut(u64::MAX, width),
            // The word's value, as if the update had worked.
            (Action::Update(..), _) => self.model.settled(cell).unwrap_or(0),
        }
    }

    /// A lane may leave a block when every unfinished lane of its warp that is in the body of the same parent stands
    /// at the same merge; lanes at the parent's own merge do not count, nor do those in a later block of that parent,
    /// which have left this one, and together with this lane. A warp is so many invocations with consecutive numbers.
    fn may_merge(&self, nodes: &[NodeId], invocation: usize) -> bool {
        let Some(warp) = self.conditions.warp else { return true };
        // A lane at a merge is still in its block. One that waits before its first operation may be in none, and waits
        // for ever.
        let own = self.forest.stack(nodes[invocation]);
        let Some(block) = own.len().checked_sub(1) else { return false };
        let parent = &own[..block];
        let later = |stack: &[OpenBlock]| {
            stack.get(block).is_some_and(|other| other.ordinal > own[block].ordinal)
        };
        let lanes = warp as usize;
        let first = invocation / lanes * lanes;
        let others = (first..(first + lanes).min(nodes.len())).filter(|&i| i != invocation);
        others.into_iter().all(|other| {
            let node = self.forest.node(nodes[other]);
            let (stack, merging) = (self.forest.stack(nodes[other]), node.step == Step::Merge);
            let ended = matches!(node.step, Step::Ended(_));
            let outside =
                !stack.starts_with(parent) || (merging && stack == parent) || later(stack);
            ended || outside || (merging && stack == own)
        })
    }

    /// What the method says of itself in the loaded state. A word's value is the one that is left when all have
    /// ended, which another invocation need not see yet under relaxed memory.
    pub(in crate::explore) fn invariant(&self, moment: Moment) -> Result<(), String> {
        let value = |address: Address| self.model.settled(self.numbering().number(address));
        let words = Snapshot { value: &value };
        let holds = |p| self.case.instance.invariant(&words, p, moment);
        guarded(|| (0..self.litmus.pixels).try_for_each(holds))
            .unwrap_or_else(|told| Err(format!("the invariant {told}")))
    }

    /// Where an invocation that ran alone was cut off, if one was; in any state.
    pub(in crate::explore) fn endless(&self) -> Option<NodeId> {
        self.endless
    }
}

impl Final {
    /// Add what became of an invocation. Returns whether its pixel needs another round.
    pub(in crate::explore) fn add(&mut self, ended: &Ended) -> bool {
        match ended {
            Ended::Resolved(pixel, held, again) => {
                self.pixels[*pixel as usize].append(held.clone());
                return *again;
            }
            Ended::Stored(outcome) => self.outcomes.push(*outcome),
            Ended::Done => {}
        }
        false
    }
}

/// By number: whether a word only grows. Empty where none does.
fn growing(layout: &Layout, numbering: &Numbering) -> Vec<bool> {
    if layout.growing().is_empty() {
        return Vec::new();
    }
    let grows = |cell: u32| {
        let at = numbering.address(cell);
        let fits = |g: &Growing| g.bits == at.bits && g.words.contains(&at.word);
        at.pixel.is_none() && layout.growing().iter().any(fits)
    };
    (0..numbering.count() as u32).map(grows).collect()
}
