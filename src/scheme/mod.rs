//! The multi-fragment schemes: a folder per family, one file per method, each written once for every memory.
//!
//! A scheme is invocations on memory. It declares its words ([`Layout`]), and then says what one invocation of each
//! pass does: [`Scheme::clear`] and [`Scheme::resolve`] once per pixel, [`Scheme::store`] once per fragment. Between
//! passes stands a barrier; within a pass, invocations run in any order and at the same time. What a scheme promises
//! is its [`Contract`], which the tests, the commands and the docs read. Adding a scheme is one file, and one line in
//! the catalogue.
//!
//! A frame is a clear pass, then one or more *rounds*. A round is the contract's [`program::Program`]: passes over
//! fragments, pixels or the frame's words, the last of which is the store pass; and resolve ([`course`]). Most methods
//! have the store pass only. Where the program repeats (depth peeling), another round follows as long as any pixel asks
//! for it in [`Scheme::again`], as in an application that reads an occlusion query.
//!
//! A folder uses only folders before it in this order, and the files beside them (`tests/layering.rs` checks that):
//!
//! `parts` → `a_buffer` → `k_buffer` → `kplus_buffer` → `peeling` → `hash_table` → `culling` → `merging` →
//! `approximate`

pub mod a_buffer;
pub mod approximate;
pub mod bound;
pub mod contract;
pub mod course;
pub mod culling;
pub mod exact;
pub mod hash_table;
pub mod held;
pub mod k_buffer;
pub mod kplus_buffer;
mod listed;
pub mod merging;
mod outcomes;
pub mod parts;
pub mod peeling;
pub mod program;
pub mod record;
pub mod records;
pub mod task;

use std::future::Future;

pub use contract::{Contract, Form, Keeps};
pub use held::{Depth, Held, HeldKind, Holds, Keys, Light};
pub use outcomes::Outcomes;
pub use record::{Record, Scale, Single, Whole};
pub use records::Records;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Global, Inputs, Layout, Memory, OwnedBlock, Pixel, Snapshot, Words};
use crate::num::planes::Distances;
use crate::raster::{Batch, Grid};

/// What a scheme is configured with. The scene's numbers are 0 unless the contract asks for them (`Contract::demand`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Config {
    /// Fragments kept per pixel, at least 1; `None` where the method keeps all or takes the scene's own bound.
    pub k: Option<u32>,
    /// Pixels with storage: indices of pixels are below this.
    pub pixels: u32,
    /// Fragments of one geometry pass over the scene.
    pub generated: u64,
    /// The largest number of fragments at any pixel.
    pub max_depth_complexity: u32,
    /// The sum over all pixels of their number of fragments, bounded by k where there is one.
    pub bounded: u64,
    /// Pages that hold all fragments of every pixel, by the contract's size of a page.
    pub pages: u64,
    /// Records that the method may divide among the pixels.
    pub records: u64,
    /// How a pixel's number of fragments becomes importance.
    pub weighting: kplus_buffer::k_variable::Weighting,
    /// Words of a pixel's occupancy mask, of 32 intervals each; 0 counts as 1.
    pub mask_words: u32,
    /// How depths stand for distances.
    pub distances: Distances,
    /// What merging must know of the run.
    pub merging: merging::Merging,
    /// What approximations must know of the run.
    pub approximation: approximate::Approximation,
    /// How pixels are numbered, for methods that must know where on the screen they are.
    pub grid: Grid,
    /// How hash tables are made.
    pub table: hash_table::table::TableSettings,
}

/// What became of a fragment, as far as its own invocation can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Outcome {
    /// Stored.
    #[default]
    Kept,
    /// Not stored: too far away.
    Culled,
    /// Stored; another fragment was displaced.
    Evicted,
    /// Not stored: no room in the pixel's own storage.
    Overflow,
    /// Not stored: no room in the frame's pool.
    Pool,
    /// Not stored: it is already there, with the same pixel, depth and data.
    Duplicate,
    /// Not stored: beyond the largest age of a hash table, or the table is full. What is not stored may be another
    /// fragment than the invocation's own, also of another pixel.
    Age,
    /// It went into another record, or into its pixel's colour. (7 is what a device says of an invocation that gave up
    /// waiting.)
    Merged = 8,
}

/// Words of the frame that the application reads back after the frame: a hash table's cells.
#[derive(Clone, Copy, Debug)]
pub struct Readback {
    /// Cells across and down.
    pub size: [u32; 2],
    /// The bit of a cell at which its age begins.
    pub age_bit: u32,
    /// The cells, row by row.
    pub cells: Cells,
}

/// Words of either width.
#[derive(Clone, Copy, Debug)]
pub enum Cells {
    /// Of 32 bits.
    Words32(Words<Global, Atomic, u32>),
    /// Of 64 bits.
    Words64(Words<Global, Atomic, u64>),
}

/// When an invariant is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// Between any two operations of the store pass.
    Always,
    /// At the barrier after it.
    Quiet,
}

/// A multi-fragment method.
pub trait Scheme: Send + Sync + Sized + 'static {
    /// What it promises.
    const CONTRACT: Contract;

    /// What a pixel holds after resolve: [`Keys`], [`Records`], [`Light`] or [`Depth`].
    type Holds: Holds;

    /// Declare the words and keep their addresses.
    fn new(config: &Config, layout: &mut Layout) -> Self;

    /// Before anything else, one invocation for the whole frame.
    fn clear_frame<M: Memory>(&self, mem: &M) -> impl Future<Output = ()> {
        let _ = mem;
        std::future::ready(())
    }

    /// Clear pass, one invocation per pixel. Words it does not write hold anything.
    fn clear<M: Memory>(&self, mem: &M, pixel: u32) -> impl Future<Output = ()>;

    /// An earlier geometry pass, number `pass` of the program, one invocation per fragment.
    fn prepare<M: Memory>(
        &self,
        mem: &M,
        pass: usize,
        fragment: Fragment,
    ) -> impl Future<Output = ()> {
        let _ = (mem, pass, fragment);
        std::future::ready(())
    }

    /// The words to the first of which, at its pixel, an earlier geometry pass adds 1 for every fragment, if that is all
    /// it does. An executor that knows a pixel's number of fragments may then add them at once.
    fn counts(&self, pass: usize) -> Option<Words<Pixel, Atomic, u32>> {
        let _ = pass;
        None
    }

    /// A full-screen pass, number `pass` of the program, one invocation per pixel.
    fn screen<M: Memory>(&self, mem: &M, pass: usize, pixel: u32) -> impl Future<Output = ()> {
        let _ = (mem, pass, pixel);
        std::future::ready(())
    }

    /// A pass over the frame's words, number `pass` of the program: the invocation `index` of [`Self::invocations`].
    fn frame<M: Memory>(&self, mem: &M, pass: usize, index: u32) -> impl Future<Output = ()> {
        let _ = (mem, pass, index);
        std::future::ready(())
    }

    /// How many invocations a pass over the frame's words has.
    fn invocations(&self, pass: usize) -> u32 {
        let _ = pass;
        0
    }

    /// Store pass, one invocation per fragment. Where the program repeats, what it says of a fragment in the last
    /// round is what became of it.
    fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> impl Future<Output = Outcome>;

    /// Store a block's fragments at once, if that is known to be faster: the words and the outcomes are those of
    /// [`Self::store`] for one after another, from the lowest bit on. No other invocation reaches the block's words
    /// meanwhile. Where an invocation may end with another one's fragment
    /// ([`Accounting::Crossing`](contract::Accounting::Crossing)), as many fragments have each outcome; which of them
    /// may differ, and if one is dropped, so may words on which nothing that is kept depends. Gives whether it did so;
    /// if not, nothing has changed.
    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        let _ = (block, batch, outcomes);
        false
    }

    /// 0 if a tile stores in the order of primitives. Otherwise it stores one block after another, each with the
    /// fragments of all primitives, and of at most so many primitives at once ([`Self::store_together`]). Every pixel's
    /// fragments come in the order of primitives in either case, but indices of pools go to other fragments. Where a pool
    /// may be too small, that would decide what is dropped, and a tile stores in the order of primitives all the same.
    fn together(&self) -> usize {
        0
    }

    /// Store a block's fragments of several primitives at once: for each batch, the outcomes of its fragments. Words and
    /// outcomes are those of [`Self::store`], as of [`Self::store_block`]. Gives whether it did so; if not, nothing has
    /// changed, and each batch is stored by itself.
    fn store_together(
        &self,
        block: &OwnedBlock<'_>,
        batches: &[Batch],
        outcomes: &mut [Outcomes],
    ) -> bool {
        let _ = (block, batches, outcomes);
        false
    }

    /// What must be true of a pixel's words, beyond what every method promises; checks look at it in every state.
    ///
    /// # Errors
    /// What is wrong, in words that name the fault.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let _ = (words, pixel, moment);
        Ok(())
    }

    /// Which pixel's invariant depends on the value written to one of the frame's words, by its place among those of
    /// its width; `None` if no pixel's does.
    fn owner(&self, bits: u32, word: u64, value: u64) -> Option<u32> {
        let _ = (bits, word, value);
        None
    }

    /// What the application reads back after a frame.
    fn readback(&self) -> Option<Readback> {
        None
    }

    /// What a pixel must hold, given all its fragments in canonical order (ranks are 0): a reference that is verified by reading,
    /// with no invocations in it. `None` where the contract says all: the exact fragments, or the nearest of them. A
    /// method that merges or approximates is held to this one; where its result depends on arrival, it must give `None`.
    fn expected(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Option<Self::Holds> {
        let _ = (inputs, pixel, generated);
        None
    }

    /// Where the result depends on arrival: all that a pixel may hold, one for each order of arrival, by a reference as
    /// above. Empty where [`Self::expected`] says it, where there are too many orders, and of a method that does not say.
    fn possible(&self, inputs: &Inputs, pixel: u32, generated: &[Fragment]) -> Vec<Self::Holds> {
        let _ = (inputs, pixel, generated);
        Vec::new()
    }

    /// How many of its nearest fragments every pixel must keep, given how many each has: a reference as above, for a
    /// method that chooses by itself ([`Keeps::NearestChosen`]). Others are not asked.
    fn chosen(&self, inputs: &Inputs, counts: &[u32]) -> Vec<u32> {
        let _ = inputs;
        counts.to_vec()
    }

    /// Resolve pass, one invocation per pixel: add what the pixel holds to `held`, lists in any order. A list may have
    /// the entries of other pixels already, which must stay as they are.
    fn resolve<M: Memory>(
        &self,
        mem: &M,
        pixel: u32,
        held: &mut Self::Holds,
    ) -> impl Future<Output = ()>;

    /// At the end of a pixel's resolve, where the program repeats: whether it needs another round.
    fn again<M: Memory>(&self, mem: &M, pixel: u32) -> impl Future<Output = bool> {
        let _ = (mem, pixel);
        std::future::ready(false)
    }
}
