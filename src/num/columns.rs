//! Counts of single bits of masks, for many masks at a time.
//!
//! A counter per bit is kept as columns of binary digits: digit d of the 64 counters of a place is one word. To add a
//! mask is to add 64 numbers of one digit with carry, which ends after two digits on average (Harley and Seal's
//! carry-save counting, in Warren, "Hacker's Delight", 2nd edition 2012, section 5-1).

use super::lanes::wide;

/// 64 counters for each of a number of places.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    places: usize,
    /// The lowest digits of all places, then the next ones.
    digits: Vec<u64>,
}

impl Columns {
    /// Zeroes.
    #[must_use]
    pub fn new(places: usize) -> Self {
        Self { places, digits: vec![0; places] }
    }

    /// Back to zeroes, for so many places.
    pub fn reset(&mut self, places: usize) {
        self.places = places;
        self.digits.clear();
        self.digits.resize(places, 0);
    }

    /// Add 1 to the counters of a place whose bits are set.
    ///
    /// # Panics
    /// If there is no such place.
    #[inline]
    pub fn add(&mut self, place: usize, mask: u64) {
        let (mut carry, mut at) = (mask, place);
        while carry != 0 {
            if at >= self.digits.len() {
                self.grow();
            }
            let digit = &mut self.digits[at];
            (*digit, carry) = (*digit ^ carry, *digit & carry);
            at += self.places;
        }
    }

    #[cold]
    fn grow(&mut self) {
        self.digits.resize(self.digits.len() + self.places, 0);
    }

    /// The counter of one bit.
    #[must_use]
    pub fn get(&self, place: usize, bit: u32) -> u32 {
        let digits = self.digits.iter().skip(place).step_by(self.places.max(1));
        digits.zip(0..).fold(0, |sum, (digit, d)| sum | ((digit >> bit & 1) as u32) << d)
    }

    /// Add the counters of the places from `first` on to `counts`, 64 for each place.
    pub fn add_to(&self, first: usize, counts: &mut [u32]) {
        let counts = counts.as_chunks_mut::<64>().0;
        wide(
            #[inline(always)]
            || {
                for (place, counts) in (first..).zip(counts) {
                    for (digits, d) in self.digits.chunks_exact(self.places.max(1)).zip(0..) {
                        add_digit(digits[place], d, counts);
                    }
                }
            },
        );
    }

    /// All counters, 64 for each place.
    #[must_use]
    pub fn counts(&self) -> Vec<u32> {
        let mut counts = vec![0; 64 * self.places];
        self.add_to(0, &mut counts);
        counts
    }
}

/// Add 2^d to the counts at the bits of a digit.
#[allow(clippy::inline_always, reason = "see `lanes`")]
#[inline(always)]
fn add_digit(digit: u64, d: u32, counts: &mut [u32; 64]) {
    if digit == 0 {
        return;
    }
    for (half, counts) in
        [digit as u32, (digit >> 32) as u32].into_iter().zip(counts.chunks_mut(32))
    {
        for (bit, count) in counts.iter_mut().enumerate() {
            *count += (half >> bit & 1) << d;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn as_one_counter_after_another(
            masks in prop::collection::vec((0usize..3, prop_oneof![any::<u64>(), Just(u64::MAX), Just(1)]), 0..90),
        ) {
            let (mut columns, mut plain) = (Columns::new(3), vec![0u32; 192]);
            for &(place, mask) in &masks {
                columns.add(place, mask);
                for bit in 0..64 {
                    plain[64 * place + bit] += (mask >> bit & 1) as u32;
                }
            }
            prop_assert_eq!(columns.counts(), &plain[..]);
            for (i, &count) in plain.iter().enumerate() {
                prop_assert_eq!(columns.get(i / 64, i as u32 % 64), count);
            }
            let mut twice = plain[64..].to_vec();
            columns.add_to(1, &mut twice);
            prop_assert!(twice.iter().zip(&plain[64..]).all(|(a, b)| *a == 2 * b));
            columns.reset(2);
            prop_assert_eq!(columns, Columns::new(2));
        }
    }

    #[test]
    fn many_of_one_pixel() {
        let mut columns = Columns::new(1);
        (0..70_000).for_each(|_| columns.add(0, 1 << 63));
        assert_eq!((columns.get(0, 63), columns.get(0, 0)), (70_000, 0));
    }
}
