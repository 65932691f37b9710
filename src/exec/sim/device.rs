//! Slots, invocations and steps.

use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};

use super::policy::{Policy, Settings};
use super::schedule::Recorder;
use crate::error::{Error, Result};
use crate::fragment::Fragment;
use crate::memory::sim::Sim;
use crate::scheme::{Keys, Outcome, Scheme};

/// Steps without any invocation ending, after which a schedule is taken to hang.
const PATIENCE: u64 = 200_000_000;

/// What an invocation is to do.
#[derive(Clone, Copy, Debug)]
pub enum Work {
    /// Clear the frame's words.
    ClearFrame,
    /// Clear a pixel.
    Clear(u32),
    /// Store a fragment.
    Store(Fragment),
    /// Resolve a pixel.
    Resolve(u32),
}

/// What an invocation did.
#[derive(Clone, Debug)]
pub enum Done {
    /// A clear.
    Cleared,
    /// A store into a pixel.
    Stored(u32, Outcome),
    /// A pixel's fragments.
    Resolved(u32, Keys),
}

/// One invocation of any pass: the single place where schemes meet simulated memory.
async fn invoke<S: Scheme>(scheme: &S, mem: &Sim, work: Work) -> Done {
    match work {
        Work::ClearFrame => {
            scheme.clear_frame(mem).await;
            Done::Cleared
        }
        Work::Clear(pixel) => {
            scheme.clear(mem, pixel).await;
            Done::Cleared
        }
        Work::Store(fragment) => Done::Stored(fragment.pixel, scheme.store(mem, fragment).await),
        Work::Resolve(pixel) => {
            let mut keys = Keys::new();
            scheme.resolve(mem, pixel, &mut keys).await;
            Done::Resolved(pixel, keys)
        }
    }
}

/// A device that runs one scheme.
pub struct Device<'a, S> {
    scheme: &'a S,
    mem: &'a Sim,
    policy: Box<dyn Policy>,
    resident: usize,
    group: usize,
    recorder: Option<Recorder>,
}

impl<'a, S: Scheme> Device<'a, S> {
    /// With the policy and residency of `settings`.
    ///
    /// # Errors
    /// A recorded schedule that cannot be read, or belongs to another run.
    pub fn new(scheme: &'a S, mem: &'a Sim, settings: &Settings) -> Result<Self> {
        let policy = super::make(settings)?;
        let (resident, group) = (policy.resident(settings.resident), policy.group());
        let recorder =
            settings.record.then(|| Recorder::new(settings.fingerprint, resident, group));
        Ok(Self { scheme, mem, policy, resident, group, recorder })
    }

    /// Run one pass to its end: the barrier.
    ///
    /// # Errors
    /// A recorded schedule that does not fit, or a schedule under which nothing ends any more.
    pub fn pass(&mut self, work: impl Iterator<Item = Work>, done: impl FnMut(Done)) -> Result<()> {
        let (scheme, mem) = (self.scheme, self.mem);
        Slots::new(mem, self.resident, self.group, move |work| invoke(scheme, mem, work)).run(
            work,
            self.policy.as_mut(),
            self.recorder.as_mut(),
            done,
        )
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

/// The resident invocations of a pass.
struct Slots<'a, F, M> {
    mem: &'a Sim,
    make: M,
    /// Boxes are made once; an invocation is set into its box.
    invocations: Vec<Pin<Box<Option<F>>>>,
    /// Slots are refilled when all `group` of theirs have ended.
    group: usize,
    live_in_group: Vec<u32>,
    live: usize,
}

impl<'a, F: Future<Output = Done>, M: Fn(Work) -> F> Slots<'a, F, M> {
    fn new(mem: &'a Sim, resident: usize, group: usize, make: M) -> Self {
        let mut invocations = Vec::new();
        invocations.resize_with(resident, || Box::pin(None));
        let live_in_group = vec![0; resident.div_ceil(group)];
        Self { mem, make, invocations, group, live_in_group, live: 0 }
    }

    fn run(
        mut self,
        mut work: impl Iterator<Item = Work>,
        policy: &mut dyn Policy,
        mut recorder: Option<&mut Recorder>,
        mut done: impl FnMut(Done),
    ) -> Result<()> {
        for group in 0..self.live_in_group.len() {
            self.refill(group, &mut work, policy, &mut done);
        }
        let (mut steps, mut last_end) = (0u64, 0u64);
        while self.live > 0 {
            let slot = policy.next()?;
            if let Some(recorder) = &mut recorder {
                recorder.step(slot);
            }
            steps += 1;
            self.mem.grant();
            match self.poll(slot) {
                None => return Err(not_live(slot)),
                Some(Poll::Pending) if steps - last_end > PATIENCE => return Err(hangs()),
                Some(Poll::Pending) => {}
                Some(Poll::Ready(result)) => {
                    last_end = steps;
                    done(result);
                    self.retire(slot, &mut work, policy, &mut done);
                }
            }
        }
        Ok(())
    }

    /// Let a slot's invocation run on to its next operation; `None` if the slot is empty.
    #[inline]
    fn poll(&mut self, slot: u32) -> Option<Poll<Done>> {
        let invocation = self.invocations.get_mut(slot as usize)?.as_mut().as_pin_mut()?;
        Some(invocation.poll(&mut Context::from_waker(Waker::noop())))
    }

    fn retire(
        &mut self,
        slot: u32,
        work: &mut impl Iterator<Item = Work>,
        policy: &mut dyn Policy,
        done: &mut impl FnMut(Done),
    ) {
        policy.retire(slot);
        self.invocations[slot as usize].set(None);
        self.live -= 1;
        let group = slot as usize / self.group;
        self.live_in_group[group] -= 1;
        if self.live_in_group[group] == 0 {
            self.refill(group, work, policy, done);
        }
    }

    /// Admit invocations into the slots of a group, up to their first operation. One without operations ends at once.
    fn refill(
        &mut self,
        group: usize,
        work: &mut impl Iterator<Item = Work>,
        policy: &mut dyn Policy,
        done: &mut impl FnMut(Done),
    ) {
        let last = ((group + 1) * self.group).min(self.invocations.len());
        for slot in group * self.group..last {
            for item in work.by_ref() {
                self.invocations[slot].set(Some((self.make)(item)));
                match self.poll(slot as u32) {
                    Some(Poll::Ready(result)) => done(result),
                    _ => {
                        policy.admit(slot as u32);
                        self.live += 1;
                        self.live_in_group[group] += 1;
                        break;
                    }
                }
            }
        }
    }
}

fn not_live(slot: u32) -> Error {
    Error::new(
        "--schedule",
        format!(
            "the recorded schedule steps slot {slot}, which is empty: it belongs to another run"
        ),
    )
}

fn hangs() -> Error {
    Error::new(
        "--schedule",
        format!("no invocation ended in {PATIENCE} steps: under this schedule the method hangs"),
    )
}
