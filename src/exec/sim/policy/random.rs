//! `random`: a uniformly random resident invocation, from a seed.

use super::Policy;
use crate::error::Result;
use crate::num::random::Random;

/// The stream of this policy's random numbers.
const STREAM: u64 = 0x5C4E_D01E;

/// The filled slots, and where each stands.
#[derive(Debug)]
pub(super) struct RandomSlot {
    random: Random,
    live: Vec<u32>,
    places: Vec<usize>,
}

impl RandomSlot {
    pub(super) fn new(seed: u64) -> Self {
        Self { random: Random::new(seed, STREAM), live: Vec::new(), places: Vec::new() }
    }
}

impl Policy for RandomSlot {
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

    fn next(&mut self) -> Result<u32> {
        let pick = self.random.below(self.live.len() as u64) as usize;
        Ok(self.live.get(pick).copied().unwrap_or(u32::MAX))
    }
}
