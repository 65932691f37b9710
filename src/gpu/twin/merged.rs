//! Merged records: their words as a device emits them, and what a method that merges must give.

use rayon::prelude::*;

use crate::exec::promise::Promise;
use crate::fragment::Fragment;
use crate::num::planes::Distances;
use crate::scheme::merging::components::{Merged, Stored, records};
use crate::scheme::merging::sums::{Integers, logarithms};
use crate::scheme::{Held, Record, Records};

/// 64-bit words of a record in the results of resolve (`parts/merged.wgsl`): its ends, and its sums.
pub const WORDS: u32 = 4;

/// The records that these words are; `None` if the last one is not whole.
#[must_use]
pub fn merged(words: &[u64]) -> Option<Vec<Merged>> {
    let record = |words: &[u64]| Merged {
        near: words[0] as u32,
        depth: (words[0] >> 32) as u32,
        sums: [words[1], words[2], words[3]],
    };
    let records = words.chunks_exact(WORDS as usize);
    records.remainder().is_empty().then(|| records.map(record).collect())
}

/// Records as the simulator's own method gives them, in canonical order: near ends as distances, and sums as colours.
#[must_use]
pub fn held(all: &[Merged], distances: &Distances) -> Records {
    let mut records = records::<Integers>(all, distances);
    records.sort();
    records
}

/// All as one.
#[must_use]
pub fn as_one(all: impl IntoIterator<Item = Merged>) -> Option<Merged> {
    all.into_iter().reduce(Merged::with::<Integers>)
}

/// What a pixel must hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixel {
    /// All its fragments as one record, if it has any: whatever the order of arrival, its records are that if they are
    /// mixed.
    pub all: Option<Merged>,
    /// Its records in canonical order; `None` where arrival decides.
    pub records: Option<Vec<Record>>,
}

/// What a method that merges must give.
#[derive(Clone, Debug)]
pub struct Promised {
    /// Where the words of each pixel's records begin in the results of resolve; one entry more than there are pixels.
    pub starts: Vec<u32>,
    /// By storage pixel.
    pub pixels: Vec<Pixel>,
    /// How whole numbers become records.
    pub distances: Distances,
}

impl Promised {
    /// For pixels with these fragments, in canonical order, and at most `k` records.
    #[must_use]
    pub fn new(
        generated: &[Vec<Fragment>],
        k: u32,
        distances: Distances,
        promise: &Promise<'_>,
    ) -> Self {
        let logarithms = logarithms();
        let pixel = |(pixel, list): (usize, &Vec<Fragment>)| {
            let alone = |f: &Fragment| {
                Stored { depth: f.depth, data: f.data, near: f.extra }
                    .alone::<Integers>(&logarithms)
            };
            let records = match promise.pixel(pixel as u32, list) {
                Some(Held::Records(records)) => Some(records.into_list()),
                _ => None,
            };
            Pixel { all: as_one(list.iter().map(alone)), records }
        };
        let mut starts = vec![0];
        for list in generated {
            let room = WORDS * k.min(list.len() as u32);
            starts.push(starts.last().map_or(0, |start| start + room));
        }
        Self { starts, pixels: generated.par_iter().enumerate().map(pixel).collect(), distances }
    }
}
