//! A device that runs one scheme, pass by pass: the single place where schemes meet simulated memory.

use std::future::Future;

use super::pass::Pass;
use super::policy::{Any, Policy, Settings};
use super::schedule::Recorder;
use crate::error::Result;
use crate::fragment::Fragment;
use crate::memory::Observer;
use crate::memory::sim::Sim;
use crate::scheme::{Keys, Outcome, Scheme};

/// The scheme, its memory, and who goes next.
#[derive(Debug)]
pub struct Device<'a, S, O> {
    scheme: &'a S,
    mem: &'a Sim<O>,
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
    pub fn new(scheme: &'a S, mem: &'a Sim<O>, settings: &Settings) -> Result<Self> {
        let policy = Any::new(settings)?;
        let (resident, group) = (policy.resident(settings.resident), policy.group());
        let recorder =
            settings.record.then(|| Recorder::new(settings.fingerprint, resident, group));
        Ok(Self { scheme, mem, policy, resident, group, recorder })
    }

    /// Clear the frame's words (`None`) and pixels, to the end: the barrier.
    ///
    /// # Errors
    /// A recorded schedule that does not fit, or a schedule under which nothing ends any more.
    pub fn clear(&mut self, work: impl Iterator<Item = Option<u32>>) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        let invoke = move |&pixel: &Option<u32>| async move {
            match pixel {
                Some(pixel) => scheme.clear(mem, pixel).await,
                None => scheme.clear_frame(mem).await,
            }
        };
        self.pass(work, invoke, |_, ()| ())
    }

    /// Store fragments, to the end.
    ///
    /// # Errors
    /// See [`Self::clear`].
    pub fn store(
        &mut self,
        work: impl Iterator<Item = Fragment>,
        done: impl FnMut(&Fragment, Outcome),
    ) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        self.pass(work, move |&fragment| scheme.store(mem, fragment), done)
    }

    /// Resolve pixels, to the end.
    ///
    /// # Errors
    /// See [`Self::clear`].
    pub fn resolve(
        &mut self,
        work: impl Iterator<Item = u32>,
        done: impl FnMut(&u32, Keys),
    ) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        let invoke = move |&pixel: &u32| async move {
            let mut keys = Keys::new();
            scheme.resolve(mem, pixel, &mut keys).await;
            keys
        };
        self.pass(work, invoke, done)
    }

    fn pass<W, F: Future>(
        &mut self,
        work: impl Iterator<Item = W>,
        invoke: impl Fn(&W) -> F,
        done: impl FnMut(&W, F::Output),
    ) -> Result<()> {
        Pass::new(self.mem, &mut self.policy, [self.resident, self.group], work, invoke, done)
            .run(self.recorder.as_mut())
    }

    /// After the last pass: the recorded schedule.
    ///
    /// # Errors
    /// A recorded schedule that goes on.
    pub fn finish(mut self) -> Result<Option<Vec<u8>>> {
        self.policy.finish()?;
        Ok(self.recorder.map(Recorder::finish))
    }
}
