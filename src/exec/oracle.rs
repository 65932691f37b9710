//! The exact reference as a frame.

use rayon::prelude::*;

use super::Job;
use super::account::Tally;
use super::frame::Frame;
use super::frame::finish::Finisher;
use crate::memory::Counters;
use crate::scheme::{Held, exact};

/// Collect, sort and cut every pixel's fragments: `k` nearest, or all.
#[must_use]
pub fn run(job: &Job<'_>, k: Option<u32>) -> Frame {
    let tiles = (0..job.front.grid.tiles()).into_par_iter().map(|tile| {
        let mut finisher = Finisher::new(job, tile);
        let mut reports = Tally::default();
        for mut keys in exact::tile(job.front, tile, job.record, None) {
            let generated = keys.len();
            keys.truncate(k.map_or(usize::MAX, |k| k as usize));
            let evicted = (generated - keys.len()) as u32;
            reports.evicted += u64::from(evicted);
            finisher.pixel(&Held::Keys(keys), generated as u32, evicted);
        }
        finisher.finish(&reports)
    });
    let tiles: Vec<_> = tiles.collect();
    Frame::new(tiles, &Tally::default(), Counters::default())
}
