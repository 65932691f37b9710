//! Contended threads: rasterizer threads hand packets over a queue to worker threads, which run store invocations on
//! shared atomics. Packets of one tile go to any free worker, so workers meet on the same pixels.
//!
//! With N threads there are N workers and N / 2 rasterizers (at least one). A worker takes the indices of pools for a
//! message of packets at once ([`pool`](crate::memory::layout::pool)). A pass that does nothing but count fragments adds
//! whole counts, tile by tile, in the surrounding thread pool, unless operations are counted.

use std::convert::Infallible;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crossbeam_channel::{Receiver, Sender, bounded};
use rayon::prelude::*;

use super::account::Tally;
use super::clock::Stopwatch;
use super::drive::Pipeline;
use super::frame::finish::{Finisher, resolve_tile};
use super::frame::rounds::Rounds;
use super::frame::{Frame, PixelCounts};
use super::interpret::Interpreted;
use super::{Instance, Job};
use crate::fragment::Packet;
use crate::memory::arena::Shared;
use crate::memory::native::Native;
use crate::memory::{Counters, Inputs, Layout, Observer};
use crate::num::columns::Columns;
use crate::raster::Batch;
use crate::scheme::Outcomes;
use crate::scheme::course::Part;
use crate::scheme::program::PassKind;

/// Packets per message: few enough that neighbouring layers of a pixel land with different workers.
const MESSAGE: usize = 64;

/// The same where nobody counts operations: then workers meet less often, and wait less for each other's cache lines.
const LARGE_MESSAGE: usize = 1_024;

/// Messages that may wait per worker.
const BACKLOG: usize = 8;

/// Invocations of a pass over the frame's words that go to a worker at once.
const CHUNK: u32 = 256;

/// Run a scheme, with its operations counted or not. Geometry passes run on threads of their own, all others in the
/// surrounding thread pool.
#[must_use]
pub fn run(instance: &dyn Instance, job: &Job<'_>, counted: bool) -> Frame {
    let layout = instance.layout();
    match (instance.compiled(), counted) {
        (Some(compiled), true) => frame::<Counters>(compiled.native_counted(), layout, job),
        (Some(compiled), false) => frame::<()>(compiled.native(), layout, job),
        (None, true) => {
            frame::<Counters>(&Interpreted { instance, inputs: &job.inputs }, layout, job)
        }
        (None, false) => frame::<()>(&Interpreted { instance, inputs: &job.inputs }, layout, job),
    }
}

fn frame<O: Observer + Default>(
    scheme: &dyn for<'a> Pipeline<Native<'a, O>>,
    layout: &Layout,
    job: &Job<'_>,
) -> Frame {
    let (grid, program) = (&job.front.grid, &job.contract.program);
    job.kit.begin(layout, grid.storage_pixels());
    let pixel = job.kit.memory.shared(layout.per_pixel(), grid.storage_pixels());
    let global = job.kit.memory.shared(layout.per_frame(), 1);
    let counters = Mutex::new(Counters::default());
    let shared = SharedMemory { pixel, global, inputs: &job.inputs, counters };

    let tile_pixels = grid.pixels_per_tile() as u32;
    let pixels = |tile: usize| tile as u32 * tile_pixels..(tile as u32 + 1) * tile_pixels;
    let each_tile = |work: &(dyn Fn(Native<'_, O>, usize) + Sync)| {
        (0..grid.tiles())
            .into_par_iter()
            .with_max_len(1)
            .for_each(|tile| shared.with(|mem| work(mem, tile)));
    };
    let mut watch = Stopwatch::start();
    let mut collected: Vec<Rounds> = Vec::new();
    if program.repeats {
        collected.resize_with(grid.tiles(), Rounds::default);
        collected.iter_mut().for_each(|tile| tile.reset(job.holds, grid.pixels_per_tile()));
    }
    let mut stored = Stored::default();
    let walked = job.course.walk(|parts| {
        let mut again = false;
        for &part in parts {
            match part {
                Part::Clear => {
                    shared.with(|mem: Native<'_, O>| scheme.clear_frame(&mem));
                    each_tile(&|mem, tile| scheme.clear(&mem, pixels(tile)));
                    watch.lap("clear");
                }
                Part::Pass(number) => {
                    let pass = &program.passes[number];
                    match pass.kind {
                        PassKind::Prepare | PassKind::Store => {
                            let pass = (number, pass.kind == PassKind::Store);
                            stored = geometry_pass::<O>(scheme, pass, (layout, job), &shared);
                        }
                        PassKind::Screen => {
                            each_tile(&|mem, tile| scheme.screen(&mem, number, pixels(tile)));
                        }
                        PassKind::Frame => frame_pass::<O>(scheme, number, &shared),
                    }
                    watch.lap(pass.name);
                }
                // A single round is resolved when it is finished.
                Part::Resolve if !program.repeats => {}
                Part::Resolve => {
                    let resolve = |(tile, collected): (usize, &mut Rounds)| {
                        shared.with(|mem: Native<'_, O>| {
                            collected.resolve(scheme, &mem, pixels(tile))
                        })
                    };
                    let tiles = collected.par_iter_mut().enumerate();
                    again |= tiles.map(resolve).reduce(|| false, |a, b| a | b);
                }
            }
        }
        Ok::<bool, Infallible>(again)
    });
    let Ok(rounds) = walked;

    let finish = |tile: usize| {
        let counts = stored.counts(tile, tile_pixels as usize);
        let none = Tally::default();
        if let Some(collected) = collected.get(tile) {
            return collected.finish(job, tile, counts, &none);
        }
        let finisher = Finisher::new(job, tile);
        shared.with(|mem: Native<'_, O>| {
            resolve_tile(scheme, &mem, pixels(tile).start, counts, finisher, &none)
        })
    };
    let tiles = (0..grid.tiles()).into_par_iter().with_max_len(1).map(finish).collect();
    watch.lap("resolve");
    let outside = shared.pixel.outside() + shared.global.outside();
    let counters = shared.counters.into_inner().unwrap_or_default();
    let frame = Frame::new(tiles, &stored.reports, counters);
    job.kit.keep_shared(shared.pixel);
    let table = job.kit.left(scheme.readback(), shared.global);
    Frame { rounds, table, outside, seconds: watch.seconds(), ..frame }
}

/// A pass over the frame's words, chunk by chunk.
fn frame_pass<O: Observer + Default>(
    scheme: &dyn for<'a> Pipeline<Native<'a, O>>,
    number: usize,
    shared: &SharedMemory<'_>,
) {
    let count = scheme.invocations(number);
    (0..count.div_ceil(CHUNK)).into_par_iter().for_each(|chunk| {
        let part = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
        shared.with(|mem: Native<'_, O>| scheme.frame(&mem, number, part));
    });
}

/// What a rasterizer sends: a packet, and how many fragments came before it at each pixel of its block, if it matters.
struct Sent {
    packet: Packet,
    ranks: Option<Box<[u32; 64]>>,
}

/// The memory that all threads share.
struct SharedMemory<'a> {
    pixel: Shared,
    global: Shared,
    inputs: &'a Inputs,
    counters: Mutex<Counters>,
}

impl SharedMemory<'_> {
    /// Work with a handle, and add up what it observed.
    fn with<O: Observer + Default, T>(&self, work: impl FnOnce(Native<'_, O>) -> T) -> T {
        let observer = O::default();
        let result = work(Native::new(&self.pixel, &self.global, self.inputs, &observer));
        if let (Some(counters), Ok(mut sum)) = (observer.counters(), self.counters.lock()) {
            sum.merge(counters);
        }
        result
    }
}

/// The results of a geometry pass other than memory.
#[derive(Default)]
struct Stored {
    /// By tile.
    generated: Vec<Mutex<Vec<u32>>>,
    /// Of every worker, over all blocks.
    gone: Vec<Columns>,
    reports: Tally,
}

impl Stored {
    fn counts(&self, tile: usize, pixels: usize) -> PixelCounts {
        let generated = self.generated[tile].lock().map(|mut g| std::mem::take(&mut *g));
        let mut gone = vec![0; pixels];
        self.gone.iter().for_each(|columns| columns.add_to(tile * pixels / 64, &mut gone));
        PixelCounts { generated: generated.unwrap_or_default(), gone }
    }
}

fn geometry_pass<O: Observer + Default>(
    scheme: &dyn for<'a> Pipeline<Native<'a, O>>,
    pass: (usize, bool),
    (layout, job): (&Layout, &Job<'_>),
    shared: &SharedMemory<'_>,
) -> Stored {
    let grid = &job.front.grid;
    // What is counted one by one must be done one by one.
    let one_by_one = pass.1 || job.culls(pass.0) || O::default().counters().is_some();
    if !one_by_one && shared.with(|mem: Native<'_, O>| scheme.count(&mem, pass.0, 0, &[])) {
        let count = |tile: usize| {
            let counts = job.front.counts_of(tile);
            let first = (tile * grid.pixels_per_tile()) as u32;
            shared.with(|mem: Native<'_, O>| scheme.count(&mem, pass.0, first, &counts));
            Mutex::new(counts)
        };
        let generated = (0..grid.tiles()).into_par_iter().map(count).collect();
        return Stored { generated, ..Stored::default() };
    }
    let mut generated = Vec::new();
    generated.resize_with(grid.tiles(), Mutex::default);
    let (sender, receiver) = bounded::<Vec<Sent>>(BACKLOG * job.threads);
    let next_tile = AtomicUsize::new(0);
    let (gone, reports) = std::thread::scope(|scope| {
        for _ in 0..(job.threads / 2).max(1) {
            let sender = sender.clone();
            let (next_tile, generated) = (&next_tile, &generated);
            let most = if O::default().counters().is_some() { MESSAGE } else { LARGE_MESSAGE };
            let work = (pass.0, most);
            scope.spawn(move || rasterize(job, work, next_tile, generated, &sender));
        }
        drop(sender);
        let workers: Vec<_> = (0..job.threads)
            .map(|_| {
                // Each has its own end of the queue: if all workers are gone, no rasterizer waits for one.
                let receiver = receiver.clone();
                let work = move |mem: Native<'_, O>| {
                    let ahead = if job.whole_pools { layout.ahead() } else { Vec::new() };
                    invoke(scheme, pass, job, &mem.taking(&ahead), &receiver)
                };
                scope.spawn(move || shared.with(work))
            })
            .collect();
        drop(receiver);
        let (mut gone, mut sum) = (Vec::new(), Tally::default());
        for worker in workers {
            match worker.join() {
                Ok((columns, tally)) => {
                    gone.push(columns);
                    sum.merge(&tally);
                }
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        (gone, sum)
    });
    Stored { generated, gone, reports }
}

/// A rasterizer thread: takes tiles until there are none, counts fragments per pixel, sends packets, at most so many at
/// once. With an interlock, what is culled must not take a rank, so this thread looks for it, too.
fn rasterize(
    job: &Job<'_>,
    (number, most): (usize, usize),
    next_tile: &AtomicUsize,
    generated: &[Mutex<Vec<u32>>],
    sender: &Sender<Vec<Sent>>,
) {
    let grid = &job.front.grid;
    let blocks = grid.pixels_per_tile() / 64;
    let (interlock, culls) = (job.contract.is_interlocked(), job.culls(number));
    let mut batch = Batch::default();
    let (mut counts, mut entered) = (Columns::default(), Columns::default());
    loop {
        let tile = next_tile.fetch_add(1, Ordering::Relaxed);
        if tile >= grid.tiles() {
            return;
        }
        counts.reset(blocks);
        entered.reset(blocks);
        let mut message = Vec::with_capacity(most);
        job.front.packets(tile, |packet| {
            let block = grid.local_block(packet) as usize;
            counts.add(block, packet.mask);
            let ranks = interlock.then(|| {
                let mut ranks = Box::new([0; 64]);
                entered.add_to(block, &mut *ranks);
                let mut mask = packet.mask;
                if culls {
                    job.front.fragments(packet, job.record, grid.first_pixel(packet), &mut batch);
                    mask &= !job.cull(&mut batch);
                }
                entered.add(block, mask);
                ranks
            });
            message.push(Sent { packet, ranks });
            if message.len() == most {
                // A closed queue means that the workers are gone; the scope reports why.
                let _ = sender.send(std::mem::replace(&mut message, Vec::with_capacity(most)));
            }
        });
        let _ = sender.send(message);
        if let Ok(mut place) = generated[tile].lock() {
            *place = counts.counts();
        }
    }
}

/// A worker thread: runs the invocations of the packets it receives, and counts what is not kept.
///
/// With an interlock, an invocation may wait for one of an earlier packet of its tile. That packet was sent earlier, so
/// another worker has it and is working on it or on a still earlier one: no invocation waits forever.
fn invoke<O: Observer>(
    scheme: &dyn for<'a> Pipeline<Native<'a, O>>,
    (number, stores): (usize, bool),
    job: &Job<'_>,
    mem: &Native<'_, O>,
    receiver: &Receiver<Vec<Sent>>,
) -> (Columns, Tally) {
    let mut missing = Columns::new(job.front.grid.storage_pixels() / 64);
    let mut reports = Tally::default();
    let mut batch = Batch::default();
    let mut outcomes = Outcomes::default();
    let culls = job.culls(number);
    // Ahead of a message, as many indices as it has fragments.
    let fragments = |message: &[Sent]| message.iter().map(|s| s.packet.mask.count_ones()).sum();
    let ahead = |message: &Vec<Sent>| {
        if stores {
            mem.take_ahead(fragments(message));
        }
    };
    for Sent { packet, ranks } in receiver.iter().inspect(ahead).flatten() {
        let first = job.front.grid.first_pixel(packet);
        let block = first as usize / 64;
        job.front.fragments(packet, job.record, first, &mut batch);
        if culls {
            let rejected = job.cull(&mut batch);
            missing.add(block, rejected);
            reports.reject(rejected.count_ones());
        }
        if let Some(ranks) = ranks {
            batch.rank(|bit| ranks[bit as usize]);
        }
        if !stores {
            scheme.prepare(mem, number, &batch);
            continue;
        }
        scheme.store(mem, &batch, &mut outcomes);
        let gone = outcomes.gone();
        if gone != 0 {
            missing.add(block, gone);
            reports.reports(&outcomes);
        }
    }
    (missing, reports)
}
