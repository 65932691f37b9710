//! Memory whose every operation is a question: an invocation stops before each one, and its driver answers.
//!
//! This memory holds no words. It says what an invocation wants to do next ([`Request`]): which word, how, in which
//! order, from where in the source; and takes the result from outside. So an invocation can be followed along any
//! sequence of results. Search needs that: it keeps the words itself, under the memory model that it explores.

use std::cell::{Cell, RefCell};
use std::future::Future;
use std::marker::PhantomData;
use std::panic::Location;
use std::pin::Pin;
use std::task::{Context, Poll};

use super::{
    Access, Address, At, Atomic, Block, Event, InputAt, Inputs, Kind, Mark, Memory, Order, Space,
    Update, Word,
};

/// A place in the source of a scheme.
pub type Site = &'static Location<'static>;

/// What an invocation wants to do to a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Read it.
    Read(Access),
    /// Write it.
    Write(u64, Access),
    /// Read, modify and write it.
    Update(Update<u64>, Order),
}

/// What an invocation waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// An operation on a word; the answer is the value read, or 0.
    Operation {
        /// The word, which the layout need not have.
        at: Address,
        /// What to do.
        action: Action,
        /// The place in the source.
        site: Site,
    },
    /// To try again from a mark.
    Spin(Mark, Site),
    /// To leave a block with the other lanes of its warp.
    Merge(Site),
}

/// A block of the invocation's stack: where it was opened, and how many its parent had opened before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenBlock {
    /// The place in the source.
    pub site: Site,
    /// The number among its parent's blocks.
    pub ordinal: u32,
}

/// One invocation's view: what it asks, and where it stands.
#[derive(Debug)]
pub struct Asked<'a> {
    inputs: &'a Inputs,
    request: Cell<Option<Request>>,
    answer: Cell<Option<u64>>,
    answered: Cell<u32>,
    blocks: RefCell<Vec<OpenBlock>>,
    /// Blocks opened so far in the body of each open block, and of the invocation.
    opened: RefCell<Vec<u32>>,
    sites: RefCell<Vec<Site>>,
    /// When the invocation last said what it depends on: after how many answers, where, and on which values.
    here: RefCell<Option<(u32, Here)>>,
    /// What the invocation has reported to be counted since the last call of `take_noted`.
    noted: RefCell<Vec<Event>>,
    lanes: bool,
    /// Calls since the last answer that asked nothing, and how many there may be.
    idle: Cell<u32>,
    patience: u32,
    /// Where the last of them was, if there were too many.
    endless: Cell<Option<Site>>,
}

/// A place in an invocation, and what it depends on from there on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Here {
    /// File, line and column.
    pub site: (&'static str, u32, u32),
    /// The values.
    pub live: Vec<u64>,
}

impl<'a> Asked<'a> {
    /// At an invocation's beginning. With `lanes`, merges are questions too.
    #[must_use]
    pub fn new(inputs: &'a Inputs, lanes: bool) -> Self {
        Self {
            inputs,
            request: Cell::new(None),
            answer: Cell::new(None),
            answered: Cell::new(0),
            blocks: RefCell::default(),
            opened: RefCell::new(vec![0]),
            sites: RefCell::default(),
            here: RefCell::default(),
            noted: RefCell::default(),
            lanes,
            idle: Cell::new(0),
            patience: u32::MAX,
            endless: Cell::new(None),
        }
    }

    /// The same, for an invocation that may be faulty: one that makes this many calls without asking anything panics,
    /// and [`Self::endless`] says where.
    #[must_use]
    pub fn with_patience(self, calls: u32) -> Self {
        Self { patience: calls, ..self }
    }

    /// The call at which the invocation was stopped, if it goes on for ever without asking anything.
    #[must_use]
    pub fn endless(&self) -> Option<Site> {
        self.endless.get()
    }

    /// Count a call that asks nothing.
    fn idles(&self, site: Site) {
        self.idle.set(self.idle.get() + 1);
        if self.idle.get() > self.patience {
            self.endless.set(Some(site));
            panic!("a loop at {site} neither ends nor accesses memory");
        }
    }

    /// The request that the invocation waits for, if it waits.
    #[must_use]
    pub fn request(&self) -> Option<Request> {
        self.request.get()
    }

    /// What the invocation has said it depends on since the last answer, if anything.
    #[must_use]
    pub fn here(&self) -> Option<Here> {
        let here = self.here.borrow();
        here.as_ref()
            .filter(|(after, _)| *after == self.answered.get())
            .map(|(_, here)| here.clone())
    }

    /// Answer the request.
    pub fn answer(&self, result: u64) {
        self.request.set(None);
        self.answer.set(Some(result));
    }

    /// The blocks that are open, outermost first.
    #[must_use]
    pub fn blocks(&self) -> Vec<OpenBlock> {
        self.blocks.borrow().clone()
    }

    /// Where blocks were opened.
    #[must_use]
    pub fn block_sites(&self) -> Vec<Site> {
        self.sites.borrow().clone()
    }

    /// What the invocation has reported to be counted since the last call.
    #[must_use]
    pub fn take_noted(&self) -> Vec<Event> {
        self.noted.take()
    }

    #[track_caller]
    fn ask<T>(&self, request: Request, read: fn(u64) -> T) -> Question<'_, T> {
        Question { asked: self, request, read, typed: PhantomData }
    }
}

/// A request that waits for its answer.
struct Question<'a, T> {
    asked: &'a Asked<'a>,
    request: Request,
    read: fn(u64) -> T,
    typed: PhantomData<T>,
}

impl<T> Unpin for Question<'_, T> {}

impl<T> Future for Question<'_, T> {
    type Output = T;

    fn poll(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<T> {
        let asked = self.asked;
        if let Some(answer) = asked.answer.take() {
            asked.answered.set(asked.answered.get() + 1);
            asked.idle.set(0);
            return Poll::Ready((self.read)(answer));
        }
        asked.request.set(Some(self.request));
        Poll::Pending
    }
}

impl Memory for Asked<'_> {
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        let (at, action) = (at.address(), Action::Read(access));
        self.ask(Request::Operation { at, action, site: Location::caller() }, W::from_u64)
    }

    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        let (at, action) = (at.address(), Action::Write(value.to_u64(), access));
        self.ask(Request::Operation { at, action, site: Location::caller() }, |_| ())
    }

    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        let (at, action) = (at.address(), Action::Update(update.map(W::to_u64), order));
        self.ask(Request::Operation { at, action, site: Location::caller() }, W::from_u64)
    }

    #[track_caller]
    fn input(&self, at: InputAt) -> u32 {
        self.idles(Location::caller());
        self.note(Event::Input);
        self.inputs.get(at)
    }

    fn note(&self, event: Event) {
        self.noted.borrow_mut().push(event);
    }

    fn spin(&self, mark: Mark) -> impl Future<Output = ()> + Unpin {
        self.ask(Request::Spin(mark, Location::caller()), |_| ())
    }

    fn mark(&self) -> Mark {
        Mark(self.answered.get())
    }

    fn here(&self, live: &[u64]) {
        let site = Location::caller();
        self.idles(site);
        let here = Here { site: (site.file(), site.line(), site.column()), live: live.to_vec() };
        *self.here.borrow_mut() = Some((self.answered.get(), here));
    }

    fn block(&self) -> Block {
        let site = Location::caller();
        self.idles(site);
        let (mut blocks, mut opened) = (self.blocks.borrow_mut(), self.opened.borrow_mut());
        let depth = blocks.len();
        blocks.push(OpenBlock { site, ordinal: opened[depth] });
        opened[depth] += 1;
        opened.push(0);
        self.sites.borrow_mut().push(site);
        Block(depth as u32)
    }

    fn merge(&self, block: Block) -> impl Future<Output = ()> + Unpin {
        Merge { asked: self, block, site: Location::caller() }
    }
}

/// The end of a block. With lanes it is a question first; then, as without lanes, the block is closed.
struct Merge<'a> {
    asked: &'a Asked<'a>,
    block: Block,
    site: Site,
}

impl Future for Merge<'_> {
    type Output = ();

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        let depth = self.block.0 as usize;
        // Blocks left by a break end here too.
        self.asked.blocks.borrow_mut().truncate(depth + 1);
        self.asked.opened.borrow_mut().truncate(depth + 2);
        if self.asked.lanes {
            let mut question = self.asked.ask(Request::Merge(self.site), |_| ());
            if Pin::new(&mut question).poll(context).is_pending() {
                return Poll::Pending;
            }
        } else {
            self.asked.idles(self.site);
        }
        self.asked.blocks.borrow_mut().truncate(depth);
        self.asked.opened.borrow_mut().truncate(depth + 1);
        Poll::Ready(())
    }
}
