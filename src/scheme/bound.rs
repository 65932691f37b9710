//! How many of a pixel's nearest fragments a method is held to.

/// One number for all pixels, one for each, or none.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Bound {
    /// All fragments.
    #[default]
    All,
    /// So many of every pixel.
    Same(u32),
    /// So many of each pixel, by its place in storage.
    PerPixel(Vec<u32>),
}

impl Bound {
    /// From `-k`: `None` is all.
    #[must_use]
    pub fn of(k: Option<u32>) -> Self {
        k.map_or(Self::All, Self::Same)
    }

    /// The bound of a pixel, if it has one.
    #[inline]
    #[must_use]
    pub fn at(&self, pixel: usize) -> Option<u32> {
        match self {
            Self::All => None,
            Self::Same(k) => Some(*k),
            Self::PerPixel(ks) => Some(ks.get(pixel).copied().unwrap_or(0)),
        }
    }

    /// How many of a pixel's `n` fragments are within its bound.
    #[inline]
    #[must_use]
    pub fn cut(&self, pixel: usize, n: usize) -> usize {
        self.at(pixel).map_or(n, |k| n.min(k as usize))
    }
}
