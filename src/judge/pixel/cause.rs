//! Single causes that a pixel's difference may have, each tried on its list of fragments.

use crate::judge::answer::{Answer, Entry};
use crate::judge::class::Class;
use crate::judge::rule::Maker;
use crate::judge::rule::order::Fragments;

/// Up to so many fragments, any two may have changed places; of more, neighbours.
const PAIRS: usize = 12;

/// Up to so many fragments, every order is tried.
const ORDERS: usize = 5;

/// The most fragments at one depth whose every order is tried.
const TIED: usize = 5;

/// The most combinations of such orders; of more, those of each group alone.
const COMBINED: u64 = 2_000;

/// What may have happened at a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::judge) enum Cause {
    /// A triangle's fragment is not there.
    Missing(u32),
    /// No fragment of an object is there, of several.
    MissingObject(usize),
    /// A triangle's fragment is there twice.
    Duplicated(u32),
    /// The fragments of two triangles have changed places.
    Swapped(u32, u32),
    /// Only so many of the nearest are there.
    Nearest(u32),
    /// Only so many are there, those that were submitted first.
    First(u32),
    /// The order of submission, or its reverse, or that from back to front.
    Order(Fragments),
}

impl Cause {
    pub(in crate::judge) fn class(self) -> Class {
        match self {
            Self::Missing(_) | Self::MissingObject(_) => Class::Missing,
            Self::Duplicated(_) => Class::Duplicated,
            Self::Swapped(..) => Class::Swapped,
            Self::Nearest(_) => Class::BeyondK,
            Self::First(_) | Self::Order(_) => Class::Order,
        }
    }
}

/// A pixel that is looked at: its fragments, and whether a colour is what is seen.
pub(super) struct Look<'a> {
    pub(super) answer: &'a Answer<'a>,
    pub(super) maker: &'a Maker<'a>,
    pub(super) list: &'a [Entry],
    pub(super) seen: &'a dyn Fn([u8; 3]) -> bool,
}

impl Look<'_> {
    /// Whether a list, sorted, gives what is seen.
    pub(super) fn gives(&self, list: &[Entry], scratch: &mut Vec<Entry>) -> bool {
        (self.seen)(self.maker.color(list, scratch))
    }

    /// Triangles whose fragment's absence gives what is seen.
    pub(super) fn missing(&self, scratch: &mut [Vec<Entry>; 2]) -> Vec<Cause> {
        let [made, scratch] = scratch;
        let mut causes = Vec::new();
        for i in 0..self.list.len() {
            made.clear();
            made.extend(self.list[..i].iter().chain(&self.list[i + 1..]));
            if self.gives(made, scratch) {
                causes.push(Cause::Missing(self.list[i].triangle));
            }
        }
        causes
    }

    /// All causes but those that need every order.
    pub(super) fn causes(&self, scratch: &mut [Vec<Entry>; 2]) -> Vec<Cause> {
        let mut causes = self.missing(scratch);
        self.objects(scratch, &mut causes);
        self.duplicated(scratch, &mut causes);
        self.kept(scratch, &mut causes);
        self.ordered(scratch, &mut causes);
        causes
    }

    fn objects(&self, [made, scratch]: &mut [Vec<Entry>; 2], causes: &mut Vec<Cause>) {
        let solid = |entry: &Entry| self.answer.solids.part(entry.triangle).map(|part| part.solid);
        let mut solids: Vec<usize> = self.list.iter().filter_map(solid).collect();
        solids.sort_unstable();
        for several in solids.chunk_by(|a, b| a == b).filter(|same| same.len() > 1) {
            made.clear();
            made.extend(self.list.iter().filter(|entry| solid(entry) != Some(several[0])));
            if self.gives(made, scratch) {
                causes.push(Cause::MissingObject(several[0]));
            }
        }
    }

    fn duplicated(&self, [made, scratch]: &mut [Vec<Entry>; 2], causes: &mut Vec<Cause>) {
        for i in 0..self.list.len() {
            made.clear();
            made.extend(self.list[..=i].iter().chain(&self.list[i..]));
            if self.gives(made, scratch) {
                causes.push(Cause::Duplicated(self.list[i].triangle));
            }
        }
    }

    /// Fewer fragments.
    fn kept(&self, [made, scratch]: &mut [Vec<Entry>; 2], causes: &mut Vec<Cause>) {
        let all = self.list.len();
        for n in 1..all {
            if self.gives(&self.list[..n], scratch) {
                causes.push(Cause::Nearest(n as u32));
            }
        }
        let mut submitted: Vec<u32> = self.list.iter().map(|entry| entry.triangle).collect();
        submitted.sort_unstable();
        for (n, &next) in submitted.iter().enumerate().skip(1) {
            made.clear();
            made.extend(self.list.iter().filter(|entry| entry.triangle < next));
            if self.gives(made, scratch) {
                causes.push(Cause::First(n as u32));
            }
        }
    }

    /// Other orders.
    fn ordered(&self, [made, scratch]: &mut [Vec<Entry>; 2], causes: &mut Vec<Cause>) {
        let kept = self.arranged(made);
        let n = made.len();
        for i in 0..n {
            let last = if n <= PAIRS { n } else { (i + 2).min(n) };
            for j in i + 1..last {
                made.swap(i, j);
                if self.blends(made, kept) {
                    let [a, b] = [made[i].triangle, made[j].triangle];
                    causes.push(Cause::Swapped(a.min(b), a.max(b)));
                }
                made.swap(i, j);
            }
        }
        for order in [Fragments::Submitted, Fragments::SubmittedUnder, Fragments::Reversed] {
            scratch.clear();
            scratch.extend_from_slice(made);
            order.arrange(self.maker.scope, scratch);
            if (self.seen)(self.maker.arranged(scratch)) {
                causes.push(Cause::Order(order));
            }
        }
    }

    /// The fragments in the order in which the rule blends them, and how many of them it does.
    fn arranged(&self, made: &mut Vec<Entry>) -> usize {
        made.clear();
        made.extend_from_slice(self.list);
        let (order, scope) = (self.maker.rule.fragments, self.maker.scope);
        if !order.is_sorted() {
            order.arrange(scope, made);
        }
        order.most(scope)
    }

    /// Whether the first so many of a list, as it is ordered, give what is seen.
    fn blends(&self, made: &[Entry], kept: usize) -> bool {
        (self.seen)(self.maker.arranged(&made[..kept.min(made.len())]))
    }

    /// Whether any order at all gives what is seen.
    pub(super) fn any_order(&self, [made, _]: &mut [Vec<Entry>; 2]) -> bool {
        let kept = self.arranged(made);
        (2..=ORDERS).contains(&made.len()) && permuted(made, 0, &mut |made| self.blends(made, kept))
    }

    /// Whether another order of fragments of nearly equal depth gives what is seen: of each group in which every one is
    /// near to the next, by `is_near`.
    pub(super) fn tied(
        &self,
        [made, scratch]: &mut [Vec<Entry>; 2],
        is_near: impl Fn(&Entry, &Entry) -> bool,
    ) -> bool {
        let kept = self.arranged(made);
        let mut groups = Vec::new();
        let mut start = 0;
        for group in made.chunk_by(|a, b| is_near(a, b)) {
            groups.extend((group.len() > 1).then_some((start, group.len())));
            start += group.len();
        }
        if groups.is_empty() {
            return false;
        }
        // All groups in the order of submission, or its reverse.
        let whole = [true, false].into_iter().any(|first| {
            scratch.clear();
            scratch.extend_from_slice(made);
            for &(start, length) in &groups {
                let group = &mut scratch[start..start + length];
                group.sort_by_key(|entry| if first { entry.triangle } else { !entry.triangle });
            }
            self.blends(scratch, kept)
        });
        let orders = |&(_, length): &(usize, usize)| (1..=length as u64).product::<u64>();
        groups.retain(|&(_, length)| length <= TIED);
        let all = groups.iter().map(orders).try_fold(1_u64, u64::checked_mul);
        whole
            || match all {
                Some(count) if count <= COMBINED => self.regrouped(made, &groups, kept),
                // Too many: each group alone.
                _ => groups.iter().any(|group| self.regrouped(made, &[*group], kept)),
            }
    }

    /// Every order of every group, given by its place and length.
    fn regrouped(&self, made: &mut Vec<Entry>, groups: &[(usize, usize)], kept: usize) -> bool {
        let Some((&(start, length), rest)) = groups.split_first() else {
            return self.blends(made, kept);
        };
        let mut order: Vec<usize> = (0..length).collect();
        let group = made[start..start + length].to_vec();
        let found = permuted(&mut order, 0, &mut |order| {
            for (i, &from) in order.iter().enumerate() {
                made[start + i] = group[from];
            }
            self.regrouped(made, rest, kept)
        });
        made[start..start + length].copy_from_slice(&group);
        found
    }
}

/// Call `look` with every order of the elements from `fixed` on, until it returns true; the order is restored.
fn permuted<T>(list: &mut [T], fixed: usize, look: &mut dyn FnMut(&mut [T]) -> bool) -> bool {
    if fixed + 1 >= list.len() {
        return look(list);
    }
    (fixed..list.len()).any(|i| {
        list.swap(fixed, i);
        let found = permuted(list, fixed + 1, look);
        list.swap(fixed, i);
        found
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_is_tried_once() {
        let mut list = [1, 2, 3, 4];
        let mut seen = std::collections::BTreeSet::new();
        let mut count = 0;
        assert!(!permuted(&mut list, 0, &mut |order| {
            seen.insert(order.to_vec());
            count += 1;
            false
        }));
        assert_eq!((seen.len(), count, list), (24, 24, [1, 2, 3, 4]));
        assert!(permuted(&mut list, 0, &mut |order| order == [4, 3, 2, 1]));
        assert_eq!(list, [1, 2, 3, 4]);
    }
}
