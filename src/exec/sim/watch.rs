//! Watching a pixel: its fragments, and their part of the schedule.

use super::slots::Watcher;
use crate::fragment::Fragment;
use crate::scheme::task::Task;

/// What happened at a pixel in the geometry passes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Watched {
    /// Its fragments, in the order of their admission.
    pub fragments: Vec<Fragment>,
    /// Which of them performed an operation, one entry per operation.
    pub steps: Vec<u32>,
    /// Where the steps of each stage begin: passes of the program between two barriers, over all rounds.
    pub stages: Vec<usize>,
}

impl Watched {
    /// The steps, each with the number of its stage.
    pub fn staged(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        let stage = |i: usize| self.stages.partition_point(|&begin| begin <= i).saturating_sub(1);
        self.steps.iter().enumerate().map(move |(i, &step)| (stage(i), step))
    }
}

/// Watches one pixel.
#[derive(Clone, Debug)]
pub(super) struct Recording {
    pixel: u32,
    /// Which of the pixel's fragments is in each slot.
    inside: Vec<Option<u32>>,
    /// Fragments of the pixel that were admitted in the present pass.
    admitted: u32,
    watched: Watched,
}

impl Recording {
    pub(super) fn new(pixel: u32) -> Self {
        Self { pixel, inside: Vec::new(), admitted: 0, watched: Watched::default() }
    }

    /// Another stage begins.
    pub(super) fn begin(&mut self) {
        self.admitted = 0;
        self.watched.stages.push(self.watched.steps.len());
    }

    pub(super) fn finish(self) -> Watched {
        self.watched
    }
}

impl Recording {
    fn note(&mut self, slot: u32, fragment: Option<&Fragment>) {
        if self.inside.len() <= slot as usize {
            self.inside.resize(slot as usize + 1, None);
        }
        let own = fragment.filter(|fragment| fragment.pixel == self.pixel);
        self.inside[slot as usize] = own.map(|_| self.admitted);
        let Some(own) = own else { return };
        // Every geometry pass has the same fragments, in the same order.
        if self.admitted as usize == self.watched.fragments.len() {
            self.watched.fragments.push(*own);
        }
        self.admitted += 1;
    }

    fn step(&mut self, slot: u32) {
        let inside = self.inside.get(slot as usize).copied().flatten();
        self.watched.steps.extend(inside);
    }
}

impl Watcher<Fragment> for Recording {
    fn takes(&mut self, slot: u32, fragment: &Fragment) {
        self.note(slot, Some(fragment));
    }

    fn steps(&mut self, slot: u32) {
        self.step(slot);
    }
}

/// In other passes, work for a fragment is distinguished from the rest.
impl Watcher<Task> for Recording {
    fn takes(&mut self, slot: u32, work: &Task) {
        let (Task::Store(fragment) | Task::Prepare(_, fragment)) = work else {
            return self.note(slot, None);
        };
        self.note(slot, Some(fragment));
    }

    fn steps(&mut self, slot: u32) {
        self.step(slot);
    }
}
