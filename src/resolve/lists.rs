//! What a frame's pixels hold, row by row.

use crate::scheme::{Depth, HeldKind, Light, Record};

/// The lists of every pixel, front to back: of fragments as keys (depth in the upper half, data word in the lower), or
/// of merged records.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists<T = u64> {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row-major; pixel p's entries are `entries[offsets[p]..offsets[p + 1]]`.
    pub offsets: Vec<u64>,
    /// All entries.
    pub entries: Vec<T>,
}

impl<T> Lists<T> {
    /// The entries of pixel (x, y), front to back.
    ///
    /// # Panics
    /// If the pixel lies outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> &[T] {
        let p = (y as usize) * (self.width as usize) + x as usize;
        &self.entries[self.offsets[p] as usize..self.offsets[p + 1] as usize]
    }
}

impl<T: Copy> Lists<T> {
    /// What remains after `keep` has cut every pixel's list; `keep` gets the pixel's number, row by row.
    #[must_use]
    pub fn cut(&self, keep: impl Fn(usize, &mut Vec<T>)) -> Self {
        let (mut offsets, mut entries) = (vec![0], Vec::new());
        for (pixel, ends) in self.offsets.windows(2).enumerate() {
            let mut list = self.entries[ends[0] as usize..ends[1] as usize].to_vec();
            keep(pixel, &mut list);
            entries.extend(list);
            offsets.push(entries.len() as u64);
        }
        Self { offsets, entries, ..*self }
    }
}

/// What the pixels of a frame hold after resolve.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kept {
    /// Lists of fragments.
    Fragments(Lists),
    /// Lists of merged records.
    Records(Lists<Record>),
    /// A colour for every pixel, row by row, and no lists.
    Color(Vec<Light>),
    /// A depth for every pixel, row by row, and no lists.
    Depths(Vec<Depth>),
    /// Lists of this kind, which are not at hand: nobody wanted more than their hash or the picture.
    Gone(HeldKind),
}

impl Kept {
    /// Which kind it is.
    #[must_use]
    pub fn kind(&self) -> HeldKind {
        match self {
            Self::Fragments(_) => HeldKind::Fragments,
            Self::Records(_) => HeldKind::Records,
            Self::Color(_) => HeldKind::Color,
            Self::Depths(_) => HeldKind::Depth,
            &Self::Gone(kind) => kind,
        }
    }

    /// How many pixels' colours are no number, if it is colours.
    #[must_use]
    pub fn nan_pixels(&self) -> Option<u64> {
        let is_nan = |light: &&Light| light.color.iter().any(|c| c.is_nan());
        match self {
            Self::Color(pixels) => Some(pixels.iter().filter(is_nan).count() as u64),
            Self::Fragments(_) | Self::Records(_) | Self::Depths(_) | Self::Gone(_) => None,
        }
    }

    /// The lists of fragments, if it is those.
    #[must_use]
    pub fn fragments(&self) -> Option<&Lists> {
        match self {
            Self::Fragments(lists) => Some(lists),
            Self::Records(_) | Self::Color(_) | Self::Depths(_) | Self::Gone(_) => None,
        }
    }
}
