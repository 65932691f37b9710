//! Runs invocations that are compiled only for the memory that asks, on any memory: each question is performed as the
//! operation that it is, and answered. Anything that can say "my next operation is this" and receive its result can be
//! run in this way.

use std::ops::Range;
use std::task::{Context, Poll, Waker};

use super::drive::{Ends, Pipeline, complete};
use super::method::Instance;
use super::sim::turns::{Room, Stage, Stepped, Stores};
use crate::error::Result;
use crate::fragment::Fragment;
use crate::memory::asked::{Action, Asked, Request};
use crate::memory::sim::Sim;
use crate::memory::{Address, Counters, Inputs, Layout, Memory, Order, Pool, Update, perform};
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::task::{Ended, Task};
use crate::scheme::{Held, Outcome, Outcomes, Readback};

/// An instance whose invocations are interpreted, with the inputs that they read.
#[derive(Clone, Copy)]
pub struct Interpreted<'a> {
    /// The instance.
    pub instance: &'a dyn Instance,
    /// The words of its inputs.
    pub inputs: &'a Inputs,
}

impl Interpreted<'_> {
    /// Run an invocation.
    pub async fn run<M: Memory>(&self, mem: &M, task: Task) -> Ended {
        let asked = Asked::new(self.inputs, false);
        let mut invocation = self.instance.ask(&asked, task);
        let layout = self.instance.layout();
        loop {
            let context = &mut Context::from_waker(Waker::noop());
            let polled = invocation.as_mut().poll(context);
            asked.take_noted().into_iter().for_each(|event| mem.note(event));
            if let Poll::Ready(ended) = polled {
                return ended;
            }
            let answer = match asked.request() {
                Some(Request::Operation { at, action, .. }) => match pool(layout, at, action) {
                    Some(pool) => mem.take(pool).await.into(),
                    None => perform(mem, at, action).await,
                },
                Some(Request::Spin(mark, _)) => {
                    mem.spin(mark).await;
                    0
                }
                Some(Request::Merge(_)) | None => 0,
            };
            asked.answer(answer);
        }
    }

    /// Run a store invocation.
    pub async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        match self.run(mem, Task::Store(fragment)).await {
            Ended::Stored(outcome) => outcome,
            Ended::Done | Ended::Resolved(..) => Outcome::Kept,
        }
    }
}

/// The pool from which an operation takes an index, if it does.
fn pool(layout: &Layout, at: Address, action: Action) -> Option<Pool> {
    let takes = at.pixel.is_none()
        && at.bits == 32
        && action == Action::Update(Update::Add(1), Order::Relaxed);
    if takes { layout.pool_at(at.word) } else { None }
}

impl<M: Memory> Pipeline<M> for Interpreted<'_> {
    fn clear_frame(&self, mem: &M) {
        complete(self.run(mem, Task::ClearFrame));
    }

    fn clear(&self, mem: &M, pixels: Range<u32>) {
        pixels.for_each(|pixel| drop(complete(self.run(mem, Task::Clear(pixel)))));
    }

    fn prepare(&self, mem: &M, pass: usize, batch: &Batch) {
        for fragment in batch.iter() {
            complete(self.run(mem, Task::Prepare(pass as u8, fragment)));
        }
    }

    fn screen(&self, mem: &M, pass: usize, pixels: Range<u32>) {
        pixels.for_each(|pixel| drop(complete(self.run(mem, Task::Screen(pass as u8, pixel)))));
    }

    fn frame(&self, mem: &M, pass: usize, indices: Range<u32>) {
        indices.for_each(|index| drop(complete(self.run(mem, Task::Frame(pass as u8, index)))));
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.instance.invocations(pass)
    }

    fn store(&self, mem: &M, batch: &Batch, outcomes: &mut Outcomes) {
        outcomes.reset();
        for bit in bits(batch.mask()) {
            outcomes.set(bit, complete(self.store(mem, batch.get(bit))));
        }
    }

    fn resolve_all(
        &self,
        mem: &M,
        pixels: Range<u32>,
        held: &mut Held,
        mut ends: Option<&mut Ends>,
    ) -> bool {
        let mut any = false;
        for pixel in pixels {
            if let Ended::Resolved(_, found, again) = complete(self.run(mem, Task::Resolve(pixel)))
            {
                held.append(found);
                any |= again;
            }
            if let Some(ends) = &mut ends {
                match &*held {
                    Held::Keys(keys) => ends.push(keys),
                    Held::Records(records) => ends.push(records),
                    Held::Light(_) | Held::Depth(_) => {}
                }
            }
        }
        any
    }

    fn readback(&self) -> Option<Readback> {
        self.instance.readback()
    }
}

impl Stepped for Interpreted<'_> {
    fn store<'a>(&'a self, stores: Stores<'a>) -> Result<()> {
        let mem = stores.mem;
        stores.run(move |&fragment: &Fragment| Interpreted::store(self, mem, fragment))
    }

    fn room<'a>(&'a self, mem: &'a Sim<Counters>, _: Stage, resident: usize) -> Room<'a> {
        Room::new(resident, move |&task| self.run(mem, task))
    }
}
