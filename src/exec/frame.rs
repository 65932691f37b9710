//! What executors give: tiles of resolved pixels, joined into lists and an image.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Job;
use super::account::{Judgement, Tally};
use super::table::Table;
use crate::fragment::{Data, data_of, depth_of};
use crate::image::Image;
use crate::memory::Counters;
use crate::raster::Grid;
use crate::resolve::Lists;
use crate::resolve::composite::Ray;
use crate::scheme::{Keeps, Keys, exact};

/// A finished frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// By tile.
    pub tiles: Vec<TileOutput>,
    /// The accounting, judged where it must be.
    pub tally: Tally,
    /// What memory saw, if it was counted.
    pub counters: Counters,
    /// Rounds of the method's program: the most that any tile went through, where tiles go on their own.
    pub rounds: u32,
    /// The hash table, if the method has one.
    pub table: Option<Table>,
    /// Seconds of each pass, where passes follow each other.
    pub seconds: BTreeMap<String, f64>,
}

/// The resolved pixels of a tile, in storage order, without those outside the image (which have no fragments).
#[derive(Clone, Debug, Default)]
pub struct TileOutput {
    /// Entries per pixel.
    pub counts: Vec<u32>,
    /// The pixels' keys one after another, front to back.
    pub keys: Vec<u64>,
    /// Their composited colours, sRGB RGBA8.
    pub colors: Vec<[u8; 4]>,
    /// This tile's part of the accounting.
    pub tally: Tally,
    /// Rounds that the tile went through, if it did so on its own.
    pub rounds: u32,
}

/// How many fragments were generated at, and reported gone from, each pixel of a tile.
#[derive(Clone, Debug, Default)]
pub struct PixelCounts {
    /// One geometry pass.
    pub generated: Vec<u32>,
    /// Culled, evicted or dropped.
    pub gone: Vec<u32>,
}

impl PixelCounts {
    /// Zeroes for a tile.
    pub fn reset(&mut self, pixels: usize) {
        for counts in [&mut self.generated, &mut self.gone] {
            counts.clear();
            counts.resize(pixels, 0);
        }
    }
}

/// Takes a tile's pixels in storage order: sorts, composites and accounts for them.
pub struct Finisher<'a> {
    job: &'a Job<'a>,
    tile: usize,
    output: TileOutput,
}

impl<'a> Finisher<'a> {
    /// For one tile.
    #[must_use]
    pub fn new(job: &'a Job<'a>, tile: usize) -> Self {
        let mut output = TileOutput::default();
        let pixels = job.front.grid.pixels_per_tile();
        output.counts.reserve_exact(pixels);
        output.colors.reserve_exact(pixels);
        Self { job, tile, output }
    }

    /// Make room for the keys of a tile with these counts.
    pub fn reserve(&mut self, generated: &[u32]) {
        let nearest = self.job.nearest.unwrap_or(u32::MAX);
        let most: usize = generated.iter().map(|&g| g.min(nearest) as usize).sum();
        self.output.keys.reserve_exact(most);
    }

    /// The next pixel: its keys in any order, and its counts.
    #[inline]
    pub fn pixel(&mut self, keys: &mut [u64], generated: u32, gone: u32) {
        self.job.sort.run(keys);
        let mut ray = Ray::default();
        for &key in keys.iter() {
            ray.over(self.color(key));
            if ray.is_opaque() {
                break;
            }
        }
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(keys.len() as u32);
        self.output.keys.extend_from_slice(keys);
        self.output.tally.pixel(generated, gone, keys.len());
    }

    #[inline]
    fn color(&self, key: u64) -> u32 {
        match self.job.record.data {
            Data::Color | Data::Nothing => data_of(key),
            Data::Primitive => {
                let local = self.output.counts.len() as u32;
                let (x, y) = self.job.front.grid.position(self.tile, local);
                self.job.front.color_of(data_of(key), x, y, depth_of(key))
            }
        }
    }

    /// All pixels are in; `reports` is what the tile's invocations said.
    #[must_use]
    pub fn finish(mut self, reports: &Tally) -> TileOutput {
        self.output.tally.merge(reports);
        self.output
    }
}

/// Take a tile's pixels, the first of which is `first` in memory, from `resolve`, which appends a pixel's keys.
pub fn resolve_tile(
    mut resolve: impl FnMut(u32, &mut Keys),
    first: u32,
    counts: &PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    let mut keys = Keys::new();
    finisher.reserve(&counts.generated);
    for (pixel, (&generated, &gone)) in (first..).zip(counts.generated.iter().zip(&counts.gone)) {
        keys.clear();
        resolve(pixel, &mut keys);
        finisher.pixel(&mut keys, generated, gone);
    }
    finisher.finish(reports)
}

/// As [`resolve_tile`], of keys that were collected over several rounds.
pub fn collected_tile(
    lists: &mut [Keys],
    counts: &PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    for (keys, (&generated, &gone)) in
        lists.iter_mut().zip(counts.generated.iter().zip(&counts.gone))
    {
        finisher.pixel(keys, generated, gone);
    }
    finisher.finish(reports)
}

impl Frame {
    /// Join tiles; judge them if the method is racy, or if any pixel did not balance.
    #[must_use]
    pub fn new(job: &Job<'_>, tiles: Vec<TileOutput>, reports: &Tally, counters: Counters) -> Self {
        let mut tally = *reports;
        tiles.iter().for_each(|tile| tally.merge(&tile.tally));
        if job.contract.racy || job.contract.judged || tally.unbalanced > 0 {
            tally.correct(&judge(job, &tiles), job.contract.keeps == Keeps::Visible);
        }
        let rounds = tiles.iter().map(|tile| tile.rounds).max().unwrap_or(0).max(1);
        Self { tiles, tally, counters, rounds, table: None, seconds: BTreeMap::new() }
    }

    /// The kept fragments and the picture, row by row. The tiles are used up.
    #[must_use]
    pub fn assemble(&mut self, grid: &Grid) -> (Lists, Image) {
        let pixels = grid.width as usize * grid.height as usize;
        let tiles = std::mem::take(&mut self.tiles);
        let total: usize = tiles.iter().map(|t| t.keys.len()).sum();
        let mut offsets = vec![0u64; pixels + 1];
        let mut keys = vec![0u64; total];
        let mut colors = vec![[0u8; 4]; pixels];
        let band_pixels = (grid.tile * grid.width) as usize;
        let mut rest = keys.as_mut_slice();
        let mut first_key = 0;
        let mut bands = Vec::new();
        let rows = tiles.chunks(grid.columns() as usize);
        let parts = offsets[1..].chunks_mut(band_pixels).zip(colors.chunks_mut(band_pixels));
        for (row, (offsets, colors)) in rows.zip(parts) {
            let size = row.iter().map(|t| t.keys.len()).sum();
            let (keys, behind) = std::mem::take(&mut rest).split_at_mut(size);
            rest = behind;
            bands.push(Band { row, offsets, colors, keys, first_key });
            first_key += size as u64;
        }
        bands.into_par_iter().for_each(|band| band.fill(grid));
        let (width, height) = (grid.width, grid.height);
        (Lists { width, height, offsets, keys }, Image { width, height, pixels: colors })
    }
}

/// One row of tiles, on its way to row-major order.
struct Band<'a> {
    row: &'a [TileOutput],
    offsets: &'a mut [u64],
    colors: &'a mut [[u8; 4]],
    keys: &'a mut [u64],
    first_key: u64,
}

impl Band<'_> {
    fn fill(self, grid: &Grid) {
        let starts: Vec<Vec<u32>> = self.row.iter().map(starts).collect();
        let mut end = 0usize;
        for (i, (offset, color)) in self.offsets.iter_mut().zip(self.colors).enumerate() {
            let (x, y) = (i as u32 % grid.width, i as u32 / grid.width);
            let (tile, local) = ((x / grid.tile) as usize, grid.local_pixel(x, y) as usize);
            let output = &self.row[tile];
            let start = starts[tile][local] as usize;
            let count = output.counts[local] as usize;
            self.keys[end..end + count].copy_from_slice(&output.keys[start..start + count]);
            end += count;
            *offset = self.first_key + end as u64;
            *color = output.colors[local];
        }
    }
}

/// Where each pixel's keys begin.
fn starts(tile: &TileOutput) -> Vec<u32> {
    let mut sum = 0;
    let start = |&count: &u32| {
        sum += count;
        sum - count
    };
    tile.counts.iter().map(start).collect()
}

/// Compare every pixel's list with what was generated there.
fn judge(job: &Job<'_>, tiles: &[TileOutput]) -> Judgement {
    let tile = |(index, output): (usize, &TileOutput)| {
        let mut judgement = Judgement::default();
        let mut end = 0;
        let generated = exact::tile(job.front, index, job.record, None);
        for (generated, &count) in generated.iter().zip(&output.counts) {
            let kept = &output.keys[end..end + count as usize];
            end += count as usize;
            judgement.pixel(generated, kept, job.nearest);
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
