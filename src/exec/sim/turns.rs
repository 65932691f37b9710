//! Which invocation goes next: the single place where schemes meet simulated memory.

use std::future::Future;

use super::Memory;
use super::policy::{Any, Scheduler, Scheduling};
use super::schedule::Recorder;
use super::slots::{Check, Slots, Watcher};
use super::submission::Submission;
use super::watch::Recording;
use crate::error::Result;
use crate::exec::account::Tally;
use crate::fragment::Fragment;
use crate::memory::Counters;
use crate::scheme::task::{Ended, Invocation, Task, invoke};
use crate::scheme::{Outcome, Scheme};

/// A scheme on simulated memory, without its type.
pub trait Stepped {
    /// Store fragments, to the end. This pass takes most of the time, so every scheme has its own code for it.
    ///
    /// # Errors
    /// A recorded schedule that does not fit, or a schedule under which nothing ends any more.
    fn store<'a>(&'a self, stores: Stores<'a>) -> Result<()>;

    /// An invocation of any pass.
    fn start<'a>(&'a self, mem: &'a Memory<Counters>, task: Task) -> Invocation<'a>;
}

impl<S: Scheme> Stepped for S {
    fn store<'a>(&'a self, stores: Stores<'a>) -> Result<()> {
        let mem = stores.mem;
        stores.run(move |&fragment: &Fragment| Scheme::store(self, mem, fragment))
    }

    fn start<'a>(&'a self, mem: &'a Memory<Counters>, task: Task) -> Invocation<'a> {
        Box::pin(invoke(self, mem, task))
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
        turns.run(mem, work, invoke, done, watcher, checker)
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
        scheme: &'a dyn Stepped,
        mem: &'a Memory<Counters>,
        work: Box<dyn Iterator<Item = Task> + 'a>,
        done: &mut dyn FnMut(&Task, Ended),
        watcher: Option<&'a mut Recording>,
        checker: Option<&'a mut (dyn Check + 'a)>,
    ) -> Result<()> {
        let watcher = watcher.map(|w| w as &mut (dyn Watcher<Task> + 'a));
        self.run(mem, work, |&task: &Task| scheme.start(mem, task), done, watcher, checker)
    }

    fn run<'a, W, F: Future>(
        &'a mut self,
        mem: &'a Memory<Counters>,
        work: impl Iterator<Item = W>,
        invoke: impl Fn(&W) -> F,
        done: impl FnMut(&W, F::Output),
        watcher: Option<&'a mut (dyn Watcher<W> + 'a)>,
        checker: Option<&'a mut (dyn Check + 'a)>,
    ) -> Result<()> {
        Slots::new(mem, &mut self.policy, [self.resident, self.group], work, invoke, done)
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
