//! A method as the explorer sees it: without its type, and asked what it does next.

use std::future::Future;
use std::marker::PhantomData;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::error::{Error, Result};
use crate::memory::asked::{Asked, Cells, Here, OpenBlock, Request, Site};
use crate::memory::{Layout, Snapshot};
use crate::scheme::catalogue::{self, Visitor};
use crate::scheme::task::invoke;
use crate::scheme::{Config, Contract, Moment, Scheme};

pub use crate::scheme::task::{Ended, Task};

/// An answer to an invocation's question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// The result of an operation, or leave to pass a merge.
    Value(u64),
    /// Try again.
    Again,
}

/// Where an invocation stands after some answers.
#[derive(Clone, Debug)]
pub(super) struct Standing {
    pub(super) next: Next,
    /// Open blocks, outermost first.
    pub(super) blocks: Vec<OpenBlock>,
    /// Where blocks were opened so far.
    pub(super) opened: Vec<Site>,
    /// What it says it depends on from here on.
    pub(super) here: Option<Here>,
}

/// What comes next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// An operation or a merge.
    Ask(Request),
    /// Again what came after so many answers.
    Back(u32, Site),
    /// Nothing.
    Ended(Ended),
}

/// A method with its configuration.
pub(super) trait Shader: Sync + Send {
    fn layout(&self) -> &Layout;

    /// Where a fresh invocation stands after these answers.
    fn follow(&self, cells: &Cells, task: Task, answers: &[Answer], lanes: bool) -> Standing;

    fn invariant(
        &self,
        words: &Snapshot<'_>,
        pixel: u32,
        moment: Moment,
    ) -> std::result::Result<(), String>;

    /// Invocations of a pass over the frame's words.
    fn invocations(&self, pass: usize) -> u32;
}

/// A method that can be checked: of the catalogue by [`subject`], or anybody's by [`Subject::of`].
#[derive(Clone, Copy)]
pub struct Subject {
    /// What it promises.
    pub contract: &'static Contract,
    pub(super) make: fn(&Config) -> Box<dyn Shader>,
}

impl std::fmt::Debug for Subject {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.contract.name)
    }
}

impl Subject {
    /// A scheme that need not be in the catalogue.
    #[must_use]
    pub fn of<S: Scheme + Send + 'static>() -> Self {
        Self { contract: &S::CONTRACT, make: make::<S> }
    }
}

fn make<S: Scheme + Send + 'static>(config: &Config) -> Box<dyn Shader> {
    let mut layout = Layout::default();
    let scheme = S::new(config, &mut layout);
    Box::new(Compiled { scheme, layout })
}

/// A method of the catalogue.
///
/// # Errors
/// An unknown name, or the sequential reference, which has no invocations to explore.
pub fn subject(name: &str) -> Result<Subject> {
    struct Find(PhantomData<()>);
    impl Visitor for Find {
        type Output = Option<Subject>;

        fn scheme<S: Scheme + Send + 'static>(self) -> Option<Subject> {
            Some(Subject::of::<S>())
        }

        fn exact(self) -> Option<Subject> {
            None
        }
    }
    catalogue::visit(name, Find(PhantomData))?.ok_or_else(|| {
        let problem = "is the sequential reference: it has no invocations whose order could matter";
        Error::new(name, problem)
    })
}

struct Compiled<S> {
    scheme: S,
    layout: Layout,
}

impl<S: Scheme + Send> Shader for Compiled<S> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn follow(&self, cells: &Cells, task: Task, answers: &[Answer], lanes: bool) -> Standing {
        let mem = Asked::new(cells, lanes);
        let next = follow(&mem, invoke(&self.scheme, &mem, task), answers);
        Standing { next, blocks: mem.blocks(), opened: mem.block_sites(), here: mem.here() }
    }

    fn invariant(
        &self,
        words: &Snapshot<'_>,
        pixel: u32,
        moment: Moment,
    ) -> std::result::Result<(), String> {
        self.scheme.invariant(words, pixel, moment)
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.scheme.invocations(pass)
    }
}

fn follow(mem: &Asked<'_>, invocation: impl Future<Output = Ended>, answers: &[Answer]) -> Next {
    let mut invocation = pin!(invocation);
    let mut context = Context::from_waker(Waker::noop());
    let mut answers = answers.iter();
    loop {
        if let Poll::Ready(ended) = invocation.as_mut().poll(&mut context) {
            debug_assert!(answers.next().is_none(), "more answers than questions");
            return Next::Ended(ended);
        }
        let Some(request) = mem.request() else {
            unreachable!("an invocation waits for this memory or for nothing")
        };
        match (request, answers.next()) {
            (_, Some(Answer::Value(value))) => mem.answer(*value),
            (_, Some(Answer::Again)) => mem.answer(0),
            (Request::Spin(mark, site), None) => return Next::Back(mark.0, site),
            (request, None) => return Next::Ask(request),
        }
    }
}
