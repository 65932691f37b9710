//! A case: one litmus pixel of one method, ready to explore; and where its invocations are after some answers.

use std::task::{Context, Poll, Waker};

use super::guard::guarded;
use super::litmus::Litmus;
use super::subject::Subject;
use crate::exec::promise::{Promise, bound};
use crate::exec::{Instance, Method};
use crate::memory::asked::{Asked, Here, OpenBlock, Request, Site};
use crate::memory::{Inputs, Numbering};
use crate::scheme::course::Course;
use crate::scheme::task::{Ended, Task};
use crate::scheme::{Contract, Held};

impl Subject {
    /// A case of it.
    #[must_use]
    pub fn case(&self, litmus: &Litmus) -> Case {
        let config = litmus.config(self.contract);
        let instance = self.method.instance(&config).expect("it is not the oracle");
        let numbering = Numbering::new(instance.layout(), litmus.pixels);
        let inputs = litmus.inputs(instance.layout());
        let litmus = litmus.clone();
        Case { method: self.method, contract: self.contract, instance, numbering, inputs, litmus }
    }
}

/// One litmus pixel of one method.
pub struct Case {
    pub(in crate::explore) method: Method,
    pub(in crate::explore) contract: &'static Contract,
    pub(in crate::explore) instance: Box<dyn Instance>,
    pub(in crate::explore) numbering: Numbering,
    pub(in crate::explore) inputs: Inputs,
    pub(in crate::explore) litmus: Litmus,
}

impl Case {
    /// What a pixel must hold, where room and arrival do not matter; `None` if the method does not specify it.
    pub(in crate::explore) fn expected(&self, pixel: u32) -> Option<Held> {
        let Self { method, instance, inputs, litmus, .. } = self;
        let counts = || litmus.counts();
        let instance = Some(&**instance);
        let bound = bound(*method, instance, litmus.k, inputs, litmus.pixels, counts);
        let promise = Promise::new(*method, instance, inputs, bound);
        promise.pixel(pixel, &litmus.sorted(self.contract, pixel))
    }

    /// All that a pixel may hold, one for each order of arrival; empty if the method does not say.
    pub(in crate::explore) fn possible(&self, pixel: u32) -> Vec<Held> {
        let generated = self.litmus.sorted(self.contract, pixel);
        self.instance.possible(&self.inputs, pixel, &generated)
    }

    /// The most invocations that run at the same time.
    pub(in crate::explore) fn width(&self) -> usize {
        let course = Course::of(&self.contract.program);
        let stages =
            self.litmus.stages(self.contract, &course, |pass| self.instance.invocations(pass));
        stages.iter().map(|stage| stage.tasks.len()).max().unwrap_or(0)
    }

    /// Where a fresh invocation is after these answers. With `lanes`, merges are questions too.
    pub(in crate::explore) fn follow(
        &self,
        task: Task,
        answers: &[Answer],
        lanes: bool,
    ) -> Standing {
        self.follow_watched(task, answers, lanes, &mut |_, _| {})
    }

    /// The same; `watch` sees every question that is answered, by its number.
    pub(in crate::explore) fn follow_watched(
        &self,
        task: Task,
        answers: &[Answer],
        lanes: bool,
        watch: &mut dyn FnMut(usize, Request),
    ) -> Standing {
        let mem = Asked::new(&self.inputs, lanes).with_patience(PATIENCE);
        let next = guarded(|| follow(&*self.instance, &mem, task, answers, watch));
        let next = next.unwrap_or_else(|told| match mem.endless() {
            Some(site) => Next::Endless(site),
            None => Next::Panics(told),
        });
        Standing { next, blocks: mem.blocks(), opened: mem.block_sites(), here: mem.here() }
    }
}

/// Calls that an invocation may make between two questions: looking at an input, opening and closing blocks.
pub(in crate::explore) const PATIENCE: u32 = 100_000;

/// An answer to an invocation's question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::explore) enum Answer {
    /// The result of an operation, or permission to pass a merge.
    Value(u64),
    /// Try again.
    Again,
}

/// Where an invocation is after some answers.
#[derive(Clone, Debug)]
pub(in crate::explore) struct Standing {
    pub(in crate::explore) next: Next,
    /// Open blocks, outermost first.
    pub(in crate::explore) blocks: Vec<OpenBlock>,
    /// Where blocks were opened so far.
    pub(in crate::explore) opened: Vec<Site>,
    /// What it says it depends on from here on.
    pub(in crate::explore) here: Option<Here>,
}

/// What comes next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::explore) enum Next {
    /// An operation or a merge.
    Ask(Request),
    /// Back to what followed this many answers.
    Back(u32, Site),
    /// Nothing.
    Ended(Ended),
    /// A panic, with what it says.
    Panics(String),
    /// A loop that asks nothing, for ever.
    Endless(Site),
}

fn follow(
    instance: &dyn Instance,
    mem: &Asked<'_>,
    task: Task,
    answers: &[Answer],
    watch: &mut dyn FnMut(usize, Request),
) -> Next {
    let mut invocation = instance.ask(mem, task);
    let mut context = Context::from_waker(Waker::noop());
    let mut answers = answers.iter().enumerate();
    loop {
        if let Poll::Ready(ended) = invocation.as_mut().poll(&mut context) {
            return Next::Ended(ended);
        }
        let Some(request) = mem.request() else {
            unreachable!("an invocation waits for this memory or for nothing")
        };
        match (request, answers.next()) {
            (request, Some((number, answer))) => {
                watch(number, request);
                match answer {
                    Answer::Value(value) => mem.answer(*value),
                    Answer::Again => mem.answer(0),
                }
            }
            (Request::Spin(mark, site), None) => return Next::Back(mark.0, site),
            (request, None) => return Next::Ask(request),
        }
    }
}
