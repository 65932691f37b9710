//! Inputs: read-only words that the application fills before the frame, such as an image or a table by triangle.
//!
//! Nothing writes them while invocations run, so a read of one is not a step of an interleaving: it has no order,
//! cannot race, and the explorer treats it as a constant of the instance.

use super::Layout;

/// What an input has a word for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Per {
    /// Each pixel: an image.
    Pixel,
    /// Each triangle of the scene, by its global index ([`Data::Primitive`](crate::fragment::Data)).
    Primitive,
    /// The frame: this many words.
    Frame(u64),
}

/// An input as a scheme declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Declared {
    /// The name by which the application fills it.
    pub name: &'static str,
    /// What it has a word for.
    pub per: Per,
    /// The value of every word that the application does not fill.
    pub default: u32,
    /// The values that checks try; if empty, only the default.
    pub tried: &'static [u32],
}

/// A declared input: the way to its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    pub(super) table: u32,
}

/// The address of one word of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputAt {
    table: u32,
    index: u32,
}

impl Input {
    /// The word of a pixel, of a triangle, or of the frame, as it was declared.
    #[inline(always)]
    #[must_use]
    pub fn at(self, index: u32) -> InputAt {
        InputAt { table: self.table, index }
    }
}

/// The words of all inputs of a scheme.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    tables: Vec<Filled>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Filled {
    words: Vec<u32>,
    /// What a word beyond the last one reads as.
    default: u32,
}

impl Inputs {
    /// Every word has its input's default: nothing is stored.
    #[must_use]
    pub fn defaults(layout: &Layout) -> Self {
        let table = |d: &Declared| Filled { words: Vec::new(), default: d.default };
        Self { tables: layout.inputs().iter().map(table).collect() }
    }

    /// Fill an input: the words of pixels are in storage order. Words beyond the last one have the default.
    pub fn fill(&mut self, input: usize, words: Vec<u32>) {
        self.tables[input].words = words;
    }

    /// A word.
    #[inline]
    #[must_use]
    pub fn get(&self, at: InputAt) -> u32 {
        let table = &self.tables[at.table as usize];
        table.words.get(at.index as usize).copied().unwrap_or(table.default)
    }

    /// Every input's words for this many pixels; those of triangles as far as they were filled.
    #[must_use]
    pub fn tables(&self, layout: &Layout, pixels: u32) -> Vec<Vec<u32>> {
        let table = |(table, declared): (&Filled, &Declared)| {
            let length = match declared.per {
                Per::Pixel => pixels as usize,
                Per::Primitive => table.words.len(),
                Per::Frame(words) => words as usize,
            };
            let mut words = table.words.clone();
            words.resize(length, declared.default);
            words
        };
        self.tables.iter().zip(layout.inputs()).map(table).collect()
    }

    /// The word of an input by its number among the scheme's.
    #[must_use]
    pub fn word(&self, input: usize, index: u32) -> u32 {
        self.get(InputAt { table: input as u32, index })
    }
}
