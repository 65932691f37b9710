//! The simulated device: thousands of resident invocations, one memory operation a step.
//!
//! Invocations are admitted in submission order (primitive by primitive over the whole image, so that nothing depends
//! on tiles) into a fixed number of slots. A [policy](policy::Policy) names the slot that performs the next operation. When an
//! invocation ends, its slot takes the next one. The sequence of slots is the schedule: it can be recorded, and run
//! again exactly.
//!
//! Passes are queues of work; a barrier between two of them means that the second begins when the first has drained.

pub mod device;
mod pass;
pub mod policy;
pub mod schedule;
mod submission;
mod watch;

use super::Job;
use super::account::Tally;
use super::clock::Stopwatch;
use super::frame::{Finisher, Frame, PixelCounts};
use crate::error::Result;
use crate::fragment::Fragment;
use crate::memory::sim::Sim as Memory;
use crate::memory::{Layout, Observer};
use crate::scheme::Scheme;
use crate::scheme::contract::Barriers;
use device::{Device, Done, Work};
use policy::Settings;
use submission::Submission;
use watch::Recording;

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
    let mut counts = PixelCounts::default();
    counts.reset(grid.storage_pixels());
    let mut reports = Tally::default();
    let mut lists = vec![Vec::new(); grid.storage_pixels()];

    let pixels = || (0..grid.storage_pixels() as u32).filter(|&p| on_screen(job, p));
    let clears = || std::iter::once(None).chain(pixels().map(Some));
    let mut recording = settings.watch.map(Recording::new);
    if S::CONTRACT.barriers == Barriers::ALL {
        device.clear(clears())?;
        watch.lap("clear");
        let submission = Submission::new(job, &mut counts.generated);
        let done = |fragment: &Fragment, outcome| {
            counts.gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
        };
        device.store(submission, done, recording.as_mut())?;
        watch.lap("store");
        device.resolve(pixels(), |&pixel, keys| lists[pixel as usize] = keys)?;
    } else {
        // Passes without a barrier between them are one queue.
        let Barriers { before_store, before_resolve } = S::CONTRACT.barriers;
        let mut done = |work: &Work, done| match (work, done) {
            (Work::Store(fragment), Done::Stored(outcome)) => {
                counts.gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
            }
            (Work::Resolve(pixel), Done::Resolved(keys)) => lists[*pixel as usize] = keys,
            _ => {}
        };
        let clears = clears().map(Work::Clear);
        let stores = Submission::new(job, &mut counts.generated).map(Work::Store);
        let resolves = pixels().map(Work::Resolve);
        match (before_store, before_resolve) {
            (false, false) => device.mixed(clears.chain(stores).chain(resolves), &mut done)?,
            (false, true) => {
                device.mixed(clears.chain(stores), &mut done)?;
                device.mixed(resolves, &mut done)?;
            }
            _ => {
                device.mixed(clears, &mut done)?;
                device.mixed(stores.chain(resolves), &mut done)?;
            }
        }
        watch.lap("store");
    }
    let schedule = device.finish()?;
    let per_tile = grid.pixels_per_tile();
    let tiles = lists.chunks_mut(per_tile).enumerate().map(|(tile, lists)| {
        let mut finisher = Finisher::new(job, tile);
        for (i, keys) in lists.iter_mut().enumerate() {
            let pixel = tile * per_tile + i;
            finisher.pixel(keys, counts.generated[pixel], counts.gone[pixel]);
        }
        finisher.finish(&Tally::default())
    });
    let tiles = tiles.collect();
    watch.lap("resolve");
    let counters = mem.observer().counters().cloned().unwrap_or_default();
    let frame = Frame::new(job, tiles, &reports, counters);
    Ok(Simulated {
        frame: Frame { seconds: watch.seconds(), ..frame },
        schedule,
        watched: recording.map(Recording::finish),
    })
}

/// Whether a storage place is a pixel of the image.
fn on_screen(job: &Job<'_>, pixel: u32) -> bool {
    let grid = &job.front.grid;
    let per_tile = grid.pixels_per_tile() as u32;
    let (x, y) = grid.position((pixel / per_tile) as usize, pixel % per_tile);
    x < grid.width && y < grid.height
}
