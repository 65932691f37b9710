//! Memory as a run goes through it: what every step found and left, and which step wrote what another reads.
//!
//! A model forgets who wrote a value: it is no part of the state. So the writers of each word's versions are kept here,
//! beside the model. Versions are put between others, and only ever dropped from the oldest on, which keeps the two in
//! step.

use crate::explore::memory::model::{Model, cut, writes};
use crate::explore::program::forest::{NodeId, Step};
use crate::explore::program::machine::Machine;
use crate::explore::program::schedule::Move;
use crate::memory::Address;
use crate::memory::asked::Action;

/// What memory held before the first step, and what every step found and left.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    /// Every word with its first value; `None` for one that was never written. In the order of the method's layout: the
    /// frame's, then pixel by pixel.
    pub initial: Vec<(Address, Option<u64>)>,
    /// One for every step.
    pub steps: Vec<Seen>,
}

/// What a step found and left.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// The newest value of the word before the step; `None` if it has none, or if no word is accessed.
    pub before: Option<u64>,
    /// What the step read, if it read.
    pub read: Option<Source>,
    /// The value that it wrote, if it wrote.
    pub wrote: Option<u64>,
    /// The words that are not as they were before the step.
    pub changes: Vec<Change>,
}

/// Where a value that was read comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The step that wrote it, counted from 0; `None` if no step did.
    pub step: Option<usize>,
    /// The steps that had written the word after that: the value that was read is stale if there are any.
    pub newer: Vec<usize>,
}

/// A word after a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The word, by its place in [`Memory::initial`].
    pub word: usize,
    /// The values that some invocation may still read, in the order in which memory has them, the newest last.
    pub versions: Vec<Version>,
    /// For every invocation, the oldest of them that it may still read; `None` for one that has ended. Empty where
    /// memory has one value at a time.
    pub oldest: Vec<Option<usize>>,
}

/// One of a word's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// The value; `None` if it was never written.
    pub value: Option<u64>,
    /// The step that wrote it, counted from 0; `None` if no step did.
    pub by: Option<usize>,
}

/// Follows a run.
pub(super) struct Watch {
    memory: Memory,
    /// The words as they are now, with their writers.
    words: Vec<Change>,
    /// What the step that runs is about to find.
    now: Seen,
    /// The word that it accesses.
    cell: Option<usize>,
}

impl Watch {
    /// Begin with the loaded state.
    pub(super) fn new(machine: &Machine<'_>, nodes: &[NodeId]) -> Self {
        let numbering = machine.numbering();
        let model = machine.memory();
        let count = numbering.count() as u32;
        let initial = (0..count).map(|cell| (numbering.address(cell), model.settled(cell)));
        let word = |cell| Change { word: cell as usize, versions: Vec::new(), oldest: Vec::new() };
        let mut words: Vec<Change> = (0..count).map(word).collect();
        for word in &mut words {
            let values = model.versions(word.word as u32).into_iter();
            word.versions.extend(values.map(|value| Version { value, by: None }));
            word.oldest = oldest(machine, nodes, word.word);
        }
        let memory = Memory { initial: initial.collect(), steps: Vec::new() };
        Self { memory, words, now: Seen::default(), cell: None }
    }

    /// Before a step, with its state loaded.
    pub(super) fn before(&mut self, machine: &Machine<'_>, step: Step, by: Move) {
        self.now = Seen::default();
        self.cell = match step {
            Step::Operation(cell, _) => machine.accessed(cell, by.alternative),
            _ => None,
        }
        .map(|(cell, _)| cell as usize);
        self.now.before = self.cell.and_then(|cell| machine.memory().settled(cell as u32));
    }

    /// When the step was performed. What a helper does but for reading has no effect.
    pub(super) fn performed(&mut self, machine: &Machine<'_>, step: Step, by: Move, result: u64) {
        let (Some(cell), Step::Operation(_, action)) = (self.cell, step) else { return };
        let reads = !matches!(action, Action::Write(..));
        if machine.is_helper(by.invocation.into()) && !matches!(action, Action::Read(_)) {
            return;
        }
        let own = self.memory.steps.len();
        let versions = &mut self.words[cell].versions;
        let last = versions.len() - 1;
        let touched = machine.memory().touched();
        let read = touched.map_or(Some(last), |touched| touched.read).filter(|_| reads);
        self.now.read = read.map(|read| Source {
            step: versions[read].by,
            newer: versions[read + 1..].iter().filter_map(|version| version.by).collect(),
        });
        let version = Version { value: None, by: Some(own) };
        if writes(action, result) {
            let bits = self.memory.initial[cell].0.bits;
            let value = match action {
                Action::Update(update, _) => update.apply(result),
                Action::Write(value, _) => value,
                Action::Read(_) => result,
            };
            self.now.wrote = Some(cut(value, bits));
            match touched {
                None => versions[last] = version,
                // An update that leaves the value as it is need not put one there.
                Some(touched) => {
                    touched.put.into_iter().for_each(|place| versions.insert(place, version));
                }
            }
        }
    }

    /// After the step, with the next state loaded: what has changed. What no step wrote was written at a barrier.
    pub(super) fn settled(&mut self, machine: &Machine<'_>, nodes: &[NodeId]) {
        let mut seen = std::mem::take(&mut self.now);
        let model: &dyn Model = machine.memory();
        let own = self.memory.steps.len();
        for (cell, word) in self.words.iter_mut().enumerate() {
            let values = model.versions(cell as u32);
            let old = word.clone();
            let dropped = word.versions.len().saturating_sub(values.len());
            word.versions.drain(..dropped);
            for (version, value) in word.versions.iter_mut().zip(values) {
                let known = version.value.or(seen.wrote.filter(|_| version.by == Some(own)));
                if known.is_some() && known != value {
                    version.by = None;
                }
                version.value = value;
            }
            word.oldest = oldest(machine, nodes, cell);
            if *word != old {
                seen.changes.push(word.clone());
            }
        }
        self.memory.steps.push(seen);
    }

    /// What was seen.
    pub(super) fn memory(self) -> Memory {
        self.memory
    }
}

/// For every invocation, the oldest version of a word that it may still read.
fn oldest(machine: &Machine<'_>, nodes: &[NodeId], cell: usize) -> Vec<Option<usize>> {
    if machine.is_sequential() {
        return Vec::new();
    }
    let live = machine.live(nodes);
    let lives = |invocation: usize| live & (1 << invocation) != 0;
    let own = |i| lives(i).then(|| machine.memory().oldest(i, cell as u32));
    (0..nodes.len()).map(own).collect()
}
