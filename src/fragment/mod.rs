//! The only types that cross from the rasterizer to the schemes, and their canonical order.

mod merge_exchange;
mod network;
pub mod sort;

use std::fmt;
use std::ops::Range;

/// One sample of one primitive at one pixel.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Fragment {
    /// Which pixel's memory it goes to: an index into the executor's pixel storage, not a screen position.
    pub pixel: u32,
    /// Stored depth: a code in the run's `num::depth::Format`, never `EMPTY`.
    pub depth: u32,
    /// RGBA8 with R in the low byte, or the global triangle index, as the run says.
    pub data: u32,
    /// A third word, as the method's contract says (`Contract::extra`): its rank, the near end of its slab, or 0.
    pub extra: u32,
}

impl Fragment {
    /// Depth in the upper half, data in the lower: the canonical total order of fragments.
    #[inline]
    #[must_use]
    pub fn key(self) -> u64 {
        key(self.depth, self.data)
    }

    /// One that is not stored yet, by its key alone.
    #[must_use]
    pub fn of_key(key: u64) -> Self {
        Self { depth: depth_of(key), data: data_of(key), ..Self::default() }
    }
}

impl fmt::Debug for Fragment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "p{} {:08x}:{:08x}", self.pixel, self.depth, self.data)
    }
}

/// The sort key of a stored fragment.
#[inline]
#[must_use]
pub const fn key(depth: u32, data: u32) -> u64 {
    ((depth as u64) << 32) | data as u64
}

/// [`key`] of a pair (depth, data).
#[inline]
#[must_use]
pub fn pair_key((depth, data): (u32, u32)) -> u64 {
    key(depth, data)
}

/// The depth word of a key.
#[inline]
#[must_use]
pub fn depth_of(key: u64) -> u32 {
    (key >> 32) as u32
}

/// The data word of a key.
#[inline]
#[must_use]
pub fn data_of(key: u64) -> u32 {
    key as u32
}

/// Edge of a block in pixels: one packet covers at most `BLOCK` x `BLOCK` pixels.
pub const BLOCK: u32 = 8;

/// The covered pixels of one primitive in one 8x8 block: what rasterizer threads hand to workers (16 bytes for up
/// to 64 fragments).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Index of the primitive in the front end's list.
    pub primitive: u32,
    /// Block column, in units of 8 pixels from the left.
    pub column: u16,
    /// Block row, in units of 8 pixels from the top.
    pub row: u16,
    /// Bit `8 * y + x` is the pixel (x, y) of the block; never 0.
    pub mask: u64,
}

/// The 32-bit word stored with a depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Data {
    /// Linear RGBA8.
    #[default]
    Color,
    /// The global triangle index; the colour is looked up at resolve.
    Primitive,
    /// 0: depth is all that is stored.
    Nothing,
}

/// The places of lists that lie one after another, by where each ends.
#[inline]
pub fn places(ends: &[u32]) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut begin = 0;
    ends.iter().map(move |&end| {
        let list = begin..end as usize;
        begin = list.end;
        list
    })
}
