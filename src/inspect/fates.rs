//! What became of each fragment of a pixel that holds a list of fragments, or a colour.

use super::found::{Became, Fate};
use super::gone::Facts;
use crate::fragment::depth_of;
use crate::scheme::Keeps;
use crate::scheme::parts::visible::is_hidden;

/// A pixel's keys before and after.
pub(super) struct Lists<'a> {
    /// In the order of the inspection's fragments.
    pub(super) own: &'a [u64],
    /// The same, sorted.
    pub(super) sorted: &'a [u64],
    /// What the pixel holds, sorted.
    pub(super) kept: &'a [u64],
    /// What it must hold, sorted; `None` if the method does not say.
    pub(super) promised: Option<&'a [u64]>,
}

fn count(keys: &[u64], key: u64) -> usize {
    keys.iter().filter(|&&other| other == key).count()
}

impl Lists<'_> {
    /// Of fragments that are wholly alike, the first ones are there.
    pub(super) fn fates(&self, facts: &Facts<'_>) -> Vec<Fate> {
        let fate = |(i, &key): (usize, &u64)| {
            let before = count(&self.own[..i], key);
            let found = count(self.kept, key);
            if before < found {
                return Fate::kept(None);
            }
            match self.promised {
                None => facts.gone(),
                Some(promised) if before < count(promised, key) => self.missing(facts, key),
                Some(promised) => beyond(facts, key, before, promised),
            }
        };
        self.own.iter().enumerate().map(fate).collect()
    }

    /// Promised, and not there.
    fn missing(&self, facts: &Facts<'_>, key: u64) -> Fate {
        let contract = facts.options.method.contract();
        let hides = contract.keeps == Keeps::Visible;
        if hides && is_hidden(self.sorted, key, facts.options.table.opaque()) {
            return Fate::new(Became::Culled, Some("hidden by fragments in front of it"));
        }
        let stands_for = |&&other: &&u64| depth_of(other) == depth_of(key);
        if contract.has_right_depths() && self.kept.iter().any(|other| stands_for(&other)) {
            return Fate::new(Became::Lost, Some("another of its depth is kept"));
        }
        facts.missing()
    }

    /// Entries that are no fragment's: what they are, and their keys.
    pub(super) fn extra(&self) -> Vec<(&'static str, u64)> {
        let mut extra = Vec::new();
        for (i, &key) in self.kept.iter().enumerate() {
            match count(self.own, key) {
                0 => extra.push(("torn", key)),
                made if count(&self.kept[..i], key) >= made => extra.push(("duplicated", key)),
                _ => {}
            }
        }
        extra
    }
}

/// Not promised, and not there; `before` other fragments are wholly alike and come before it.
fn beyond(facts: &Facts<'_>, key: u64, before: usize, promised: &[u64]) -> Fate {
    let contract = facts.options.method.contract();
    if !contract.keeps_alike() && before > 0 && promised.contains(&key) {
        return Fate::new(Became::Dropped, Some("duplicate"));
    }
    let same_depth = |other: &u64| depth_of(*other) == depth_of(key);
    if contract.keeps == Keeps::Layers && promised.iter().any(same_depth) {
        return Fate::new(Became::Lost, Some("of every depth, one fragment is kept"));
    }
    facts.rejected(Some(&format!("beyond the nearest {}", promised.len())))
}

/// Of a pixel that holds a colour, into which it resolved `kept` of its `generated` fragments.
pub(super) fn of_color(facts: &Facts<'_>, generated: usize, kept: u32) -> Vec<Fate> {
    let all = facts.all_there() || kept as usize == generated;
    let reason = if all {
        "blended into the pixel's colour"
    } else {
        "blended into the pixel's colour, or not kept: which is not known"
    };
    vec![Fate::new(Became::Merged, Some(reason)); generated]
}
