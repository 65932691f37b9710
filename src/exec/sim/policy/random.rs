//! `random`: a uniformly random resident invocation, from a seed.

use super::Scheduler;
use crate::error::Result;
use crate::num::random::{Random, below};

/// The stream of this policy's random numbers.
const STREAM: u64 = 0x5C4E_D01E;

/// The filled slots, and the position of each.
#[derive(Debug)]
pub(super) struct RandomSlot {
    random: Random,
    /// The bits of the next pick, drawn a step ahead: a mispredicted step does not wait for them.
    bits: u64,
    live: Vec<u32>,
    places: Vec<usize>,
}

impl RandomSlot {
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Random::new(seed, STREAM);
        let bits = random.bits();
        Self { random, bits, live: Vec::new(), places: Vec::new() }
    }

    /// The slot that the drawn bits select among those filled now.
    #[inline]
    fn pick(&self) -> Option<u32> {
        self.live.get(below(self.bits, self.live.len() as u64) as usize).copied()
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
        let slot = self.pick();
        self.bits = self.random.bits();
        Ok(slot.unwrap_or(u32::MAX))
    }

    #[inline]
    fn hint(&self) -> Option<u32> {
        self.pick()
    }
}
