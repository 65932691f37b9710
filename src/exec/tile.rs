//! Tiles in parallel: a worker owns a tile's pixels, so their memory is plain cells.
//!
//! Where no pixel waits for another ([`Program::is_local`](crate::scheme::contract::Program::is_local)), a tile goes
//! through all its passes and rounds at once, and its memory is the worker's, used again for the next tile: its pixels'
//! records, and its range of the pools, which then stays in the worker's cache. Else every tile keeps its memory, and a
//! pass ends for all tiles before the next begins.

use std::cell::Cell;
use std::ops::Range;

use rayon::prelude::*;

use super::Job;
use super::account::Tally;
use super::drive::{Outcomes, Pipeline};
use super::frame::{Finisher, Frame, PixelCounts, TileOutput, collected_tile, resolve_tile};
use super::table::Table;
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::memory::{Counters, Layout, Observer};
use crate::raster::Batch;
use crate::scheme::contract::{Kind, Pass};
use crate::scheme::{Keys, Outcome};

/// Invocations of a pass over the frame's words that go to a worker at once.
const CHUNK: u32 = 256;

/// Run a scheme. Call it inside the thread pool that shall do the work.
#[must_use]
pub fn run<O: Observer + Default + Send>(
    scheme: &dyn for<'a> Pipeline<Exclusive<'a, O>>,
    layout: &Layout,
    job: &Job<'_>,
) -> Frame {
    let global = Shared::new(layout.per_frame(), 1);
    let run = Run { scheme, layout, global: &global, job };
    let observer = O::default();
    let none = Owned::new(Layout::default().per_pixel(), 0);
    scheme.clear_frame(&Exclusive::new(&none, &global, None, &observer));
    let outputs = if job.contract.program.is_local() { run.tiles() } else { run.passes() };
    let mut counters = observer.counters().cloned().unwrap_or_default();
    let mut tiles = Vec::with_capacity(outputs.len());
    for (tile, counts) in outputs {
        counters.merge(&counts);
        tiles.push(tile);
    }
    let table = scheme.readback().map(|readback| Table::new(&readback, &global));
    Frame { table, ..Frame::new(job, tiles, &Tally::default(), counters) }
}

/// What all workers know.
struct Run<'a, O> {
    scheme: &'a dyn for<'b> Pipeline<Exclusive<'b, O>>,
    layout: &'a Layout,
    global: &'a Shared,
    job: &'a Job<'a>,
}

/// A tile at work: its memory, and what is known of its pixels.
struct Tile<O> {
    index: usize,
    memory: Owned,
    /// The worker's own range of every pool: that of a tile that was its.
    pool: Range<u64>,
    /// The next index of that range, if there is one.
    next: Option<Cell<u32>>,
    counts: PixelCounts,
    reports: Tally,
    rounds: u32,
    /// The pixels' fragments of all rounds so far, where there are several.
    lists: Vec<Keys>,
    observer: O,
    batch: Batch,
}

impl<O: Observer + Default + Send> Run<'_, O> {
    /// One tile after another, each from beginning to end.
    fn tiles(&self) -> Vec<(TileOutput, Counters)> {
        (0..self.job.front.grid.tiles())
            .into_par_iter()
            .map_init(
                || self.tile(),
                |tile, index| {
                    self.begin(tile, index);
                    let passes = self.job.contract.program.passes;
                    loop {
                        tile.rounds += 1;
                        for (number, pass) in passes.iter().enumerate() {
                            self.pass(tile, number, pass);
                        }
                        if !self.job.contract.program.repeats || !self.collect(tile) {
                            break;
                        }
                    }
                    self.finish(tile)
                },
            )
            .collect()
    }

    /// One pass after another, each for all tiles.
    fn passes(&self) -> Vec<(TileOutput, Counters)> {
        let program = &self.job.contract.program;
        let begun = |index: usize| {
            let mut tile = self.tile();
            self.begin(&mut tile, index);
            tile
        };
        let count = self.job.front.grid.tiles();
        let mut tiles: Vec<Tile<O>> = (0..count).into_par_iter().map(begun).collect();
        let mut counters = Counters::default();
        loop {
            tiles.iter_mut().for_each(|tile| tile.rounds += 1);
            for (number, pass) in program.passes.iter().enumerate() {
                if pass.kind == Kind::Frame {
                    counters.merge(&self.frame(number));
                } else {
                    tiles.par_iter_mut().for_each(|tile| self.pass(tile, number, pass));
                }
            }
            let again = |tile: &mut Tile<O>| self.collect(tile);
            if !program.repeats || !tiles.par_iter_mut().map(again).reduce(|| false, |a, b| a | b) {
                break;
            }
        }
        let mut outputs: Vec<(TileOutput, Counters)> =
            tiles.par_iter_mut().map(|tile| self.finish(tile)).collect();
        if let Some((_, first)) = outputs.first_mut() {
            first.merge(&counters);
        }
        outputs
    }

    fn tile(&self) -> Tile<O> {
        let pixels = self.job.front.grid.pixels_per_tile();
        Tile {
            index: 0,
            memory: Owned::new(self.layout.per_pixel(), pixels),
            pool: 0..0,
            next: None,
            counts: PixelCounts::default(),
            reports: Tally::default(),
            rounds: 0,
            lists: Vec::new(),
            observer: O::default(),
            batch: Batch::default(),
        }
    }

    fn first(&self, tile: &Tile<O>) -> u32 {
        (tile.index * self.job.front.grid.pixels_per_tile()) as u32
    }

    fn memory<'b>(&'b self, tile: &'b Tile<O>) -> Exclusive<'b, O> {
        let first = self.first(tile);
        Exclusive::from(first, &tile.memory, self.global, tile.next.as_ref(), &tile.observer)
    }

    /// Memory keeps the contents of the tile before: only a clear pass makes it fit for use.
    fn begin(&self, tile: &mut Tile<O>, index: usize) {
        let pixels = self.job.front.grid.pixels_per_tile();
        tile.index = index;
        tile.rounds = 0;
        tile.observer = O::default();
        if let Some(&[before, after]) = self.job.before_tile.get(index..index + 2) {
            // Where a pool is too small, which of its ranges a tile has decides what is dropped.
            if !self.job.whole_pools || after - before > tile.pool.end - tile.pool.start {
                tile.pool = before..after;
            }
            tile.next = Some(Cell::new(tile.pool.start as u32));
        }
        if self.job.contract.program.repeats {
            tile.lists.clear();
            tile.lists.resize(pixels, Keys::new());
        }
        let first = self.first(tile);
        self.scheme.clear(&self.memory(tile), first..first + pixels as u32);
    }

    fn pass(&self, tile: &mut Tile<O>, number: usize, pass: &Pass) {
        let pixels = self.job.front.grid.pixels_per_tile() as u32;
        let first = self.first(tile);
        match pass.kind {
            Kind::Screen => {
                self.scheme.screen(&self.memory(tile), number, first..first + pixels);
            }
            // Of one tile's passes, one over the frame's words can only be its own.
            Kind::Frame => {}
            Kind::Prepare | Kind::Store => self.geometry(tile, number, pass.kind == Kind::Store),
        }
    }

    /// A geometry pass. What a store pass of an earlier round said is forgotten.
    fn geometry(&self, tile: &mut Tile<O>, number: usize, stores: bool) {
        let (job, grid) = (self.job, &self.job.front.grid);
        let (first, interlock) = (self.first(tile), job.contract.interlock);
        let mem =
            Exclusive::from(first, &tile.memory, self.global, tile.next.as_ref(), &tile.observer);
        let Tile { counts, reports, batch, .. } = tile;
        counts.reset(grid.pixels_per_tile());
        *reports = Tally::default();
        let mut outcomes: Outcomes = [Outcome::Kept; 64];
        job.front.packets(tile.index, |packet| {
            let place = first + grid.local_block(packet) * 64;
            job.front.fragments(packet, job.record, place, batch);
            if interlock {
                batch.rank(|pixel| counts.generated[(pixel - first) as usize]);
            }
            let fragments = batch.fragments();
            if stores {
                self.scheme.store(&mem, fragments, &mut outcomes);
            } else {
                self.scheme.prepare(&mem, number, fragments);
            }
            for (fragment, &outcome) in fragments.iter().zip(&outcomes) {
                let pixel = (fragment.pixel - first) as usize;
                counts.generated[pixel] += 1;
                counts.gone[pixel] += u32::from(reports.report(outcome));
            }
        });
    }

    /// A pass over the frame's words; what was counted.
    fn frame(&self, number: usize) -> Counters {
        let count = self.scheme.invocations(number);
        let chunk = |begin: u32| {
            let none = Owned::new(Layout::default().per_pixel(), 0);
            let observer = O::default();
            let mem = Exclusive::new(&none, self.global, None, &observer);
            self.scheme.frame(&mem, number, begin * CHUNK..count.min((begin + 1) * CHUNK));
            observer.counters().cloned().unwrap_or_default()
        };
        let all: Vec<Counters> = (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        let mut sum = Counters::default();
        all.iter().for_each(|counters| sum.merge(counters));
        sum
    }

    /// Resolve one of several rounds; whether a pixel needs another one.
    fn collect(&self, tile: &mut Tile<O>) -> bool {
        let first = self.first(tile);
        let mut lists = std::mem::take(&mut tile.lists);
        let mem = self.memory(tile);
        let mut again = false;
        for (pixel, keys) in (first..).zip(&mut lists) {
            again |= self.scheme.resolve(&mem, pixel, keys);
        }
        tile.lists = lists;
        again
    }

    fn finish(&self, tile: &mut Tile<O>) -> (TileOutput, Counters) {
        let finisher = Finisher::new(self.job, tile.index);
        let (counts, reports) = (&tile.counts, &tile.reports);
        let rounds = tile.rounds;
        let output = if self.job.contract.program.repeats {
            collected_tile(&mut tile.lists, counts, finisher, reports)
        } else {
            let (mem, first) = (self.memory(tile), self.first(tile));
            resolve_tile(
                |pixel, keys| {
                    self.scheme.resolve(&mem, pixel, keys);
                },
                first,
                counts,
                finisher,
                reports,
            )
        };
        let counters = tile.observer.counters().cloned().unwrap_or_default();
        (TileOutput { rounds, ..output }, counters)
    }
}
