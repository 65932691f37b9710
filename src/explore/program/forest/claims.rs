//! Is it true what a forest was built on? That an invocation is a function of its answers, and that a wait or a `here`
//! leads to where everything goes on as before.

use std::collections::BTreeMap;

use super::{Forest, NodeId, Step};
use crate::explore::program::case::{Answer, Next};
use crate::memory::asked::Request;

/// Nodes, and the answers that lead to each from a common node above.
type Paths = Vec<(NodeId, Vec<Answer>)>;

impl Forest<'_> {
    /// Follow every chain's answers once more: an invocation must do what it did before. The last are followed first, so
    /// that others run before it than before; and small forests several times. What is wrong, if anything is.
    ///
    /// A static, a cell or a clock in a scheme are found so, if what they hold makes a difference by then.
    pub(in crate::explore) fn check_repeats(&self) -> std::result::Result<(), String> {
        let rounds = 1 + 500 / self.nodes.len().max(1);
        // A chain has all nodes above its last one in it.
        let mut has_below = vec![false; self.nodes.len()];
        let edges = self.nodes.iter().filter_map(|node| node.parent);
        edges.for_each(|(above, _)| has_below[above as usize] = true);
        let lasts = (0..self.nodes.len() as NodeId).rev().filter(|&id| !has_below[id as usize]);
        let lasts: Vec<NodeId> = lasts.take(Self::MOST_COMPARISONS).collect();
        (0..rounds).try_for_each(|_| lasts.iter().try_for_each(|&node| self.check_repeat(node)))
    }

    fn check_repeat(&self, id: NodeId) -> std::result::Result<(), String> {
        let node = self.node(id);
        let answers = self.answers(node.parent);
        let mut chain = vec![id];
        while let Some((above, _)) = self.node(chain[chain.len() - 1]).parent {
            chain.push(above);
        }
        let mut strange = None;
        let mut watch = |number: usize, request: Request| {
            let above = chain[chain.len() - 1 - number];
            if !self.agrees(above, &Next::Ask(request)) {
                strange = strange.or(Some(above));
            }
        };
        let task = self.tasks[node.task as usize];
        let next = self.case.follow_watched(task, &answers, self.lanes, &mut watch).next;
        let same = match (node.step, &next) {
            (Step::Ended(end), Next::Ended(ended)) => self.ended(end) == ended,
            (Step::Panics(panic), Next::Panics(told)) => self.told(panic) == told,
            // It was cut off, or it waits before its first operation.
            (Step::Endless, Next::Ask(_) | Next::Endless(_)) => true,
            (Step::Merge, Next::Back(..)) => true,
            _ => self.agrees(id, &next),
        };
        let strange = strange.or((!same).then_some(id));
        strange.map_or(Ok(()), |strange| {
            let site = self.node(strange).site.map(|site| format!(" at {site}"));
            let place = site.unwrap_or_default();
            Err(format!(
                "the scheme keeps state outside of its words: an invocation that gets the same answers does not always \
                 do the same{place}"
            ))
        })
    }

    /// How many comparisons [`Self::check_claims`] makes at most.
    const MOST_COMPARISONS: usize = 20_000;

    /// How often a wait is repeated, to find what counts its attempts.
    const ROUNDS: usize = 16;

    /// Follow every edge that a wait closed, or that was led to a node that was there, on the unmerged invocation,
    /// through all that was explored below its target, and round and round the wait itself: what comes next must be
    /// the same. The number of comparisons, and the first that failed.
    ///
    /// "Below" are the nodes whose chain has the target in it, and ends. Further edges to a node that was there are
    /// claims of their own, and are compared from their own node, not from here. If there are too many comparisons,
    /// the rest is left out silently.
    pub(in crate::explore) fn check_claims(&self) -> std::result::Result<usize, String> {
        let mut compared = 0;
        let mut below: BTreeMap<NodeId, Paths> = BTreeMap::new();
        for &(from, answer) in &self.claims {
            let Some(&(_, target)) = self.node(from).children.iter().find(|c| c.0 == answer) else {
                continue;
            };
            let paths = below.entry(target).or_insert_with(|| self.paths_below(target));
            // The invocation that really waited, and tries again. Nodes never have this answer: they stand for the
            // first try.
            let mut twin = self.answers(Some((from, answer)));
            twin.push(Answer::Again);
            if !self.compare(from, &twin, paths, &mut compared)? {
                return Ok(compared);
            }
            compared += self.go_round(from, answer, target).ok_or_else(|| self.lie(from))?;
        }
        // Invocations that came another way to what `here` says is one place.
        for &(from, answer, target) in &self.merges {
            let paths = below.entry(target).or_insert_with(|| self.paths_below(target));
            let twin = self.answers(Some((from, answer)));
            if !self.compare(from, &twin, paths, &mut compared)? {
                return Ok(compared);
            }
        }
        Ok(compared)
    }

    /// Lead a twin along paths: it must do what is at their nodes, and end as they do. Whether there was room for
    /// all.
    fn compare(
        &self,
        from: NodeId,
        twin: &[Answer],
        paths: &Paths,
        compared: &mut usize,
    ) -> std::result::Result<bool, String> {
        let follow = |path: &[Answer]| {
            let answers = [twin, path].concat();
            self.case.follow(self.task(from), &answers, self.lanes).next
        };
        for (node, path) in paths {
            if *compared >= Self::MOST_COMPARISONS {
                return Ok(false);
            }
            *compared += 1;
            if !self.agrees(*node, &follow(path)) {
                return Err(self.lie(from));
            }
            // Ended nodes are shared, and on no path: compare how the invocation ends.
            for &(answer, child) in &self.node(*node).children {
                let Step::Ended(end) = self.node(child).step else { continue };
                *compared += 1;
                let last = [path.as_slice(), &[Answer::Value(answer)]].concat();
                if follow(&last) != Next::Ended(self.ended(end).clone()) {
                    return Err(self.lie(from));
                }
            }
        }
        Ok(true)
    }

    /// Repeat a wait that goes back from `from` to `target`; how many steps were as before, if all were. Every round
    /// gets the answers of the first, so it must be the first, step by step, and wait again at its end.
    fn go_round(&self, from: NodeId, answer: u64, target: NodeId) -> Option<usize> {
        let task = self.task(from);
        let mut answers = self.answers(Some((from, answer)));
        // The answers of one round: those of the chain from the target on.
        let round = answers.split_off(self.answers(self.node(target).parent).len());
        let mut nodes = vec![from];
        while let Some(&last) = nodes.last()
            && last != target
        {
            nodes.push(self.node(last).parent?.0);
        }
        nodes.reverse();
        answers.extend(&round);
        for _ in 0..Self::ROUNDS {
            answers.push(Answer::Again);
            for (&node, &result) in nodes.iter().zip(&round) {
                let next = self.case.follow(task, &answers, self.lanes).next;
                if !self.agrees(node, &next) {
                    return None;
                }
                answers.push(result);
            }
            let next = self.case.follow(task, &answers, self.lanes).next;
            if !matches!(next, Next::Back(..)) {
                return None;
            }
        }
        Some(Self::ROUNDS * (round.len() + 1))
    }

    /// A false claim in words.
    fn lie(&self, from: NodeId) -> String {
        let site = self.node(from).site.map(ToString::to_string).unwrap_or_default();
        format!(
            "after the step at {site}, the invocation does not do what it did before: a mark, or a list of what it \
             depends on, claims more than is true"
        )
    }

    /// Every node below one, with the answers that lead there, the node itself first.
    fn paths_below(&self, target: NodeId) -> Paths {
        let mut found = vec![(target, Vec::new())];
        let mut at = 0;
        while at < found.len() && found.len() < Self::MOST_COMPARISONS {
            let (node, path) = found[at].clone();
            for &(answer, child) in &self.node(node).children {
                let own = self.node(child).parent == Some((node, answer));
                if own && !matches!(self.node(child).step, Step::Ended(_)) {
                    let mut path = path.clone();
                    path.push(Answer::Value(answer));
                    found.push((child, path));
                }
            }
            at += 1;
        }
        found
    }

    /// Whether an invocation is about to do what is at a node. The same operation may stand at another place of the
    /// source; a merge may not.
    fn agrees(&self, node: NodeId, next: &Next) -> bool {
        let node = self.node(node);
        match (node.step, next) {
            (
                Step::Operation(cell, action),
                Next::Ask(Request::Operation { at, action: a, .. }),
            ) => (cell, action) == (self.case.numbering.number(*at), *a),
            (Step::Merge, Next::Ask(Request::Merge(site))) => node.site == Some(*site),
            _ => false,
        }
    }
}
