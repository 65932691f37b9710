//! Tiles in parallel: a worker owns a tile's pixels, so their memory is plain cells.
//!
//! Where no pixel waits for another ([`Program::is_local`](crate::scheme::program::Program::is_local)), a tile goes
//! through all its passes and rounds at once, and its memory belongs to the worker, which reuses it for the next tile:
//! its pixels' records, and its range of the pools, which then stays in the worker's cache. Otherwise every tile keeps
//! its memory, and a pass ends for all tiles before the next begins.

mod geometry;

use std::convert::Infallible;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use super::account::Tally;
use super::drive::Pipeline;
use super::frame::finish::{Finisher, resolve_tile};
use super::frame::rounds::Rounds;
use super::frame::{Frame, TileOutput};
use super::interpret::Interpreted;
use super::{Instance, Job};
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::memory::{Ahead, Counters, Layout, Observer};
use crate::scheme::course::Part;
use crate::scheme::program::PassKind;
use geometry::{Geometry, Room};

/// Invocations of a pass over the frame's words that go to a worker at once.
const CHUNK: u32 = 256;

/// Run a scheme, with its operations counted or not. Call it inside the thread pool that is to do the work.
#[must_use]
pub fn run(instance: &dyn Instance, job: &Job<'_>, counted: bool) -> Frame {
    let layout = instance.layout();
    match (instance.compiled(), counted) {
        (Some(compiled), true) => frame::<Counters>(compiled.exclusive_counted(), layout, job),
        (Some(compiled), false) => frame::<()>(compiled.exclusive(), layout, job),
        (None, _) => {
            let interpreted = Interpreted { instance, inputs: &job.inputs };
            let counters =
                |frame: &Frame| if counted { frame.counters.clone() } else { Counters::default() };
            let drawn = frame::<Counters>(&interpreted, layout, job);
            Frame { counters: counters(&drawn), ..drawn }
        }
    }
}

fn frame<O: Observer + Default + Send>(
    scheme: &dyn for<'a> Pipeline<Exclusive<'a, O>>,
    layout: &Layout,
    job: &Job<'_>,
) -> Frame {
    job.kit.begin(layout, job.front.grid.storage_pixels());
    let global = job.kit.memory.shared(layout.per_frame(), 1);
    let tiles = Tiles { scheme, layout, global: &global, job };
    let cleared = tiles.on_frame(|mem| scheme.clear_frame(mem));
    let outputs = if job.contract.program.is_local() { tiles.each() } else { tiles.together() };
    let mut counters = cleared;
    let mut done = Vec::with_capacity(outputs.len());
    for (tile, counts) in outputs {
        counters.merge(&counts);
        done.push(tile);
    }
    let frame = Frame::new(done, &Tally::default(), counters);
    let outside = frame.outside + global.outside();
    let table = job.kit.left(scheme.readback(), global);
    Frame { table, outside, ..frame }
}

/// The context that all workers share.
struct Tiles<'a, O> {
    scheme: &'a dyn for<'b> Pipeline<Exclusive<'b, O>>,
    layout: &'a Layout,
    global: &'a Shared,
    job: &'a Job<'a>,
}

/// A tile in progress: its memory, and what is known about its pixels.
struct Tile<O> {
    index: usize,
    memory: Owned,
    /// The worker's own range of every pool: the range of one of its tiles.
    pool: Range<u64>,
    /// What is left of that range, if there is one.
    ahead: Vec<Ahead>,
    room: Room,
    /// What the pixels hold from all rounds so far, if there are several.
    collected: Rounds,
    observer: O,
    /// Accesses outside of its memory by the worker's earlier tiles.
    outside_before: u64,
}

impl<O: Observer + Default + Send> Tiles<'_, O> {
    /// One tile after another, each from beginning to end. A worker gives away all but the tile that it works on, since
    /// tiles differ in what they hold.
    fn each(&self) -> Vec<(TileOutput, Counters)> {
        let count = self.job.front.grid.tiles();
        let workers: Vec<_> = (0..rayon::current_num_threads()).map(|_| Mutex::new(None)).collect();
        let lock = |worker| -> MutexGuard<'_, Option<Tile<O>>> {
            Mutex::lock(worker).unwrap_or_else(PoisonError::into_inner)
        };
        let work = |index| {
            let worker = &workers[rayon::current_thread_index().unwrap_or(0) % workers.len()];
            let taken = lock(worker).take();
            let mut tile = taken.unwrap_or_else(|| self.tile());
            let done = self.whole(&mut tile, index);
            *lock(worker) = Some(tile);
            done
        };
        let done = (0..count).into_par_iter().with_max_len(1).map(work).collect();
        let tiles = workers.iter().filter_map(|worker| lock(worker).take());
        tiles.for_each(|tile| self.job.kit.keep_owned(tile.memory));
        done
    }

    /// All passes and rounds of a tile.
    fn whole(&self, tile: &mut Tile<O>, index: usize) -> (TileOutput, Counters) {
        let walked = self.job.course.walk(|parts| {
            let mut again = false;
            for &part in parts {
                match part {
                    Part::Clear => self.clear(tile, index),
                    Part::Pass(number) => self.pass(tile, number),
                    Part::Resolve => again |= self.collect(tile),
                }
            }
            Ok::<bool, Infallible>(again)
        });
        let Ok(rounds) = walked;
        self.finish(tile, rounds)
    }

    /// One stage after another, each for all tiles.
    fn together(&self) -> Vec<(TileOutput, Counters)> {
        let mut tiles: Vec<Tile<O>> = Vec::new();
        let mut counters = Counters::default();
        let walked = self.job.course.walk(|parts| {
            let mut again = false;
            for &part in parts {
                match part {
                    Part::Clear => {
                        let cleared = |index: usize| {
                            let mut tile = self.tile();
                            self.clear(&mut tile, index);
                            tile
                        };
                        let count = self.job.front.grid.tiles();
                        tiles = (0..count).into_par_iter().with_max_len(1).map(cleared).collect();
                    }
                    Part::Pass(number) if self.kind(number) == PassKind::Frame => {
                        counters.merge(&self.frame(number));
                    }
                    Part::Pass(number) => {
                        tiles
                            .par_iter_mut()
                            .with_max_len(1)
                            .for_each(|tile| self.pass(tile, number));
                    }
                    Part::Resolve => {
                        let collect = |tile: &mut Tile<O>| self.collect(tile);
                        again |= tiles
                            .par_iter_mut()
                            .with_max_len(1)
                            .map(collect)
                            .reduce(|| false, |a, b| a | b);
                    }
                }
            }
            Ok::<bool, Infallible>(again)
        });
        let Ok(rounds) = walked;
        let finish = |tile: &mut Tile<O>| self.finish(tile, rounds);
        let mut outputs: Vec<_> = tiles.par_iter_mut().with_max_len(1).map(finish).collect();
        tiles.into_iter().for_each(|tile| self.job.kit.keep_owned(tile.memory));
        if let Some((_, first)) = outputs.first_mut() {
            first.merge(&counters);
        }
        outputs
    }

    fn kind(&self, pass: usize) -> PassKind {
        self.job.contract.program.passes[pass].kind
    }

    fn tile(&self) -> Tile<O> {
        let pixels = self.job.front.grid.pixels_per_tile();
        Tile {
            index: 0,
            memory: self.job.kit.memory.owned(self.layout.per_pixel(), pixels),
            pool: 0..0,
            ahead: Vec::new(),
            room: Room::default(),
            collected: Rounds::default(),
            observer: O::default(),
            outside_before: 0,
        }
    }

    fn first(&self, tile: &Tile<O>) -> u32 {
        (tile.index * self.job.front.grid.pixels_per_tile()) as u32
    }

    fn memory<'b>(&'b self, tile: &'b Tile<O>) -> Exclusive<'b, O> {
        Exclusive::new(&tile.memory, self.global, &self.job.inputs, &tile.observer)
            .from(self.first(tile))
            .taking(&tile.ahead)
    }

    /// Work on the frame's words, and give what was counted.
    fn on_frame(&self, work: impl FnOnce(&Exclusive<'_, O>)) -> Counters {
        let none = Owned::new(Layout::default().per_pixel(), 0);
        let observer = O::default();
        work(&Exclusive::new(&none, self.global, &self.job.inputs, &observer));
        observer.counters().cloned().unwrap_or_default()
    }

    /// Memory keeps the contents of the tile before: only a clear pass prepares it for use.
    fn clear(&self, tile: &mut Tile<O>, index: usize) {
        let pixels = self.job.front.grid.pixels_per_tile();
        tile.index = index;
        tile.outside_before = tile.memory.outside();
        tile.observer = O::default();
        if let Some(&[before, after]) = self.job.before_tile.get(index..index + 2) {
            // If a pool is too small, the range that a tile has decides what is dropped.
            if !self.job.whole_pools || after - before > tile.pool.end - tile.pool.start {
                tile.pool = before..after;
            }
            if tile.ahead.is_empty() {
                tile.ahead = self.layout.ahead();
            }
            let count = (tile.pool.end - tile.pool.start) as u32;
            tile.ahead.iter().for_each(|ahead| ahead.set(tile.pool.start as u32, count));
        }
        if self.job.contract.program.repeats {
            tile.collected.reset(self.job.holds, pixels);
        }
        let first = self.first(tile);
        self.scheme.clear(&self.memory(tile), first..first + pixels as u32);
    }

    fn pass(&self, tile: &mut Tile<O>, number: usize) {
        let pixels = self.job.front.grid.pixels_per_tile() as u32;
        let first = self.first(tile);
        match self.kind(number) {
            PassKind::Screen => {
                self.scheme.screen(&self.memory(tile), number, first..first + pixels);
            }
            // A pass over the frame's words is not run tile by tile.
            PassKind::Frame => {}
            PassKind::Prepare => self.geometry(tile, number, false),
            PassKind::Store => self.geometry(tile, number, true),
        }
    }

    fn geometry(&self, tile: &mut Tile<O>, number: usize, stores: bool) {
        let (job, first) = (self.job, self.first(tile));
        let mem = Exclusive::new(&tile.memory, self.global, &job.inputs, &tile.observer)
            .from(first)
            .taking(&tile.ahead);
        let geometry = Geometry {
            scheme: self.scheme,
            job,
            mem,
            tile: tile.index,
            number,
            stores,
            culls: job.culls(number),
            interlock: job.contract.is_interlocked(),
            counted: tile.observer.counters().is_some(),
            first,
        };
        geometry.run(&mut tile.room);
    }

    /// Run a pass over the frame's words, and give what was counted.
    fn frame(&self, number: usize) -> Counters {
        let count = self.scheme.invocations(number);
        let chunk = |begin: u32| {
            let indices = begin * CHUNK..count.min((begin + 1) * CHUNK);
            self.on_frame(|mem| self.scheme.frame(mem, number, indices))
        };
        let all: Vec<Counters> = (0..count.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        let mut sum = Counters::default();
        all.iter().for_each(|counters| sum.merge(counters));
        sum
    }

    /// Resolve one of several rounds; whether a pixel needs another one. A single round is resolved when it is
    /// finished.
    fn collect(&self, tile: &mut Tile<O>) -> bool {
        if !self.job.contract.program.repeats {
            return false;
        }
        let first = self.first(tile);
        let pixels = first..first + self.job.front.grid.pixels_per_tile() as u32;
        let mut collected = std::mem::take(&mut tile.collected);
        let again = collected.resolve(self.scheme, &self.memory(tile), pixels);
        tile.collected = collected;
        again
    }

    fn finish(&self, tile: &mut Tile<O>, rounds: u32) -> (TileOutput, Counters) {
        let Room { counts, reports, .. } = &tile.room;
        let counts = counts.of_pixels();
        let output = if self.job.contract.program.repeats {
            tile.collected.finish(self.job, tile.index, counts, reports)
        } else {
            let finisher = Finisher::new(self.job, tile.index);
            let (mem, first) = (self.memory(tile), self.first(tile));
            resolve_tile(self.scheme, &mem, first, counts, finisher, reports)
        };
        let counters = tile.observer.counters().cloned().unwrap_or_default();
        let outside = tile.memory.outside() - tile.outside_before;
        (TileOutput { rounds, outside, ..output }, counters)
    }
}
