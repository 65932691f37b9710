//! A tile's merged records in little memory. Where nothing was merged, a record is a fragment, which takes 8 bytes, or
//! 12 with its near end, instead of 56: less for the system to hand out, page by page, and that is most of what long
//! lists cost.

use crate::fragment::{data_of, depth_of, key};
use crate::num::depth::EMPTY;
use crate::scheme::{Record, Scale, Single, Whole};

/// Records, one after another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compact {
    /// Those of one fragment, as keys. The depth [`EMPTY`], which no fragment has, says that it is the record of the
    /// data word's number.
    keys: Vec<u64>,
    /// The near ends of the first of them, by place; the others are surfaces.
    nears: Vec<u32>,
    /// How thick those are.
    scale: Scale,
    /// The others.
    records: Vec<Record>,
}

impl Compact {
    /// Forget all, and keep the room.
    pub fn clear(&mut self) {
        self.keys.clear();
        self.nears.clear();
        self.records.clear();
        self.scale = Scale::default();
    }

    /// Make room for so many that are one fragment each.
    pub fn reserve(&mut self, count: usize) {
        self.keys.reserve_exact(count);
    }

    /// Add records of one fragment each.
    #[inline]
    pub fn singles<T: Single>(&mut self, all: &[T], scale: Scale) {
        let begin = self.keys.len();
        self.keys.extend(all.iter().map(|one| one.key()));
        if T::THICK {
            // As much room as the keys have, so that it does not grow step by step.
            self.nears.reserve_exact(self.keys.capacity() - self.nears.len());
            let known = self.nears.len();
            self.nears.extend(self.keys[known..begin].iter().map(|&key| depth_of(key)));
            self.nears.extend(all.iter().map(|one| one.near()));
            self.scale = scale;
        }
    }

    /// Add a record.
    #[inline]
    pub fn record(&mut self, record: Record) {
        self.keys.push(key(EMPTY, self.records.len() as u32));
        self.records.push(record);
    }

    /// Copy the records from number `first` on, as many as `out` takes.
    pub fn copy(&self, first: usize, out: &mut [Record]) {
        for (place, (out, &key)) in (first..).zip(out.iter_mut().zip(&self.keys[first..])) {
            let merged =
                if depth_of(key) == EMPTY { self.records.get(data_of(key) as usize) } else { None };
            *out = merged.copied().unwrap_or_else(|| match self.nears.get(place) {
                Some(&near) => Whole { key, near }.record(self.scale),
                None => Record::of_key(key),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_comes_out() {
        let (near, far) = (key(3, 0x8000_FF01), key(EMPTY - 1, u32::MAX));
        let merged = Record { thickness: 0.5, weight: 2.0, ..Record::surface(4, 7) };
        let mut compact = Compact::default();
        let scale = Scale::default();
        let thick = Whole { key: key(4, 0xFF00_0000), near: 1 };
        compact.singles(&[near], scale);
        assert_eq!(compact.nears.capacity(), 0, "surfaces take no more than their keys");
        compact.record(merged);
        compact.singles(&[thick], scale);
        compact.record(Record::surface(EMPTY, 9));
        compact.singles(&[far, far], scale);
        let [near, far] = [near, far].map(Record::of_key);
        let expected = [near, merged, thick.record(scale), Record::surface(EMPTY, 9), far, far];
        let mut found = [Record::default(); 6];
        compact.copy(0, &mut found);
        assert_eq!(found, expected);
        compact.copy(2, &mut found[..3]);
        assert_eq!(found[..3], expected[2..5]);
    }
}
