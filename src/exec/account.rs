//! Accounting: where every fragment went.
//!
//! generated + duplicated + torn = kept + merged + culled + evicted + dropped, per pixel and in sum.
//!
//! Each invocation reports its own outcome, and that balances if no update is lost. An update lost in a race is
//! invisible to the invocation that lost it, so a method whose contract says `racy`, and any pixel that does not
//! balance, is *judged*: its list is compared with the generated multiset. An entry that was never generated is torn;
//! one more often than generated is duplicated; a generated fragment that is missing was lost if it belongs to the k
//! nearest, and evicted (or culled) if it does not.

use crate::num::lanes::wide;
use crate::scheme::parts::visible::is_hidden;
use crate::scheme::{Outcome, Outcomes};

/// Sums over pixels; each addition is exact, so their order does not matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Fragments of one geometry pass.
    pub generated: u64,
    /// Entries in the resolved lists; if there are none, fragments that were stored one by one until resolve.
    pub kept: u64,
    /// Merged into another record, or into a pixel's colour.
    pub merged: u64,
    /// Rejected before they were stored.
    pub culled: u64,
    /// Those of them that did not reach the scheme: they lie behind the bound of a culling pass.
    pub rejected: u64,
    /// Stored, and pushed out later.
    pub evicted: u64,
    /// Entries beyond the number of times they were generated.
    pub duplicated: u64,
    /// Entries that were never generated.
    pub torn: u64,
    /// Dropped for lack of room in the pixel.
    pub overflow: u64,
    /// Dropped for lack of room in the frame's pool.
    pub pool: u64,
    /// Dropped because they were already stored.
    pub duplicate: u64,
    /// Dropped beyond the largest age of a hash table.
    pub age: u64,
    /// Dropped by a race.
    pub lost: u64,
    /// The largest number of fragments at a pixel.
    pub max_depth_complexity: u32,
    /// Pixels whose reports did not balance.
    pub unbalanced: u64,
    /// Over those pixels: fragments generated but not accounted for.
    pub missing: u64,
    /// Over those pixels: fragments accounted for but not generated.
    pub surplus: u64,
}

impl Tally {
    /// Add another's sums.
    pub fn merge(&mut self, other: &Self) {
        self.generated += other.generated;
        self.kept += other.kept;
        self.merged += other.merged;
        self.culled += other.culled;
        self.rejected += other.rejected;
        self.evicted += other.evicted;
        self.duplicated += other.duplicated;
        self.torn += other.torn;
        self.overflow += other.overflow;
        self.pool += other.pool;
        self.duplicate += other.duplicate;
        self.age += other.age;
        self.lost += other.lost;
        self.max_depth_complexity = self.max_depth_complexity.max(other.max_depth_complexity);
        self.unbalanced += other.unbalanced;
        self.missing += other.missing;
        self.surplus += other.surplus;
    }

    /// Count an invocation's report. Returns whether its pixel has one fragment less than was generated.
    #[inline]
    pub fn report(&mut self, outcome: Outcome) -> bool {
        match outcome {
            Outcome::Kept => return false,
            Outcome::Culled => self.culled += 1,
            Outcome::Evicted => self.evicted += 1,
            Outcome::Overflow => self.overflow += 1,
            Outcome::Pool => self.pool += 1,
            Outcome::Duplicate => self.duplicate += 1,
            Outcome::Age => self.age += 1,
            Outcome::Merged => self.merged += 1,
        }
        true
    }

    /// Count the reports of a batch.
    #[inline]
    pub fn reports(&mut self, outcomes: &Outcomes) {
        self.culled += outcomes.count(Outcome::Culled);
        self.evicted += outcomes.count(Outcome::Evicted);
        self.overflow += outcomes.count(Outcome::Overflow);
        self.pool += outcomes.count(Outcome::Pool);
        self.duplicate += outcomes.count(Outcome::Duplicate);
        self.age += outcomes.count(Outcome::Age);
        self.merged += outcomes.count(Outcome::Merged);
    }

    /// Count fragments that did not reach the scheme.
    #[inline]
    pub fn reject(&mut self, count: u32) {
        self.culled += u64::from(count);
        self.rejected += u64::from(count);
    }

    /// Count a resolved pixel with `generated` fragments, of which `gone` were reported as not kept; resolve found
    /// `kept`, and merged others into them.
    #[inline]
    pub fn pixel(&mut self, generated: u32, gone: u32, kept: usize, merged: u32) {
        let (made, accounted) =
            (u64::from(generated), u64::from(gone) + kept as u64 + u64::from(merged));
        self.generated += made;
        self.kept += kept as u64;
        self.merged += u64::from(merged);
        self.max_depth_complexity = self.max_depth_complexity.max(generated);
        if made != accounted {
            self.unbalanced += 1;
            self.missing += made.saturating_sub(accounted);
            self.surplus += accounted.saturating_sub(made);
        }
    }

    /// Count resolved pixels, as [`Self::pixel`] does: fragments generated, gone and kept of each, and those merged, if
    /// any were.
    ///
    /// # Panics
    /// If a list is shorter than the first; that of merged ones may be empty.
    pub fn pixels(&mut self, [generated, gone, kept]: [&[u32]; 3], merged: &[u32]) {
        let count = generated.len();
        let (gone, kept) = (&gone[..count], &kept[..count]);
        let [made, found, most, off] = wide(
            #[inline(always)]
            || {
                let [mut made, mut found, mut most, mut off] = [0; 4];
                for i in 0..count {
                    let [own, gone, kept] = [generated[i], gone[i], kept[i]].map(u64::from);
                    (made, found, most) = (made + own, found + kept, own.max(most));
                    off |= own ^ (gone + kept);
                }
                [made, found, most, off]
            },
        );
        if off != 0 || !merged.is_empty() {
            for i in 0..count {
                let merged = merged.get(i).map_or(0, |&merged| merged);
                self.pixel(generated[i], gone[i], kept[i] as usize, merged);
            }
            return;
        }
        self.generated += made;
        self.kept += found;
        self.max_depth_complexity = self.max_depth_complexity.max(most as u32);
    }

    /// For methods without lists of fragments to compare: what is missing counts as lost, and what is surplus as
    /// duplicated.
    pub fn correct_by_count(&mut self) {
        self.lost += self.missing;
        self.duplicated += self.surplus;
    }

    /// Dropped for any reason.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.reported() + self.lost
    }

    /// Dropped, and reported as dropped by the invocation that did it.
    #[must_use]
    fn reported(&self) -> u64 {
        self.overflow + self.pool + self.duplicate + self.age
    }

    /// Whether the sums balance.
    #[must_use]
    pub fn balances(&self) -> bool {
        self.generated + self.duplicated + self.torn
            == self.kept + self.merged + self.culled + self.evicted + self.dropped()
    }

    /// Replace what racing invocations reported by what the lists show. Reports of drops stay, since the invocation
    /// that drops a fragment knows it. `culled` keeps its reports as far as they fit.
    /// `culls`: the method culls promised fragments that cannot be seen, so `culled` is a report of drops too.
    pub fn correct(&mut self, judgement: &Judgement, culls: bool) {
        self.duplicated = judgement.duplicated;
        self.torn = judgement.torn;
        if culls {
            // Of the missing fragments that can be seen, this many were dropped for other reasons; the rest were culled
            // wrongly.
            let wrongly = judgement.visible.saturating_sub(self.reported());
            self.culled = self.culled.saturating_sub(wrongly);
        }
        let dropped = self.reported() + if culls { self.culled } else { 0 };
        self.lost = judgement.lost.saturating_sub(dropped);
        let beyond = judgement.beyond + judgement.lost - self.lost - dropped;
        if culls {
            self.evicted = beyond;
            return;
        }
        self.culled = self.culled.min(beyond);
        self.evicted = beyond - self.culled;
    }
}

/// What comparing lists with the generated multiset shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Judgement {
    /// Entries beyond the number of times they were generated.
    pub duplicated: u64,
    /// Entries never generated.
    pub torn: u64,
    /// Missing, and among the k nearest.
    pub lost: u64,
    /// Missing, and not among the k nearest.
    pub beyond: u64,
    /// Missing, and not hidden by others, where a method culls hidden fragments.
    pub visible: u64,
}

impl Judgement {
    /// Compare one pixel: both lists sorted; `nearest` is the number the method promises to keep.
    pub fn pixel(&mut self, generated: &[u64], kept: &[u64], nearest: Option<u32>) {
        let nearest = nearest.map_or(usize::MAX, |k| k as usize);
        let (mut g, mut r) = (0, 0);
        while g < generated.len() || r < kept.len() {
            let key = match (generated.get(g), kept.get(r)) {
                (Some(&a), Some(&b)) => a.min(b),
                (Some(&a), None) => a,
                (None, Some(&b)) => b,
                (None, None) => return,
            };
            let made = run(&generated[g..], key);
            let found = run(&kept[r..], key);
            self.run(made, found, nearest.saturating_sub(g).min(made));
            (g, r) = (g + made, r + found);
        }
    }

    /// Judge one pixel of a method that culls early: count what is missing although it can be seen.
    pub fn seen(&mut self, generated: &[u64], kept: &[u64], opaque: u16) {
        let mut g = 0;
        while g < generated.len() {
            let key = generated[g];
            let made = run(&generated[g..], key);
            g += made;
            let missing = made.saturating_sub(kept.iter().filter(|&&k| k == key).count());
            if missing > 0 && !is_hidden(generated, key, opaque) {
                self.visible += missing as u64;
            }
        }
    }

    /// One key: how often it was made, how often it was found, and how many of it belong to the nearest.
    fn run(&mut self, made: usize, found: usize, wanted: usize) {
        if made == 0 {
            self.torn += found as u64;
            return;
        }
        let lost = wanted.saturating_sub(found);
        self.duplicated += found.saturating_sub(made) as u64;
        self.lost += lost as u64;
        self.beyond += (made.saturating_sub(found) - lost) as u64;
    }

    /// Add another's sums.
    pub fn merge(&mut self, other: &Self) {
        self.duplicated += other.duplicated;
        self.torn += other.torn;
        self.lost += other.lost;
        self.beyond += other.beyond;
        self.visible += other.visible;
    }
}

/// How many of the first entries equal `key`.
fn run(keys: &[u64], key: u64) -> usize {
    keys.iter().take_while(|&&k| k == key).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge(generated: &[u64], kept: &[u64], nearest: Option<u32>) -> [u64; 4] {
        let mut j = Judgement::default();
        j.pixel(generated, kept, nearest);
        [j.duplicated, j.torn, j.lost, j.beyond]
    }

    #[test]
    fn judgements() {
        assert_eq!(judge(&[1, 2, 3], &[1, 2, 3], None), [0, 0, 0, 0]);
        assert_eq!(judge(&[1, 2, 3], &[1, 2], Some(2)), [0, 0, 0, 1], "3 is beyond the 2 nearest");
        assert_eq!(judge(&[1, 2, 3], &[1, 3], Some(2)), [0, 0, 1, 0], "2 was lost; 3 is there");
        assert_eq!(judge(&[1, 2, 3], &[2, 2], Some(2)), [1, 0, 1, 1]);
        assert_eq!(judge(&[1, 2], &[1, 7], None), [0, 1, 1, 0], "7 was never made");
        assert_eq!(judge(&[4, 4, 4], &[4], Some(2)), [0, 0, 1, 1], "of three equal, two belong");
        assert_eq!(judge(&[], &[], None), [0, 0, 0, 0]);
    }

    #[test]
    fn what_was_culled_and_can_be_seen_was_lost() {
        // Four missing: two hidden, one culled although it can be seen, one beyond the largest age.
        let reports = Tally { generated: 9, kept: 5, culled: 3, age: 1, ..Tally::default() };
        for (visible, culled, lost) in [(2, 2, 1), (1, 3, 0), (0, 3, 0)] {
            let judgement = Judgement { lost: 4, visible, ..Judgement::default() };
            let mut tally = reports;
            tally.correct(&judgement, true);
            assert_eq!((tally.culled, tally.lost), (culled, lost), "{visible}");
            assert!(tally.balances(), "{tally:?}");
        }
    }

    #[test]
    fn pixels_are_counted_as_one_by_one() {
        let generated: Vec<u32> = (0..130).map(|i| i * 7 % 11).collect();
        let gone: Vec<u32> = generated.iter().map(|g| g / 3).collect();
        let exact: Vec<u32> = generated.iter().zip(&gone).map(|(a, b)| a - b).collect();
        let changed = |place: usize, value: u32| {
            let mut kept = exact.clone();
            kept[place] = value;
            kept
        };
        let mut far = generated.clone();
        far[129] = u32::MAX;
        let merged: Vec<u32> = (0..130).map(|i| i % 2).collect();
        for (generated, kept, merged) in [
            (&generated, exact.clone(), vec![]),
            (&generated, changed(0, 9), vec![]),
            (&generated, changed(129, u32::MAX), vec![]),
            (&far, changed(128, 0), vec![]),
            (&generated, exact.clone(), merged.clone()),
        ] {
            let [mut one, mut all] = [Tally { kept: 3, generated: 5, ..Tally::default() }; 2];
            for i in 0..130 {
                let merged = merged.get(i).map_or(0, |&m| m);
                one.pixel(generated[i], gone[i], kept[i] as usize, merged);
            }
            all.pixels([generated, &gone, &kept], &merged);
            assert_eq!(all, one);
        }
    }

    #[test]
    fn a_corrected_tally_balances() {
        // Three generated, k = 2; both invocations that were too late report the same eviction.
        let mut tally = Tally { generated: 3, kept: 2, evicted: 2, ..Tally::default() };
        let mut judgement = Judgement::default();
        judgement.pixel(&[1, 2, 3], &[1, 1], Some(2));
        tally.correct(&judgement, false);
        assert!(tally.balances(), "{tally:?}");
        assert_eq!((tally.lost, tally.duplicated, tally.evicted), (1, 1, 1));
    }
}
