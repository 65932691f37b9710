//! What operations cost on the machine itself, without a scheme around them: short loops that somebody else times.
//!
//! Atomics go along words that stay in the first-level cache, as those of neighbouring pixels do. Every thread has words
//! of its own: what contention adds is not in here.

use std::hint::black_box;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Words that atomics go along: 8 KiB of 32 bits, 16 KiB of 64.
const WORDS: usize = 2_048;

/// An operation that can be timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// `atomicExchange` of 32 bits.
    Exchange,
    /// A lock and its unlock: an exchange that acquires, and a store that releases.
    LockedPair,
    /// `atomicMax` of 64 bits, which is a loop of compare-exchanges on most machines.
    CompareExchangeMax,
    /// `atomicAdd` of 32 bits.
    Add,
}

/// The words of one thread.
#[derive(Debug)]
pub struct Probe {
    narrow: Box<[AtomicU32]>,
    wide: Box<[AtomicU64]>,
}

impl Default for Probe {
    fn default() -> Self {
        Self {
            narrow: bytemuck::allocation::zeroed_slice_box(WORDS),
            wide: bytemuck::allocation::zeroed_slice_box(WORDS),
        }
    }
}

impl Probe {
    /// Perform an operation on every word, so many times over; how often that was.
    pub fn perform(&self, operation: Operation, times: u32) -> u64 {
        for turn in 1..=times {
            match operation {
                Operation::Exchange => self.narrow(|word| {
                    black_box(word.swap(turn, Ordering::Relaxed));
                }),
                Operation::LockedPair => self.narrow(|word| {
                    black_box(word.swap(1, Ordering::Acquire));
                    word.store(0, Ordering::Release);
                }),
                Operation::CompareExchangeMax => {
                    for word in &self.wide {
                        black_box(word.fetch_max(turn.into(), Ordering::Relaxed));
                    }
                }
                Operation::Add => self.narrow(|word| {
                    black_box(word.fetch_add(1, Ordering::Relaxed));
                }),
            }
        }
        u64::from(times) * WORDS as u64
    }

    fn narrow(&self, work: impl Fn(&AtomicU32)) {
        self.narrow.iter().for_each(work);
    }
}

/// Plain words of one thread, to be read and written in their order.
#[derive(Debug)]
pub struct Stretch(Vec<u64>);

impl Stretch {
    /// So many bytes, in whole words.
    #[must_use]
    pub fn new(bytes: usize) -> Self {
        // Not zero: pages of zeroes may not be there before the first write.
        Self(vec![1; bytes / 8])
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.0.len() * 8
    }

    /// Read every word; their sum.
    #[must_use]
    pub fn read(&self) -> u64 {
        black_box(&self.0).iter().fold(0, |sum, word| sum.wrapping_add(*word))
    }

    /// Write every word.
    pub fn write(&mut self, value: u64) {
        black_box(&mut self.0).fill(value);
        black_box(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each operation does what it is called, on every word, as often as it says.
    #[test]
    fn operations_are_performed() {
        let narrow = |operation| {
            let probe = Probe::default();
            assert_eq!(probe.perform(operation, 3), 3 * WORDS as u64);
            assert!(probe.wide.iter().all(|word| word.load(Ordering::Relaxed) == 0));
            let first = probe.narrow[0].load(Ordering::Relaxed);
            assert!(probe.narrow.iter().all(|word| word.load(Ordering::Relaxed) == first));
            first
        };
        assert_eq!(narrow(Operation::Exchange), 3, "the last turn's");
        assert_eq!(narrow(Operation::Add), 3, "one a turn");
        assert_eq!(narrow(Operation::LockedPair), 0, "unlocked");
        let probe = Probe::default();
        assert_eq!(probe.perform(Operation::CompareExchangeMax, 5), 5 * WORDS as u64);
        assert!(probe.wide.iter().all(|word| word.load(Ordering::Relaxed) == 5));
        assert!(probe.narrow.iter().all(|word| word.load(Ordering::Relaxed) == 0));
    }

    #[test]
    fn every_word_of_a_stretch_is_read_and_written() {
        let mut stretch = Stretch::new(8 * 1_000 + 7);
        assert_eq!((stretch.bytes(), stretch.read()), (8_000, 1_000));
        stretch.write(7);
        assert_eq!(stretch.read(), 7_000);
    }
}
