//! Tiles in parallel: a worker owns a tile's pixels, so their memory is plain cells.

use std::cell::Cell;

use rayon::prelude::*;

use super::Job;
use super::account::Tally;
use super::drive::{self, Outcomes};
use super::frame::{Finisher, Frame, PixelCounts, TileOutput, resolve_tile};
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::memory::native::Native;
use crate::memory::{Counters, Layout, Observer};
use crate::raster::Batch;
use crate::scheme::{Outcome, Scheme};

/// Run a scheme. Call it inside the thread pool that shall do the work.
#[must_use]
pub fn run<S: Scheme, O: Observer + Default>(scheme: &S, layout: &Layout, job: &Job<'_>) -> Frame {
    let pixels = job.front.grid.pixels_per_tile();
    let global = Shared::new(layout.per_frame(), 1);
    let none = Shared::new(Layout::default().per_pixel(), 0);
    drive::clear_frame(scheme, &Native::new(&none, &global, &()));
    let worker = || Worker {
        memory: Owned::new(layout.per_pixel(), pixels),
        counts: PixelCounts::default(),
        batch: Batch::default(),
    };
    let outputs: Vec<(TileOutput, Counters)> = (0..job.front.grid.tiles())
        .into_par_iter()
        .map_init(worker, |worker, tile| worker.tile::<S, O>(scheme, &global, job, tile))
        .collect();
    let mut counters = Counters::default();
    let mut tiles = Vec::with_capacity(outputs.len());
    for (tile, counts) in outputs {
        counters.merge(&counts);
        tiles.push(tile);
    }
    Frame::new(job, tiles, &Tally::default(), counters)
}

/// What a thread keeps from tile to tile. The memory keeps its contents too: only a clear pass makes it fit for use.
struct Worker {
    memory: Owned,
    counts: PixelCounts,
    batch: Batch,
}

impl Worker {
    fn tile<S: Scheme, O: Observer + Default>(
        &mut self,
        scheme: &S,
        global: &Shared,
        job: &Job<'_>,
        tile: usize,
    ) -> (TileOutput, Counters) {
        let grid = &job.front.grid;
        let observer = O::default();
        let next = job.before_tile.get(tile).map(|&before| Cell::new(before as u32));
        let mem = Exclusive::new(&self.memory, global, next.as_ref(), &observer);
        self.counts.reset(grid.pixels_per_tile());
        let mut reports = Tally::default();
        let mut outcomes: Outcomes = [Outcome::Kept; 64];
        drive::clear(scheme, &mem, 0..grid.pixels_per_tile() as u32);
        job.front.packets(tile, |packet| {
            let first = grid.local_block(packet) * 64;
            job.front.fragments(packet, job.record, first, &mut self.batch);
            let fragments = self.batch.fragments();
            drive::store(scheme, &mem, fragments, &mut outcomes);
            for (fragment, &outcome) in fragments.iter().zip(&outcomes) {
                self.counts.generated[fragment.pixel as usize] += 1;
                self.counts.gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
            }
        });
        let finisher = Finisher::new(job, tile);
        let output = resolve_tile(scheme, &mem, 0, &self.counts, finisher, &reports);
        (output, observer.counters().cloned().unwrap_or_default())
    }
}
