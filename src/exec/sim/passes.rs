//! The passes of a frame, one after another; or overlapping, where a contract lacks a barrier.

use super::checker::{Check, Checker};
use super::device::Device;
use super::submission::Submission;
use super::watch::Recording;
use crate::error::Result;
use crate::exec::clock::Stopwatch;
use crate::exec::{Job, Tally};
use crate::fragment::Fragment;
use crate::memory::Observer;
use crate::scheme::contract::{Barrier, Form, Kind, Pass};
use crate::scheme::task::{Ended, Task};
use crate::scheme::{Keys, Scheme};

/// What they leave behind besides memory, by storage pixel.
pub(super) struct Passes<'a> {
    job: &'a Job<'a>,
    pub(super) generated: Vec<u32>,
    /// Fragments reported as not kept, in the last round.
    pub(super) gone: Vec<u32>,
    pub(super) reports: Tally,
    /// The fragments of all rounds.
    pub(super) lists: Vec<Keys>,
    /// How many there were.
    pub(super) rounds: u32,
}

/// Work of some passes.
type Queue<'a> = Box<dyn Iterator<Item = Task> + 'a>;

/// What stands in one queue.
#[derive(Clone, Copy)]
enum Part<'a> {
    Clear,
    Pass(usize, &'a Pass),
    Resolve,
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
            rounds: 0,
        }
    }

    /// Clear, and rounds until no pixel asks for another.
    pub(super) fn run<S: Scheme, O: Observer>(
        &mut self,
        scheme: &S,
        device: &mut Device<'_, S, O>,
        mut recording: Option<&mut Recording>,
        mut checker: Option<&mut Checker<'_, S, O>>,
        watch: &mut Stopwatch,
    ) -> Result<()> {
        let program = &S::CONTRACT.program;
        // Passes without a barrier between them are one queue: the later one's invocations take the slots that become
        // free.
        let mut queues: Vec<Vec<Part<'_>>> = vec![vec![Part::Clear]];
        let passes = program.passes.iter().enumerate();
        let parts = passes.map(|(number, pass)| (pass.before, Part::Pass(number, pass)));
        for (before, part) in parts.chain([(program.before_resolve, Part::Resolve)]) {
            match queues.last_mut() {
                Some(queue) if before == Barrier::Missing => queue.push(part),
                _ => queues.push(vec![part]),
            }
        }
        loop {
            let mut again = false;
            // What overlaps with clear is not repeated with it: faults of that kind have one round.
            for queue in &queues[usize::from(self.rounds > 0)..] {
                let of_program = queue.iter().any(|part| matches!(part, Part::Pass(..)));
                if let Some(recording) = recording.as_deref_mut().filter(|_| of_program) {
                    recording.begin();
                }
                let watched = recording.as_deref_mut();
                let checker = checker.as_deref_mut();
                let name = self.queue(scheme, device, queue, watched, checker, &mut again)?;
                watch.lap(name);
            }
            self.rounds += 1;
            if !again {
                return Ok(());
            }
        }
    }

    /// Run one queue; its name.
    fn queue<S: Scheme, O: Observer>(
        &mut self,
        scheme: &S,
        device: &mut Device<'_, S, O>,
        parts: &[Part<'_>],
        recording: Option<&mut Recording>,
        checker: Option<&mut Checker<'_, S, O>>,
        again: &mut bool,
    ) -> Result<&'static str> {
        let Self { job, generated, gone, reports, lists, .. } = self;
        let stores = |part: &Part<'_>| matches!(part, Part::Pass(_, p) if p.kind == Kind::Store);
        if parts.iter().any(stores) {
            gone.fill(0);
            *reports = Tally::default();
        }
        // Only while fragments are stored, and nothing else runs.
        let checker = checker.filter(|_| parts.iter().all(stores));
        let mut checker = checker.map(Checker::begin);
        let check = checker.as_deref_mut().map(|c| c as &mut dyn Check);
        // A constant condition: for a fault, the compiler makes no code of its own.
        if const { !matches!(S::CONTRACT.form, Form::Mutation) && S::CONTRACT.program.is_complete() }
            && parts.iter().all(stores)
        {
            let done = |fragment: &Fragment, outcome| {
                gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
            };
            device.store(Submission::new(job, generated), done, recording, check)?;
            checker.into_iter().for_each(Checker::end);
            return Ok("store");
        }
        let mut done = |task: &Task, ended| match (task, ended) {
            (Task::Store(fragment), Ended::Stored(outcome)) => {
                gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
            }
            (_, Ended::Resolved(pixel, mut keys, more)) => {
                let list = &mut lists[pixel as usize];
                if list.is_empty() {
                    *list = keys;
                } else {
                    list.append(&mut keys);
                }
                *again |= more;
            }
            _ => {}
        };
        let mut counts = Some(&mut *generated);
        let mut name = "resolve";
        let mut work: Queue<'_> = Box::new(std::iter::empty());
        // The store pass counts what is generated; an earlier geometry pass counts it for nobody.
        for part in parts {
            let next: Queue<'_> = match *part {
                Part::Clear => {
                    name = "clear";
                    Box::new(std::iter::once(Task::ClearFrame).chain(pixels(job).map(Task::Clear)))
                }
                Part::Resolve => Box::new(pixels(job).map(Task::Resolve)),
                Part::Pass(number, pass) => {
                    name = pass.name;
                    let place = number as u8;
                    match pass.kind {
                        Kind::Screen => Box::new(pixels(job).map(move |p| Task::Screen(place, p))),
                        Kind::Frame => {
                            let all = 0..scheme.invocations(number);
                            Box::new(all.map(move |index| Task::Frame(place, index)))
                        }
                        Kind::Prepare => {
                            let all = Submission::uncounted(job);
                            Box::new(all.map(move |fragment| Task::Prepare(place, fragment)))
                        }
                        Kind::Store => match counts.take() {
                            Some(counts) => Box::new(Submission::new(job, counts).map(Task::Store)),
                            None => Box::new(Submission::uncounted(job).map(Task::Store)),
                        },
                    }
                }
            };
            work = Box::new(work.chain(next));
        }
        device.tasks(work, &mut done, recording, check)?;
        checker.into_iter().for_each(Checker::end);
        Ok(name)
    }
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
