//! Schedules as values.
//!
//! A recorded schedule is bytes: `FLS1`, the fingerprint of what was run (8 bytes, little-endian), then LEB128 numbers:
//! resident slots, slots per group, and runs of (slot, steps). It is complete: the same scene, method and options under
//! it give the same interleaving, operation by operation.

use sha2::{Digest, Sha256};

use crate::error::{Error, Result};

const MAGIC: &[u8; 4] = b"FLS1";

/// Identifies what a schedule was recorded from: 8 bytes of the SHA-256 of the texts that describe it, one per line.
#[must_use]
pub fn fingerprint(of: impl Iterator<Item = String>) -> u64 {
    let mut digest = Sha256::new();
    for text in of {
        digest.update(text.as_bytes());
        digest.update(b"\n");
    }
    let digest = digest.finalize();
    u64::from_le_bytes(std::array::from_fn(|i| digest[i]))
}

/// Writes a schedule as it happens.
#[derive(Clone, Debug)]
pub struct Recorder {
    bytes: Vec<u8>,
    run: Option<(u32, u64)>,
}

impl Recorder {
    /// At the beginning of a run.
    #[must_use]
    pub fn new(fingerprint: u64, resident: usize, group: usize) -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(fingerprint.to_le_bytes());
        push(&mut bytes, resident as u64);
        push(&mut bytes, group as u64);
        Self { bytes, run: None }
    }

    /// A slot performed one operation.
    #[inline]
    pub fn step(&mut self, slot: u32) {
        match &mut self.run {
            Some((last, steps)) if *last == slot => *steps += 1,
            _ => {
                self.flush();
                self.run = Some((slot, 1));
            }
        }
    }

    fn flush(&mut self) {
        if let Some((slot, steps)) = self.run.take() {
            push(&mut self.bytes, u64::from(slot));
            push(&mut self.bytes, steps);
        }
    }

    /// The schedule.
    #[must_use]
    pub fn finish(mut self) -> Vec<u8> {
        self.flush();
        self.bytes
    }
}

/// Reads a schedule.
#[derive(Clone, Debug)]
pub struct Reader {
    bytes: Vec<u8>,
    place: usize,
    run: (u32, u64),
    /// Slots of the recorded device.
    pub resident: usize,
    /// Slots that are refilled together.
    pub group: usize,
}

/// More slots than any device has: a corrupt schedule must not cause huge allocations.
const MAX_RESIDENT: u64 = 1 << 24;

impl Reader {
    /// Read the head of a schedule.
    ///
    /// # Errors
    /// Not a schedule, or one from another run.
    pub fn new(bytes: Vec<u8>, fingerprint: u64) -> Result<Self> {
        if bytes.len() < 12 || &bytes[..4] != MAGIC {
            return Err(bad("is not a schedule that fragloom recorded (FLS1)"));
        }
        if bytes[4..12] != fingerprint.to_le_bytes() {
            return Err(bad("was recorded from another scene, method or option"));
        }
        let mut reader = Self { bytes, place: 12, run: (0, 0), resident: 0, group: 0 };
        let resident = reader.number().filter(|&r| (1..=MAX_RESIDENT).contains(&r));
        let group = reader.number().filter(|&g| (1..=MAX_RESIDENT).contains(&g));
        let (Some(resident), Some(group)) = (resident, group) else {
            return Err(bad("is damaged: slots or group out of range"));
        };
        (reader.resident, reader.group) = (resident as usize, group as usize);
        Ok(reader)
    }

    /// The slot of the next step.
    ///
    /// # Errors
    /// The schedule is at its end, or damaged.
    pub fn next_step(&mut self) -> Result<u32> {
        while self.run.1 == 0 {
            let (slot, steps) = (self.number(), self.number());
            let (Some(slot), Some(steps)) = (slot, steps) else {
                return Err(bad("ends before the run does"));
            };
            let slot = u32::try_from(slot).map_err(|_| bad("is damaged: slot out of range"))?;
            self.run = (slot, steps);
        }
        self.run.1 -= 1;
        Ok(self.run.0)
    }

    /// Whether nothing is left.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.run.1 == 0 && self.place == self.bytes.len()
    }

    fn number(&mut self) -> Option<u64> {
        let mut value = 0u64;
        for shift in (0..63).step_by(7) {
            let byte = *self.bytes.get(self.place)?;
            self.place += 1;
            value |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }
}

fn push(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

fn bad(problem: &str) -> Error {
    Error::new("--schedule recorded", format!("the schedule {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::Random;

    #[test]
    fn what_is_recorded_is_read() {
        let mut random = Random::new(5, 0);
        let steps: Vec<u32> = (0..5_000).map(|_| random.below(200) as u32 / 3 * 3).collect();
        let mut recorder = Recorder::new(7, 300, 3);
        steps.iter().for_each(|&s| recorder.step(s));
        let bytes = recorder.finish();
        let mut reader = Reader::new(bytes.clone(), 7).unwrap();
        assert_eq!((reader.resident, reader.group), (300, 3));
        for &step in &steps {
            assert!(!reader.is_done());
            assert_eq!(reader.next_step().unwrap(), step);
        }
        assert!(reader.is_done() && reader.next_step().is_err());
        assert!(Reader::new(bytes[..11].to_vec(), 7).is_err());
        assert!(Reader::new(bytes, 8).is_err());
    }
}
