//! Slots, invocations and steps: one pass.
//!
//! The cost of a step is mostly waiting: for the branch that depends on where the invocation stands, which no processor
//! predicts under a random schedule, and for the cache. So the loop is kept short, everything it needs next is
//! requested a step ahead, and invocations are just the futures of their scheme, in a pool of places that are made once.

use std::marker::PhantomData;
use std::ops::Range;
use std::task::{Context, Poll, Waker};

use super::policy::{Any, Scheduler};
use super::pool::Pool;
use super::schedule::Recorder;
use crate::error::{Error, Result};
use crate::memory::Observer;
use crate::memory::sim::Sim;

/// Checks memory after each step.
pub(super) trait Check {
    /// After a step.
    fn step(&mut self);
}

/// Steps without any invocation ending, after which a schedule is taken to hang.
const PATIENCE: u64 = 200_000_000;

/// The invocations of a pass: those that wait for a slot, and those in slots.
pub(super) struct Slots<'a, O, W, R, Q, P, D> {
    mem: &'a Sim<O>,
    policy: &'a mut Any,
    /// Work for invocations, in order of admission.
    queue: Q,
    /// By slot.
    invocations: P,
    /// Takes their results.
    done: D,
    result: PhantomData<R>,
    /// By slot; kept apart from the invocations, so that a step touches little memory.
    work: Vec<Option<W>>,
    /// Slots are refilled when all `group` slots of a group have ended.
    group: usize,
    live_in_group: Vec<u32>,
    live: usize,
    /// Slots that are to be filled now.
    vacant: Range<usize>,
    watcher: Option<&'a mut (dyn Watcher<W> + 'a)>,
    checker: Option<&'a mut (dyn Check + 'a)>,
}

/// Is notified when an invocation takes a slot and when a slot makes a step.
pub(super) trait Watcher<W> {
    /// Work was set into a slot.
    fn takes(&mut self, slot: u32, work: &W);

    /// A slot's invocation performs an operation.
    fn steps(&mut self, slot: u32);
}

impl<'a, O, W, R, Q, P, D> Slots<'a, O, W, R, Q, P, D>
where
    O: Observer,
    Q: Iterator<Item = W>,
    P: Pool<W, R>,
    D: FnMut(&W, R),
{
    pub(super) fn new(
        mem: &'a Sim<O>,
        policy: &'a mut Any,
        [resident, group]: [usize; 2],
        queue: Q,
        invocations: P,
        done: D,
    ) -> Self {
        let work = std::iter::repeat_with(|| None).take(resident).collect();
        let (live_in_group, vacant) = (vec![0; resident.div_ceil(group)], 0..resident);
        let live = 0;
        Self {
            mem,
            policy,
            queue,
            invocations,
            done,
            result: PhantomData,
            work,
            group,
            live_in_group,
            live,
            vacant,
            watcher: None,
            checker: None,
        }
    }

    /// With a watcher.
    pub(super) fn watched(self, watcher: Option<&'a mut (dyn Watcher<W> + 'a)>) -> Self {
        Self { watcher, ..self }
    }

    /// With a check of memory after every step.
    pub(super) fn checked(self, checker: Option<&'a mut (dyn Check + 'a)>) -> Self {
        Self { checker, ..self }
    }

    /// Run it to its end.
    ///
    /// Invocations are polled in this one place, so that the compiler inlines them into the loop. A slot is polled once
    /// when it is filled, which takes the invocation to its first operation, and then once a step.
    pub(super) fn run(mut self, mut recorder: Option<&mut Recorder>) -> Result<()> {
        let context = &mut Context::from_waker(Waker::noop());
        let mut patience = PATIENCE;
        loop {
            let filled = self.fill();
            let slot = match filled {
                Some(slot) => slot,
                None if self.live == 0 => return Ok(()),
                None => self.next(recorder.as_deref_mut())?,
            };
            let Some(polled) = self.invocations.poll(slot as usize, context) else {
                return Err(not_live(slot));
            };
            let waited = self.mem.take_waited();
            if let Some(checker) = &mut self.checker {
                checker.step();
            }
            match polled {
                Poll::Pending => {
                    if filled.is_some() {
                        self.admit(slot);
                    } else if waited {
                        self.policy.waits(slot);
                    }
                    patience -= 1;
                    if patience == 0 {
                        return Err(hangs());
                    }
                }
                Poll::Ready(result) => {
                    patience = PATIENCE;
                    self.end(slot as usize, result);
                    if filled.is_none() {
                        self.retire(slot);
                    }
                }
            }
        }
    }

    /// Pick the slot that performs the next operation, and grant the operation.
    #[inline]
    fn next(&mut self, recorder: Option<&mut Recorder>) -> Result<u32> {
        let slot = self.policy.next()?;
        if let Some(hint) = self.policy.hint() {
            self.invocations.touch(hint as usize);
        }
        if let Some(recorder) = recorder {
            recorder.step(slot);
        }
        if let Some(watcher) = &mut self.watcher {
            watcher.steps(slot);
        }
        self.mem.grant();
        Ok(slot)
    }

    /// Place the queue's next invocation in a vacant slot, if there are both.
    #[inline]
    fn fill(&mut self) -> Option<u32> {
        if self.vacant.is_empty() { None } else { self.take() }
    }

    #[inline(never)]
    fn take(&mut self) -> Option<u32> {
        let Some(work) = self.queue.next() else {
            self.vacant = 0..0;
            return None;
        };
        let slot = self.vacant.start;
        self.invocations.set(slot, &work);
        if let Some(watcher) = &mut self.watcher {
            watcher.takes(slot as u32, &work);
        }
        self.work[slot] = Some(work);
        Some(slot as u32)
    }

    /// Admit the newest invocation, which is at its first operation. One that ends without any leaves its slot vacant.
    fn admit(&mut self, slot: u32) {
        self.policy.admit(slot);
        self.vacant.start += 1;
        self.live += 1;
        self.live_in_group[slot as usize / self.group] += 1;
    }

    fn end(&mut self, slot: usize, result: R) {
        if let Some(work) = &self.work[slot] {
            (self.done)(work, result);
        }
    }

    fn retire(&mut self, slot: u32) {
        self.policy.retire(slot);
        self.live -= 1;
        let group = slot as usize / self.group;
        self.live_in_group[group] -= 1;
        if self.live_in_group[group] == 0 {
            let first = group * self.group;
            self.vacant = first..(first + self.group).min(self.work.len());
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
