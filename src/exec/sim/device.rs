//! A device that runs one scheme, pass by pass: the single place where schemes meet simulated memory.

use std::future::Future;
use std::pin::Pin;

use super::checker::Check;
use super::pass::{Pass, Watcher};
use super::policy::{Any, Policy, Settings};
use super::schedule::Recorder;
use super::watch::Recording;
use crate::error::Result;
use crate::fragment::Fragment;
use crate::memory::Observer;
use crate::memory::sim::Sim;
use crate::scheme::task::{Ended, Task, invoke};
use crate::scheme::{Outcome, Scheme};

/// An invocation of any pass of any scheme.
type Invocation<'a> = Pin<Box<dyn Future<Output = Ended> + 'a>>;

/// The scheme, its memory, and who goes next.
#[derive(Debug)]
pub(super) struct Device<'a, S, O> {
    scheme: &'a S,
    mem: &'a Sim<O>,
    turns: Turns,
}

/// Who goes next, and how many are there at once.
#[derive(Debug)]
struct Turns {
    policy: Any,
    resident: usize,
    group: usize,
    recorder: Option<Recorder>,
}

impl<'a, S: Scheme, O: Observer> Device<'a, S, O> {
    /// With the policy and residency of `settings`.
    ///
    /// # Errors
    /// A recorded schedule that cannot be read, or belongs to another run.
    pub(super) fn new(scheme: &'a S, mem: &'a Sim<O>, settings: &Settings) -> Result<Self> {
        let policy = Any::new(settings)?;
        let (resident, group) = (policy.resident(settings.resident), policy.group());
        let recorder =
            settings.record.then(|| Recorder::new(settings.fingerprint, resident, group));
        Ok(Self { scheme, mem, turns: Turns { policy, resident, group, recorder } })
    }

    /// Store fragments, to the end: the barrier. The pass that takes the time, so it has code of its own for every
    /// scheme.
    ///
    /// # Errors
    /// A recorded schedule that does not fit, or a schedule under which nothing ends any more.
    pub(super) fn store<'b>(
        &'b mut self,
        work: impl Iterator<Item = Fragment>,
        done: impl FnMut(&Fragment, Outcome),
        watcher: Option<&'b mut Recording>,
        checker: Option<&'b mut (dyn Check + 'b)>,
    ) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        let invoke = move |&fragment: &Fragment| scheme.store(mem, fragment);
        let watcher = watcher.map(|w| w as &mut (dyn Watcher<Fragment> + 'b));
        self.turns.pass(mem, work, invoke, done, watcher, checker)
    }

    /// Run invocations of any passes, to the end. What stands in one queue has no barrier inside.
    ///
    /// # Errors
    /// See [`Self::store`].
    pub(super) fn tasks<'b>(
        &'b mut self,
        work: Box<dyn Iterator<Item = Task> + 'b>,
        done: &'b mut dyn FnMut(&Task, Ended),
        watcher: Option<&'b mut Recording>,
        checker: Option<&'b mut (dyn Check + 'b)>,
    ) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        let make = move |&task: &Task| -> Invocation<'b> { Box::pin(invoke(scheme, mem, task)) };
        self.turns.tasks(mem, work, &make, done, watcher, checker)
    }

    /// After the last pass: the recorded schedule.
    ///
    /// # Errors
    /// A recorded schedule that goes on.
    pub(super) fn finish(self) -> Result<Option<Vec<u8>>> {
        let Turns { mut policy, recorder, .. } = self.turns;
        policy.finish()?;
        Ok(recorder.map(Recorder::finish))
    }
}

impl Turns {
    /// One code for all schemes.
    fn tasks<'b, O: Observer>(
        &'b mut self,
        mem: &'b Sim<O>,
        work: Box<dyn Iterator<Item = Task> + 'b>,
        make: &dyn Fn(&Task) -> Invocation<'b>,
        done: &mut dyn FnMut(&Task, Ended),
        watcher: Option<&'b mut Recording>,
        checker: Option<&'b mut (dyn Check + 'b)>,
    ) -> Result<()> {
        let watcher = watcher.map(|w| w as &mut (dyn Watcher<Task> + 'b));
        self.pass(mem, work, make, done, watcher, checker)
    }

    fn pass<'b, O: Observer, W, F: Future>(
        &'b mut self,
        mem: &'b Sim<O>,
        work: impl Iterator<Item = W>,
        invoke: impl Fn(&W) -> F,
        done: impl FnMut(&W, F::Output),
        watcher: Option<&'b mut (dyn Watcher<W> + 'b)>,
        checker: Option<&'b mut (dyn Check + 'b)>,
    ) -> Result<()> {
        Pass::new(mem, &mut self.policy, [self.resident, self.group], work, invoke, done)
            .watched(watcher)
            .checked(checker)
            .run(self.recorder.as_mut())
    }
}
