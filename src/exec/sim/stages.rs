//! The stages of a frame, one after another. Parts of one stage are one queue: invocations of a later part take slots
//! as they become free.

use super::Memory;
use super::checker::Checker;
use super::slots::Check;
use super::submission::{Submission, rejected};
use super::turns::{Stage, Stepped, Stores, Turns};
use super::watch::Recording;
use crate::error::Result;
use crate::exec::clock::Stopwatch;
use crate::exec::{Job, Tally};
use crate::memory::Counters;
use crate::scheme::Held;
use crate::scheme::course::Part;
use crate::scheme::program::PassKind;
use crate::scheme::task::{Ended, Task};

/// Their results other than memory, by storage pixel.
pub(super) struct Stages<'a> {
    job: &'a Job<'a>,
    mem: &'a Memory<Counters>,
    scheme: &'a dyn Stepped,
    /// How many invocations a pass over the frame's words has.
    invocations: &'a dyn Fn(usize) -> u32,
    pub(super) generated: Vec<u32>,
    /// Fragments reported as not kept, in the last round.
    pub(super) gone: Vec<u32>,
    pub(super) reports: Tally,
    /// What the pixels hold after all rounds.
    pub(super) held: Vec<Held>,
}

/// Work of a stage.
type Queue<'a> = Box<dyn Iterator<Item = Task> + 'a>;

impl<'a> Stages<'a> {
    pub(super) fn new(
        job: &'a Job<'a>,
        mem: &'a Memory<Counters>,
        scheme: &'a dyn Stepped,
        invocations: &'a dyn Fn(usize) -> u32,
    ) -> Self {
        let pixels = job.front.grid.storage_pixels();
        Self {
            job,
            mem,
            scheme,
            invocations,
            generated: vec![0; pixels],
            gone: vec![0; pixels],
            reports: Tally::default(),
            held: vec![job.holds.empty(); pixels],
        }
    }

    /// Run them all, and give the number of rounds.
    pub(super) fn run(
        &mut self,
        turns: &mut Turns,
        mut recording: Option<&mut Recording>,
        mut checker: Option<&mut Checker<'_>>,
        watch: &mut Stopwatch,
    ) -> Result<u32> {
        self.job.course.walk(|parts| {
            let of_program = parts.iter().any(|part| matches!(part, Part::Pass(_)));
            if let Some(recording) = recording.as_deref_mut().filter(|_| of_program) {
                recording.begin();
            }
            let again =
                self.stage(turns, parts, recording.as_deref_mut(), checker.as_deref_mut())?;
            watch.lap(self.name(parts));
            Ok(again)
        })
    }

    /// The phase that a stage's time belongs to.
    fn name(&self, parts: &[Part]) -> &'static str {
        let name = |part: &Part| match part {
            Part::Clear => "clear",
            Part::Pass(number) => self.job.contract.program.passes[*number].name,
            Part::Resolve => "resolve",
        };
        let last = |parts: &[Part]| parts.iter().rev().find(|p| **p != Part::Resolve).map(name);
        last(parts).unwrap_or("resolve")
    }

    fn kind(&self, part: &Part) -> Option<PassKind> {
        match part {
            Part::Pass(number) => Some(self.job.contract.program.passes[*number].kind),
            Part::Clear | Part::Resolve => None,
        }
    }

    /// Run one stage. Returns whether a pixel needs another round.
    fn stage(
        &mut self,
        turns: &mut Turns,
        parts: &[Part],
        watcher: Option<&mut Recording>,
        checker: Option<&mut Checker<'_>>,
    ) -> Result<bool> {
        let stores = |part: &Part| self.kind(part) == Some(PassKind::Store);
        let (some, all) = (parts.iter().any(stores), parts.iter().all(stores));
        let store = parts.iter().find_map(|part| match part {
            Part::Pass(number) if stores(part) => Some(*number),
            _ => None,
        });
        if some {
            self.reports = Tally::default();
            self.gone.fill(0);
        }
        if let Some(number) = store {
            // What does not reach the scheme is known before anything runs.
            for (gone, count) in self.gone.iter_mut().zip(rejected(self.job, number)) {
                *gone += count;
                self.reports.reject(count);
            }
        }
        // Only while fragments are stored, and nothing else runs.
        let mut checker = checker.filter(|_| all).map(Checker::begin);
        let check = checker.as_deref_mut().map(|c| c as &mut dyn Check);
        let (job, mem, scheme) = (self.job, self.mem, self.scheme);
        let mut again = false;
        if let (true, Some(store)) = (all, store) {
            let work = Submission::new(job, store, &mut self.generated);
            let (gone, reports) = (self.gone.as_mut_slice(), &mut self.reports);
            scheme.store(Stores { mem, turns, work, gone, reports, watcher, checker: check })?;
        } else {
            let Self { generated, gone, reports, held, invocations, .. } = self;
            let mut arrived = Arrived { lists: Vec::with_capacity(ARRIVED), held };
            let mut done = |task: &Task, ended| match (task, ended) {
                (Task::Store(fragment), Ended::Stored(outcome)) => {
                    gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
                }
                (_, Ended::Resolved(pixel, found, more)) => {
                    arrived.push(pixel, found);
                    again |= more;
                }
                _ => {}
            };
            let mut work: Option<Queue<'_>> = None;
            // The store pass counts what is generated; an earlier geometry pass does not count.
            let mut counts = Some(generated.as_mut_slice());
            for &part in parts {
                let more = queue(job, part, invocations, &mut counts);
                work = Some(match work {
                    Some(work) => Box::new(work.chain(more)),
                    None => more,
                });
            }
            let work = work.unwrap_or_else(|| Box::new(std::iter::empty()));
            let kind = |number: usize| job.contract.program.passes[number].kind;
            let stage = Stage::of(parts, kind);
            let room = |resident| scheme.room(mem, stage, resident);
            turns.tasks(room, mem, work, &mut done, watcher, check)?;
            arrived.set_down();
        }
        checker.into_iter().for_each(Checker::end);
        Ok(again)
    }
}

/// How many results of resolve are kept back, to go to their pixels together: one by one, each would wait for the cache
/// by itself.
const ARRIVED: usize = 64;

/// Results of resolve on their way.
struct Arrived<'a> {
    lists: Vec<(u32, Held)>,
    /// By pixel.
    held: &'a mut [Held],
}

impl Arrived<'_> {
    fn push(&mut self, pixel: u32, found: Held) {
        if found.adds_nothing() {
            return;
        }
        self.lists.push((pixel, found));
        if self.lists.len() == ARRIVED {
            self.set_down();
        }
    }

    fn set_down(&mut self) {
        self.lists.drain(..).for_each(|(pixel, found)| self.held[pixel as usize].append(found));
    }
}

/// The work of one part.
fn queue<'a>(
    job: &'a Job<'_>,
    part: Part,
    invocations: &dyn Fn(usize) -> u32,
    counts: &mut Option<&'a mut [u32]>,
) -> Queue<'a> {
    let number = match part {
        Part::Clear => {
            return Box::new(std::iter::once(Task::ClearFrame).chain(pixels(job).map(Task::Clear)));
        }
        Part::Resolve => return Box::new(pixels(job).map(Task::Resolve)),
        Part::Pass(number) => number,
    };
    let place = number as u8;
    match job.contract.program.passes[number].kind {
        PassKind::Screen => Box::new(pixels(job).map(move |p| Task::Screen(place, p))),
        PassKind::Frame => {
            let all = 0..invocations(number);
            Box::new(all.map(move |index| Task::Frame(place, index)))
        }
        PassKind::Prepare => {
            Box::new(Submission::uncounted(job, number).map(move |f| Task::Prepare(place, f)))
        }
        PassKind::Store => match counts.take() {
            Some(counts) => Box::new(Submission::new(job, number, counts).map(Task::Store)),
            None => Box::new(Submission::uncounted(job, number).map(Task::Store)),
        },
    }
}

/// The storage places that hold pixels of the image.
fn pixels<'a>(job: &'a Job<'_>) -> impl Iterator<Item = u32> + use<'a> {
    let grid = &job.front.grid;
    let per_tile = grid.pixels_per_tile() as u32;
    (0..grid.storage_pixels() as u32).filter(move |pixel| {
        let (x, y) = grid.position((pixel / per_tile) as usize, pixel % per_tile);
        x < grid.width && y < grid.height
    })
}
