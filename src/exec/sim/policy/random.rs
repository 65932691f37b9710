//! `random`: a uniformly random resident invocation, from a seed.

use super::Scheduler;
use crate::error::Result;
use crate::num::random::{Random, below};

/// The stream of this policy's random numbers.
const STREAM: u64 = 0x5C4E_D01E;

/// Picks whose bits are drawn before they are made. What follows from them takes longer than a step: the slot, and its
/// invocation's way into the cache.
const AHEAD: usize = 8;

/// The filled slots, and the position of each.
#[derive(Debug)]
pub(super) struct RandomSlot {
    random: Random,
    /// The bits of the next picks, a ring: those of the next one are at `turn`.
    bits: [u64; AHEAD],
    turn: usize,
    live: Vec<u32>,
    places: Vec<usize>,
}

impl RandomSlot {
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Random::new(seed, STREAM);
        let bits = std::array::from_fn(|_| random.bits());
        Self { random, bits, turn: 0, live: Vec::new(), places: Vec::new() }
    }

    /// The slot that bits select among those filled now.
    #[inline]
    fn pick(&self, bits: u64) -> Option<u32> {
        self.live.get(below(bits, self.live.len() as u64) as usize).copied()
    }
}

impl Scheduler for RandomSlot {
    fn admit(&mut self, slot: u32) {
        if self.places.len() <= slot as usize {
            self.places.resize(slot as usize + 1, 0);
        }
        self.places[slot as usize] = self.live.len();
        self.live.push(slot);
    }

    fn retire(&mut self, slot: u32) {
        let place = self.places[slot as usize];
        self.live.swap_remove(place);
        if let Some(&moved) = self.live.get(place) {
            self.places[moved as usize] = place;
        }
    }

    #[inline]
    fn next(&mut self) -> Result<u32> {
        let slot = self.pick(self.bits[self.turn]);
        self.bits[self.turn] = self.random.bits();
        self.turn = (self.turn + 1) % AHEAD;
        Ok(slot.unwrap_or(u32::MAX))
    }

    /// The last of the picks drawn ahead: it follows, unless slots fill or empty before.
    #[inline]
    fn hint(&self) -> Option<u32> {
        self.pick(self.bits[(self.turn + AHEAD - 1) % AHEAD])
    }
}
