//! A tile's merged records in little memory. Where nothing was merged, a record is a fragment, which takes 8 bytes
//! instead of 56: less for the system to hand out, page by page, and that is most of what long lists cost.

use crate::fragment::{data_of, depth_of, key};
use crate::num::depth::EMPTY;
use crate::scheme::Record;

/// Records, one after another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compact {
    /// Surfaces of one fragment, as keys. The depth [`EMPTY`], which no fragment has, says that it is the record of the
    /// data word's number.
    keys: Vec<u64>,
    /// The others.
    records: Vec<Record>,
}

impl Compact {
    /// Make room for so many that are surfaces.
    pub fn reserve(&mut self, count: usize) {
        self.keys.reserve_exact(count);
    }

    /// Add surfaces of one fragment each, as keys with colour words.
    #[inline]
    pub fn surfaces(&mut self, keys: &[u64]) {
        self.keys.extend_from_slice(keys);
    }

    /// Add a record.
    #[inline]
    pub fn record(&mut self, record: Record) {
        self.keys.push(key(EMPTY, self.records.len() as u32));
        self.records.push(record);
    }

    /// Copy the records from number `first` on, as many as `out` takes.
    pub fn copy(&self, first: usize, out: &mut [Record]) {
        for (out, &key) in out.iter_mut().zip(&self.keys[first..]) {
            *out = match depth_of(key) {
                EMPTY => self.records[data_of(key) as usize],
                _ => Record::of_key(key),
            };
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
        compact.surfaces(&[near]);
        compact.record(merged);
        compact.record(Record::surface(EMPTY, 9));
        compact.surfaces(&[far, far]);
        let [near, far] = [near, far].map(Record::of_key);
        let expected = [near, merged, Record::surface(EMPTY, 9), far, far];
        let mut found = [Record::default(); 5];
        compact.copy(0, &mut found);
        assert_eq!(found, expected);
        compact.copy(2, &mut found[..3]);
        assert_eq!(found[..3], expected[2..]);
    }
}
