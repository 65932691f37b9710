//! The results of executors: tiles of resolved pixels ([`finish`]), of one round or of several ([`rounds`]), joined into
//! lists and an image (`join`).

pub mod finish;
mod join;
pub mod rounds;

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Job;
use super::account::{Judgement, Tally};
use super::table::Left;
use crate::memory::Counters;
use crate::scheme::{Depth, HeldKind, Keeps, Light, Records, exact};

/// A finished frame.
#[derive(Debug, Default)]
pub struct Frame {
    /// By tile.
    pub tiles: Vec<TileOutput>,
    /// The accounting, judged where necessary.
    pub tally: Tally,
    /// The operations counted, if they were counted.
    pub counters: Counters,
    /// Accesses outside of the method's words.
    pub outside: u64,
    /// Rounds of the method's program: the largest number of any tile, if tiles proceed on their own.
    pub rounds: u32,
    /// The hash table, if the method has one.
    pub table: Option<Left>,
    /// Seconds of each pass, if passes run one after another.
    pub seconds: BTreeMap<String, f64>,
}

/// The resolved pixels of a tile, in storage order, without those outside the image (which have no fragments).
#[derive(Clone, Debug, Default)]
pub struct TileOutput {
    /// Entries per pixel.
    pub counts: Vec<u32>,
    /// What the pixels hold.
    pub column: Column,
    /// Their composited colours, sRGB RGBA8.
    pub colors: Vec<[u8; 4]>,
    /// This tile's part of the accounting.
    pub tally: Tally,
    /// Rounds that the tile went through, if it did so on its own.
    pub rounds: u32,
    /// Accesses outside of the words that the tile's worker owns.
    pub outside: u64,
}

/// What the pixels of a tile hold, one after another, front to back.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Fragments.
    Keys(Vec<u64>),
    /// Merged records.
    Records(Records),
    /// One colour a pixel.
    Lights(Vec<Light>),
    /// One depth a pixel.
    Depths(Vec<Depth>),
}

impl Default for Column {
    fn default() -> Self {
        Self::Keys(Vec::new())
    }
}

impl TileOutput {
    /// Without contents, but with its room.
    #[must_use]
    pub fn emptied(mut self) -> Self {
        self.counts.clear();
        self.colors.clear();
        match &mut self.column {
            Column::Keys(keys) => keys.clear(),
            Column::Records(records) => records.clear(),
            Column::Lights(lights) => lights.clear(),
            Column::Depths(depths) => depths.clear(),
        }
        let Self { counts, colors, column, .. } = self;
        Self { counts, colors, column, ..Self::default() }
    }
}

impl Column {
    /// The fragments; none if it holds something else.
    #[must_use]
    pub fn keys(&self) -> &[u64] {
        match self {
            Self::Keys(keys) => keys,
            Self::Records(_) | Self::Lights(_) | Self::Depths(_) => &[],
        }
    }
}

/// How many fragments were generated at, and reported gone from, each pixel of a tile.
#[derive(Clone, Debug, Default)]
pub struct PixelCounts {
    /// One geometry pass.
    pub generated: Vec<u32>,
    /// Culled, evicted or dropped.
    pub gone: Vec<u32>,
}

impl Frame {
    /// Join tiles. The accounting is what invocations reported, until it is settled.
    #[must_use]
    pub fn new(tiles: Vec<TileOutput>, reports: &Tally, counters: Counters) -> Self {
        let mut tally = *reports;
        tiles.iter().for_each(|tile| tally.merge(&tile.tally));
        let rounds = tiles.iter().map(|tile| tile.rounds).max().unwrap_or(0).max(1);
        let outside = tiles.iter().map(|tile| tile.outside).sum();
        Self { tiles, tally, counters, rounds, outside, table: None, seconds: BTreeMap::new() }
    }

    /// Correct the accounting by what pixels hold. If the method is racy, or any pixel did not balance, every list is
    /// compared with the exact one, which is no part of the method's work. Returns whether that was so.
    pub fn settle(&mut self, job: &Job<'_>) -> bool {
        if job.holds != HeldKind::Fragments || job.picture_only {
            self.tally.correct_by_count();
            return false;
        }
        let judged =
            job.contract.is_racy() || job.contract.is_judged() || self.tally.unbalanced > 0;
        if judged {
            let judgement = judge(job, &self.tiles);
            self.tally.correct(&judgement, job.contract.keeps == Keeps::Visible);
        }
        judged
    }
}

/// Compare every pixel's list with the fragments generated there.
fn judge(job: &Job<'_>, tiles: &[TileOutput]) -> Judgement {
    let per_tile = job.front.grid.pixels_per_tile();
    let tile = |(index, output): (usize, &TileOutput)| {
        let mut judgement = Judgement::default();
        let mut end = 0;
        let generated = exact::tile(job.front, index, job.record, None);
        let pixels = (index * per_tile..).zip(generated.iter().zip(&output.counts));
        for (pixel, (generated, &count)) in pixels {
            let kept = &output.column.keys()[end..end + count as usize];
            end += count as usize;
            judgement.pixel(generated, kept, job.nearest.at(pixel));
            if job.contract.keeps == Keeps::Visible {
                judgement.seen(generated, kept, job.opaque);
            }
        }
        judgement
    };
    let all: Vec<Judgement> = tiles.par_iter().enumerate().map(tile).collect();
    let mut sum = Judgement::default();
    all.iter().for_each(|j| sum.merge(j));
    sum
}
