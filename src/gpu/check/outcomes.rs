//! What explains an outcome of a litmus pixel that a device shows: an interleaving, relaxed memory, or nothing that is
//! explored. No device is needed here: recorded outcomes go the same way.

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::explore::program::instances::{Family, instances};
use crate::explore::replay;
use crate::explore::{
    Conditions, Explored, Limits, Litmus, MemoryModel, Profile, Subject, Token, explore,
};
use crate::scheme::Held;

/// States up to which an instance is explored, under each memory model.
const STATES: usize = 2_000_000;

/// The memory of WGSL.
const RELAXED: Conditions = Conditions { memory: MemoryModel::Relaxed(Profile::Wgsl), warp: None };

/// What explains an outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// An interleaving gives it.
    SequentiallyConsistent,
    /// No interleaving gives it, but relaxed memory as WGSL leaves it does.
    Relaxed,
    /// Nothing that was explored gives it.
    Outside,
}

impl Class {
    /// The name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SequentiallyConsistent => "sequentially consistent",
            Self::Relaxed => "relaxed",
            Self::Outside => "outside",
        }
    }
}

/// An outcome that was seen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// The litmus pixel.
    pub litmus: String,
    /// What the pixel held.
    pub outcome: String,
    /// How often.
    pub runs: u64,
    /// What explains it.
    pub class: Class,
    /// The token of a shortest schedule that gives it under relaxed memory.
    pub token: Option<String>,
    /// Every execution was explored before it was said to be outside.
    pub complete: bool,
}

/// The litmus pixels of a method of which copies are run: those with a pixel that has room for all its fragments.
#[must_use]
pub fn copied(subject: &Subject, fragments: u32) -> Vec<Litmus> {
    let family = Family { fragments, ks: vec![1, 2], helpers: 0 };
    let is_copied = |litmus: &Litmus| {
        let n = litmus.fragments.len();
        litmus.pixels == 1 && litmus.room as usize == n && n > 1
    };
    instances(subject, &family).into_iter().filter(is_copied).collect()
}

/// A litmus pixel, and all outcomes that it can have.
#[derive(Debug)]
pub struct Possible<'a> {
    subject: &'a Subject,
    litmus: &'a Litmus,
    interleavings: Explored,
    /// Explored once it is asked for: it takes longer.
    relaxed: Option<Explored>,
}

impl<'a> Possible<'a> {
    /// Explore all interleavings; `None` if there are too many states.
    #[must_use]
    pub fn new(subject: &'a Subject, litmus: &'a Litmus) -> Option<Self> {
        let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
        let interleavings = explored(subject, litmus, conditions);
        let possible = Self { subject, litmus, interleavings, relaxed: None };
        possible.interleavings.complete.then_some(possible)
    }

    /// What the pixel may hold after an interleaving.
    pub fn interleavings(&self) -> impl Iterator<Item = &Held> {
        self.interleavings.outcomes.keys().map(|pixels| &pixels[0])
    }

    /// All that relaxed memory gives.
    pub fn relaxed(&mut self) -> &Explored {
        let (subject, litmus) = (self.subject, self.litmus);
        self.relaxed.get_or_insert_with(|| explored(subject, litmus, RELAXED))
    }

    /// Explain an outcome. `beyond`: words that the pixel held beyond those that are told.
    ///
    /// # Errors
    /// The schedule that gives it does not run again.
    pub fn explain(&mut self, held: &Held, beyond: u32, runs: u64) -> Result<Outcome> {
        let pixels = std::slice::from_ref(held);
        let mut outcome = Outcome {
            litmus: self.litmus.describe(),
            outcome: held.to_string(),
            runs,
            class: Class::SequentiallyConsistent,
            token: None,
            complete: true,
        };
        if beyond == 0 && self.interleavings.outcomes.contains_key(pixels) {
            return Ok(outcome);
        }
        let (subject, litmus) = (self.subject, self.litmus);
        let relaxed = self.relaxed();
        match relaxed.outcomes.get(pixels).filter(|_| beyond == 0) {
            Some(schedule) => {
                let token = replay::of_outcome(subject, litmus, RELAXED, schedule)?;
                outcome.class = Class::Relaxed;
                outcome.token = Some(Token::Litmus(token).to_string());
            }
            None => {
                outcome.class = Class::Outside;
                outcome.complete = relaxed.complete;
                if beyond > 0 {
                    outcome.outcome += &format!(" and {beyond} more words");
                }
            }
        }
        Ok(outcome)
    }
}

fn explored(subject: &Subject, litmus: &Litmus, conditions: Conditions) -> Explored {
    explore(subject, litmus, conditions, &Limits { states: STATES, cancelled: &|| false })
}
