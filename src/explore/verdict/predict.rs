//! What a device may show of a method's twin: what the checker says of it under relaxed memory as the twin's language
//! has it.
//!
//! Instances are explored by size. The first size at which a result is wrong decides, unless results are wrong in which
//! of equal depths they have, and in nothing else: then larger sizes may show more. A size with an instance that has too
//! many states decides nothing by being right, and is the last one. So a prediction has its bound, and is computed from
//! results alone: what a contract declares has no part in it.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::survey::witness;
use crate::explore::memory::model::{MemoryModel, Profile};
use crate::explore::program::instances::{Family, of_size};
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::Conditions;
use crate::explore::program::subject::Subject;
use crate::explore::search::explore;
use crate::explore::search::explored::{Explored, Limits};
use crate::explore::search::property::{self, Property};
use crate::fragment::depth_of;
use crate::scheme::Held;

/// States of an instance: enough for two fragments of every method, and for three of most. A prediction takes seconds.
pub const STATES: usize = 20_000;

/// Fragments of an instance, at most.
const FRAGMENTS: u32 = 3;

/// The properties that results show; the others concern what is behind them.
const SHOWN: [Property; 3] = [Property::Keeps, Property::Intact, Property::OneOutcome];

/// What a device may show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expects {
    /// The result that the contract names; any of several, where it leaves that to arrival.
    Equal,
    /// The right depths; which of equal ones is open.
    EqualDepths,
    /// Fragments may be lost, doubled or torn.
    Loss,
    /// Nothing was explored to its end.
    Unknown,
}

impl Expects {
    /// In words.
    #[must_use]
    pub fn says(self) -> &'static str {
        match self {
            Self::Equal => "must be equal",
            Self::EqualDepths => "may confuse equal depths",
            Self::Loss => "may lose, double or tear",
            Self::Unknown => "not known",
        }
    }
}

/// What the checker expects of a method on devices.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Prediction {
    /// What a device may show.
    pub expects: Expects,
    /// All instances with up to so many fragments were explored in all interleavings, or up to the first wrong result.
    pub fragments: u32,
    /// The shortest schedule to a wrong result, to be replayed.
    pub token: Option<String>,
    /// Its steps.
    pub steps: u64,
    /// What it shows, and of which instance.
    pub message: String,
}

/// A wrong result of an instance.
struct Wrong<'a> {
    property: Property,
    litmus: &'a Litmus,
    explored: &'a Explored,
}

impl Wrong<'_> {
    fn steps(&self) -> usize {
        self.explored.violations[&self.property].schedule.len()
    }
}

/// What devices may show of a method whose twin is written in a language.
#[must_use]
pub fn predict(subject: &Subject, profile: Profile) -> Prediction {
    within(subject, profile, STATES)
}

/// The same with at most so many states of an instance.
fn within(subject: &Subject, profile: Profile, states: usize) -> Prediction {
    let conditions = Conditions { memory: MemoryModel::Relaxed(profile), warp: None };
    let limits = Limits { states, cancelled: &|| false };
    let mut known = Prediction {
        expects: Expects::Unknown,
        fragments: 0,
        token: None,
        steps: 0,
        message: String::new(),
    };
    for n in 1..=FRAGMENTS {
        let family = Family { fragments: n, ks: vec![1, 2], helpers: 0 };
        let all: Vec<(Litmus, Explored)> = of_size(subject, &family, n)
            .into_par_iter()
            .map(|litmus| {
                let explored = explore(subject, &litmus, conditions, &limits);
                (litmus, explored)
            })
            .collect();
        let Some(wrong) = shortest(&all) else {
            if all.iter().any(|(_, explored)| !explored.complete) {
                break;
            }
            known.fragments = n;
            if known.expects == Expects::Unknown {
                known.expects = Expects::Equal;
            }
            continue;
        };
        let right = all.iter().all(|(litmus, e)| has_right_depths(subject, litmus, e));
        if !right || known.token.is_none() {
            let (token, message) = told(subject, conditions, &wrong);
            let expects = if right { Expects::EqualDepths } else { Expects::Loss };
            let steps = wrong.steps() as u64;
            known = Prediction { expects, fragments: n, token, steps, message };
        }
        known.fragments = n;
        if !right {
            break;
        }
    }
    known
}

/// Its token, and what it shows.
fn told(subject: &Subject, conditions: Conditions, wrong: &Wrong<'_>) -> (Option<String>, String) {
    let (property, litmus) = (wrong.property, wrong.litmus);
    let found = &wrong.explored.violations[&property];
    let schedule: [&[_]; 2] = [&found.schedule, &[]];
    let (token, told) = witness(subject, property, litmus, conditions, schedule, &found.message);
    (token, format!("{}: {told}", litmus.describe()))
}

/// The wrong result with the shortest way to it; the first of several.
fn shortest(all: &[(Litmus, Explored)]) -> Option<Wrong<'_>> {
    let wrong = all.iter().flat_map(|(litmus, explored)| {
        let shown = SHOWN.into_iter().filter(|p| explored.violations.contains_key(p));
        shown.map(move |property| Wrong { property, litmus, explored })
    });
    wrong.min_by_key(|wrong| (wrong.steps(), wrong.property))
}

/// Whether every result of an instance has the depths that it must have, in order, and as many.
fn has_right_depths(subject: &Subject, litmus: &Litmus, explored: &Explored) -> bool {
    if SHOWN.iter().all(|property| !explored.violations.contains_key(property)) {
        return true;
    }
    let Some(expected) = property::expected(&subject.case(litmus)) else { return false };
    let depths = |held: &Held| -> Option<Vec<u32>> {
        held.keys().map(|keys| keys.iter().map(|&key| depth_of(key)).collect())
    };
    let right: Vec<Option<Vec<u32>>> = expected.iter().map(depths).collect();
    let same = |pixels: &Vec<Held>| {
        pixels.iter().zip(&right).all(|(held, right)| right.is_some() && depths(held) == *right)
    };
    explored.complete && explored.outcomes.keys().all(same)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;

    fn of(name: &str, profile: Profile, states: usize) -> Prediction {
        let method = Catalogue::default().find("test", name).expect("a method");
        within(&Subject::new(method).expect("a scheme"), profile, states)
    }

    /// Of three k-buffers that differ in how they are synchronised, three things are expected.
    #[test]
    fn results_decide_what_is_expected() {
        let found = ["kb-mdt64", "kb-mdt32", "kb", "ab-ll", "ab-ll@plain-head"]
            .map(|name| of(name, Profile::Wgsl, STATES));
        let expects = found.each_ref().map(|one| one.expects);
        use Expects::{Equal, EqualDepths, Loss};
        assert_eq!(expects[..4], [Equal, EqualDepths, Loss, Equal], "{found:?}");
        for one in &found {
            assert_eq!(one.token.is_some(), one.expects != Equal, "{one:?}");
            assert_eq!(one.steps > 0, one.expects != Equal, "{one:?}");
        }
        assert_eq!(found[0].fragments, FRAGMENTS);
    }

    /// A lock orders what its language lets it order.
    #[test]
    fn the_language_decides_too() {
        let of = |profile| of("kplus-array", profile, STATES).expects;
        let found = [Profile::Wgsl, Profile::Vulkan, Profile::Glsl].map(of);
        assert_eq!(found, [Expects::Loss, Expects::Equal, Expects::Equal]);
    }

    /// Too few states are no verdict, and are not counted as explored.
    #[test]
    fn what_was_not_explored_is_not_expected() {
        let found: Vec<Prediction> = [1, 4, 8, 16, 32, 64, 128, STATES]
            .into_iter()
            .map(|states| of("kb-mdt64", Profile::Wgsl, states))
            .collect();
        assert!(found.is_sorted_by_key(|one| one.fragments), "{found:?}");
        for one in &found {
            let expects = if one.fragments > 0 { Expects::Equal } else { Expects::Unknown };
            assert_eq!(one.expects, expects, "{one:?}");
        }
        let ends = [found.first(), found.last()].map(|one| one.map(|one| one.fragments));
        assert_eq!(ends, [Some(0), Some(FRAGMENTS)], "{found:?}");
        assert!(found.iter().any(|one| (1..FRAGMENTS).contains(&one.fragments)), "{found:?}");
    }
}
