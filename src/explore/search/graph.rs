//! The graph of a search's states: its edges, whether they make a cycle, and how many paths there are.

use super::space::StateId;

/// The graph of states.
#[derive(Default)]
pub(in crate::explore) struct Graph {
    /// Where each state's edges begin.
    pub(in crate::explore) first: Vec<usize>,
    pub(in crate::explore) targets: Vec<StateId>,
    pub(in crate::explore) movers: Vec<u8>,
}

impl Graph {
    pub(in crate::explore) fn edges(&self, state: usize) -> std::ops::Range<usize> {
        self.first[state]..self.first[state + 1]
    }

    pub(in crate::explore) fn states(&self) -> usize {
        self.first.len().saturating_sub(1)
    }

    /// Bytes in use.
    pub(in crate::explore) fn bytes(&self) -> usize {
        size_of_val(&*self.first) + size_of_val(&*self.targets) + size_of_val(&*self.movers)
    }
}

/// Whether some path leads from a state back to itself.
pub(super) fn is_cyclic(graph: &Graph) -> bool {
    let states = graph.states();
    let targets = |state: usize| graph.edges(state).map(|e| graph.targets[e] as usize);
    let mut waiting = vec![0u32; states];
    (0..states).for_each(|s| targets(s).filter(|&t| t < states).for_each(|t| waiting[t] += 1));
    let mut ready: Vec<usize> = (0..states).filter(|&s| waiting[s] == 0).collect();
    let mut done = 0;
    while let Some(state) = ready.pop() {
        done += 1;
        for target in targets(state).filter(|&t| t < states) {
            waiting[target] -= 1;
            if waiting[target] == 0 {
                ready.push(target);
            }
        }
    }
    done < states
}

/// The number of paths from the first state to one without successors, steps that change nothing left out; `None` if
/// there are other cycles, or too many paths.
pub(super) fn executions(graph: &Graph) -> Option<u128> {
    let states = graph.states();
    let mut waiting = vec![0u32; states];
    let steps = |state: usize| {
        graph.edges(state).map(|e| graph.targets[e] as usize).filter(move |&t| t != state)
    };
    (0..states).for_each(|s| steps(s).for_each(|t| waiting[t] += 1));
    let mut paths = vec![0u128; states];
    let mut ready: Vec<usize> = (0..states).filter(|&s| waiting[s] == 0).collect();
    *paths.first_mut()? = 1;
    let (mut done, mut sum) = (0, 0u128);
    while let Some(state) = ready.pop() {
        done += 1;
        let mut ends = true;
        for target in steps(state) {
            ends = false;
            paths[target] = paths[target].checked_add(paths[state])?;
            waiting[target] -= 1;
            if waiting[target] == 0 {
                ready.push(target);
            }
        }
        if ends {
            sum = sum.checked_add(paths[state])?;
        }
    }
    (done == states && sum < 1 << 127).then_some(sum)
}

#[cfg(test)]
impl Graph {
    /// A graph from edges (state, mover, target), in the order of their states.
    pub(in crate::explore) fn of(states: usize, edges: &[(usize, u8, StateId)]) -> Self {
        assert!(edges.is_sorted_by_key(|edge| edge.0));
        Self {
            first: (0..=states).map(|s| edges.partition_point(|edge| edge.0 < s)).collect(),
            targets: edges.iter().map(|edge| edge.2).collect(),
            movers: edges.iter().map(|edge| edge.1).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two invocations, `steps` steps each, that never meet: a grid.
    fn grid(steps: usize) -> Graph {
        let side = steps + 1;
        let mut edges = Vec::new();
        for state in 0..side * side {
            if state % side < steps {
                edges.push((state, 0, state as StateId + 1));
            }
            if state / side < steps {
                edges.push((state, 1, (state + side) as StateId));
            }
        }
        Graph::of(side * side, &edges)
    }

    /// Interleavings of two sequences: 2n over n.
    #[test]
    fn executions_of_a_grid_are_binomial() {
        for (steps, expected) in [(0, 1), (1, 2), (2, 6), (3, 20), (10, 184_756)] {
            assert_eq!(executions(&grid(steps)), Some(expected), "{steps} steps");
            assert!(!is_cyclic(&grid(steps)));
        }
        assert_eq!(executions(&grid(62)), Some(1_520_803_477_811_874_490_019_821_888_415_218_656));
        assert_eq!(executions(&grid(70)), None, "more than fits");
    }

    #[test]
    fn executions_end_in_any_state_without_a_step() {
        let two_ends = Graph::of(4, &[(0, 0, 1), (0, 1, 2), (1, 1, 3), (2, 0, 3), (2, 0, 1)]);
        assert_eq!(executions(&two_ends), Some(3));
        let twice = Graph::of(2, &[(0, 0, 1), (0, 0, 1)]);
        assert_eq!(executions(&twice), Some(2), "by two values of one read");
    }

    /// A failed attempt that leads back at once is not counted; a longer way round makes executions endless.
    #[test]
    fn cycles_are_seen() {
        let waits = Graph::of(2, &[(0, 0, 0), (0, 1, 1)]);
        assert_eq!((executions(&waits), is_cyclic(&waits)), (Some(1), true));
        let round = Graph::of(3, &[(0, 0, 1), (1, 0, 0), (1, 1, 2)]);
        assert_eq!((executions(&round), is_cyclic(&round)), (None, true));
    }
}
