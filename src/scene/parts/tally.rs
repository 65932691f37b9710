//! Warnings that are said once, however often their cause is met.

/// What was tolerated in one file: a line per kind, with the first place and how many there are.
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Tally {
    kinds: Vec<(&'static str, String, usize)>,
}

impl Tally {
    /// Counts one of a kind; `first` says what it is, and is asked only for the first.
    pub(in crate::scene) fn add(&mut self, kind: &'static str, first: impl FnOnce() -> String) {
        match self.kinds.iter_mut().find(|(known, ..)| *known == kind) {
            Some((.., count)) => *count += 1,
            None => self.kinds.push((kind, first(), 1)),
        }
    }

    /// Adds what was met after all that is here.
    pub(in crate::scene) fn append(&mut self, after: Self) {
        for (kind, first, more) in after.kinds {
            match self.kinds.iter_mut().find(|(known, ..)| *known == kind) {
                Some((.., count)) => *count += more,
                None => self.kinds.push((kind, first, more)),
            }
        }
    }

    /// Why nothing is left, for the error that says so: what was met of some kinds; empty where it was none of them.
    pub(in crate::scene) fn reasons(&self, is_reason: impl Fn(&str) -> bool) -> String {
        let found = self.kinds.iter().filter(|(kind, ..)| is_reason(kind));
        let reasons: Vec<String> =
            found.map(|(kind, first, _)| format!("{first}: {kind}")).collect();
        if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join("; ")) }
    }

    /// One sentence for each kind.
    pub(in crate::scene) fn warnings(self, place: &str) -> Vec<String> {
        let sentence = |(kind, first, count): (&str, String, usize)| match count {
            1 => format!("{place}: {first}: {kind}"),
            _ => format!("{place}: {first}: {kind} ({count} in all)"),
        };
        self.kinds.into_iter().map(sentence).collect()
    }

    /// A channel of a colour, or an opacity, brought into 0..1; a value that is not a number becomes 0.
    pub(in crate::scene) fn clamped(&mut self, value: f64, place: impl FnOnce() -> String) -> f32 {
        if !(0.0..=1.0).contains(&value) {
            self.add("is not within 0 to 1 and is clamped", || format!("{}: {value}", place()));
        }
        if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) as f32 }
    }
}
