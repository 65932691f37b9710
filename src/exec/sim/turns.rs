//! Which invocation goes next: the single place where schemes meet simulated memory.

use std::future::Future;

use super::Memory;
use super::policy::{Any, Scheduler, Scheduling};
use super::pool::{Places, Pool};
use super::schedule::Recorder;
use super::slots::{Check, Slots, Watcher};
use super::submission::Submission;
use super::watch::Recording;
use crate::error::Result;
use crate::exec::account::Tally;
use crate::fragment::Fragment;
use crate::memory::Counters;
use crate::scheme::course::Part;
use crate::scheme::program::PassKind;
use crate::scheme::task::{Ended, Task, invoke, resolve};
use crate::scheme::{Outcome, Scheme};

/// A scheme on simulated memory, without its type.
pub trait Stepped {
    /// Store fragments, to the end. This pass takes most of the time, so every scheme has its own code for it.
    ///
    /// # Errors
    /// A recorded schedule that does not fit, or a schedule under which nothing ends any more.
    fn store<'a>(&'a self, stores: Stores<'a>) -> Result<()>;

    /// Room for so many invocations of any other stage.
    fn room<'a>(&'a self, mem: &'a Memory<Counters>, stage: Stage, resident: usize) -> Room<'a>;
}

/// What is invoked in a stage, as far as it is of one kind: an invocation then takes no more room than that asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Clearing.
    Clear,
    /// An earlier geometry pass, by its number.
    Prepare(usize),
    /// A full-screen pass, by its number.
    Screen(usize),
    /// Resolving.
    Resolve,
    /// Anything.
    Mixed,
}

impl Stage {
    /// Of a course's stage, with the kinds of its passes.
    pub(super) fn of(parts: &[Part], kind: impl Fn(usize) -> PassKind) -> Self {
        match *parts {
            [Part::Clear] => Self::Clear,
            [Part::Resolve] => Self::Resolve,
            [Part::Pass(number)] => match kind(number) {
                PassKind::Prepare => Self::Prepare(number),
                PassKind::Screen => Self::Screen(number),
                PassKind::Frame | PassKind::Store => Self::Mixed,
            },
            _ => Self::Mixed,
        }
    }
}

/// Room for the invocations of a stage.
pub struct Room<'a>(Box<dyn Pool<Task, Ended> + 'a>);

impl<'a> Room<'a> {
    /// For so many invocations that are made like this.
    pub(in crate::exec) fn new<F: Future<Output = Ended> + 'a>(
        resident: usize,
        invoke: impl Fn(&Task) -> F + 'a,
    ) -> Self {
        Self(Box::new(Places::new(resident, invoke)))
    }
}

impl<S: Scheme> Stepped for S {
    fn store<'a>(&'a self, stores: Stores<'a>) -> Result<()> {
        let mem = stores.mem;
        stores.run(move |&fragment: &Fragment| Scheme::store(self, mem, fragment))
    }

    fn room<'a>(&'a self, mem: &'a Memory<Counters>, stage: Stage, resident: usize) -> Room<'a> {
        match stage {
            Stage::Clear => Room::new(resident, move |&task| {
                let pixel = match task {
                    Task::Clear(pixel) => Some(pixel),
                    _ => None,
                };
                async move {
                    match pixel {
                        Some(pixel) => self.clear(mem, pixel).await,
                        None => self.clear_frame(mem).await,
                    }
                    Ended::Done
                }
            }),
            Stage::Prepare(pass) => Room::new(resident, move |task| {
                let fragment = task.fragment().unwrap_or_default();
                async move {
                    self.prepare(mem, pass, fragment).await;
                    Ended::Done
                }
            }),
            Stage::Screen(pass) => Room::new(resident, move |task| {
                let pixel = task.pixel().unwrap_or_default();
                async move {
                    self.screen(mem, pass, pixel).await;
                    Ended::Done
                }
            }),
            Stage::Resolve => Room::new(resident, move |task| {
                resolve(self, mem, task.pixel().unwrap_or_default())
            }),
            Stage::Mixed => Room::new(resident, move |&task| invoke(self, mem, task)),
        }
    }
}

/// The policy, and how many invocations are resident.
#[derive(Debug)]
pub(super) struct Turns {
    policy: Any,
    resident: usize,
    group: usize,
    recorder: Option<Recorder>,
}

/// The fragments to store, and where their outcomes are reported.
pub struct Stores<'a> {
    pub(in crate::exec) mem: &'a Memory<Counters>,
    pub(super) turns: &'a mut Turns,
    pub(super) work: Submission<'a>,
    /// By storage pixel: fragments reported as not kept.
    pub(super) gone: &'a mut [u32],
    pub(super) reports: &'a mut Tally,
    pub(super) watcher: Option<&'a mut Recording>,
    pub(super) checker: Option<&'a mut (dyn Check + 'a)>,
}

impl<'a> Stores<'a> {
    /// Run one store invocation per fragment.
    pub(in crate::exec) fn run<F: Future<Output = Outcome>>(
        self,
        invoke: impl Fn(&Fragment) -> F,
    ) -> Result<()> {
        let Self { mem, turns, work, gone, reports, watcher, checker } = self;
        let done = |fragment: &Fragment, outcome| {
            gone[fragment.pixel as usize] += u32::from(reports.report(outcome));
        };
        let watcher = watcher.map(|w| w as &mut (dyn Watcher<Fragment> + 'a));
        let places = Places::new(turns.resident, invoke);
        turns.run(mem, work, places, done, watcher, checker)
    }
}

impl Turns {
    /// With the policy and residency of `scheduling`.
    ///
    /// # Errors
    /// A recorded schedule that cannot be read, or belongs to another run.
    pub(super) fn new(scheduling: &Scheduling) -> Result<Self> {
        let policy = Any::new(scheduling)?;
        let (resident, group) = (policy.resident(scheduling.resident), policy.group());
        let recorder =
            scheduling.record.then(|| Recorder::new(scheduling.fingerprint, resident, group));
        Ok(Self { policy, resident, group, recorder })
    }

    /// Run invocations of any passes, to the end. There is no barrier within one queue. All schemes share this code.
    ///
    /// # Errors
    /// See [`Stepped::store`].
    pub(super) fn tasks<'a>(
        &'a mut self,
        room: impl FnOnce(usize) -> Room<'a>,
        mem: &'a Memory<Counters>,
        work: Box<dyn Iterator<Item = Task> + 'a>,
        done: &mut dyn FnMut(&Task, Ended),
        watcher: Option<&'a mut Recording>,
        checker: Option<&'a mut (dyn Check + 'a)>,
    ) -> Result<()> {
        let watcher = watcher.map(|w| w as &mut (dyn Watcher<Task> + 'a));
        let Room(pool) = room(self.resident);
        self.run(mem, work, pool, done, watcher, checker)
    }

    fn run<'a, W, R>(
        &'a mut self,
        mem: &'a Memory<Counters>,
        work: impl Iterator<Item = W>,
        pool: impl Pool<W, R>,
        done: impl FnMut(&W, R),
        watcher: Option<&'a mut (dyn Watcher<W> + 'a)>,
        checker: Option<&'a mut (dyn Check + 'a)>,
    ) -> Result<()> {
        Slots::new(mem, &mut self.policy, [self.resident, self.group], work, pool, done)
            .watched(watcher)
            .checked(checker)
            .run(self.recorder.as_mut())
    }

    /// After the last pass: the recorded schedule.
    ///
    /// # Errors
    /// A recorded schedule that is not at its end.
    pub(super) fn finish(mut self) -> Result<Option<Vec<u8>>> {
        self.policy.finish()?;
        Ok(self.recorder.map(Recorder::finish))
    }
}
