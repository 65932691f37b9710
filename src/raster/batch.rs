//! The fragments of one packet, word by word: what the store pass works through.
//!
//! A word of a fragment lies at the bit that the fragment has in the packet's mask, so that whole blocks are written as
//! lanes, a fragment is left out by its bit, and nothing is moved. Places whose bit is not set hold anything.

use crate::fragment::Fragment;

/// Words of a block: one for each pixel.
pub(super) type Lanes = [u32; 64];

/// The fragments of one packet.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The place of the block's first pixel in the executor's storage.
    pub(super) first: u32,
    pub(super) mask: u64,
    pub(super) depths: Lanes,
    pub(super) data: Same,
    pub(super) extras: Same,
}

/// Lanes that may all hold one value, which need not be written twice.
#[derive(Clone, Debug)]
pub(super) struct Same {
    lanes: Lanes,
    value: Option<u32>,
}

impl Default for Same {
    fn default() -> Self {
        Self { lanes: [0; 64], value: Some(0) }
    }
}

impl Same {
    /// Hold one value.
    #[inline]
    pub(super) fn fill(&mut self, value: u32) {
        if self.value != Some(value) {
            *self = Self { lanes: [value; 64], value: Some(value) };
        }
    }

    /// Hold several.
    #[inline]
    pub(super) fn lanes(&mut self) -> &mut Lanes {
        self.value = None;
        &mut self.lanes
    }
}

impl Default for Batch {
    fn default() -> Self {
        let (data, extras) = (Same::default(), Same::default());
        Self { first: 0, mask: 0, depths: [0; 64], data, extras }
    }
}

/// The numbers of the bits that are set, the lowest first.
#[inline]
pub fn bits(mut mask: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = (mask != 0).then(|| mask.trailing_zeros());
        mask &= mask.wrapping_sub(1);
        bit
    })
}

impl Batch {
    /// A single fragment.
    #[must_use]
    pub fn one(fragment: Fragment) -> Self {
        let mut batch = Self { first: fragment.pixel, mask: 1, ..Self::default() };
        batch.depths[0] = fragment.depth;
        batch.data.fill(fragment.data);
        batch.extras.fill(fragment.extra);
        batch
    }

    /// Fragments of one block: of pixels from a multiple of 64 on, none of which has two. Of several, the last counts.
    #[must_use]
    pub fn of_block(fragments: &[Fragment]) -> Self {
        let mut batch = Self::default();
        for fragment in fragments {
            let bit = fragment.pixel % 64;
            batch.first = fragment.pixel - bit;
            batch.mask |= 1 << bit;
            batch.depths[bit as usize] = fragment.depth;
            batch.data.lanes()[bit as usize] = fragment.data;
            batch.extras.lanes()[bit as usize] = fragment.extra;
        }
        batch
    }

    /// Which pixels of the block have one: bit `8 * y + x`.
    #[inline]
    #[must_use]
    pub fn mask(&self) -> u64 {
        self.mask
    }

    /// The place of the block's first pixel in the executor's storage, which has the fragment of bit 0.
    #[inline]
    #[must_use]
    pub fn first(&self) -> u32 {
        self.first
    }

    /// The depth words, each at its bit; places whose bit is not set hold anything.
    #[inline]
    #[must_use]
    pub fn depths(&self) -> &[u32; 64] {
        &self.depths
    }

    /// The data words, in the same way.
    #[inline]
    #[must_use]
    pub fn data(&self) -> &[u32; 64] {
        &self.data.lanes
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.mask.count_ones() as usize
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.mask == 0
    }

    /// The fragment at a bit that is set.
    #[allow(clippy::inline_always, reason = "the cost of a scheme is the cost of its store pass")]
    #[inline(always)]
    #[must_use]
    pub fn get(&self, bit: u32) -> Fragment {
        // A bit is below 64; the mask only spares the check.
        let i = bit as usize & 63;
        Fragment {
            pixel: self.first + bit,
            depth: self.depths[i],
            data: self.data.lanes[i],
            extra: self.extras.lanes[i],
        }
    }

    /// The fragments, in the order of the mask's bits.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = Fragment> + '_ {
        bits(self.mask).map(|bit| self.get(bit))
    }

    /// Give every fragment the third word that `rank` knows by its bit.
    #[inline]
    pub fn rank(&mut self, mut rank: impl FnMut(u32) -> u32) {
        let lanes = self.extras.lanes();
        bits(self.mask).for_each(|bit| lanes[bit as usize] = rank(bit));
    }

    /// Leave out those for which `is_rejected` is true, and give their bits.
    #[inline]
    pub fn reject(&mut self, is_rejected: impl Fn(&Fragment) -> bool) -> u64 {
        let of = |bit: u32| u64::from(is_rejected(&self.get(bit))) << bit;
        let rejected: u64 = bits(self.mask).map(of).sum();
        self.mask &= !rejected;
        rejected
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_with_their_bits() {
        let mut batch = Batch { first: 64, mask: 0x8000_0000_0000_0105, ..Batch::default() };
        batch.depths = std::array::from_fn(|i| 10 * i as u32);
        batch.data.fill(7);
        batch.rank(|bit| bit + 1);
        let made: Vec<_> = batch.iter().map(|f| (f.pixel, f.depth, f.data, f.extra)).collect();
        assert_eq!(made, [(64, 0, 7, 1), (66, 20, 7, 3), (72, 80, 7, 9), (127, 630, 7, 64)]);
        assert_eq!(batch.reject(|f| f.depth > 50 && f.depth < 100), 1 << 8);
        assert_eq!((batch.mask(), batch.len()), (0x8000_0000_0000_0005, 3));
        batch.extras.fill(0);
        batch.data.lanes()[2] = 9;
        batch.data.fill(7);
        assert!(batch.iter().all(|f| f.extra == 0 && f.data == 7), "filled again");
        let one = |pixel| Fragment { pixel, depth: 6 * pixel, data: 7, extra: 8 };
        assert!(Batch::one(one(5)).iter().eq([one(5)]));
        assert!(Batch::of_block(&[one(67), one(64)]).iter().eq([one(64), one(67)]));
    }
}
