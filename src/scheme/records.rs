//! Merged records, one after another, in little memory. Where nothing was merged, a record is a fragment, which takes 8
//! bytes, or 12 with its near end, instead of 56; it is spelt out where somebody looks at it.

use std::ops::Range;

use super::record::{Record, Scale, Single, Whole};
use crate::fragment::sort::Sort;
use crate::fragment::{data_of, depth_of, key};
use crate::num::depth::EMPTY;

/// How many places are made at once.
const AT_ONCE: usize = 8;

/// Merged records of a pixel, or of several, one pixel after another.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Records {
    /// One each: of what is one fragment, its key with the colour word. The depth [`EMPTY`], which no fragment has, says
    /// that it is the record of the data word's number.
    keys: Vec<u64>,
    /// The near ends of the first of them, by place; the others are surfaces.
    nears: Vec<u32>,
    /// Those that are not one fragment.
    list: Vec<Record>,
    /// How thick what is one fragment is.
    pub scale: Scale,
    /// Fragments that went into another record during resolve: those that no store invocation has reported as
    /// [`Outcome::Merged`](super::Outcome).
    pub merged: u32,
}

impl Records {
    /// Records as they are.
    #[must_use]
    pub fn of(list: Vec<Record>, merged: u32) -> Self {
        let keys = (0..list.len() as u32).map(|number| key(EMPTY, number)).collect();
        Self { keys, list, merged, ..Self::default() }
    }

    /// None yet, to be of this scale.
    #[must_use]
    pub fn at(scale: Scale) -> Self {
        Self { scale, ..Self::default() }
    }

    /// Forget all of them, and keep the room.
    pub fn clear(&mut self) {
        self.keys.clear();
        self.nears.clear();
        self.list.clear();
        self.merged = 0;
    }

    /// Make room for so many that are one fragment each, and hardly more.
    pub fn reserve(&mut self, count: usize) {
        self.keys.reserve_exact(count + AT_ONCE);
    }

    /// Add a surface of one fragment: its key with the colour word.
    #[inline]
    pub fn surface(&mut self, key: u64) {
        self.keys.push(key);
    }

    /// Add what is one fragment; [`Records::scale`] says how thick it is.
    #[inline]
    pub fn whole(&mut self, Whole { key, near }: Whole) {
        let place = self.keys.len();
        self.keys.push(key);
        if near < depth_of(key) {
            if self.nears.len() < place {
                self.pad(place);
            }
            self.nears.push(near);
        }
    }

    /// Make so many more places, to be filled one by one in their order ([`Records::put`], [`Records::put_record`]).
    /// Returns the first.
    #[inline]
    pub fn spread(&mut self, count: usize) -> usize {
        let first = self.keys.len();
        let end = first + count;
        // By a few at once, which takes no call.
        while self.keys.len() < end {
            self.keys.extend_from_slice(&[0; AT_ONCE]);
        }
        self.keys.truncate(end);
        first
    }

    /// Put a record into a place.
    #[inline]
    pub fn put_record(&mut self, place: usize, record: Record) {
        self.keys[place] = key(EMPTY, self.list.len() as u32);
        if let Some(own) = self.nears.get_mut(place) {
            *own = EMPTY;
        }
        self.list.push(record);
    }

    /// Add a record.
    #[inline]
    pub fn push(&mut self, record: Record) {
        self.keys.push(key(EMPTY, self.list.len() as u32));
        self.list.push(record);
    }

    /// Add others.
    pub fn append(&mut self, more: &Self) {
        let (place, first) = (self.keys.len(), self.list.len() as u32);
        let own = |&key: &u64| if is_merged(key) { key + u64::from(first) } else { key };
        self.keys.extend(more.keys.iter().map(own));
        if !more.nears.is_empty() {
            self.pad(place);
            self.nears.extend(&more.nears);
        }
        self.list.extend(&more.list);
        if !more.is_empty() {
            self.scale = more.scale;
        }
        self.merged += more.merged;
    }

    /// Let at least so many have near ends of their own.
    #[inline(never)]
    fn pad(&mut self, places: usize) {
        if self.nears.len() < places {
            // As much room as the keys have, so that it does not grow step by step.
            self.nears.reserve_exact(self.keys.capacity().max(places) - self.nears.len());
            self.nears.extend(self.keys[self.nears.len()..places].iter().map(|&key| depth_of(key)));
        }
    }

    /// How many there are.
    #[inline]
    #[must_use]
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// There is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// All in these places are one fragment each.
    #[inline]
    #[must_use]
    pub fn are_single(&self, places: Range<usize>) -> bool {
        self.list.is_empty() || !self.keys[places].iter().any(|&key| is_merged(key))
    }

    /// Those in these places, in canonical order and one fragment each, do not overlap.
    #[must_use]
    pub fn are_apart(&self, places: Range<usize>) -> bool {
        let starts = places.start + 1..places.end.min(self.nears.len()).max(places.start + 1);
        starts.into_iter().all(|place| depth_of(self.keys[place - 1]) <= self.nears[place])
    }

    /// The key in a place: a fragment's, or that of a record that is none.
    #[inline]
    #[must_use]
    pub fn key(&self, place: usize) -> u64 {
        self.keys[place]
    }

    /// What is in a place, which is one fragment.
    #[inline]
    #[must_use]
    pub fn single(&self, place: usize) -> Whole {
        let key = self.keys[place];
        Whole { key, near: self.nears.get(place).copied().unwrap_or(depth_of(key)) }
    }

    /// Put what is one fragment into a place.
    #[inline]
    pub fn put(&mut self, place: usize, Whole { key, near }: Whole) {
        self.keys[place] = key;
        if let Some(own) = self.nears.get_mut(place) {
            *own = near;
        } else if near < depth_of(key) {
            if self.nears.len() < place {
                self.pad(place);
            }
            self.nears.push(near);
        }
    }

    /// The record that is no single fragment in a place, if it is one.
    #[inline]
    #[must_use]
    pub fn merged_at(&self, place: usize) -> Option<&Record> {
        let key = self.keys[place];
        if is_merged(key) { self.list.get(data_of(key) as usize) } else { None }
    }

    /// The record in a place, spelt out.
    #[inline]
    #[must_use]
    pub fn record(&self, place: usize) -> Record {
        match self.merged_at(place) {
            Some(record) => *record,
            None => self.single(place).record(self.scale),
        }
    }

    /// All of them, spelt out.
    pub fn spelt_out(&self) -> impl Iterator<Item = Record> + '_ {
        (0..self.len()).map(|place| self.record(place))
    }

    /// Forget all from this place on.
    pub fn truncate(&mut self, places: usize) {
        self.keys.truncate(places);
        self.nears.truncate(places);
        let last = self.keys.iter().filter(|&&key| is_merged(key)).map(|&key| data_of(key) + 1);
        self.list.truncate(if self.list.is_empty() { 0 } else { last.max().unwrap_or(0) as usize });
    }

    /// Put a pixel's records into canonical order, spelt out.
    pub fn sort(&mut self) {
        let mut list: Vec<Record> = self.spelt_out().collect();
        list.sort_unstable();
        *self = Self { scale: self.scale, ..Self::of(list, self.merged) };
    }

    /// All of them in their order, spelt out.
    #[must_use]
    pub fn into_list(self) -> Vec<Record> {
        self.spelt_out().collect()
    }

    /// Copy the records from a place on, as many as `out` takes.
    pub fn copy(&self, first: usize, out: &mut [Record]) {
        for (place, out) in (first..).zip(out) {
            *out = self.record(place);
        }
    }

    /// Put a pixel's records, in these places, into canonical order. Those that are one fragment, all of them, are put
    /// in order by `sort`, which sorts ascending.
    #[inline]
    pub fn arrange(&mut self, places: Range<usize>, sort: impl Fn(&mut [u64])) {
        if !self.are_single(places.clone()) {
            self.arrange_any(places);
        } else if self.nears.len() <= places.start {
            sort(&mut self.keys[places]);
        } else {
            self.arrange_thick(places, sort);
        }
    }

    /// As [`Records::arrange`], of all pixels, but for a picture alone: near ends stay where they are. Returns whether it
    /// could be done: every record is one fragment.
    #[inline]
    pub fn arrange_colors(&mut self, ends: &[u32], sort: Sort) -> bool {
        if self.list.is_empty() {
            sort.lists(&mut self.keys, ends);
        }
        self.list.is_empty()
    }

    /// Depths decide, but for ties.
    fn arrange_thick(&mut self, places: Range<usize>, sort: impl Fn(&mut [u64])) {
        self.pad(places.end);
        let (keys, nears) = (&mut self.keys[places.clone()], &mut self.nears[places]);
        if keys.windows(2).all(|two| depth_of(two[0]) < depth_of(two[1])) {
            return;
        }
        let arranged = match keys.len() {
            0 | 1 => true,
            2..=8 => arrange_by_depth::<8>(keys, nears, sort),
            9..=32 => arrange_by_depth::<32>(keys, nears, sort),
            _ => false,
        };
        if arranged {
            return;
        }
        let mut wholes: Vec<Whole> =
            keys.iter().zip(&*nears).map(|(&key, &near)| Whole { key, near }).collect();
        wholes.sort_unstable();
        for ((own, near), whole) in keys.iter_mut().zip(nears).zip(wholes) {
            (*own, *near) = (whole.key, whole.near);
        }
    }

    /// Among them are records that are not one fragment.
    fn arrange_any(&mut self, places: Range<usize>) {
        let depth = |place: usize| {
            self.merged_at(place).map_or_else(|| depth_of(self.keys[place]), |merged| merged.depth)
        };
        let mut order: Vec<(u32, usize)> =
            places.clone().map(|place| (depth(place), place)).collect();
        order.sort_unstable_by(|&(a, i), &(b, j)| {
            a.cmp(&b).then_with(|| self.record(i).cmp(&self.record(j)))
        });
        let moved: Vec<(u64, u32)> =
            order.iter().map(|&(_, from)| (self.keys[from], self.single(from).near)).collect();
        let has_nears = self.nears.len() > places.start;
        if has_nears {
            self.pad(places.end);
        }
        for (place, (key, near)) in places.zip(moved) {
            self.keys[place] = key;
            if has_nears {
                self.nears[place] = near;
            }
        }
    }
}

/// Sort at most `MOST` by depth alone. Returns whether that was enough: no two have the same.
#[inline]
fn arrange_by_depth<const MOST: usize>(
    keys: &mut [u64],
    nears: &mut [u32],
    sort: impl Fn(&mut [u64]),
) -> bool {
    // Depths with places, and what was there.
    let (mut all, mut data, mut ends) = ([0; MOST], [0; MOST], [0; MOST]);
    for (i, (&own, &near)) in keys.iter().zip(&*nears).enumerate() {
        (all[i], data[i], ends[i]) = (key(depth_of(own), i as u32), data_of(own), near);
    }
    let all = &mut all[..keys.len()];
    sort(all);
    if all.windows(2).any(|two| depth_of(two[0]) == depth_of(two[1])) {
        return false;
    }
    for (&moved, (own, near)) in all.iter().zip(keys.iter_mut().zip(nears)) {
        let from = data_of(moved) as usize % MOST;
        (*own, *near) = (key(depth_of(moved), data[from]), ends[from]);
    }
    true
}

/// It stands for a record of the list.
#[inline]
fn is_merged(key: u64) -> bool {
    depth_of(key) == EMPTY
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::num::ray::Ray;
    use crate::scheme::Holds;

    #[test]
    fn what_goes_in_comes_out() {
        let (near, far) = (key(3, 0x8000_FF01), key(EMPTY - 1, u32::MAX));
        let merged = Record { thickness: 0.5, weight: 2.0, ..Record::surface(4, 7) };
        let mut records = Records::default();
        records.surface(near);
        assert_eq!(records.nears.capacity(), 0, "surfaces take no more than their keys");
        records.push(merged);
        let thick = Whole { key: key(4, 0xFF00_0000), near: 1 };
        records.whole(thick);
        records.push(Record::surface(EMPTY, 9));
        records.surface(far);
        records.whole(Whole::surface(far));
        let [near, far] = [near, far].map(Record::of_key);
        let scale = records.scale;
        let expected = [near, merged, thick.record(scale), Record::surface(EMPTY, 9), far, far];
        let mut found = [Record::default(); 6];
        records.copy(0, &mut found);
        assert_eq!(found, expected);
        records.copy(2, &mut found[..3]);
        assert_eq!(found[..3], expected[2..5]);
        assert!(records.are_single(4..6) && !records.are_single(1..3));
        records.truncate(3);
        records.push(merged);
        assert_eq!(records.into_list(), [&expected[..3], &[merged]].concat());
    }

    #[test]
    fn surfaces_are_records_of_the_list_once_sorted() {
        let (near, far) = (key(3, 0x8000_FF01), key(5, 0xFF01_80FF));
        let list = vec![Record { weight: 2.0, ..Record::surface(4, 0x8000_FF01) }];
        let mut records = Records::of(list.clone(), 1);
        records.surface(far);
        records.surface(near);
        let mut held = records.into_held();
        assert_eq!(held.len(), 3);
        held.sort();
        let sorted = vec![Record::of_key(near), list[0], Record::of_key(far)];
        assert_eq!(held, Records::of(sorted, 1).into_held());
    }

    /// Entries of few depths, so that many are equal; what cannot be seen included.
    fn entries(most: usize) -> impl Strategy<Value = Vec<(Whole, bool)>> {
        let words = prop::sample::select(vec![0x8000_FF01, 0xFF01_80FF, 0x00FF_0000, 0xFF, 0]);
        let one = (3..9_u32, words, 0..4_u32, prop::bool::weighted(0.2));
        let whole = |(depth, word, thick, merged): (u32, u32, u32, bool)| {
            (Whole { key: key(depth, word), near: depth - thick.min(2) }, merged)
        };
        prop::collection::vec(one.prop_map(whole), 0..most)
    }

    fn of(entries: &[(Whole, bool)], thick: bool, merged: bool) -> Records {
        let mut records = Records::default();
        for &(whole, is_merged) in entries {
            let whole = if thick { whole } else { Whole::surface(whole.key) };
            if merged && is_merged {
                records.push(Record { weight: 2.0, ..whole.record(records.scale) });
            } else {
                records.whole(whole);
            }
        }
        records
    }

    proptest! {
        /// Places filled one by one hold what is added one by one.
        #[test]
        fn places_are_filled_in_their_order(
            pixels in prop::collection::vec(entries(40), 1..5), thick: bool, merged: bool,
        ) {
            let (mut added, mut filled) = (Records::default(), Records::default());
            for pixel in &pixels {
                let own = of(pixel, thick, merged);
                added.append(&own);
                let first = filled.spread(own.len());
                prop_assert_eq!(first + own.len(), added.len());
                for place in 0..own.len() {
                    match own.merged_at(place) {
                        Some(&record) => filled.put_record(first + place, record),
                        None => filled.put(first + place, own.single(place)),
                    }
                }
            }
            prop_assert_eq!(filled.nears.is_empty(), added.nears.is_empty());
            prop_assert_eq!(filled.into_list(), added.into_list());
        }

        /// What is in order for a picture shows what is in order.
        #[test]
        fn near_ends_do_not_show(entries in entries(40), thick: bool, merged: bool) {
            let (mut whole, mut colors) = (of(&entries, thick, merged), of(&entries, thick, merged));
            whole.arrange(0..entries.len(), <[u64]>::sort_unstable);
            let arranged = colors.arrange_colors(&[entries.len() as u32], Sort::default());
            prop_assert_eq!(arranged, whole.list.is_empty());
            let look = |records: &Records| {
                let mut ray = Ray::default();
                (0..records.len()).for_each(|place| ray.over(data_of(records.key(place))));
                ray
            };
            prop_assert!(!arranged || look(&colors) == look(&whole));
        }

        /// A pixel's records, between those of others, in the order of what they stand for.
        #[test]
        fn arranged_records_are_in_the_order_of_what_they_stand_for(
            pixels in prop::collection::vec(entries(40), 1..5), thick: bool, merged: bool,
        ) {
            let mut all = Records::default();
            let mut ends = vec![0];
            let mut expected = Vec::new();
            for pixel in &pixels {
                let own = of(pixel, thick, merged);
                all.append(&own);
                ends.push(all.len());
                let mut list = own.into_list();
                list.sort_unstable();
                expected.extend(list);
            }
            for ends in ends.windows(2) {
                all.arrange(ends[0]..ends[1], <[u64]>::sort_unstable);
            }
            prop_assert_eq!(all.into_list(), expected);
        }
    }
}
