//! The results of executors: tiles of resolved pixels, joined into lists and an image.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Job;
use super::account::{Judgement, Tally};
use super::table::TableWords;
use crate::fragment::{Data, data_of, depth_of};
use crate::image::Image;
use crate::memory::Counters;
use crate::raster::Grid;
use crate::resolve::compact::Compact;
use crate::resolve::composite::Ray;
use crate::resolve::{Kept, Lists};
use crate::scheme::{Depth, Held, HeldKind, Keeps, Light, Record, Records, Scale, Single, exact};

/// A finished frame.
#[derive(Clone, Debug, Default)]
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
    pub table: Option<TableWords>,
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
    Records(Compact),
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

impl Column {
    fn new(kind: HeldKind) -> Self {
        match kind {
            HeldKind::Fragments => Self::Keys(Vec::new()),
            HeldKind::Records => Self::Records(Compact::default()),
            HeldKind::Color => Self::Lights(Vec::new()),
            HeldKind::Depth => Self::Depths(Vec::new()),
        }
    }

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

/// Merged records of a pixel that room is made for: the `-k` that is usual.
const USUAL: u32 = 8;

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
        let mut output = TileOutput { column: Column::new(job.holds), ..TileOutput::default() };
        let pixels = job.front.grid.pixels_per_tile();
        output.counts.reserve_exact(pixels);
        output.colors.reserve_exact(pixels);
        Self { job, tile, output }
    }

    /// Make room for the keys of a tile with these counts.
    pub fn reserve(&mut self, generated: &[u32]) {
        if let Column::Records(records) = &mut self.output.column {
            records.reserve(generated.iter().map(|&g| g.min(USUAL) as usize).sum());
            return;
        }
        let Column::Keys(keys) = &mut self.output.column else { return };
        let first = self.tile * self.job.front.grid.pixels_per_tile();
        let most = |(i, &g): (usize, &u32)| self.job.nearest.cut(first + i, g as usize);
        keys.reserve_exact(generated.iter().enumerate().map(most).sum());
    }

    /// The next pixel: what it holds, lists in any order, and its counts.
    #[inline]
    pub fn pixel(&mut self, held: &mut Held, generated: u32, gone: u32) {
        match held {
            Held::Keys(keys) => self.keys(keys, generated, gone),
            Held::Records(records) => self.records(records, generated, gone),
            Held::Light(_) | Held::Depth(_) => self.other(held, generated, gone),
        }
    }

    /// The next pixel: its fragments in any order, and its counts.
    #[inline]
    pub fn keys(&mut self, keys: &mut [u64], generated: u32, gone: u32) {
        self.singles(keys, Scale::default(), generated, gone, 0);
    }

    /// What is one fragment each, and how many fragments were merged into others.
    #[inline]
    fn singles<T: Single>(
        &mut self,
        all: &mut [T],
        scale: Scale,
        generated: u32,
        gone: u32,
        merged: u32,
    ) {
        self.job.sort.run(all);
        let mut ray = Ray::default();
        for one in all.iter() {
            ray.over(self.color(one.key()));
            if ray.is_opaque() {
                break;
            }
        }
        match &mut self.output.column {
            Column::Keys(keys) => keys.extend(all.iter().map(|one| one.key())),
            Column::Records(records) => records.singles(all, scale),
            Column::Lights(_) | Column::Depths(_) => {}
        }
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(all.len() as u32);
        self.output.tally.pixel(generated, gone, all.len(), merged);
    }

    /// Merged records. Those of one fragment are sorted and composited as fragments are, which gives the same.
    fn records(&mut self, records: &mut Records, generated: u32, gone: u32) {
        if !records.wholes.is_empty() {
            records.unite();
        }
        let Records { list, surfaces, wholes, scale, merged } = records;
        let scale = *scale;
        match (list.is_empty(), wholes.is_empty()) {
            (true, true) => self.singles(surfaces, scale, generated, gone, *merged),
            (true, false) => self.singles(wholes, scale, generated, gone, *merged),
            (false, true) => self.mixed(list, (surfaces, scale), generated, gone, *merged),
            (false, false) => self.mixed(list, (wholes, scale), generated, gone, *merged),
        }
    }

    /// Records among which there are some of one fragment.
    fn mixed<T: Single>(
        &mut self,
        list: &mut [Record],
        (singles, scale): (&mut [T], Scale),
        generated: u32,
        gone: u32,
        merged: u32,
    ) {
        self.job.sort.run(singles);
        list.sort_unstable();
        let Column::Records(all) = &mut self.output.column else { return };
        let (mut ray, mut rest) = (Ray::default(), &*singles);
        for record in list.iter().map(Some).chain([None]) {
            let is_before = |one: T| record.is_none_or(|record| is_before(one, scale, record));
            let (before, behind) = rest.split_at(rest.partition_point(|&one| is_before(one)));
            before.iter().for_each(|one| ray.over(data_of(one.key())));
            all.singles(before, scale);
            rest = behind;
            if let Some(record) = record {
                ray.over_record(record);
                all.record(*record);
            }
        }
        let count = list.len() + singles.len();
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(count as u32);
        self.output.tally.pixel(generated, gone, count, merged);
    }

    /// A colour or a depth.
    #[inline(never)]
    fn other(&mut self, held: &Held, generated: u32, gone: u32) {
        let mut ray = Ray::default();
        match (held, &mut self.output.column) {
            (Held::Light(light), Column::Lights(all)) => {
                ray = Ray::of_light(light);
                all.push(*light);
            }
            (Held::Depth(depth), Column::Depths(all)) => {
                ray = Ray::of_depth(*depth);
                all.push(*depth);
            }
            _ => {}
        }
        self.output.colors.push(ray.finish(self.job.background));
        self.output.counts.push(0);
        self.output.tally.pixel(generated, gone, held.len(), 0);
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

    /// All pixels are in; `reports` is what the tile's invocations reported.
    #[must_use]
    pub fn finish(mut self, reports: &Tally) -> TileOutput {
        self.output.tally.merge(reports);
        self.output
    }
}

/// Whether a fragment comes before a record in canonical order.
#[inline]
fn is_before(one: impl Single, scale: Scale, record: &Record) -> bool {
    match depth_of(one.key()).cmp(&record.depth) {
        Ordering::Equal => one.record(scale) < *record,
        order => order == Ordering::Less,
    }
}

/// Take a tile's pixels, the first of which is `first` in memory, from `resolve`, which adds what a pixel holds.
pub fn resolve_tile(
    mut resolve: impl FnMut(u32, &mut Held),
    first: u32,
    counts: &PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    let mut held = finisher.job.holds.empty();
    finisher.reserve(&counts.generated);
    for (pixel, (&generated, &gone)) in (first..).zip(counts.generated.iter().zip(&counts.gone)) {
        held.clear();
        resolve(pixel, &mut held);
        finisher.pixel(&mut held, generated, gone);
    }
    finisher.finish(reports)
}

/// As [`resolve_tile`], from what was collected over several rounds.
pub fn collected_tile(
    collected: &mut [Held],
    counts: &PixelCounts,
    mut finisher: Finisher<'_>,
    reports: &Tally,
) -> TileOutput {
    for (held, (&generated, &gone)) in
        collected.iter_mut().zip(counts.generated.iter().zip(&counts.gone))
    {
        finisher.pixel(held, generated, gone);
    }
    finisher.finish(reports)
}

impl Frame {
    /// Join tiles; judge them if the method is racy, or if any pixel did not balance.
    #[must_use]
    pub fn new(job: &Job<'_>, tiles: Vec<TileOutput>, reports: &Tally, counters: Counters) -> Self {
        let mut tally = *reports;
        tiles.iter().for_each(|tile| tally.merge(&tile.tally));
        if job.holds != HeldKind::Fragments {
            tally.correct_by_count();
        } else if job.contract.is_racy() || job.contract.is_judged() || tally.unbalanced > 0 {
            tally.correct(&judge(job, &tiles), job.contract.keeps == Keeps::Visible);
        }
        let rounds = tiles.iter().map(|tile| tile.rounds).max().unwrap_or(0).max(1);
        let outside = tiles.iter().map(|tile| tile.outside).sum();
        Self { tiles, tally, counters, rounds, outside, table: None, seconds: BTreeMap::new() }
    }

    /// What the pixels hold, and the picture, row by row. The tiles are consumed.
    #[must_use]
    pub fn assemble(&mut self, grid: &Grid) -> (Kept, Image) {
        let tiles = std::mem::take(&mut self.tiles);
        let (kept, pixels) = match tiles.first().map(|tile| &tile.column) {
            Some(Column::Records(_)) => {
                let (lists, pixels) = join(&tiles, grid, |column, first, out| {
                    if let Column::Records(records) = column {
                        records.copy(first, out);
                    }
                });
                (Kept::Records(lists), pixels)
            }
            Some(Column::Lights(_)) => {
                let (_, pixels) = join::<u64>(&tiles, grid, |_, _, _| ());
                let light = |column: &Column, i: usize| match column {
                    Column::Lights(lights) => lights[i],
                    _ => Light::default(),
                };
                (Kept::Color(each(&tiles, grid, light)), pixels)
            }
            Some(Column::Depths(_)) => {
                let (_, pixels) = join::<u64>(&tiles, grid, |_, _, _| ());
                let depth = |column: &Column, i: usize| match column {
                    Column::Depths(depths) => depths[i],
                    _ => Depth::default(),
                };
                (Kept::Depths(each(&tiles, grid, depth)), pixels)
            }
            Some(Column::Keys(_)) | None => {
                let (lists, pixels) = join(&tiles, grid, |column, first, out| {
                    out.copy_from_slice(&column.keys()[first..first + out.len()]);
                });
                (Kept::Fragments(lists), pixels)
            }
        };
        (kept, Image { width: grid.width, height: grid.height, pixels })
    }
}

/// Lists and colours, row by row; `copy` reads a column's entries from a place on.
fn join<T: Copy + Default + Send + Sync>(
    tiles: &[TileOutput],
    grid: &Grid,
    copy: impl Fn(&Column, usize, &mut [T]) + Sync,
) -> (Lists<T>, Vec<[u8; 4]>) {
    let (width, height) = (grid.width, grid.height);
    let pixels = width as usize * height as usize;
    let total: usize = tiles.iter().map(entries_of).sum();
    let mut offsets = vec![0u64; pixels + 1];
    let mut entries = vec![T::default(); total];
    let mut colors = vec![[0u8; 4]; pixels];
    let band_pixels = (grid.tile * width) as usize;
    let mut rest = entries.as_mut_slice();
    let mut first_entry = 0;
    let mut bands = Vec::new();
    let rows = tiles.chunks(grid.columns() as usize);
    let parts = offsets[1..].chunks_mut(band_pixels).zip(colors.chunks_mut(band_pixels));
    for (row, (offsets, colors)) in rows.zip(parts) {
        let size = row.iter().map(entries_of).sum();
        let (entries, behind) = std::mem::take(&mut rest).split_at_mut(size);
        rest = behind;
        bands.push(Band { row, offsets, colors, entries, first_entry });
        first_entry += size as u64;
    }
    bands.into_par_iter().for_each(|band| band.fill(grid, &copy));
    (Lists { width, height, offsets, entries }, colors)
}

/// One row of tiles, on its way to row-major order.
struct Band<'a, T> {
    row: &'a [TileOutput],
    offsets: &'a mut [u64],
    colors: &'a mut [[u8; 4]],
    entries: &'a mut [T],
    first_entry: u64,
}

impl<T> Band<'_, T> {
    fn fill(self, grid: &Grid, copy: &impl Fn(&Column, usize, &mut [T])) {
        let starts: Vec<Vec<u32>> = self.row.iter().map(starts).collect();
        let mut end = 0usize;
        for (i, (offset, color)) in self.offsets.iter_mut().zip(self.colors).enumerate() {
            let (x, y) = (i as u32 % grid.width, i as u32 / grid.width);
            let (tile, local) = ((x / grid.tile) as usize, grid.local_pixel(x, y) as usize);
            let output = &self.row[tile];
            let start = starts[tile][local] as usize;
            let count = output.counts[local] as usize;
            copy(&output.column, start, &mut self.entries[end..end + count]);
            end += count;
            *offset = self.first_entry + end as u64;
            *color = output.colors[local];
        }
    }
}

/// How many entries a tile has.
fn entries_of(tile: &TileOutput) -> usize {
    tile.counts.iter().map(|&count| count as usize).sum()
}

/// Where each pixel's entries begin.
fn starts(tile: &TileOutput) -> Vec<u32> {
    let mut sum = 0;
    let start = |&count: &u32| {
        sum += count;
        sum - count
    };
    tile.counts.iter().map(start).collect()
}

/// What pixels hold that have one value each, row by row.
fn each<T>(tiles: &[TileOutput], grid: &Grid, value: impl Fn(&Column, usize) -> T) -> Vec<T> {
    let pixels = (0..grid.height).flat_map(|y| (0..grid.width).map(move |x| (x, y)));
    let of = |(x, y): (u32, u32)| {
        let tile = (y / grid.tile * grid.columns() + x / grid.tile) as usize;
        value(&tiles[tile].column, grid.local_pixel(x, y) as usize)
    };
    pixels.map(of).collect()
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
