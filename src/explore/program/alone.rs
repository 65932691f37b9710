//! Clear and resolve, one invocation after another, where their order cannot matter.
//!
//! Invocations that ran in one order, of which none read a word that nobody had written, and no two accessed one word
//! that one of them wrote, do the same in every other order and under every memory model. By induction over the
//! operations of another order: each reads what it wrote itself, or what was there before the stage, as it did here. So
//! it does next what it did here, and the words that are accessed are the same.

use std::collections::BTreeMap;

use super::forest::{Forest, NodeId, Step};
use super::shared::Shared;
use crate::explore::memory::model::cut;
use crate::memory::Numbering;
use crate::memory::asked::Action;
use crate::scheme::task::{Ended, Task};

/// The most steps of an invocation that runs alone: more only if it waits, and that is for the search to see.
const MOST_STEPS: usize = 1 << 20;

/// Invocations of one stage that ran one after another, and did not meet.
#[derive(Default)]
pub(super) struct Alone {
    /// By number, the last value written.
    pub(super) written: BTreeMap<u32, u64>,
    /// How they ended.
    pub(super) ends: Vec<Ended>,
    /// Where one of them was cut off, if it was: a list that is a ring must not hold us up.
    pub(super) endless: Option<NodeId>,
}

impl Alone {
    /// Run tasks on words that have the values of `below` where none was written. `None` if the order may matter: two
    /// of them meet, or one reads what nobody wrote; or if one leaves its words, panics or waits: that is for the
    /// search to see; or if it was missed in the forest.
    pub(super) fn run(
        forest: &mut Shared<Forest<'_>>,
        tasks: &[Task],
        below: &dyn Fn(u32) -> Option<u64>,
        numbering: &Numbering,
    ) -> Option<Self> {
        let mut alone = Self::default();
        let mut accesses = Accesses::default();
        for (invocation, &task) in tasks.iter().enumerate() {
            let mut node = forest.root(task);
            let mut left = MOST_STEPS;
            loop {
                left = left.checked_sub(1)?;
                let result = match forest.node(node).step {
                    Step::Ended(end) => {
                        alone.ends.push(forest.ended(end).clone());
                        break;
                    }
                    Step::Endless => {
                        alone.endless = Some(node);
                        break;
                    }
                    Step::Merge => 0,
                    Step::Panics(_) => return None,
                    Step::Operation(cell, _) if Numbering::is_outside(cell) => return None,
                    Step::Operation(cell, action) => {
                        if accesses.meet(invocation, cell, !matches!(action, Action::Read(_))) {
                            return None;
                        }
                        let bits = numbering.address(cell).bits;
                        alone.perform(cell, action, bits, below)?
                    }
                };
                node = forest.child(node, result);
                if forest.has_missed() {
                    return None;
                }
            }
        }
        Some(alone)
    }

    /// Perform an operation. The value read, or 0; `None` if nobody wrote it.
    fn perform(
        &mut self,
        cell: u32,
        action: Action,
        bits: u32,
        below: &dyn Fn(u32) -> Option<u64>,
    ) -> Option<u64> {
        let old = || self.written.get(&cell).copied().or_else(|| below(cell));
        let (result, new) = match action {
            Action::Read(_) => return old(),
            Action::Write(value, _) => (0, value),
            Action::Update(update, _) => {
                let old = old()?;
                (old, update.apply(old))
            }
        };
        self.written.insert(cell, cut(new, bits));
        Some(result)
    }
}

/// The words that were accessed.
#[derive(Default)]
struct Accesses(BTreeMap<u32, Accessed>);

/// How a word was accessed.
struct Accessed {
    /// The first invocation that did.
    by: usize,
    /// Others did, too.
    several: bool,
    /// One of them wrote it.
    written: bool,
}

impl Accesses {
    /// Add an access. Returns whether several invocations access the word, and one of them writes it.
    fn meet(&mut self, invocation: usize, cell: u32, writes: bool) -> bool {
        let new = Accessed { by: invocation, several: false, written: false };
        let word = self.0.entry(cell).or_insert(new);
        word.several |= word.by != invocation;
        word.written |= writes;
        word.several && word.written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the last of these accesses (invocation, word, whether it writes) makes invocations meet.
    fn meet(all: &[(usize, u32, bool)]) -> bool {
        let mut accesses = Accesses::default();
        let met =
            all.iter().map(|&(invocation, cell, writes)| accesses.meet(invocation, cell, writes));
        met.last().unwrap_or(false)
    }

    #[test]
    fn invocations_meet_at_a_word_that_one_writes() {
        assert!(!meet(&[(0, 7, true), (0, 7, false), (0, 7, true)]), "one alone");
        assert!(!meet(&[(0, 7, false), (1, 7, false), (2, 7, false)]), "readers");
        assert!(!meet(&[(0, 7, true), (1, 8, true)]), "other words");
        assert!(meet(&[(0, 7, true), (1, 7, false)]), "a reader after a writer");
        assert!(meet(&[(0, 7, false), (1, 7, true)]), "a writer after a reader");
        assert!(meet(&[(0, 7, true), (1, 8, true), (1, 7, true)]), "two writers");
        assert!(meet(&[(0, 7, false), (1, 7, false), (0, 7, true)]), "the first one, later");
    }
}
