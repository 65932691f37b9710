//! A device that runs one scheme, pass by pass: the single place where schemes meet simulated memory.

use std::future::Future;

use super::pass::{Pass, Watcher};
use super::policy::{Any, Policy, Settings};
use super::schedule::Recorder;
use super::watch::Recording;
use crate::error::Result;
use crate::fragment::Fragment;
use crate::memory::Observer;
use crate::memory::sim::Sim;
use crate::scheme::{Keys, Outcome, Scheme};

/// One invocation of any pass.
#[derive(Clone, Copy, Debug)]
pub enum Work {
    /// Clear a pixel, or the frame's words.
    Clear(Option<u32>),
    /// Store a fragment.
    Store(Fragment),
    /// Resolve a pixel.
    Resolve(u32),
}

/// What it gave.
#[derive(Clone, Debug)]
pub enum Done {
    /// Nothing.
    Cleared,
    /// What became of the fragment.
    Stored(Outcome),
    /// The pixel's fragments.
    Resolved(Keys),
}

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
        self.pass(work, invoke, |_, ()| (), None)
    }

    /// Store fragments, to the end.
    ///
    /// # Errors
    /// See [`Self::clear`].
    pub fn store<'b>(
        &'b mut self,
        work: impl Iterator<Item = Fragment>,
        done: impl FnMut(&Fragment, Outcome),
        watcher: Option<&'b mut Recording>,
    ) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        let invoke = move |&fragment: &Fragment| scheme.store(mem, fragment);
        self.pass(work, invoke, done, watcher.map(|w| w as &mut (dyn Watcher<Fragment> + 'b)))
    }

    /// Run work of several passes as one, to the end: what happens where a barrier is missing.
    ///
    /// # Errors
    /// See [`Self::clear`].
    pub fn mixed<'b>(
        &'b mut self,
        work: impl Iterator<Item = Work>,
        done: impl FnMut(&Work, Done),
        watcher: Option<&'b mut Recording>,
    ) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        let invoke = move |&work: &Work| async move {
            match work {
                Work::Clear(None) => scheme.clear_frame(mem).await,
                Work::Clear(Some(pixel)) => scheme.clear(mem, pixel).await,
                Work::Store(fragment) => return Done::Stored(scheme.store(mem, fragment).await),
                Work::Resolve(pixel) => {
                    let mut keys = Keys::new();
                    scheme.resolve(mem, pixel, &mut keys).await;
                    return Done::Resolved(keys);
                }
            }
            Done::Cleared
        };
        self.pass(work, invoke, done, watcher.map(|w| w as &mut (dyn Watcher<Work> + 'b)))
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
        self.pass(work, invoke, done, None)
    }

    fn pass<'b, W, F: Future>(
        &'b mut self,
        work: impl Iterator<Item = W>,
        invoke: impl Fn(&W) -> F,
        done: impl FnMut(&W, F::Output),
        watcher: Option<&'b mut (dyn Watcher<W> + 'b)>,
    ) -> Result<()> {
        let mem: &'b Sim<O> = self.mem;
        Pass::new(mem, &mut self.policy, [self.resident, self.group], work, invoke, done)
            .watched(watcher)
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
