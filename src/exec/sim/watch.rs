//! Watching a pixel: its fragments, and the part of the schedule that is their own.

use super::pass::Watcher;
use crate::fragment::Fragment;
use crate::scheme::task::Task;

/// What happened at a pixel in the store pass.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Watched {
    /// Its fragments, in the order of their admission.
    pub fragments: Vec<Fragment>,
    /// Which of them performed an operation, one entry per operation.
    pub steps: Vec<u32>,
}

/// Watches one pixel.
#[derive(Clone, Debug)]
pub struct Recording {
    pixel: u32,
    /// Which of the pixel's fragments is in each slot.
    inside: Vec<Option<u32>>,
    watched: Watched,
}

impl Recording {
    pub(super) fn new(pixel: u32) -> Self {
        Self { pixel, inside: Vec::new(), watched: Watched::default() }
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
        self.inside[slot as usize] = own.map(|_| self.watched.fragments.len() as u32);
        self.watched.fragments.extend(own);
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

/// Where passes overlap, stores are told from the rest.
impl Watcher<Task> for Recording {
    fn takes(&mut self, slot: u32, work: &Task) {
        let Task::Store(fragment) = work else { return self.note(slot, None) };
        self.note(slot, Some(fragment));
    }

    fn steps(&mut self, slot: u32) {
        self.step(slot);
    }
}
