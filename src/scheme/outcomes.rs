//! What became of the fragments of a block.

use super::Outcome;

/// How many kinds of outcomes there may be.
const KINDS: usize = Outcome::Merged as usize + 1;

/// The outcomes of a batch: for each kind, the bits of the fragments that had it. Fragments without a bit were kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcomes {
    masks: [u64; KINDS],
    /// All of them. It is read right after they were written, and a wide load would have to wait for narrow stores.
    gone: u64,
}

impl Outcomes {
    /// For another batch: all are kept.
    #[inline]
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// What became of the fragment at a bit. It is said once.
    #[inline]
    pub fn set(&mut self, bit: u32, outcome: Outcome) {
        if outcome != Outcome::Kept {
            let own = 1 << (bit & 63);
            self.masks[outcome as usize] |= own;
            self.gone |= own;
        }
    }

    /// What became of those at each mask's bits; the others are kept. No two masks share a bit.
    #[inline]
    pub fn assign<const N: usize>(&mut self, all: [(u64, Outcome); N]) {
        self.reset();
        for (mask, outcome) in all.into_iter().filter(|(_, outcome)| *outcome != Outcome::Kept) {
            self.masks[outcome as usize] = mask;
            self.gone |= mask;
        }
    }

    /// The bits of the fragments that were not kept.
    #[inline]
    #[must_use]
    pub fn gone(&self) -> u64 {
        self.gone
    }

    /// The code of that of the fragment at bit 0.
    #[must_use]
    pub fn first(&self) -> u32 {
        (0..).zip(&self.masks).find(|(_, mask)| *mask & 1 != 0).map_or(0, |(code, _)| code)
    }

    /// How many have this outcome, of at most 64; those at bits that are not set count as kept.
    #[inline]
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u64 {
        let mask = match outcome {
            Outcome::Kept => !self.gone,
            other => self.masks[other as usize],
        };
        // Most are 0.
        if mask == 0 { 0 } else { mask.count_ones().into() }
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
            outcomes.reset();
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
                let mut alone = Outcomes::default();
                let code = 2 * (evicted >> bit & 1) + 8 * (age >> bit & 1);
                alone.masks = outcomes.masks.map(|mask| mask >> bit & 1);
                assert_eq!(u64::from(alone.first()), code, "{bit}");
            }
        }
        outcomes.reset();
        assert_eq!(
            (outcomes.gone(), outcomes.count(Outcome::Kept)),
            (0, 64),
            "nothing is left over"
        );
    }
}
