//! `pct:D`: probabilistic concurrency testing (Burckhardt, Kothari, Musuvathi, Nagarakatte, "A randomized scheduler
//! with probabilistic guarantees of finding bugs", ASPLOS 2010). Every invocation has a random priority, and the
//! highest one runs; at D - 1 random moments the running one falls below all others. A fault that needs D ordered
//! events is found with a probability that does not vanish in the number of steps, as it does under `random`.
//!
//! The paper knows the number of invocations and steps beforehand. Here invocations come as a stream: each draws its
//! priority when it is admitted, and moments are drawn so that D - 1 of them fall, on average, into a *generation*, the
//! time in which all residents are replaced ([`STEPS`] operations each). So the paper's bound holds approximately for a
//! litmus pixel, and per generation for a scene.
//!
//! A waiting invocation also falls below all others; otherwise it would wait forever for one that never runs.

use std::collections::BTreeSet;

use super::Scheduler;
use crate::error::Result;
use crate::num::random::Random;

/// Operations of an invocation, roughly.
const STEPS: u64 = 16;

/// The stream of this policy's random numbers.
const STREAM: u64 = 0x9C7_9C7;

/// Priorities that have not fallen begin here.
const HIGH: u64 = 1 << 63;

/// The filled slots by priority.
#[derive(Debug)]
pub(super) struct Pct {
    random: Random,
    /// The running invocation falls with a chance of `falls` in `generation` at each step.
    falls: u64,
    generation: u64,
    queue: BTreeSet<(u64, u32)>,
    priorities: Vec<u64>,
    /// The priority of the next invocation to fall: below all earlier ones.
    bottom: u64,
}

impl Pct {
    pub(super) fn new(seed: u64, depth: u32, resident: usize) -> Self {
        Self {
            random: Random::new(seed, STREAM),
            falls: u64::from(depth) - 1,
            generation: STEPS * resident as u64,
            queue: BTreeSet::new(),
            priorities: Vec::new(),
            bottom: HIGH,
        }
    }

    fn fall(&mut self, slot: u32) {
        self.bottom -= 1;
        let priority = &mut self.priorities[slot as usize];
        self.queue.remove(&(*priority, slot));
        *priority = self.bottom;
        self.queue.insert((self.bottom, slot));
    }
}

impl Scheduler for Pct {
    fn admit(&mut self, slot: u32) {
        if self.priorities.len() <= slot as usize {
            self.priorities.resize(slot as usize + 1, 0);
        }
        let priority = HIGH | self.random.bits();
        self.priorities[slot as usize] = priority;
        self.queue.insert((priority, slot));
    }

    fn retire(&mut self, slot: u32) {
        self.queue.remove(&(self.priorities[slot as usize], slot));
    }

    fn waits(&mut self, slot: u32) {
        self.fall(slot);
    }

    fn next(&mut self) -> Result<u32> {
        let Some(&(_, slot)) = self.queue.last() else { return Ok(u32::MAX) };
        if self.falls == 0 || self.random.below(self.generation) >= self.falls {
            return Ok(slot);
        }
        self.fall(slot);
        Ok(self.queue.last().map_or(slot, |&(_, slot)| slot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seed: u64, depth: u32) -> Vec<u32> {
        let mut pct = Pct::new(seed, depth, 4);
        (0..4).for_each(|slot| pct.admit(slot));
        (0..200).map(|_| pct.next().expect("a slot")).collect()
    }

    #[test]
    fn a_seed_is_a_schedule() {
        assert_eq!(run(3, 3), run(3, 3));
        assert_ne!(run(3, 3), run(4, 3));
    }

    #[test]
    fn without_falls_the_highest_runs_to_its_end() {
        for seed in 0..8 {
            let slots = run(seed, 1);
            assert!(slots.iter().all(|&slot| slot == slots[0]));
        }
    }

    #[test]
    fn falls_are_as_frequent_as_asked_for() {
        let switches = |depth| {
            let all =
                (0..64).map(|seed| run(seed, depth).windows(2).filter(|w| w[0] != w[1]).count());
            all.sum::<usize>()
        };
        // 200 steps are about three generations of 4 x 16.
        let (two, five) = (switches(2), switches(5));
        assert!((100..300).contains(&two), "{two}");
        assert!((500..1_000).contains(&five), "{five}");
    }

    #[test]
    fn who_waits_lets_all_others_go_first() {
        let mut pct = Pct::new(0, 1, 3);
        (0..3).for_each(|slot| pct.admit(slot));
        let first = pct.next().expect("a slot");
        pct.waits(first);
        let second = pct.next().expect("a slot");
        pct.waits(second);
        let third = pct.next().expect("a slot");
        pct.waits(third);
        assert_eq!(pct.next(), Ok(first), "and then it is its turn again");
        assert_eq!(first + second + third, 3);
    }
}
