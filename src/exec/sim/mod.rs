//! The simulated device: thousands of resident invocations, one memory operation a step.
//!
//! Invocations are admitted in submission order (primitive by primitive over the whole image, so that nothing depends
//! on tiles) into a fixed number of slots. A [policy](policy::Policy) names the slot that performs the next operation. When an
//! invocation ends, its slot takes the next one. The sequence of slots is the schedule: it can be recorded, and run
//! again exactly.
//!
//! Passes are queues of work; a barrier between two of them means that the second begins when the first has drained.

mod checker;
mod device;
mod pass;
mod passes;
pub mod policy;
pub mod schedule;
mod submission;
mod watch;

use super::Job;
use super::account::Tally;
use super::clock::Stopwatch;
use super::frame::{Finisher, Frame};
use super::table::Table;
use crate::error::Result;
use crate::memory::sim::Sim as Memory;
use crate::memory::{Layout, Observer};
use crate::scheme::Scheme;
use checker::Checker;
use device::Device;
use passes::Passes;
use policy::Settings;
use watch::Recording;

pub use checker::Checked;
pub use watch::Watched;

/// What a run on the simulated device gives.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The finished frame.
    pub frame: Frame,
    /// The schedule, if it was recorded.
    pub schedule: Option<Vec<u8>>,
    /// What happened at the pixel that was watched.
    pub watched: Option<Watched>,
    /// What was looked at after every step, if that was asked for.
    pub checked: Option<Checked>,
}

/// Run a scheme. `pattern` fills memory beforehand: only clear passes make it fit for use.
///
/// # Errors
/// A recorded schedule that belongs to another run, or a schedule under which nothing ends any more.
pub fn run<S: Scheme, O: Observer + Default>(
    scheme: &S,
    layout: &Layout,
    job: &Job<'_>,
    settings: &Settings,
    pattern: u64,
) -> Result<Simulated> {
    let grid = &job.front.grid;
    let mem = Memory::new(layout, grid.storage_pixels(), pattern, O::default());
    let mut device = Device::new(scheme, &mem, settings)?;
    let mut watch = Stopwatch::start();
    let mut passes = Passes::new(job);
    let mut recording = settings.watch.map(Recording::new);
    let pixels = grid.storage_pixels() as u32;
    let mut checker = settings.check.then(|| Checker::new(scheme, &mem, layout, pixels));
    passes.run(scheme, &mut device, recording.as_mut(), checker.as_mut(), &mut watch)?;
    let schedule = device.finish()?;
    let per_tile = grid.pixels_per_tile();
    let Passes { generated, gone, reports, mut lists, rounds, .. } = passes;
    let tiles = lists.chunks_mut(per_tile).enumerate().map(|(tile, lists)| {
        let mut finisher = Finisher::new(job, tile);
        for (i, keys) in lists.iter_mut().enumerate() {
            let pixel = tile * per_tile + i;
            finisher.pixel(keys, generated[pixel], gone[pixel]);
        }
        finisher.finish(&Tally::default())
    });
    let tiles = tiles.collect();
    watch.lap("resolve");
    let counters = mem.observer().counters().cloned().unwrap_or_default();
    let frame = Frame::new(job, tiles, &reports, counters);
    let table = scheme.readback().map(|readback| Table::new(&readback, &mem));
    Ok(Simulated {
        frame: Frame { rounds, table, seconds: watch.seconds(), ..frame },
        schedule,
        watched: recording.map(Recording::finish),
        checked: checker.map(Checker::finish),
    })
}
