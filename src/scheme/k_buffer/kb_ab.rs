//! k-buffers on top of A-buffers (Yu, Yang, Hensley, Harada, Yu, "A framework for rendering complex scattering effects
//! on hair", 2012, first solution; k+-buffer paper, section 4): all fragments are stored, and resolve selects the k
//! nearest.
//!
//! One wrapper for the A-buffers there are: it hands everything on, and cuts what resolve gives.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Inside, Layout, Memory, OwnedBlock, Pixel, Snapshot, Words};
use crate::raster::Batch;
use crate::scheme::a_buffer::ab_array::{AbArray, AtomicAdd};
use crate::scheme::a_buffer::ab_ll::{self, AbLinkedList};
use crate::scheme::a_buffer::s_buffer::{self, SBuffer};
use crate::scheme::contract::{Accounting, Keeps, Overflow};
use crate::scheme::parts::select;
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Outcomes, Scheme};

/// An A-buffer from which k are selected.
pub trait Base: Scheme<Holds = Keys> {
    /// The contract of the k-buffer made of it.
    const SELECTED: Contract;
}

/// What resolve keeps of an A-buffer.
pub trait Choice<A>: Send + Sync + 'static {
    /// The contract of the result.
    const CONTRACT: Contract;
    /// Keep k of the keys from number `first` on, which are those of one pixel.
    fn cut(keys: &mut Keys, first: usize, k: usize);
}

/// The k nearest.
#[derive(Debug)]
pub enum Nearest {}

/// M7: the first k of the list, whichever they are.
#[derive(Debug)]
pub enum First {}

impl<A: Base> Choice<A> for Nearest {
    const CONTRACT: Contract = A::SELECTED;

    fn cut(keys: &mut Keys, first: usize, k: usize) {
        select::nearest(keys, first, k);
    }
}

impl Choice<AbLinkedList> for First {
    const CONTRACT: Contract = AbLinkedList::<ab_ll::Correct>::SELECTED.fault(
        "kb-ab-ll@M7",
        "Fault M7: resolve takes the first k of the list instead of the nearest k",
        "f(p) <= k",
    );

    fn cut(keys: &mut Keys, first: usize, k: usize) {
        keys.truncate(first + k);
    }
}

/// The method.
#[derive(Debug)]
pub struct KbAb<A, C = Nearest> {
    k: u32,
    all: A,
    choice: PhantomData<C>,
}

/// The contract of a k-buffer on an A-buffer.
const fn selected(
    name: &'static str,
    title: &'static str,
    section: &'static str,
    frame_words: &'static str,
    of: Contract,
) -> Contract {
    Contract {
        title,
        paper: "Yu, Yang, Hensley, Harada, Yu 2012; Vasilakis, Fudos 2014",
        section,
        program: of.program,
        words: of.words,
        frame_words,
        overflow: Overflow::Never("selected at resolve"),
        accounting: Accounting::Judged,
        needs: of.needs,
        wgsl: of.wgsl,
        demand: of.demand,
        source: of.source,
        ..Contract::new(name, Keeps::Nearest)
    }
}

impl Base for AbArray<AtomicAdd> {
    const SELECTED: Contract = selected(
        "kb-ab-array",
        "k nearest of an A-buffer in fixed arrays",
        "k+-buffer paper, 4 (KB-AB-Array)",
        "0",
        <Self as Scheme>::CONTRACT,
    );
}

impl Base for AbLinkedList<ab_ll::Correct> {
    const SELECTED: Contract = selected(
        "kb-ab-ll",
        "k nearest of an A-buffer in linked lists",
        "k+-buffer paper, 2 (KB-AB-LL)",
        "3F + 1",
        <Self as Scheme>::CONTRACT,
    );
}

impl Base for SBuffer<s_buffer::Correct> {
    const SELECTED: Contract = selected(
        "kb-ab-sb",
        "k nearest of an S-buffer",
        "k+-buffer paper, 4 (KB-AB-SB)",
        "2F + G + H",
        <Self as Scheme>::CONTRACT,
    );
}

impl<A: Base, C: Choice<A>> Scheme for KbAb<A, C> {
    const CONTRACT: Contract = C::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let all = Config { k: None, bounded: config.generated, ..*config };
        Self { k: config.k.unwrap_or(8), all: A::new(&all, layout), choice: PhantomData }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.all.clear_frame(Inside::<_, Self>::of(mem)).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.all.clear(Inside::<_, Self>::of(mem), pixel).await;
    }

    async fn prepare<M: Memory>(&self, mem: &M, pass: usize, fragment: Fragment) {
        self.all.prepare(Inside::<_, Self>::of(mem), pass, fragment).await;
    }

    fn counts(&self, pass: usize) -> Option<Words<Pixel, Atomic, u32>> {
        self.all.counts(pass)
    }

    async fn screen<M: Memory>(&self, mem: &M, pass: usize, pixel: u32) {
        self.all.screen(Inside::<_, Self>::of(mem), pass, pixel).await;
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.all.invocations(pass)
    }

    async fn frame<M: Memory>(&self, mem: &M, pass: usize, index: u32) {
        self.all.frame(Inside::<_, Self>::of(mem), pass, index).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        self.all.store(Inside::<_, Self>::of(mem), fragment).await
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        self.all.store_block(block, batch, outcomes)
    }

    fn together(&self) -> usize {
        self.all.together()
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        self.all.invariant(words, pixel, moment)
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let first = keys.len();
        self.all.resolve(Inside::<_, Self>::of(mem), pixel, keys).await;
        C::cut(keys, first, self.k as usize);
    }
}
