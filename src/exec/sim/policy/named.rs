//! Policies by name.

use std::fs;

use crate::error::{Error, Result};

/// Which invocation goes next on the simulated device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Policy {
    /// The oldest invocation runs to its end: submission order.
    Order,
    /// The youngest resident invocation goes first.
    Reverse,
    /// Each in turn, one operation each.
    RoundRobin,
    /// A uniformly random resident invocation.
    Random,
    /// Warps of N consecutive invocations in lockstep, in turn.
    Warp(u32),
    /// Priorities, and D - 1 random moments at which the highest one falls; D is at least 1.
    Pct(u32),
    /// A schedule recorded before.
    Recorded(Vec<u8>),
}

impl Policy {
    /// A policy as it is typed after `--schedule`, and as tokens name it: `order`, `reverse`, `round-robin`, `random`,
    /// `pct:D`, `warp:N` or `recorded:FILE`, which reads the file.
    ///
    /// # Errors
    /// An unknown policy, a warp or a depth of 0, or a file that cannot be read.
    ///
    /// ```
    /// use fragloom::render::Policy;
    ///
    /// assert_eq!(Policy::parse("warp:32"), Ok(Policy::Warp(32)));
    /// assert!(Policy::parse("warp:0").is_err());
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        if let Some(file) = text.strip_prefix("recorded:") {
            let read = fs::read(file);
            return read.map(Self::Recorded).map_err(|error| {
                Error::new("--schedule", format!("{file} cannot be read: {error}"))
            });
        }
        if let Some(Ok(lanes @ 1..)) = text.strip_prefix("warp:").map(str::parse) {
            return Ok(Self::Warp(lanes));
        }
        if let Some(Ok(depth @ 1..)) = text.strip_prefix("pct:").map(str::parse) {
            return Ok(Self::Pct(depth));
        }
        match text {
            "order" => Ok(Self::Order),
            "reverse" => Ok(Self::Reverse),
            "round-robin" => Ok(Self::RoundRobin),
            "random" => Ok(Self::Random),
            _ => {
                let right = "must be order, reverse, round-robin, random, pct:D or warp:N (D and N at \
                             least 1), or recorded:FILE";
                Err(Error::new("--schedule", format!("{text:?} {right}")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules() {
        assert_eq!(Policy::parse("round-robin").unwrap(), Policy::RoundRobin);
        assert_eq!(Policy::parse("warp:32").unwrap(), Policy::Warp(32));
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), [1, 2, 3]).unwrap();
        let recorded = format!("recorded:{}", file.path().display());
        assert_eq!(Policy::parse(&recorded).unwrap(), Policy::Recorded(vec![1, 2, 3]));
        for bad in ["", "warp", "warp:0", "warp:x", "fifo", "recorded:", "recorded:/no/such/file"] {
            assert_eq!(Policy::parse(bad).unwrap_err().place(), "--schedule", "{bad}");
        }
    }
}
