//! The passes of a frame, one after another; or overlapping, where a contract lacks a barrier.

use super::device::{Device, Done, Work};
use super::submission::Submission;
use super::watch::Recording;
use crate::error::Result;
use crate::exec::clock::Stopwatch;
use crate::exec::{Job, Tally};
use crate::fragment::Fragment;
use crate::memory::Observer;
use crate::scheme::contract::Barriers;
use crate::scheme::{Keys, Scheme};

/// What they leave behind besides memory, by storage pixel.
pub(super) struct Passes<'a> {
    job: &'a Job<'a>,
    pub(super) generated: Vec<u32>,
    /// Fragments reported as not kept.
    pub(super) gone: Vec<u32>,
    pub(super) reports: Tally,
    pub(super) lists: Vec<Keys>,
}

impl<'a> Passes<'a> {
    pub(super) fn new(job: &'a Job<'a>) -> Self {
        let pixels = job.front.grid.storage_pixels();
        Self {
            job,
            generated: vec![0; pixels],
            gone: vec![0; pixels],
            reports: Tally::default(),
            lists: vec![Keys::new(); pixels],
        }
    }

    /// One after another.
    pub(super) fn apart<S: Scheme, O: Observer>(
        &mut self,
        device: &mut Device<'_, S, O>,
        recording: Option<&mut Recording>,
        watch: &mut Stopwatch,
    ) -> Result<()> {
        let Self { job, generated, gone, reports, lists } = self;
        device.clear(clears(job))?;
        watch.lap("clear");
        let done = |fragment: &Fragment, outcome| {
            gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
        };
        device.store(Submission::new(job, generated), done, recording)?;
        watch.lap("store");
        device.resolve(pixels(job), |&pixel, keys| lists[pixel as usize] = keys)
    }

    /// Passes without a barrier between them are one queue: the later one's invocations take the slots that become
    /// free.
    pub(super) fn overlapping<S: Scheme, O: Observer>(
        &mut self,
        device: &mut Device<'_, S, O>,
        barriers: Barriers,
        mut recording: Option<&mut Recording>,
        watch: &mut Stopwatch,
    ) -> Result<()> {
        let Self { job, generated, gone, reports, lists } = self;
        let mut done = |work: &Work, done| match (work, done) {
            (Work::Store(fragment), Done::Stored(outcome)) => {
                gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
            }
            (Work::Resolve(pixel), Done::Resolved(keys)) => lists[*pixel as usize] = keys,
            _ => {}
        };
        let stores = Submission::new(job, generated).map(Work::Store);
        let later: [(bool, Queue<'_>); 2] = [
            (barriers.before_store, Box::new(stores)),
            (barriers.before_resolve, Box::new(pixels(job).map(Work::Resolve))),
        ];
        let mut queue: Queue<'_> = Box::new(clears(job).map(Work::Clear));
        for (barrier, next) in later {
            if barrier {
                device.mixed(queue, &mut done, recording.as_deref_mut())?;
                queue = next;
            } else {
                queue = Box::new(queue.chain(next));
            }
        }
        device.mixed(queue, &mut done, recording)?;
        watch.lap("store");
        Ok(())
    }
}

/// Work of any passes; of one type, since it is rare.
type Queue<'a> = Box<dyn Iterator<Item = Work> + 'a>;

/// The frame's words, then every pixel's.
fn clears(job: &Job<'_>) -> impl Iterator<Item = Option<u32>> {
    std::iter::once(None).chain(pixels(job).map(Some))
}

/// The storage places that are pixels of the image.
fn pixels(job: &Job<'_>) -> impl Iterator<Item = u32> {
    let grid = &job.front.grid;
    let per_tile = grid.pixels_per_tile() as u32;
    (0..grid.storage_pixels() as u32).filter(move |pixel| {
        let (x, y) = grid.position((pixel / per_tile) as usize, pixel % per_tile);
        x < grid.width && y < grid.height
    })
}
