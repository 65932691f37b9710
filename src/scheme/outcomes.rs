//! What became of the fragments of a block.

use super::Outcome;

/// The outcomes of a batch, a byte for each fragment at its bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcomes {
    codes: [u8; 64],
}

impl Default for Outcomes {
    fn default() -> Self {
        Self { codes: [Outcome::Kept as u8; 64] }
    }
}

impl Outcomes {
    /// For another batch, of fragments at these bits. What is not set is kept.
    #[inline]
    pub fn reset(&mut self, mask: u64) {
        if mask != u64::MAX {
            *self = Self::default();
        }
    }

    /// What became of the fragment at a bit.
    #[inline]
    pub fn set(&mut self, bit: u32, outcome: Outcome) {
        self.codes[bit as usize & 63] = outcome as u8;
    }

    /// What became of all of them: of those at each mask's bits, that; the others were kept. No two masks share a bit.
    #[inline]
    pub fn assign<const N: usize>(&mut self, all: [(u64, Outcome); N]) {
        const ONES: u64 = 0x0101_0101_0101_0101;
        for (i, codes) in self.codes.as_chunks_mut::<8>().0.iter_mut().enumerate() {
            let code = |(mask, outcome): &(u64, Outcome)| {
                // Byte b keeps bit b alone; then the bytes that have any become 1.
                let own = ((mask >> (8 * i) & 0xFF) * ONES) & 0x8040_2010_0804_0201;
                (((own + 0x7F * ONES) >> 7) & ONES) * *outcome as u64
            };
            *codes = all.iter().map(code).fold(0, |sum, code| sum | code).to_le_bytes();
        }
    }

    /// The bits of the fragments that were not kept.
    #[inline]
    #[must_use]
    pub fn gone(&self) -> u64 {
        const LOW: u64 = 0x7F7F_7F7F_7F7F_7F7F;
        let mut gone = 0;
        for (i, bytes) in self.codes.as_chunks().0.iter().enumerate() {
            let bytes = u64::from_le_bytes(*bytes);
            // The upper bit of every byte that is not 0, then these eight side by side.
            let upper = (((bytes & LOW) + LOW) | bytes) & !LOW;
            gone |= ((upper >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i);
        }
        gone
    }

    /// The code of the first one's.
    #[must_use]
    pub fn first(&self) -> u32 {
        self.codes[0].into()
    }

    /// How many have this outcome, of at most 64; those at bits that are not set count as kept.
    #[inline]
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u64 {
        u64::from(self.codes.iter().map(|&code| u8::from(code == outcome as u8)).sum::<u8>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_are_counted_and_found_by_their_bits() {
        let all = [
            Outcome::Kept,
            Outcome::Culled,
            Outcome::Evicted,
            Outcome::Overflow,
            Outcome::Pool,
            Outcome::Duplicate,
            Outcome::Age,
            Outcome::Merged,
        ];
        let mut outcomes = Outcomes::default();
        for round in 0..8 {
            outcomes.reset(u64::MAX);
            let of = |bit: u32| all[((bit * bit + round) % 11 % 8) as usize];
            (0..64).for_each(|bit| outcomes.set(bit, of(bit)));
            for outcome in all {
                let count = (0..64).filter(|&bit| of(bit) == outcome).count();
                assert_eq!(outcomes.count(outcome), count as u64, "{outcome:?}");
            }
            let gone: u64 =
                (0..64).filter(|&bit| of(bit) != Outcome::Kept).map(|bit| 1 << bit).sum();
            assert_eq!(outcomes.gone(), gone);
        }
        for (evicted, age) in [(0, 0), (u64::MAX, 0), (1 << 63 | 0x1234, 0xFFFF << 40 | 1)] {
            outcomes.assign([(evicted, Outcome::Evicted), (age, Outcome::Merged)]);
            for bit in 0..64 {
                let code = 2 * (evicted >> bit & 1) + 8 * (age >> bit & 1);
                assert_eq!(u64::from(outcomes.codes[bit]), code, "{bit}");
            }
        }
        outcomes.reset(5);
        assert_eq!(
            (outcomes.gone(), outcomes.count(Outcome::Kept)),
            (0, 64),
            "nothing is left over"
        );
    }
}
