//! From stage to stage, and from round to round: what happens when all invocations of a stage have ended.

use std::collections::BTreeMap;

use super::{At, Final, MOST_ROUNDS, Machine};
use crate::explore::program::alone::Alone;
use crate::explore::program::forest::{NodeId, Step};
use crate::scheme::course;
use crate::scheme::{Held, Moment};

impl Machine<'_> {
    /// Encode the beginning of a stage, on the present memory. No invocation of it has moved.
    pub(super) fn begin(&mut self, at: At, state: &mut Vec<u32>) {
        self.at = at;
        let tasks = self.stages[at.stage as usize].tasks.clone();
        state.clear();
        state.extend(tasks.into_iter().map(|task| self.forest.root(task)));
        state.resize(self.head, 0);
        state[self.head - 1] = at.pack();
        let live = self.live(&state[..self.width]);
        self.model.store(live, state);
    }

    /// Encode the loaded memory behind a head, and begin the next stage if all have ended (2). What is wrong at a
    /// barrier between rounds, if anything is.
    pub(in crate::explore) fn settle(&mut self, state: &mut Vec<u32>) -> Option<String> {
        let live = self.live(&state[..self.width]);
        self.model.store(live, state);
        if live == 0 { self.advance(state) } else { None }
    }

    /// Begin the next stage, or the next round, as long as none is left in the present one.
    pub(super) fn advance(&mut self, state: &mut Vec<u32>) -> Option<String> {
        let mut wrong = None;
        while self.live(&state[..self.width]) == 0 {
            let at = self.at;
            // The course counts the stages that are not explored, too.
            let here = course::At { stage: at.stage as usize + self.before, round: at.round };
            let next = self.explored(self.course.after(here, false));
            let resolves = next.is_some_and(|next| Some(next.stage) == self.resolves);
            let alone = self.resolve_alone();
            if let Some(next) = next
                && alone.is_none()
            {
                let mut results = at.results;
                if resolves {
                    wrong = wrong.or(self.invariant(Moment::Quiet).err());
                    let (reported, _) = self.reported(&state[..self.width]);
                    results = self.intern(reported);
                }
                self.model.barrier(&BTreeMap::new());
                self.begin(At { stage: next.stage, results, ..at }, state);
                continue;
            }
            // The end of a round. Resolve says whether there is another; if it is left out, it runs now.
            if !self.contract.program.repeats {
                break;
            }
            if let Some(cut_off) = alone.as_ref().and_then(|alone| alone.endless) {
                self.cut_off(cut_off);
                break;
            }
            let written = alone.as_ref().map(|alone| alone.written.clone()).unwrap_or_default();
            let (mut end, again) = self.resolved(&state[..self.width], alone);
            let resolve = course::At { stage: self.course.stages().len() - 1, ..here };
            let Some(next) = self.explored(self.course.after(resolve, again)) else { break };
            if at.round == MOST_ROUNDS {
                self.full |= self.forest.grow(|_| true).unwrap_or(false);
                break;
            }
            if self.is_in_passes() {
                wrong = wrong.or(self.invariant(Moment::Quiet).err());
            }
            // In one order, so that equal results have one index.
            end.pixels.iter_mut().for_each(Held::sort);
            let results = self.intern(Final { outcomes: Vec::new(), ..end });
            self.model.barrier(&written);
            self.begin(At { results, ..next }, state);
        }
        wrong
    }

    /// An invocation that ran alone was cut off here. It is for the machine to note whose tables grow.
    fn cut_off(&mut self, node: NodeId) {
        if self.forest.grow(|_| ()).is_some() {
            self.endless = Some(node);
        }
    }

    /// The index of results. Any, if it is missed.
    fn intern(&mut self, results: Final) -> u32 {
        let known = self.results.iter().position(|known| *known == results);
        let new = |all: &mut Vec<Final>| {
            all.push(results);
            all.len() - 1
        };
        known.or_else(|| self.results.grow(new)).unwrap_or(0) as u32
    }

    /// A stage of the course as one of those that are explored, if it is one.
    fn explored(&self, at: Option<course::At>) -> Option<At> {
        let course::At { stage, round } = at?;
        let stage = stage - self.before;
        (stage < self.stages.len()).then_some(At { stage: stage as u32, round, results: 0 })
    }

    /// How the loaded state ends, all invocations having ended: the lists after resolve. `None` if resolve was cut
    /// off, or has asked for too many rounds.
    pub(in crate::explore) fn finish(&mut self, nodes: &[NodeId]) -> Option<Final> {
        let alone = self.resolve_alone();
        if let Some(cut_off) = alone.as_ref().and_then(|alone| alone.endless) {
            self.cut_off(cut_off);
            return None;
        }
        let (mut end, again) = self.resolved(nodes, alone);
        if again && self.at.round == MOST_ROUNDS {
            return None;
        }
        end.pixels.iter_mut().for_each(Held::sort);
        Some(end)
    }

    /// What has been found up to the loaded state, and whether some pixel needs another round.
    fn reported(&self, nodes: &[NodeId]) -> (Final, bool) {
        let mut found = self.results[self.at.results as usize].clone();
        let mut again = false;
        for (invocation, &node) in nodes.iter().enumerate() {
            if let Step::Ended(end) = self.forest.node(node).step
                && !self.is_helper(invocation)
            {
                again |= found.add(self.forest.ended(end));
            }
        }
        (found, again)
    }

    /// The same after resolve, with the lists in any order.
    fn resolved(&self, nodes: &[NodeId], alone: Option<Alone>) -> (Final, bool) {
        let (mut found, mut again) = self.reported(nodes);
        for ended in alone.into_iter().flat_map(|alone| alone.ends) {
            again |= found.add(&ended);
        }
        (found, again)
    }

    /// Resolve one pixel after another, if resolve is next and the order cannot matter. It is behind a barrier:
    /// everything that was written is seen. The model stays as it is.
    fn resolve_alone(&mut self) -> Option<Alone> {
        let resolves = self.resolves.filter(|&resolves| resolves == self.at.stage + 1)?;
        if !self.leaves_out {
            return None;
        }
        let tasks = self.stages[resolves as usize].tasks.clone();
        let model = &self.model;
        Alone::run(&mut self.forest, &tasks, &|cell| model.settled(cell), &self.case.numbering)
    }
}
