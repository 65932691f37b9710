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

/// The date in Greenwich, as `YYYY-MM-DD`.
#[must_use]
pub fn today() -> String {
    #[expect(clippy::disallowed_methods, reason = "reported only")]
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let [year, month, day] = civil(since.map_or(0, |since| since.as_secs() / 86_400));
    format!("{year:04}-{month:02}-{day:02}")
}

/// Year, month and day of a day since 1970-01-01. Years begin in March here, so that a leap day is the last.
fn civil(days: u64) -> [u64; 3] {
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let date = of_year - (153 * month + 2) / 5 + 1;
    let (month, later) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    [year + era * 400 + later, month, date]
}

#[expect(clippy::disallowed_methods, reason = "reported only")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every day is the one after the day before.
    #[test]
    fn days_have_their_dates() {
        assert_eq!(civil(0), [1970, 1, 1]);
        assert_eq!(civil(20_787), [2026, 11, 30]);
        let [mut year, mut month, mut day] = civil(0);
        for days in 1..60_000 {
            let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            let length = [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
            day += 1;
            if day > length[month as usize - 1] {
                (month, day) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
            assert_eq!(civil(days), [year, month, day]);
        }
    }
}
