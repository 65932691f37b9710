//! The names of a layout's words: what people read in place of numbers.

use super::{Address, Space};
use crate::memory::word::Word;

/// Which words have which name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Names {
    runs: Vec<Run>,
    next: Option<&'static str>,
}

/// Words that were declared together.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Run {
    name: &'static str,
    global: bool,
    bits: u32,
    first: u64,
    count: u64,
}

impl Names {
    /// The next words have this name.
    pub(super) fn next(&mut self, name: &'static str) {
        self.next = Some(name);
    }

    /// The next words have this name, if they have no other.
    pub(super) fn next_or(&mut self, name: &'static str) {
        self.next.get_or_insert(name);
    }

    /// Words were declared.
    pub(super) fn give<S: Space, W: Word>(&mut self, first: u64, count: u64) {
        if let Some(name) = self.next.take() {
            self.runs.push(Run { name, global: S::GLOBAL, bits: W::BITS, first, count });
        }
    }

    /// A word's name.
    pub(super) fn of(&self, address: Address) -> Option<String> {
        let has = |run: &&Run| {
            let place = address.word.checked_sub(run.first);
            (run.global, run.bits) == (address.pixel.is_none(), address.bits)
                && place.is_some_and(|place| place < run.count)
        };
        let run = self.runs.iter().find(has)?;
        let place = address.word - run.first;
        Some(if run.count == 1 { run.name.to_owned() } else { format!("{}[{place}]", run.name) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Atomic, Global, Layout, Pixel, Plain, Words};
    use super::*;

    #[test]
    fn words_have_the_name_that_was_given_before_them() {
        let mut layout = Layout::default();
        let _ = layout.lock();
        let _: Words<Pixel, Plain, u32> = layout.named("depth").pixel(2);
        let _: Words<Pixel, Atomic, u64> = layout.pixel(1);
        let _: Words<Global, Plain, u64> = layout.named("keys").global(3);
        let _ = layout.named("turns").interlock();
        let name = |pixel, word, bits| layout.name_of(Address { pixel, word, bits });
        let is = |name: &str| Some(name.to_owned());
        assert_eq!(name(Some(0), 0, 32), is("lock"));
        assert_eq!(name(Some(5), 2, 32), is("depth[1]"));
        assert_eq!(name(Some(0), 3, 32), is("turns"));
        assert_eq!(name(None, 2, 64), is("keys[2]"));
        assert_eq!(name(Some(0), 0, 64), None, "declared without a name");
        assert_eq!((name(None, 3, 64), name(None, 0, 32)), (None, None), "not there");
    }
}
