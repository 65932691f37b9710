//! Progress: does every invocation end, given what a device guarantees to schedule?
//!
//! Models as in Sorensen et al., "Specifying and testing GPU workgroup progress models" (OOPSLA 2021), Table 1. An
//! execution that never ends is, from some point on, a walk inside a strongly connected part of the state graph. For
//! every set A of live invocations, a cycle that moves exactly A is fair if every invocation that the model guarantees
//! to be scheduled is in A (or disabled somewhere on the cycle, as a lane that waits for others of its warp). A fair
//! cycle refutes termination; stem and cycle together are the lasso. Progress is explored under sequential consistency.

use super::exhaustive::graph;
use super::explored::Limits;
use super::graph::Graph;
use super::space::{Space, StateId};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::case::Case;
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::{Conditions, MOST_INVOCATIONS, Machine};
use crate::explore::program::schedule::{Move, Schedule};
use crate::explore::program::subject::Subject;

/// Which invocations a device guarantees to schedule again and again, as long as they have not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Progress {
    /// None.
    Unfair,
    /// The lowest invocation that has not ended (HSA).
    Hsa,
    /// Those that have moved once (occupancy-bound execution).
    Obe,
    /// Both of these.
    HsaObe,
    /// Those that have moved, and all before one that has (linear OBE).
    Lobe,
    /// All.
    Fair,
}

impl Progress {
    /// All models, weakest first where they are comparable.
    pub const ALL: [Self; 6] =
        [Self::Unfair, Self::Hsa, Self::Obe, Self::HsaObe, Self::Lobe, Self::Fair];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unfair => "unfair",
            Self::Hsa => "hsa",
            Self::Obe => "obe",
            Self::HsaObe => "hsa+obe",
            Self::Lobe => "lobe",
            Self::Fair => "fair",
        }
    }

    /// Bits of the invocations that are guaranteed to move.
    fn guaranteed(self, live: u32, moved: u32) -> u32 {
        let lowest = live & live.wrapping_neg();
        let up_to_last_moved = match moved {
            0 => 0,
            _ => u32::MAX >> moved.leading_zeros(),
        };
        let all = match self {
            Self::Unfair => 0,
            Self::Hsa => lowest,
            Self::Obe => moved,
            Self::HsaObe => lowest | moved,
            Self::Lobe => up_to_last_moved,
            Self::Fair => u32::MAX,
        };
        all & live
    }
}

/// An execution that never ends: the stem, then the cycle forever. With an empty cycle, no invocation can move at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lasso {
    /// From the beginning into the cycle.
    pub stem: Schedule,
    /// What repeats.
    pub cycle: Schedule,
}

/// The result of exploring an instance's progress.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progressed {
    /// States of the graph; 0 if it was not completed.
    pub states: usize,
    /// For each model of [`Progress::ALL`], how the instance fails to end.
    pub lassos: [Option<Lasso>; 6],
}

/// Whether one instance of a method ends, under every model; with `warp`, as lanes that reconverge. `None` if not all
/// of its states were visited.
#[must_use]
pub fn ends(
    subject: &Subject,
    litmus: &Litmus,
    warp: Option<u32>,
    limits: &Limits<'_>,
) -> Option<Progressed> {
    explore(&subject.case(litmus), warp, limits)
}

/// Whether an instance ends under every model; `None` if its graph was not completed.
pub(in crate::explore) fn explore(
    case: &Case,
    warp: Option<u32>,
    limits: &Limits<'_>,
) -> Option<Progressed> {
    let conditions = Conditions { memory: MemoryModel::Sequential, warp };
    let (graph, space, machine) = graph(case, conditions, limits)?;
    Some(Endings { graph, space, machine }.run())
}

struct Endings<'a> {
    graph: Graph,
    space: Space,
    machine: Machine<'a>,
}

/// The live, the moved and the disabled invocations of a state.
#[derive(Clone, Copy, Debug, Default)]
struct Who {
    live: u32,
    moved: u32,
    disabled: u32,
}

impl Endings<'_> {
    fn run(mut self) -> Progressed {
        let states = self.graph.states();
        let who: Vec<Who> = (0..states).map(|s| self.who(s as StateId)).collect();
        let mut lassos: [Option<Lasso>; 6] = std::array::from_fn(|_| None);
        if let Some(stuck) =
            (0..states).find(|&s| who[s].live != 0 && self.graph.edges(s).is_empty())
        {
            let lasso = Lasso { stem: self.space.path(stuck as StateId), cycle: Vec::new() };
            lassos = std::array::from_fn(|_| Some(lasso.clone()));
        }
        let count = self.machine.width.min(MOST_INVOCATIONS);
        for set in 1..(1u64 << count) {
            if lassos.iter().all(Option::is_some) {
                break;
            }
            self.cycles_of(set as u32, &who, &mut lassos);
        }
        Progressed { states, lassos }
    }

    fn who(&mut self, state: StateId) -> Who {
        let count = self.machine.width;
        let words = self.space.get(state).to_vec();
        let nodes = &words[..count];
        let live = self.machine.live(nodes);
        self.machine.load(&words);
        let mut disabled = 0;
        for i in 0..count {
            if live & (1 << i) != 0 && self.machine.alternatives(nodes, i) == 0 {
                disabled |= 1 << i;
            }
        }
        Who { live, moved: words[count], disabled }
    }

    /// Judge the cycles that move exactly the invocations of `set`.
    fn cycles_of(&self, set: u32, who: &[Who], lassos: &mut [Option<Lasso>; 6]) {
        for part in self.parts(set) {
            let Who { live, moved, .. } = who[part[0]];
            let inside = |state: usize| part.binary_search(&state).is_ok();
            let edges = part.iter().flat_map(|&s| self.graph.edges(s).map(move |e| (s, e)));
            let movers = edges
                .filter(|&(_, e)| set & (1 << self.graph.movers[e]) != 0)
                .filter(|&(_, e)| inside(self.graph.targets[e] as usize))
                .fold(0, |bits, (_, e)| bits | 1 << self.graph.movers[e]);
            if movers != set {
                continue;
            }
            let excused = part.iter().fold(0, |bits, &s| bits | who[s].disabled);
            for (model, lasso) in Progress::ALL.iter().zip(lassos.iter_mut()) {
                if lasso.is_none() && model.guaranteed(live, moved) & !(set | excused) == 0 {
                    *lasso = Some(self.lasso(&part, set));
                }
            }
        }
    }

    /// The strongly connected parts of the graph that only `set` moves, those without an edge left out; each sorted.
    /// Tarjan's algorithm, without recursion.
    fn parts(&self, set: u32) -> Vec<Vec<usize>> {
        const NEW: u32 = u32::MAX;
        let states = self.graph.states();
        let (mut index, mut low) = (vec![NEW; states], vec![0u32; states]);
        let (mut on_stack, mut stack, mut parts) = (vec![false; states], Vec::new(), Vec::new());
        let mut next = 0;
        let mut calls: Vec<(usize, usize)> = Vec::new();
        for start in 0..states {
            if index[start] != NEW {
                continue;
            }
            calls.push((start, self.graph.edges(start).start));
            while let Some(&mut (state, ref mut edge)) = calls.last_mut() {
                if index[state] == NEW {
                    (index[state], low[state]) = (next, next);
                    next += 1;
                    stack.push(state);
                    on_stack[state] = true;
                }
                let end = self.graph.edges(state).end;
                let mut deeper = None;
                while *edge < end && deeper.is_none() {
                    let e = *edge;
                    *edge += 1;
                    let target = self.graph.targets[e] as usize;
                    if set & (1 << self.graph.movers[e]) == 0 {
                        continue;
                    }
                    if index[target] == NEW {
                        deeper = Some(target);
                    } else if on_stack[target] {
                        low[state] = low[state].min(index[target]);
                    }
                }
                if let Some(target) = deeper {
                    calls.push((target, self.graph.edges(target).start));
                    continue;
                }
                calls.pop();
                if let Some(&(caller, _)) = calls.last() {
                    low[caller] = low[caller].min(low[state]);
                }
                if low[state] == index[state] {
                    let mut part = Vec::new();
                    while let Some(member) = stack.pop() {
                        on_stack[member] = false;
                        part.push(member);
                        if member == state {
                            break;
                        }
                    }
                    part.sort_unstable();
                    if part.len() > 1 || self.loops(state, set) {
                        parts.push(part);
                    }
                }
            }
        }
        parts.sort_unstable();
        parts
    }

    fn loops(&self, state: usize, set: u32) -> bool {
        self.graph.edges(state).any(|e| {
            self.graph.targets[e] as usize == state && set & (1 << self.graph.movers[e]) != 0
        })
    }

    /// A path into a part, and a walk in it that moves all of `set` and comes back.
    fn lasso(&self, part: &[usize], set: u32) -> Lasso {
        let home = part[0];
        let (mut at, mut cycle) = (home, Vec::new());
        for mover in (0..32).filter(|i| set & (1 << i) != 0) {
            if cycle.iter().any(|by: &Move| by.invocation == mover) {
                continue;
            }
            let arrives = |_, e: usize| self.graph.movers[e] == mover;
            at = self.walk(part, set, at, &arrives, &mut cycle);
        }
        if at != home {
            let arrives = |target, _| target == home;
            self.walk(part, set, at, &arrives, &mut cycle);
        }
        Lasso { stem: self.space.path(home as StateId), cycle }
    }

    /// The shortest walk in a part that ends with an edge for which `arrives` holds. Returns where it ends.
    fn walk(
        &self,
        part: &[usize],
        set: u32,
        from: usize,
        arrives: &dyn Fn(usize, usize) -> bool,
        walked: &mut Schedule,
    ) -> usize {
        let place = |state: usize| part.binary_search(&state).ok();
        let mut came: Vec<Option<(usize, usize)>> = vec![None; part.len()];
        let mut queue = std::collections::VecDeque::from([from]);
        while let Some(state) = queue.pop_front() {
            for e in self.graph.edges(state) {
                let target = self.graph.targets[e] as usize;
                let Some(at) = place(target).filter(|_| set & (1 << self.graph.movers[e]) != 0)
                else {
                    continue;
                };
                if arrives(target, e) {
                    let mut edges = vec![e];
                    let mut back = state;
                    while back != from {
                        let Some((before, edge)) = place(back).and_then(|p| came[p]) else { break };
                        edges.push(edge);
                        back = before;
                    }
                    walked.extend(edges.iter().rev().map(|&e| self.step(e)));
                    return target;
                }
                if came[at].is_none() && target != from {
                    came[at] = Some((state, e));
                    queue.push_back(target);
                }
            }
        }
        from
    }

    /// The move of an edge. Its alternative is found by counting: edges of one mover are consecutive.
    fn step(&self, edge: usize) -> Move {
        let mover = self.graph.movers[edge];
        let state = self.graph.first.partition_point(|&first| first <= edge) - 1;
        let before = self.graph.edges(state).start..edge;
        let alternative = before.filter(|&e| self.graph.movers[e] == mover).count() as u16;
        Move { invocation: mover, alternative }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whom_the_models_guarantee() {
        let who = |live, moved| Progress::ALL.map(|p| p.guaranteed(live, moved));
        assert_eq!(who(0b1111, 0b0000), [0, 0b0001, 0, 0b0001, 0, 0b1111]);
        assert_eq!(who(0b1111, 0b0100), [0, 0b0001, 0b0100, 0b0101, 0b0111, 0b1111]);
        assert_eq!(who(0b1110, 0b0101), [0, 0b0010, 0b0100, 0b0110, 0b0110, 0b1110]);
    }

    /// Look at a hand-made graph, in which state n was reached by n moves of invocation 7.
    fn look<T>(graph: Graph, at: impl Fn(&Endings<'_>) -> T) -> T {
        let method = crate::catalogue::method("z-buffer").expect("a method");
        let subject = Subject::new(method).expect("no oracle");
        let litmus = Litmus {
            pixels: 1,
            k: None,
            room: 1,
            fragments: vec![Default::default()],
            helpers: 0,
            table: None,
            inputs: Vec::new(),
        };
        let case = subject.case(&litmus);
        let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
        let machine = Machine::new(&case, conditions, true);
        let mut space = Space::new();
        for state in 0..graph.states() as StateId {
            let by = Move { invocation: 7, alternative: 0 };
            space.insert(&[state], state.saturating_sub(1), by);
        }
        at(&Endings { graph, space, machine })
    }

    /// A ring of 1, 2, 3 that invocations 0 and 1 move, 2 with a step of its own back; 4 waits alone; 5 is the end.
    fn rings() -> Graph {
        Graph::of(
            6,
            &[
                (0, 0, 1),
                (1, 0, 2),
                (2, 1, 3),
                (2, 0, 1),
                (3, 0, 1),
                (3, 1, 4),
                (4, 1, 4),
                (4, 0, 5),
            ],
        )
    }

    #[test]
    fn parts_are_those_that_the_set_moves() {
        let parts = |set| look(rings(), |endings| endings.parts(set));
        assert_eq!(parts(0b01), [vec![1, 2]]);
        assert_eq!(parts(0b10), [vec![4]]);
        assert_eq!(parts(0b11), [vec![1, 2, 3], vec![4]]);
        assert_eq!(parts(0b100), Vec::<Vec<usize>>::new());
    }

    /// Against reachability, on random graphs.
    #[test]
    fn parts_are_mutually_reachable() {
        const STATES: usize = 9;
        for seed in 0..300 {
            let random = |i: usize| crate::num::random::bits(seed, 1, i as u64);
            let edge = |i: usize| (i / 2, (i % 2) as u8, random(i) as StateId % STATES as StateId);
            let edges: Vec<_> =
                (0..2 * STATES).filter(|&i| random(i) >> 62 != 0).map(edge).collect();
            for set in 1..4u32 {
                let mut reaches = [[false; STATES]; STATES];
                for &(from, _, to) in edges.iter().filter(|edge| set & (1 << edge.1) != 0) {
                    reaches[from][to as usize] = true;
                }
                for via in 0..STATES {
                    for from in 0..STATES {
                        for to in 0..STATES {
                            reaches[from][to] |= reaches[from][via] && reaches[via][to];
                        }
                    }
                }
                let with = |a: usize| -> Vec<usize> {
                    (0..STATES).filter(|&b| reaches[a][b] && reaches[b][a]).collect()
                };
                let mut expected: Vec<Vec<usize>> =
                    (0..STATES).filter(|&a| reaches[a][a]).map(with).collect();
                expected.sort();
                expected.dedup();
                let found = look(Graph::of(STATES, &edges), |endings| endings.parts(set));
                assert_eq!(found, expected, "{edges:?} by {set:b}");
            }
        }
    }

    /// The walk is closed, moves every invocation of the set, and each of its moves is possible at its place.
    #[test]
    fn a_lasso_comes_back_and_moves_everybody() {
        let by = |invocation, alternative| Move { invocation, alternative };
        let lasso = look(rings(), |endings| endings.lasso(&[1, 2, 3], 0b11));
        assert_eq!(lasso.stem, [by(7, 0)]);
        assert_eq!(lasso.cycle, [by(0, 0), by(1, 0), by(0, 0)]);
        let lasso = look(rings(), |endings| endings.lasso(&[4], 0b10));
        assert_eq!((lasso.stem.len(), lasso.cycle), (4, vec![by(1, 0)]));
        let other_value = Graph::of(2, &[(0, 0, 1), (0, 0, 0)]);
        let lasso = look(other_value, |endings| endings.lasso(&[0], 0b1));
        assert_eq!(lasso.cycle, [by(0, 1)], "the second of its values");
    }
}
