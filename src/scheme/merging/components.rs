//! What order-independent merging gives, as a function of a pixel's slabs alone: slabs that overlap, or are linked by
//! others that do, are one component; the nearest components are records, and the rest is the tail.
//!
//! No method can give that in bounded memory, in one pass: when 2k slabs that lie apart have come in, a last one may
//! still join the nearest k of them, and the others must then be told apart. So `dfb+ofm` keeps all fragments, and
//! `skb+ofm` gives it wherever no more than k - 1 slabs lie apart ([`never_overflows`]), or none overlap.

use std::cmp::Ordering;

use super::sums::{self, Logarithms, Mix, Sums};
use crate::fragment::key;
use crate::num::planes::Distances;
use crate::scheme::{Record, Records, Scale, Whole};

/// A fragment's slab as it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stored {
    /// The depth word of its far end.
    pub depth: u32,
    /// Its colour word.
    pub data: u32,
    /// The depth word of its near end.
    pub near: u32,
}

/// A record of merged slabs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Merged {
    /// The depth word of its near end.
    pub near: u32,
    /// The depth word of its far end.
    pub depth: u32,
    /// What it looks like.
    pub sums: Sums,
}

impl Merged {
    /// Both as one.
    #[inline]
    #[must_use]
    pub fn with<M: Mix>(self, new: Self) -> Self {
        Self {
            near: self.near.min(new.near),
            depth: self.depth.max(new.depth),
            sums: M::mix(self.sums, new.sums),
        }
    }

    /// What comes first is nearer: by depth, then by colour word, then by the near end. Colour words are made only
    /// where depths are equal.
    #[inline]
    #[must_use]
    pub fn order<M: Mix>(&self, other: &Self) -> Ordering {
        let rest = |merged: &Self| (M::word(merged.sums), merged.near);
        self.depth.cmp(&other.depth).then_with(|| rest(self).cmp(&rest(other)))
    }

    /// As it leaves the method.
    #[inline]
    #[must_use]
    pub fn record<M: Mix>(&self, distances: &Distances) -> Record {
        let Self { near, depth, sums } = *self;
        let thickness = Scale(*distances).between(near, depth);
        Record { depth, thickness, rgba: M::rgba(sums), weight: sums::weight(sums).into() }
    }
}

impl Stored {
    /// As a record of its own.
    #[must_use]
    pub fn alone<M: Mix>(self, logarithms: &Logarithms) -> Merged {
        let sums = M::one(self.data, logarithms);
        Merged { near: self.near, depth: self.depth, sums }
    }

    /// It is no surface: it may overlap others.
    #[must_use]
    pub fn is_thick(&self) -> bool {
        self.near < self.depth
    }
}

/// The components, nearest first, of slabs in canonical order.
#[must_use]
pub fn components<M: Mix>(slabs: &[Stored], logarithms: &Logarithms) -> Vec<Merged> {
    let mut thick: Vec<Stored> = slabs.iter().copied().filter(Stored::is_thick).collect();
    thick.sort_unstable_by_key(|slab| (slab.near, *slab));
    let mut all: Vec<Merged> = Vec::new();
    for slab in thick {
        let alone = slab.alone::<M>(logarithms);
        match all.last_mut().filter(|last| slab.near < last.depth) {
            Some(last) => *last = last.with::<M>(alone),
            None => all.push(alone),
        }
    }
    // A surface overlaps nothing.
    all.extend(
        slabs.iter().filter(|slab| !slab.is_thick()).map(|slab| slab.alone::<M>(logarithms)),
    );
    all.sort_by(Merged::order::<M>);
    all
}

/// At most `k` records: the nearest components, and the rest as a tail.
#[must_use]
pub fn with_tail<M: Mix>(mut all: Vec<Merged>, k: u32) -> Vec<Merged> {
    let k = k as usize;
    if all.len() > k {
        let rest = all.drain(k - 1..).reduce(Merged::with::<M>);
        all.extend(rest);
    }
    all
}

/// Records as they leave a method, with the fragments merged into others.
#[must_use]
pub fn records<M: Mix>(all: &[Merged], distances: &Distances) -> Records {
    let mut records = Records::at(Scale(*distances));
    put_all::<M>(&mut records, all, distances);
    records
}

/// Put a record, as it leaves a method, into one of the places made for it, and count the fragments merged into it.
#[inline(always)]
#[allow(clippy::inline_always, reason = "once for every record")]
pub fn put<M: Mix>(records: &mut Records, place: usize, merged: &Merged, distances: &Distances) {
    let Merged { near, depth, sums } = *merged;
    match M::exact(sums) {
        Some(word) => records.put(place, Whole { key: key(depth, word), near }),
        None => records.put_record(place, merged.record::<M>(distances)),
    }
    records.merged += sums::weight(merged.sums).saturating_sub(1);
}

/// Put records after others, as they leave a method.
pub fn put_all<M: Mix>(records: &mut Records, all: &[Merged], distances: &Distances) {
    let places = records.spread(all.len())..;
    places.zip(all).for_each(|(place, merged)| put::<M>(records, place, merged, distances));
}

/// Whether at most `most` of these slabs, in canonical order, lie apart from each other: then no more records than that
/// can exist at any time, whatever the order of arrival.
#[must_use]
pub fn never_overflows(slabs: &[Stored], most: u32) -> bool {
    let mut apart = slabs.iter().filter(|slab| !slab.is_thick()).count();
    // The one that ends first leaves the most room behind it.
    let mut end = 0;
    for slab in slabs.iter().filter(|slab| slab.is_thick()) {
        if slab.near >= end {
            (apart, end) = (apart + 1, slab.depth);
        }
    }
    apart <= most as usize
}
