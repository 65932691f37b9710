//! Counter-based random numbers: a value is a pure function of (seed, stream, index), so that results do not depend on
//! the order of requests. The mixer is `SplitMix64`'s finalizer (Steele, Lea, Flood, "Fast splittable pseudorandom
//! number generators", OOPSLA 2014), applied once per input word.

/// The 64 random bits at `index` of `stream` under `seed`.
#[must_use]
pub fn bits(seed: u64, stream: u64, index: u64) -> u64 {
    mix(mix(mix(seed).wrapping_add(stream)).wrapping_add(index))
}

fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// Random bits as a number uniform in `0..n` (multiply-shift; the bias is below n / 2^64). `n` = 0 gives 0.
#[inline]
#[must_use]
pub fn below(bits: u64, n: u64) -> u64 {
    ((u128::from(bits) * u128::from(n)) >> 64) as u64
}

/// One stream read in order: for generators that simply want "the next one".
#[derive(Clone, Debug)]
pub struct Random {
    /// Seed and stream, mixed.
    base: u64,
    next: u64,
}

impl Random {
    /// The stream `stream` under `seed`, at its beginning.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Self { base: mix(mix(seed).wrapping_add(stream)), next: 0 }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.next += 1;
        mix(self.base.wrapping_add(self.next - 1))
    }

    /// [`below`] of the next bits.
    pub fn below(&mut self, n: u64) -> u64 {
        below(self.bits(), n)
    }

    /// Uniform in [0, 1): a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A uniformly random permutation in place (Fisher-Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_in_order_is_the_stream_by_index() {
        let mut random = Random::new(7, 3);
        assert!((0..100).all(|i| random.bits() == bits(7, 3, i)));
    }

    #[test]
    fn below_and_unit_keep_their_ranges() {
        let mut random = Random::new(0, 0);
        assert!((0..1_000).all(|_| random.below(3) < 3 && (0.0..1.0).contains(&random.unit())));
        assert_eq!(random.below(0), 0);
    }
}
