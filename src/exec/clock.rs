//! The one place that reads a clock. Times are only reported; nothing else depends on them.

use std::collections::BTreeMap;
use std::time::Instant;

/// Seconds by phase.
#[derive(Clone, Debug)]
pub struct Stopwatch {
    last: Instant,
    seconds: BTreeMap<String, f64>,
}

impl Stopwatch {
    /// Started now.
    #[must_use]
    pub fn start() -> Self {
        Self { last: now(), seconds: BTreeMap::new() }
    }

    /// End a phase: the time since the last one belongs to `phase`.
    pub fn lap(&mut self, phase: &str) {
        let time = now();
        *self.seconds.entry(phase.to_owned()).or_default() += (time - self.last).as_secs_f64();
        self.last = time;
    }

    /// All phases so far.
    #[must_use]
    pub fn seconds(self) -> BTreeMap<String, f64> {
        self.seconds
    }
}

#[expect(clippy::disallowed_methods, reason = "reported only")]
fn now() -> Instant {
    Instant::now()
}
