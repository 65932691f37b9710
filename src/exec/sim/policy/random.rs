//! `random`: a uniformly random resident invocation, from a seed.

use super::Scheduler;
use crate::error::Result;
use crate::num::random::{Random, below};

/// The stream of this policy's random numbers.
const STREAM: u64 = 0x5C4E_D01E;

/// Picks whose bits are drawn before they are made: an invocation's way into the cache takes longer than a step.
const AHEAD: usize = 8;

/// The filled slots, and the position of each.
#[derive(Debug)]
pub(super) struct RandomSlot {
    random: Random,
    /// The bits of the next picks, a ring: those of the next one are at `turn`.
    bits: [u64; AHEAD],
    turn: usize,
    /// The next pick among the slots filled now. It is made a step ahead, so that a step that no processor predicts need
    /// not wait for it as well.
    slot: u32,
    live: Vec<u32>,
    places: Vec<usize>,
}

impl RandomSlot {
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Random::new(seed, STREAM);
        let bits = std::array::from_fn(|_| random.bits());
        Self { random, bits, turn: 0, slot: u32::MAX, live: Vec::new(), places: Vec::new() }
    }

    /// The slot that bits select among those filled now.
    #[inline]
    fn pick(&self, turn: usize) -> u32 {
        let place = below(self.bits[turn % AHEAD], self.live.len() as u64);
        self.live.get(place as usize).copied().unwrap_or(u32::MAX)
    }
}

impl Scheduler for RandomSlot {
    fn admit(&mut self, slot: u32) {
        if self.places.len() <= slot as usize {
            self.places.resize(slot as usize + 1, 0);
        }
        self.places[slot as usize] = self.live.len();
        self.live.push(slot);
        self.slot = self.pick(self.turn);
    }

    fn retire(&mut self, slot: u32) {
        let place = self.places[slot as usize];
        self.live.swap_remove(place);
        if let Some(&moved) = self.live.get(place) {
            self.places[moved as usize] = place;
        }
        self.slot = self.pick(self.turn);
    }

    #[inline]
    fn next(&mut self) -> Result<u32> {
        let slot = self.slot;
        self.bits[self.turn] = self.random.bits();
        self.turn = (self.turn + 1) % AHEAD;
        self.slot = self.pick(self.turn);
        Ok(slot)
    }

    /// The last of the picks drawn ahead: it follows, unless slots fill or empty before.
    #[inline]
    fn hint(&self) -> Option<u32> {
        Some(self.pick(self.turn + AHEAD - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each pick is that of the stream's next bits among the slots filled at that moment, whatever was drawn ahead.
    #[test]
    fn picks_made_ahead_are_those_made_in_time() {
        let mut policy = RandomSlot::new(11);
        let mut stream = Random::new(11, STREAM);
        let mut events = Random::new(3, 0);
        let mut live: Vec<u32> = Vec::new();
        for _ in 0..20_000 {
            let empty: Vec<u32> = (0..40).filter(|slot| !live.contains(slot)).collect();
            if live.is_empty() || !empty.is_empty() && events.below(3) == 0 {
                let slot = empty[events.below(empty.len() as u64) as usize];
                policy.admit(slot);
                live.push(slot);
            }
            let expected = live[stream.below(live.len() as u64) as usize];
            assert_eq!(policy.next(), Ok(expected));
            if events.below(4) == 0 {
                policy.retire(expected);
                let place = live.iter().position(|&slot| slot == expected);
                live.swap_remove(place.expect("it was there"));
            }
        }
    }

    /// Where nothing fills or empties, a hint comes true eight steps later.
    #[test]
    fn hints_come_true() {
        let mut policy = RandomSlot::new(2);
        (0..100).for_each(|slot| policy.admit(slot));
        let mut hints = Vec::new();
        let mut next = || {
            let slot = policy.next().expect("a slot");
            hints.extend(policy.hint());
            slot
        };
        let slots: Vec<u32> = (0..1_000).map(|_| next()).collect();
        assert_eq!(slots[AHEAD..], hints[..slots.len() - AHEAD]);
    }
}
