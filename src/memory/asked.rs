//! Memory whose every operation is a question: an invocation stops before each one, and whoever drives it answers.
//!
//! This memory holds no words. It says what an invocation wants to do next ([`Request`]): which word, how, in which
//! order, from where in the source; and takes the result from outside. So one invocation can be followed along any
//! results at all, which is what search needs: it keeps the words itself, under whatever memory model it explores.

use std::cell::{Cell, RefCell};
use std::future::Future;
use std::marker::PhantomData;
use std::panic::Location;
use std::pin::Pin;
use std::task::{Context, Poll};

use super::layout::Sizes;
use super::{Access, At, Atomic, Block, Kind, Layout, Mark, Memory, Order, Space, Update, Word};

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
    /// An operation on a word, by its number in [`Cells`]; the answer is the value read, or 0.
    Operation {
        /// The word; [`Cells::OUTSIDE`] where the layout has none.
        cell: u32,
        /// What to do.
        action: Action,
        /// From where.
        site: Site,
    },
    /// To try again from a mark.
    Spin(Mark, Site),
    /// To leave a block with the other lanes of its warp.
    Merge(Site),
}

/// The words of a few pixels and of the frame, numbered: the frame's first, then pixel by pixel; 32-bit words before
/// 64-bit ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cells {
    frame: Sizes,
    pixel: Sizes,
    pixels: u32,
}

/// What a cell's number stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellName {
    /// The pixel; `None` for the frame.
    pub pixel: Option<u32>,
    /// The word within the record of its width.
    pub word: u64,
    /// 32 or 64.
    pub bits: u32,
}

impl Cells {
    /// The number of a word that does not exist.
    pub const OUTSIDE: u32 = u32::MAX;

    /// The words of a layout for so many pixels.
    #[must_use]
    pub fn new(layout: &Layout, pixels: u32) -> Self {
        Self { frame: layout.per_frame(), pixel: layout.per_pixel(), pixels }
    }

    fn of(sizes: Sizes) -> u64 {
        sizes.words32 + sizes.words64
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        Self::of(self.frame) + Self::of(self.pixel) * u64::from(self.pixels)
    }

    /// The number of a word, or [`Self::OUTSIDE`].
    #[must_use]
    pub fn number<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>) -> u32 {
        let (record, base) = if S::GLOBAL {
            (self.frame, 0)
        } else {
            (self.pixel, Self::of(self.frame) + Self::of(self.pixel) * u64::from(at.pixel))
        };
        let (first, count) = match W::BITS {
            64 => (record.words32, record.words64),
            _ => (0, record.words32),
        };
        let inside = at.word < count && (S::GLOBAL || at.pixel < self.pixels);
        if inside { (base + first + at.word) as u32 } else { Self::OUTSIDE }
    }

    /// The number of a pixel's 32-bit word.
    #[must_use]
    pub fn pixel_word(&self, pixel: u32, word: u64) -> u32 {
        (Self::of(self.frame) + Self::of(self.pixel) * u64::from(pixel) + word) as u32
    }

    /// What a number stands for.
    #[must_use]
    pub fn name(&self, cell: u32) -> CellName {
        let (frame, record) = (Self::of(self.frame), Self::of(self.pixel).max(1));
        let cell = u64::from(cell);
        let (pixel, sizes, word) = if cell < frame {
            (None, self.frame, cell)
        } else {
            let pixel = (cell - frame) / record;
            (Some(pixel as u32), self.pixel, (cell - frame) % record)
        };
        if word < sizes.words32 {
            CellName { pixel, word, bits: 32 }
        } else {
            CellName { pixel, word: word - sizes.words32, bits: 64 }
        }
    }
}

/// Words at one moment, for looking at and not for computing with.
pub struct Snapshot<'a> {
    /// The numbering.
    pub cells: &'a Cells,
    /// A word's value by its number; `None` while it holds what nobody wrote.
    pub value: &'a dyn Fn(u32) -> Option<u64>,
}

impl Snapshot<'_> {
    /// The word's value; `None` while it holds what nobody wrote.
    #[must_use]
    pub fn get<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>) -> Option<W> {
        (self.value)(self.cells.number(at)).map(W::from_u64)
    }
}

/// A block of the invocation's stack: where it was opened, and how many its parent had opened before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenBlock {
    /// Where.
    pub site: Site,
    /// The number among its parent's blocks.
    pub ordinal: u32,
}

/// One invocation's view: what it asks, and where it stands.
#[derive(Debug)]
pub struct Asked<'a> {
    cells: &'a Cells,
    request: Cell<Option<Request>>,
    answer: Cell<Option<u64>>,
    answered: Cell<u32>,
    blocks: RefCell<Vec<OpenBlock>>,
    /// Blocks opened so far in the body of each open block, and of the invocation.
    opened: RefCell<Vec<u32>>,
    sites: RefCell<Vec<Site>>,
    /// After how many answers the invocation last said what it depends on, where, and on what.
    here: RefCell<Option<(u32, Here)>>,
    lanes: bool,
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
    pub fn new(cells: &'a Cells, lanes: bool) -> Self {
        Self {
            cells,
            request: Cell::new(None),
            answer: Cell::new(None),
            answered: Cell::new(0),
            blocks: RefCell::default(),
            opened: RefCell::new(vec![0]),
            sites: RefCell::default(),
            here: RefCell::default(),
            lanes,
        }
    }

    /// What the invocation waits for, if it does.
    #[must_use]
    pub fn request(&self) -> Option<Request> {
        self.request.get()
    }

    /// What the invocation said it depends on since the last answer, if it did.
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
            return Poll::Ready((self.read)(answer));
        }
        asked.request.set(Some(self.request));
        Poll::Pending
    }
}

fn widen<W: Word>(update: Update<W>) -> Update<u64> {
    match update {
        Update::Exchange(v) => Update::Exchange(v.to_u64()),
        Update::CompareExchange { expected, new } => {
            Update::CompareExchange { expected: expected.to_u64(), new: new.to_u64() }
        }
        Update::Add(v) => Update::Add(v.to_u64()),
        Update::And(v) => Update::And(v.to_u64()),
        Update::Or(v) => Update::Or(v.to_u64()),
        Update::Min(v) => Update::Min(v.to_u64()),
        Update::Max(v) => Update::Max(v.to_u64()),
    }
}

impl Memory for Asked<'_> {
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        let (cell, action) = (self.cells.number(at), Action::Read(access));
        self.ask(Request::Operation { cell, action, site: Location::caller() }, W::from_u64)
    }

    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        let (cell, action) = (self.cells.number(at), Action::Write(value.to_u64(), access));
        self.ask(Request::Operation { cell, action, site: Location::caller() }, |_| ())
    }

    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        let (cell, action) = (self.cells.number(at), Action::Update(widen(update), order));
        self.ask(Request::Operation { cell, action, site: Location::caller() }, W::from_u64)
    }

    fn spin(&self, mark: Mark) -> impl Future<Output = ()> + Unpin {
        self.ask(Request::Spin(mark, Location::caller()), |_| ())
    }

    fn mark(&self) -> Mark {
        Mark(self.answered.get())
    }

    fn here(&self, live: &[u64]) {
        let site = Location::caller();
        let here = Here { site: (site.file(), site.line(), site.column()), live: live.to_vec() };
        *self.here.borrow_mut() = Some((self.answered.get(), here));
    }

    fn block(&self) -> Block {
        let site = Location::caller();
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

/// The end of a block: with lanes, a question; then, and without, the block is closed.
struct Merge<'a> {
    asked: &'a Asked<'a>,
    block: Block,
    site: Site,
}

impl Future for Merge<'_> {
    type Output = ();

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        let depth = self.block.0 as usize;
        // Blocks that were left by a break end here too.
        self.asked.blocks.borrow_mut().truncate(depth + 1);
        self.asked.opened.borrow_mut().truncate(depth + 2);
        if self.asked.lanes {
            let mut question = self.asked.ask(Request::Merge(self.site), |_| ());
            if Pin::new(&mut question).poll(context).is_pending() {
                return Poll::Pending;
            }
        }
        self.asked.blocks.borrow_mut().truncate(depth);
        self.asked.opened.borrow_mut().truncate(depth + 1);
        Poll::Ready(())
    }
}
