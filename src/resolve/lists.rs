//! The kept fragments of a frame.

/// The kept fragments of every pixel, front to back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row-major; pixel p's fragments are `keys[offsets[p]..offsets[p + 1]]`.
    pub offsets: Vec<u64>,
    /// Depth in the upper half, data word in the lower.
    pub keys: Vec<u64>,
}

impl Lists {
    /// The keys of pixel (x, y), front to back.
    ///
    /// # Panics
    /// If the pixel lies outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> &[u64] {
        let p = (y as usize) * (self.width as usize) + x as usize;
        &self.keys[self.offsets[p] as usize..self.offsets[p + 1] as usize]
    }

    /// What remains when `keep` has cut every pixel's list.
    #[must_use]
    pub fn cut(&self, keep: impl Fn(&mut Vec<u64>)) -> Self {
        let (mut offsets, mut keys) = (vec![0], Vec::new());
        for ends in self.offsets.windows(2) {
            let mut list = self.keys[ends[0] as usize..ends[1] as usize].to_vec();
            keep(&mut list);
            keys.extend(list);
            offsets.push(keys.len() as u64);
        }
        Self { offsets, keys, ..*self }
    }
}
