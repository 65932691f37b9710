//! Decision trees: what each invocation does next, along every sequence of answers met so far.
//!
//! An invocation is a deterministic function of its task and of its operations' results. A node of its tree stands
//! for the operations completed so far with their results; its label is the operation that comes next, or how it
//! ended. A node is made once, by following a fresh invocation along its own answers, so exploring needs neither to
//! copy nor to hash a future. The invocations of one task share a tree, and a state has a [`NodeId`] where it would
//! have an invocation.
//!
//! A tree has fewer nodes than histories, in three ways. Ended invocations are one node per outcome. `spin(mark)`
//! leads back to the mark's node. `here(live)` leads to the node at which an invocation of this task has stood at
//! that place before, with the same values and locks. The first is exact; the others are claims of the scheme, that
//! what follows is the same, and [`Forest::check_claims`] compares.
//!
//! State: a forest is no part of a state; states have its node numbers. It only grows, and a number never changes its
//! meaning. So in the states of one search, equal numbers are one position.
//!
//! Invariants:
//!
//! 1. A fresh invocation of a node's `task` that gets the answers along the chain of `parent`s stands at the node's
//!    `step`.
//! 2. (node, answer) has one child, and always the same. It is a new node, or one that was there: only a new one has
//!    the edge as its `parent`. So `parent`s make a tree for every task, and chains have no waits in them.
//! 3. The n-th node of a chain, from 0, stands after n answers. A mark is a number of answers, hence a place in a
//!    chain.
//! 4. `held` follows from the operations and answers on the chain.
//!
//! Why it is sound: by 1, and since tasks and answers decide everything, invocations of one task that get the same
//! answers are at the same node and have the same future. Inputs are constants of the case, and an invocation sees
//! nothing else. A write counts as an operation, with answer 0: what has been read says where an invocation stands
//! only together with what has been done. So a search over numbers finds what a search over invocations would, if
//! claims are true. A false claim may hide behaviour; the comparison is made on the answers that the search met, at
//! the end of an exhaustive one.
//!
//! Left out: claims are not compared after a search for progress, nor beyond `MOST_COMPARISONS`; a count of
//! attempts that shows only after `ROUNDS` of them is not seen; where a node below leads back, or to a node
//! that was there, it is not compared that the other invocation gets there too. A wait goes back to its mark's
//! `held`, whatever was locked since. Locks are the first 32 lock words, taken by an update from 0. A loop that
//! neither waits nor says `here` is unrolled, up to [`Litmus::most_operations`](super::litmus::Litmus::most_operations).
//!
//! Published: an invocation that is run again from its beginning, for want of a copy: Godefroid, "Model checking for
//! programming languages using `VeriSoft`" (POPL 1997). Nodes with a question and a continuation for each answer are
//! interaction trees (Xia et al., POPL 2020). A number in the state instead of a process's own state: Holzmann,
//! "State compression in SPIN" (SPIN 1997). A wait that says that it waits is the yield of Musuvathi and Qadeer,
//! "Fair stateless model checking" (PLDI 2008); as an edge that leads back, it stays in the graph, so that an endless
//! wait is a cycle.

mod claims;

use std::collections::{BTreeMap, BTreeSet};

use super::case::{Answer, Case, Next};
use super::shared::Shared;
use crate::memory::asked::{Action, Here, OpenBlock, Request, Site};
use crate::memory::{Address, Numbering, Update};
use crate::scheme::task::{Ended, Task};

/// Index of a node.
pub(in crate::explore) type NodeId = u32;

/// What an invocation does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::explore) enum Step {
    /// An operation on a cell.
    Operation(u32, Action),
    /// Leave a block; or, at a root, wait before the first operation.
    Merge,
    /// It has ended; index of the outcome.
    Ended(u32),
    /// Panic; index of what it says.
    Panics(u32),
    /// It has done as much as is followed, and has not ended.
    Endless,
}

/// A fault that taking this step commits, whatever memory holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::explore) enum Fault {
    /// The word does not exist.
    Outside,
    /// A lock is freed that the invocation does not hold.
    ForeignLock,
    /// The invocation has ended and still holds a lock.
    KeepsLock,
    /// The invocation waits before it has done anything: for ever.
    WaitsForNothing,
    /// A word becomes smaller that only grows while fragments are stored.
    Shrinks,
    /// The scheme's code panics.
    Panics,
}

/// A place in a tree: the operations of `task` completed so far, with their results.
#[derive(Debug)]
pub(in crate::explore) struct Node {
    /// What comes next.
    pub(in crate::explore) step: Step,
    /// From where in the source the step is taken.
    pub(in crate::explore) site: Option<Site>,
    /// Locks held before the step, one bit each.
    pub(in crate::explore) held: u32,
    /// What is wrong with the step, if anything is.
    pub(in crate::explore) fault: Option<Fault>,
    /// Index of the open blocks.
    pub(in crate::explore) blocks: u32,
    /// Whether this node repeats an attempt: a wait leads back to it.
    pub(in crate::explore) waits: bool,
    /// The nodes after the answers met so far (2).
    children: Vec<(u64, NodeId)>,
    /// The edge that made this node; `None` at a root.
    parent: Option<(NodeId, u64)>,
    /// Index of the task.
    task: u32,
}

/// The trees of one instance's tasks.
pub(in crate::explore) struct Forest<'a> {
    case: &'a Case,
    /// Merges are steps.
    lanes: bool,
    /// The cells that are locks; the bits of `held` are in this order.
    locks: Vec<u32>,
    tasks: Vec<Task>,
    /// The root of each task's tree.
    roots: Vec<NodeId>,
    nodes: Vec<Node>,
    /// Every outcome, and the node that ends with it. If a false `here` merges an end with another place, the node
    /// does not exist.
    ends: Vec<(Ended, NodeId)>,
    /// The lists of open blocks met so far: a node has an index.
    stacks: Vec<Vec<OpenBlock>>,
    /// Edges that a wait made: (parent, answer).
    claims: Vec<(NodeId, u64)>,
    /// The node of a task that stands at a place, with locks held, in blocks, and depends on these values only. Locks
    /// are not among what an invocation knows of itself, but faults depend on them.
    heres: BTreeMap<(u32, u32, u32, Here), NodeId>,
    /// Edges to such a node that was there: (parent, answer, node).
    merges: Vec<(NodeId, u64, NodeId)>,
    /// Operations and blocks that were reached, also by helpers, whatever their updates returned.
    sites: BTreeSet<(&'static str, u32, u32)>,
    /// Where invocations wait outside of any block.
    bare_waits: BTreeSet<(&'static str, u32)>,
    /// What panics say.
    told: Vec<String>,
    /// The most operations of an invocation.
    most: usize,
}

/// A forest in the hands of machines: it grows where one asks for what is not there yet.
impl Shared<Forest<'_>> {
    /// The node at which an invocation of this task begins. Any, if it is missed.
    pub(in crate::explore) fn root(&mut self, task: Task) -> NodeId {
        let known = self.known_root(task);
        known.or_else(|| self.grow(|forest| forest.root(task))).unwrap_or(0)
    }

    /// The node after a node's step gave `answer`. Any, if it is missed.
    #[inline]
    pub(in crate::explore) fn child(&mut self, node: NodeId, answer: u64) -> NodeId {
        let known = self.known_child(node, answer);
        known.or_else(|| self.grow(|forest| forest.new_child(node, answer))).unwrap_or(node)
    }
}

impl<'a> Forest<'a> {
    /// No trees yet. With `lanes`, leaving a block is a step.
    pub(in crate::explore) fn new(case: &'a Case, lanes: bool) -> Self {
        let words = case.instance.layout().locks();
        let lock = |pixel, word| Address { pixel: Some(pixel), word, bits: 32 };
        let of_pixel = |p| words.iter().map(move |&word| case.numbering.number(lock(p, word)));
        Self {
            case,
            lanes,
            locks: (0..case.litmus.pixels).flat_map(of_pixel).take(32).collect(),
            tasks: Vec::new(),
            roots: Vec::new(),
            nodes: Vec::new(),
            ends: Vec::new(),
            stacks: vec![Vec::new()],
            claims: Vec::new(),
            heres: BTreeMap::new(),
            merges: Vec::new(),
            sites: BTreeSet::new(),
            bare_waits: BTreeSet::new(),
            told: Vec::new(),
            most: case.litmus.most_operations(),
        }
    }

    /// The node at which an invocation of this task begins. Equal tasks have one root, so that a search may put their
    /// invocations in order.
    fn root(&mut self, task: Task) -> NodeId {
        self.known_root(task).unwrap_or_else(|| {
            self.tasks.push(task);
            let root = self.grow(None, self.tasks.len() as u32 - 1);
            self.roots.push(root);
            root
        })
    }

    /// The same, if there is one already.
    fn known_root(&self, task: Task) -> Option<NodeId> {
        let known = self.tasks.iter().position(|&t| t == task)?;
        Some(self.roots[known])
    }

    /// A node by its number.
    #[inline]
    pub(in crate::explore) fn node(&self, node: NodeId) -> &Node {
        &self.nodes[node as usize]
    }

    /// The task that a node is of.
    pub(in crate::explore) fn task(&self, node: NodeId) -> Task {
        self.tasks[self.node(node).task as usize]
    }

    /// An outcome by its index in [`Step::Ended`].
    pub(in crate::explore) fn ended(&self, end: u32) -> &Ended {
        &self.ends[end as usize].0
    }

    /// What a panic says, by its index in [`Step::Panics`].
    pub(in crate::explore) fn told(&self, panic: u32) -> &str {
        &self.told[panic as usize]
    }

    /// The open blocks of a node, outermost first.
    pub(in crate::explore) fn stack(&self, node: NodeId) -> &[OpenBlock] {
        &self.stacks[self.node(node).blocks as usize]
    }

    /// Operations and blocks reached: file, line, column.
    pub(in crate::explore) fn sites(&self) -> &BTreeSet<(&'static str, u32, u32)> {
        &self.sites
    }

    /// Waits that stand in no block: file and line.
    pub(in crate::explore) fn bare_waits(&self) -> &BTreeSet<(&'static str, u32)> {
        &self.bare_waits
    }

    /// The node after a node's step gave `answer`, if there is one already (2).
    #[inline]
    fn known_child(&self, node: NodeId, answer: u64) -> Option<NodeId> {
        let children = &self.nodes[node as usize].children;
        children.iter().find(|c| c.0 == answer).map(|&(_, child)| child)
    }

    /// Make the node after a node's step gave `answer`, by running an invocation (2).
    #[cold]
    fn new_child(&mut self, node: NodeId, answer: u64) -> NodeId {
        let task = self.node(node).task;
        let child = self.grow(Some((node, answer)), task);
        self.nodes[node as usize].children.push((answer, child));
        child
    }

    /// Whether an answer to a node's step leads back, to try again.
    pub(in crate::explore) fn goes_back(&self, node: NodeId, answer: u64) -> bool {
        self.claims.contains(&(node, answer))
    }

    /// The answers that lead to a node with this parent: those of its chain (1).
    fn answers(&self, parent: Option<(NodeId, u64)>) -> Vec<Answer> {
        let mut answers = Vec::new();
        let mut at = parent;
        while let Some((node, answer)) = at {
            answers.push(Answer::Value(answer));
            at = self.node(node).parent;
        }
        answers.reverse();
        answers
    }

    /// The node below an edge: run a fresh invocation up to what it asks next, and make a node of that, or find the
    /// one that it is.
    fn grow(&mut self, parent: Option<(NodeId, u64)>, task: u32) -> NodeId {
        let answers = self.answers(parent);
        let last = parent.and_then(|(node, _)| self.node(node).site);
        let standing = self.case.follow(self.tasks[task as usize], &answers, self.lanes);
        for site in standing.opened {
            self.reached(site);
        }
        let (step, site) = match standing.next {
            // Nothing was asked, so there is nothing to go back to.
            Next::Back(_, site) if parent.is_none() => (Step::Merge, Some(site)),
            Next::Back(depth, site) => {
                self.reached(site);
                if standing.blocks.is_empty() {
                    self.bare_waits.insert((site.file(), site.line()));
                }
                return self.back(parent, depth);
            }
            Next::Ended(ended) => match self.end(parent, task, ended) {
                Ok(known) => return known,
                Err(new) => (Step::Ended(new), None),
            },
            Next::Panics(told) => {
                self.told.push(told);
                (Step::Panics(self.told.len() as u32 - 1), None)
            }
            Next::Endless(site) => (Step::Endless, Some(site)),
            Next::Ask(_) if answers.len() >= self.most => (Step::Endless, last),
            Next::Ask(Request::Operation { at, action, site }) => {
                self.reached(site);
                (Step::Operation(self.case.numbering.number(at), action), Some(site))
            }
            Next::Ask(Request::Merge(site)) => (Step::Merge, Some(site)),
            Next::Ask(Request::Spin(..)) => unreachable!("waits are followed back"),
        };
        let held = parent.map_or(0, |(node, answer)| self.held_after(node, answer));
        let fault = self.fault(self.tasks[task as usize], step, held);
        let blocks = self.intern(standing.blocks);
        let id = self.nodes.len() as NodeId;
        if let Some(here) = standing.here {
            // Open blocks decide where lanes come together, and nothing else.
            let place = (task, held, if self.lanes { blocks } else { 0 }, here);
            if let Some(&known) = self.heres.get(&place) {
                // Recorded, to compare this edge's invocation with the known one's.
                self.merges.extend(parent.map(|(from, answer)| (from, answer, known)));
                return known;
            }
            self.heres.insert(place, id);
        }
        let (children, waits) = (Vec::new(), false);
        self.nodes.push(Node { step, site, held, fault, blocks, waits, children, parent, task });
        id
    }

    /// Record a place of the source.
    fn reached(&mut self, site: Site) {
        self.sites.insert((site.file(), site.line(), site.column()));
    }

    /// The node that a wait goes back to: the one on its own chain after `depth` answers (3).
    fn back(&mut self, parent: Option<(NodeId, u64)>, depth: u32) -> NodeId {
        let Some((from, answer)) = parent else { return 0 };
        self.claims.push((from, answer));
        let mut path = vec![from];
        while let Some((node, _)) = self.node(path[path.len() - 1]).parent {
            path.push(node);
        }
        path.reverse();
        let target = path[(depth as usize).min(path.len() - 1)];
        self.nodes[target as usize].waits = true;
        target
    }

    /// The one node of an outcome, or the index for a new one. Locks still held are a fault of their own, so they are
    /// part of what is the same.
    fn end(
        &mut self,
        parent: Option<(NodeId, u64)>,
        task: u32,
        ended: Ended,
    ) -> std::result::Result<NodeId, u32> {
        let held = parent.map_or(0, |(node, answer)| self.held_after(node, answer));
        let same = |(known, id): &&(Ended, NodeId)| {
            let node = self.node(*id);
            *known == ended && node.task == task && node.held == held
        };
        if let Some((_, id)) = self.ends.iter().find(same) {
            return Ok(*id);
        }
        self.ends.push((ended, self.nodes.len() as NodeId));
        Err(self.ends.len() as u32 - 1)
    }

    /// The locks held after a node's step gave `answer` (4). A lock is free at 0; an update takes it if it finds 0
    /// and leaves another value, and frees it the other way round.
    fn held_after(&self, node: NodeId, answer: u64) -> u32 {
        let node = self.node(node);
        let Step::Operation(cell, action) = node.step else { return node.held };
        let Some(lock) = self.locks.iter().position(|&l| l == cell) else { return node.held };
        let bit = 1 << lock;
        match action {
            Action::Read(_) => node.held,
            // These free a lock whatever value they find.
            Action::Write(0, _) | Action::Update(Update::Exchange(0) | Update::And(0), _) => {
                node.held & !bit
            }
            Action::Write(..) => node.held,
            Action::Update(update, _) if answer == 0 && update.apply(0) != 0 => node.held | bit,
            Action::Update(update, _) if answer != 0 && update.apply(answer) == 0 => {
                node.held & !bit
            }
            Action::Update(..) => node.held,
        }
    }

    /// What is wrong with a step, whatever memory holds. A store task must hold the lock that it writes 0 to, by a
    /// store, an exchange or an and; other updates that free a lock are not looked at.
    fn fault(&self, task: Task, step: Step, held: u32) -> Option<Fault> {
        let (cell, action) = match step {
            Step::Operation(cell, action) => (cell, action),
            Step::Merge if !self.lanes => return Some(Fault::WaitsForNothing),
            Step::Ended(_) => return (held != 0).then_some(Fault::KeepsLock),
            Step::Panics(_) => return Some(Fault::Panics),
            Step::Merge | Step::Endless => return None,
        };
        if Numbering::is_outside(cell) {
            return Some(Fault::Outside);
        }
        // The clear pass frees locks, too: no invocation holds one then.
        if !matches!(task, Task::Store(_)) {
            return None;
        }
        let lock = self.locks.iter().position(|&l| l == cell)?;
        let frees = matches!(
            action,
            Action::Write(0, _) | Action::Update(Update::Exchange(0) | Update::And(0), _)
        );
        (frees && held & (1 << lock) == 0).then_some(Fault::ForeignLock)
    }

    /// The index of a list of open blocks; equal lists have one.
    fn intern(&mut self, stack: Vec<OpenBlock>) -> u32 {
        match self.stacks.iter().position(|known| *known == stack) {
            Some(known) => known as u32,
            None => {
                self.stacks.push(stack);
                self.stacks.len() as u32 - 1
            }
        }
    }
}
