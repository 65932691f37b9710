//! `warp:N`: N consecutive invocations form a warp. Each turn, every unfinished lane of one warp performs one
//! operation, in lane order; then the next warp has its turn. A warp is replaced when all its lanes have ended.
//!
//! This is lockstep of memory operations. It does not model reconvergence after branches.

use std::collections::VecDeque;

use super::Scheduler;
use crate::error::Result;

/// Warps with unfinished lanes, in turn; the first one is at `lane`.
#[derive(Debug)]
pub(super) struct Warp {
    lanes: u32,
    turn: VecDeque<u32>,
    live: Vec<u32>,
    filled: Vec<bool>,
    lane: u32,
}

impl Warp {
    pub(super) fn new(lanes: u32) -> Self {
        Self { lanes, turn: VecDeque::new(), live: Vec::new(), filled: Vec::new(), lane: 0 }
    }

    fn next_turn(&mut self) {
        self.lane = 0;
        if let Some(warp) = self.turn.pop_front()
            && self.live[warp as usize] > 0
        {
            self.turn.push_back(warp);
        }
    }
}

impl Scheduler for Warp {
    fn admit(&mut self, slot: u32) {
        let warp = (slot / self.lanes) as usize;
        if self.live.len() <= warp {
            self.live.resize(warp + 1, 0);
            self.filled.resize((warp + 1) * self.lanes as usize, false);
        }
        self.filled[slot as usize] = true;
        self.live[warp] += 1;
        if self.live[warp] == 1 && !self.turn.contains(&(warp as u32)) {
            self.turn.push_back(warp as u32);
        }
    }

    fn retire(&mut self, slot: u32) {
        self.filled[slot as usize] = false;
        self.live[(slot / self.lanes) as usize] -= 1;
    }

    fn next(&mut self) -> Result<u32> {
        while let Some(&warp) = self.turn.front() {
            while self.lane < self.lanes {
                let slot = warp * self.lanes + self.lane;
                self.lane += 1;
                if self.filled[slot as usize] {
                    return Ok(slot);
                }
            }
            self.next_turn();
        }
        Ok(u32::MAX)
    }

    fn group(&self) -> usize {
        self.lanes as usize
    }
}
