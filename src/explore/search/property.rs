//! What is checked.

use crate::exec::account::Judgement;
use crate::explore::program::case::Case;
use crate::explore::program::forest::Fault;
use crate::explore::program::litmus::Litmus;
use crate::explore::program::machine::Final;
use crate::fragment::depth_of;
use crate::scheme::contract::{Keeps, Overflow};
use crate::scheme::parts::visible::is_hidden;
use crate::scheme::{Contract, Depth, Held, Outcome};

/// A property of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Property {
    /// A pixel holds what the contract says: the k nearest, all, the nearest one.
    Keeps,
    /// No entry is duplicated, and every entry was generated.
    Intact,
    /// What invocations report adds up to what was generated.
    Accounting,
    /// No lock is held by two invocations, freed by one that does not hold it, or kept.
    MutualExclusion,
    /// No access goes outside of the method's words.
    Bounds,
    /// The method's own invariant.
    Invariant,
    /// The result is the same for all interleavings, unless the contract says that it may depend on arrival, and what
    /// the method specifies leaves it open.
    OneOutcome,
    /// The result is the same for all interleavings, whatever the contract says: asked by claims alone.
    ArrivalFree,
    /// No two conflicting accesses, of which one is plain, are unordered.
    RaceFree,
    /// Every invocation ends.
    Termination,
    /// The scheme's code does not panic.
    Panics,
    /// An invocation that gets the same answers does the same.
    Repeats,
}

impl Property {
    /// All, in the order of reports.
    pub const ALL: [Self; 12] = [
        Self::Keeps,
        Self::Intact,
        Self::Accounting,
        Self::MutualExclusion,
        Self::Bounds,
        Self::Invariant,
        Self::OneOutcome,
        Self::ArrivalFree,
        Self::RaceFree,
        Self::Termination,
        Self::Panics,
        Self::Repeats,
    ];

    /// Those without which nothing can be checked: they have a row only where they are violated.
    pub const CONDITIONS: [Self; 2] = [Self::Panics, Self::Repeats];

    /// It is about all results together: no single run shows that it fails.
    #[must_use]
    pub fn is_of_all_results(self) -> bool {
        matches!(self, Self::OneOutcome | Self::ArrivalFree)
    }

    /// The name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Keeps => "keeps",
            Self::Intact => "intact",
            Self::Accounting => "accounting",
            Self::MutualExclusion => "mutual-exclusion",
            Self::Bounds => "bounds",
            Self::Invariant => "invariant",
            Self::OneOutcome => "one-outcome",
            Self::ArrivalFree => "arrival-free",
            Self::RaceFree => "race-free",
            Self::Termination => "termination",
            Self::Panics => "panics",
            Self::Repeats => "repeats",
        }
    }
}

impl Fault {
    pub(in crate::explore) fn property(self) -> Property {
        match self {
            Self::Outside => Property::Bounds,
            Self::ForeignLock | Self::KeepsLock => Property::MutualExclusion,
            Self::WaitsForNothing => Property::Termination,
            Self::Shrinks => Property::Invariant,
            Self::Panics => Property::Panics,
        }
    }

    pub(in crate::explore) fn message(self) -> &'static str {
        match self {
            Self::Outside => "an access outside of the method's words",
            Self::ForeignLock => "a lock is freed by an invocation that does not hold it",
            Self::KeepsLock => "an invocation ends and still holds a lock",
            Self::WaitsForNothing => "an invocation waits before its first operation, for ever",
            Self::Shrinks => "a word that only grows becomes smaller",
            Self::Panics => "the scheme's code panics",
        }
    }
}

/// Whether several results are right: the instance has no room for all that its contract wants to keep, and the
/// contract says that drops depend on arrival; or the method may cull what is hidden, but need not.
pub(in crate::explore) fn overflows(contract: &Contract, litmus: &Litmus) -> bool {
    if contract.keeps == Keeps::Visible {
        return true;
    }
    let short = (room(contract, litmus) as usize) < litmus.fragments.len();
    short && matches!(contract.overflow, Overflow::Drops(_))
}

/// Room that the method has: what it is configured with, or the most that it can have.
fn room(contract: &Contract, litmus: &Litmus) -> u32 {
    litmus.room.min(contract.max_k)
}

/// What was wrong with a finished run.
pub(in crate::explore) fn judge(case: &Case, run: &Final) -> Vec<(Property, String)> {
    let (contract, litmus) = (case.contract, &case.litmus);
    let mut wrong = Vec::new();
    let mut judgement = Judgement::default();
    for (pixel, held) in (0..).zip(&run.pixels) {
        let generated = litmus.generated(pixel);
        let reports = reports(contract, litmus, run, pixel);
        let kept = match held {
            Held::Keys(list) if contract.crosses() => {
                keeps_of_table(contract, litmus, &generated, list, &run.outcomes)
            }
            Held::Keys(list) if !contract.keeps.is_approximate() => {
                keeps(case, pixel, &generated, list, &reports)
            }
            held => as_expected(case, pixel, held),
        };
        if let Some(message) = kept {
            wrong.push((Property::Keeps, format!("{}{message}", place(litmus, pixel))));
        }
        if let Held::Keys(list) = held {
            judgement.pixel(&generated, list, None);
        }
        let gone = reports.iter().filter(|&&o| o != Outcome::Kept).count();
        let there = held.len() + held.merged() as usize;
        if !contract.is_judged() && !contract.crosses() && there + gone != generated.len() {
            let message = format!(
                "{}{} generated, {there} in the list, {gone} reported as gone",
                place(litmus, pixel),
                generated.len(),
            );
            wrong.push((Property::Accounting, message));
        }
    }
    if contract.crosses() {
        let listed: usize = run.pixels.iter().map(Held::len).sum();
        let gone = run.outcomes.iter().filter(|&&o| o != Outcome::Kept).count();
        if listed + gone != litmus.fragments.len() {
            let n = litmus.fragments.len();
            let message = format!("{n} generated, {listed} in the lists, {gone} reported as gone");
            wrong.push((Property::Accounting, message));
        }
    }
    if judgement.duplicated + judgement.torn > 0 {
        let message =
            format!("{} entries duplicated, {} torn", judgement.duplicated, judgement.torn);
        wrong.push((Property::Intact, message));
    }
    wrong
}

fn place(litmus: &Litmus, pixel: u32) -> String {
    if litmus.pixels > 1 { format!("pixel {pixel}: ") } else { String::new() }
}

/// What the invocations of a pixel reported.
fn reports(contract: &Contract, litmus: &Litmus, run: &Final, pixel: u32) -> Vec<Outcome> {
    let own = litmus.fragments(contract).zip(&run.outcomes).filter(|(f, _)| f.pixel == pixel);
    own.map(|(_, &outcome)| outcome).collect()
}

/// For anything but a plain list of fragments: it must be what the method specifies; if that depends on arrival, what
/// some order of arrival gives.
fn as_expected(case: &Case, pixel: u32, held: &Held) -> Option<String> {
    if let (Held::Depth(Depth(bound)), Keeps::Bound) = (held, case.contract.keeps) {
        let generated = case.litmus.generated(pixel);
        let k = case.litmus.k.map_or(usize::MAX, |k| k as usize);
        let cut = generated.iter().take(k).find(|&&key| depth_of(key) > *bound);
        if let Some(&key) = cut {
            return Some(format!("{held} cuts {}, one of the {k} nearest", keys(&[key])));
        }
    }
    let open = overflows(case.contract, &case.litmus);
    if let Some(expected) = case.expected(pixel).filter(|_| !open) {
        return (expected != *held).then(|| format!("{held} instead of {expected}"));
    }
    let possible = case.possible(pixel);
    let wrong = !possible.is_empty() && !possible.contains(held);
    wrong.then(|| format!("{held}, which no order of arrival gives"))
}

fn keeps(
    case: &Case,
    pixel: u32,
    generated: &[u64],
    list: &[u64],
    reports: &[Outcome],
) -> Option<String> {
    let (contract, litmus) = (case.contract, &case.litmus);
    let expected = case.expected(pixel).and_then(|held| held.keys().map(<[u64]>::to_vec))?;
    let dropped = reports.iter().filter(|o| matches!(o, Outcome::Overflow | Outcome::Pool)).count();
    let right = match contract.keeps {
        // Drops by arrival: any of the fragments may be missing, but no more than were reported, and no more than do
        // not fit.
        Keeps::All | Keeps::FirstArrivals if overflows(contract, litmus) => {
            let room = room(contract, litmus) as usize;
            let enough = match contract.keeps {
                Keeps::FirstArrivals => dropped == generated.len().saturating_sub(room),
                _ => dropped <= (litmus.fragments.len() - room) * contract.page as usize,
            };
            enough && list.len() + dropped == generated.len() && is_part(list, generated)
        }
        // By depth alone, whichever of the equal ones came first.
        Keeps::Nearest | Keeps::NearestBy(_) if contract.is_arrival_dependent() => {
            let depths = |keys: &[u64]| keys.iter().map(|&key| depth_of(key)).collect::<Vec<_>>();
            depths(list) == depths(&expected) && is_part(list, generated)
        }
        _ => list == expected,
    };
    (!right).then(|| format!("{} instead of {}", keys(list), keys(&expected)))
}

/// The same where fragments of all pixels share a table: what one invocation drops may belong to another's pixel, so
/// reports count for all pixels together.
fn keeps_of_table(
    contract: &Contract,
    litmus: &Litmus,
    generated: &[u64],
    list: &[u64],
    reports: &[Outcome],
) -> Option<String> {
    let mut expected = generated.to_vec();
    contract.keep(&mut expected, None);
    let opaque = litmus.table.unwrap_or_default().opaque;
    let dropped = reports.iter().any(|o| matches!(o, Outcome::Age | Outcome::Pool));
    let hidden = |key: u64| contract.keeps == Keeps::Visible && is_hidden(generated, key, opaque);
    let mut rest = list.iter().peekable();
    // Any fragment may be the dropped one; the accounting checks how many there are.
    let right = expected.iter().all(|&key| {
        let found = rest.next_if(|&&kept| kept == key).is_some();
        found || dropped || hidden(key)
    }) && rest.peek().is_none();
    (!right).then(|| format!("{} instead of {}", keys(list), keys(&expected)))
}

/// What every pixel must hold, where room and arrival do not matter; `None` if the method does not specify it.
pub(in crate::explore) fn expected(case: &Case) -> Option<Vec<Held>> {
    (0..case.litmus.pixels).map(|pixel| case.expected(pixel)).collect()
}

/// Whether one sorted list's entries are among another's.
fn is_part(part: &[u64], whole: &[u64]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|key| rest.any(|other| other == key))
}

/// Keys as depth/data, hexadecimal.
fn keys(keys: &[u64]) -> String {
    Held::Keys(keys.to_vec()).to_string()
}
