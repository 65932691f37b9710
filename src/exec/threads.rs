//! Contended threads: rasterizer threads hand packets over a queue to worker threads, which run store invocations on
//! shared atomics. Packets of one tile go to whoever is free, so workers meet on the same pixels.
//!
//! With N threads there are N workers and N / 2 rasterizers (at least one).

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use crossbeam_channel::{Receiver, Sender, bounded};
use rayon::prelude::*;

use super::Job;
use super::account::Tally;
use super::clock::Stopwatch;
use super::drive::{self, Outcomes};
use super::frame::{Finisher, Frame, PixelCounts, resolve_tile};
use crate::fragment::Packet;
use crate::memory::arena::Shared;
use crate::memory::native::Native;
use crate::memory::{Counters, Layout, Observer};
use crate::raster::Batch;
use crate::scheme::{Outcome, Scheme};

/// Packets per message: few enough that neighbouring layers of a pixel land with different workers.
const MESSAGE: usize = 64;

/// Messages that may wait per worker.
const BACKLOG: usize = 8;

/// Run a scheme. Clear and resolve run in the surrounding thread pool, store on threads of its own.
#[must_use]
pub fn run<S: Scheme, O: Observer + Default>(scheme: &S, layout: &Layout, job: &Job<'_>) -> Frame {
    let grid = &job.front.grid;
    let pixel = Shared::new(layout.per_pixel(), grid.storage_pixels());
    let global = Shared::new(layout.per_frame(), 1);
    let shared = SharedMemory { pixel, global, counters: Mutex::new(Counters::default()) };

    let tile_pixels = grid.pixels_per_tile() as u32;
    let place = |tile: usize| tile as u32 * tile_pixels;
    let mut watch = Stopwatch::start();
    shared.with(|mem: Native<'_, O>| drive::clear_frame(scheme, &mem));
    (0..grid.tiles()).into_par_iter().for_each(|tile| {
        shared.with(|mem: Native<'_, O>| {
            drive::clear(scheme, &mem, place(tile)..place(tile) + tile_pixels);
        });
    });

    watch.lap("clear");
    let stored = store_pass::<S, O>(scheme, job, &shared);
    watch.lap("store");

    let tiles = (0..grid.tiles()).into_par_iter().map(|tile| {
        let counts = stored.counts(tile, tile_pixels as usize);
        let finisher = Finisher::new(job, tile);
        let none = Tally::default();
        shared.with(|mem: Native<'_, O>| {
            resolve_tile(scheme, &mem, place(tile), &counts, finisher, &none)
        })
    });
    let tiles = tiles.collect();
    watch.lap("resolve");
    let counters = shared.counters.into_inner().unwrap_or_default();
    let frame = Frame::new(job, tiles, &stored.reports, counters);
    Frame { seconds: watch.seconds(), ..frame }
}

/// What all threads reach.
struct SharedMemory {
    pixel: Shared,
    global: Shared,
    counters: Mutex<Counters>,
}

impl SharedMemory {
    /// Work with a handle, and add up what it observed.
    fn with<O: Observer + Default, T>(&self, work: impl FnOnce(Native<'_, O>) -> T) -> T {
        let observer = O::default();
        let result = work(Native::new(&self.pixel, &self.global, &observer));
        if let (Some(counters), Ok(mut sum)) = (observer.counters(), self.counters.lock()) {
            sum.merge(counters);
        }
        result
    }
}

/// What the store pass leaves behind besides memory.
struct Stored {
    generated: Vec<Mutex<Vec<u32>>>,
    gone: Vec<AtomicU32>,
    reports: Tally,
}

impl Stored {
    fn counts(&self, tile: usize, pixels: usize) -> PixelCounts {
        let generated = self.generated[tile].lock().map(|mut g| std::mem::take(&mut *g));
        let gone = &self.gone[tile * pixels..(tile + 1) * pixels];
        PixelCounts {
            generated: generated.unwrap_or_default(),
            gone: gone.iter().map(|g| g.load(Ordering::Relaxed)).collect(),
        }
    }
}

fn store_pass<S: Scheme, O: Observer + Default>(
    scheme: &S,
    job: &Job<'_>,
    shared: &SharedMemory,
) -> Stored {
    let grid = &job.front.grid;
    let mut gone = Vec::new();
    gone.resize_with(grid.storage_pixels(), AtomicU32::default);
    let mut generated = Vec::new();
    generated.resize_with(grid.tiles(), Mutex::default);
    let stored = Stored { generated, gone, reports: Tally::default() };
    let (sender, receiver) = bounded(BACKLOG * job.threads);
    let next_tile = AtomicUsize::new(0);
    let reports = std::thread::scope(|scope| {
        for _ in 0..(job.threads / 2).max(1) {
            let sender = sender.clone();
            let (next_tile, generated) = (&next_tile, &stored.generated);
            scope.spawn(move || rasterize(job, next_tile, generated, &sender));
        }
        drop(sender);
        let workers: Vec<_> = (0..job.threads)
            .map(|_| {
                // Each has its own end of the queue: if all workers are gone, no rasterizer waits for one.
                let (receiver, gone) = (receiver.clone(), &stored.gone);
                let work = move |mem: Native<'_, O>| invoke(scheme, job, &mem, &receiver, gone);
                scope.spawn(move || shared.with(work))
            })
            .collect();
        drop(receiver);
        let mut sum = Tally::default();
        for worker in workers {
            match worker.join() {
                Ok(tally) => sum.merge(&tally),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        sum
    });
    Stored { reports, ..stored }
}

/// A rasterizer thread: takes tiles until there are none, counts fragments per pixel, sends packets.
fn rasterize(
    job: &Job<'_>,
    next_tile: &AtomicUsize,
    generated: &[Mutex<Vec<u32>>],
    sender: &Sender<Vec<Packet>>,
) {
    let grid = &job.front.grid;
    loop {
        let tile = next_tile.fetch_add(1, Ordering::Relaxed);
        if tile >= grid.tiles() {
            return;
        }
        let mut counts = vec![0u32; grid.pixels_per_tile()];
        let mut message = Vec::with_capacity(MESSAGE);
        job.front.packets(tile, |packet| {
            let first = grid.local_block(packet) as usize * 64;
            let block = &mut counts[first..first + 64];
            for (bit, count) in block.iter_mut().enumerate() {
                *count += (packet.mask >> bit & 1) as u32;
            }
            message.push(packet);
            if message.len() == MESSAGE {
                // A closed queue means that the workers are gone; the scope reports why.
                let _ = sender.send(std::mem::replace(&mut message, Vec::with_capacity(MESSAGE)));
            }
        });
        let _ = sender.send(message);
        if let Ok(mut place) = generated[tile].lock() {
            *place = counts;
        }
    }
}

/// A worker thread: runs the store invocations of the packets it receives.
fn invoke<S: Scheme, O: Observer>(
    scheme: &S,
    job: &Job<'_>,
    mem: &Native<'_, O>,
    receiver: &Receiver<Vec<Packet>>,
    gone: &[AtomicU32],
) -> Tally {
    let mut reports = Tally::default();
    let mut batch = Batch::default();
    let mut outcomes: Outcomes = [Outcome::Kept; 64];
    for packet in receiver.iter().flatten() {
        job.front.fragments(packet, job.record, job.front.grid.first_pixel(packet), &mut batch);
        drive::store(scheme, mem, batch.fragments(), &mut outcomes);
        for (fragment, &outcome) in batch.fragments().iter().zip(&outcomes) {
            if reports.report(outcome) {
                gone[fragment.pixel as usize].fetch_add(1, Ordering::Relaxed);
            }
        }
    }
    reports
}
