//! A debug check of the simulated device: after every step of a store pass, what a method guarantees about its words.

use super::slots::Check;
use crate::exec::Instance;
use crate::memory::sim::{Change, Sim};
use crate::memory::{Address, Counters, Growing, Snapshot};
use crate::scheme::Moment;

/// What was checked, and what was wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Checked {
    /// Steps that changed a word of the frame, each of which was checked.
    pub steps: u64,
    /// Steps after which something was wrong.
    pub violations: u64,
    /// The first of them.
    pub first: Option<String>,
}

/// Checks every change of the frame's words: those that must grow do, and the invariant holds for the pixel that the
/// changed word belongs to.
pub(super) struct Checker<'a> {
    instance: &'a dyn Instance,
    mem: &'a Sim<Counters>,
    checked: Checked,
}

impl<'a> Checker<'a> {
    pub(super) fn new(instance: &'a dyn Instance, mem: &'a Sim<Counters>) -> Self {
        Self { instance, mem, checked: Checked::default() }
    }

    /// A store pass begins.
    pub(super) fn begin(&mut self) -> &mut Self {
        self.mem.tell_changes(true);
        self
    }

    /// It has ended.
    pub(super) fn end(&mut self) {
        self.mem.tell_changes(false);
    }

    pub(super) fn finish(self) -> Checked {
        self.checked
    }

    fn look(&self, change: Change) -> Result<(), String> {
        let Change { bits, word, old, new } = change;
        let grows = |g: &Growing| g.bits == bits && g.words.contains(&word);
        if new < old && self.instance.layout().growing().iter().any(grows) {
            return Err(format!("a word that only grows fell from {old:x} to {new:x}"));
        }
        let Some(pixel) = self.instance.owner(bits, word, new) else { return Ok(()) };
        let value = |address: Address| self.mem.value(address);
        let words = Snapshot { value: &value };
        self.instance.invariant(&words, pixel, Moment::Always)
    }
}

impl Check for Checker<'_> {
    fn step(&mut self) {
        let Some(change) = self.mem.take_change() else { return };
        self.checked.steps += 1;
        if let Err(message) = self.look(change) {
            self.checked.violations += 1;
            self.checked.first.get_or_insert(message);
        }
    }
}
