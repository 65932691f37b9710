//! The simulated device: thousands of resident invocations, one memory operation per step.
//!
//! Invocations are admitted in submission order (primitive by primitive over the whole image, so that nothing depends
//! on tiles) into a fixed number of slots. A [policy](policy::Policy) names the slot that performs the next operation.
//! When an invocation ends, its slot takes the next one. The sequence of slots is the schedule: it can be recorded, and
//! replayed exactly.
//!
//! Passes are queues of work; a barrier between two of them means that the second begins when the first has drained.

mod checker;
pub mod policy;
mod pool;
pub mod schedule;
mod slots;
mod stages;
mod submission;
pub(super) mod turns;
mod watch;

use super::account::Tally;
use super::clock::Stopwatch;
use super::frame::Frame;
use super::frame::finish::Finisher;
use super::interpret::Interpreted;
use super::table::{Left, TableWords};
use super::{Instance, Job};
use crate::error::Result;
use crate::memory::Counters;
use crate::memory::sim::Sim as Memory;
use checker::Checker;
use policy::Scheduling;
use stages::Stages;
use turns::Turns;
use watch::Recording;

pub use checker::Checked;
pub use turns::{Room, Stage, Stepped, Stores};
pub use watch::Watched;

/// The result of a run on the simulated device.
#[derive(Debug)]
pub struct Simulated {
    /// The finished frame.
    pub frame: Frame,
    /// The schedule, if it was recorded.
    pub schedule: Option<Vec<u8>>,
    /// What happened at the pixel that was watched.
    pub watched: Option<Watched>,
    /// What was checked after every step, if requested.
    pub checked: Option<Checked>,
}

/// Run a scheme; its operations are always counted. `pattern` fills memory beforehand: only a clear pass prepares it
/// for use.
///
/// # Errors
/// A recorded schedule that belongs to another run, or a schedule under which nothing ends any more.
pub fn run(
    instance: &dyn Instance,
    job: &Job<'_>,
    scheduling: &Scheduling,
    pattern: u64,
) -> Result<Simulated> {
    let grid = &job.front.grid;
    let (layout, inputs) = (instance.layout(), job.inputs.clone());
    let mem = Memory::new(layout, grid.storage_pixels(), inputs, pattern, Counters::default());
    let interpreted = Interpreted { instance, inputs: &job.inputs };
    let scheme = match instance.compiled() {
        Some(compiled) => compiled.stepped(),
        None => &interpreted,
    };
    let mut turns = Turns::new(scheduling)?;
    let mut watch = Stopwatch::start();
    let invocations = |pass| instance.invocations(pass);
    let mut stages = Stages::new(job, &mem, scheme, &invocations);
    let mut recording = scheduling.watch.map(Recording::new);
    let mut checker = scheduling.check.then(|| Checker::new(instance, &mem));
    let rounds = stages.run(&mut turns, recording.as_mut(), checker.as_mut(), &mut watch)?;
    let schedule = turns.finish()?;
    let per_tile = grid.pixels_per_tile();
    let Stages { generated, gone, reports, held, .. } = stages;
    let tiles = held.chunks(per_tile).enumerate().map(|(tile, held)| {
        let mut finisher = Finisher::new(job, tile);
        for (i, held) in held.iter().enumerate() {
            let pixel = tile * per_tile + i;
            finisher.pixel(held, generated[pixel], gone[pixel]);
        }
        finisher.finish(&Tally::default())
    });
    let tiles = tiles.collect();
    watch.lap("resolve");
    let frame = Frame::new(tiles, &reports, mem.observer().clone());
    let table = instance.readback().map(|readback| Left::Read(TableWords::new(&readback, &mem)));
    Ok(Simulated {
        frame: Frame { rounds, table, outside: mem.outside(), seconds: watch.seconds(), ..frame },
        schedule,
        watched: recording.map(Recording::finish),
        checked: checker.map(Checker::finish),
    })
}
