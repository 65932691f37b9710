//! How passes run: the executors of the invocations of clear, store and resolve.
//!
//! * [`tile`]: tiles in parallel; each worker owns its tile's pixels (exclusive memory), and resolves them while they
//!   are in its cache.
//! * [`threads`]: rasterizer threads hand packets to worker threads that contend on shared atomics, even for the same
//!   pixel.
//! * [`sim`]: one thread steps resident invocations, one memory operation at a time, as a policy decides.
//! * [`oracle`]: the exact reference, which is not a scheme.
//!
//! All four give the same [`Frame`], and every one of them accounts for every fragment ([`account`]). The method's
//! [`Course`] says what runs when. A barrier for the whole frame separates stages. The exception is `tile`: for a
//! method that needs no more, the barrier separates only the stages of each tile, since a tile's passes share only
//! pixel storage, and pools whose nodes no other tile reads.
//!
//! A scheme comes as a [`Method`], and an executor sees it through a [`drive::Pipeline`]: compiled for its memory, or
//! [interpreted](interpret).

pub mod account;
pub mod clock;
pub mod drive;
pub mod frame;
pub mod interpret;
pub mod kit;
pub mod method;
pub mod one_pixel;
pub mod oracle;
pub mod promise;
pub mod sim;
pub mod table;
pub mod threads;
pub mod tile;

use crate::fragment::sort::Sort;
use crate::memory::Inputs;
use crate::raster::{Batch, FrontEnd, Record};
use crate::scheme::bound::Bound;
use crate::scheme::course::Course;
use crate::scheme::program::PassKind;
use crate::scheme::{Contract, HeldKind, Keeps};

pub use account::Tally;
pub use frame::Frame;
pub use kit::Kit;
pub use method::{Instance, Method};

/// What is drawn: the same for every executor.
#[derive(Debug)]
pub struct Job<'a> {
    /// The scene's primitives.
    pub front: &'a FrontEnd,
    /// What a fragment's words hold.
    pub record: Record,
    /// How a pixel's fragments are sorted.
    pub sort: Sort,
    /// Linear 16-bit RGB.
    pub background: [u16; 3],
    /// The number of nearest fragments that the method promises to keep.
    pub nearest: Bound,
    /// What the method promises, and which passes it has.
    pub contract: &'static Contract,
    /// Which stages a frame has.
    pub course: Course,
    /// What a pixel holds after resolve.
    pub holds: HeldKind,
    /// The words of the method's inputs.
    pub inputs: Inputs,
    /// Fragments in all tiles before each tile, and at the end in all tiles, if they were counted; otherwise empty.
    pub before_tile: Vec<u64>,
    /// Whether pools have room for every fragment: nothing limits them.
    pub whole_pools: bool,
    /// Worker threads.
    pub threads: usize,
    /// Transmittance below which nothing behind can be seen, where a method culls early.
    pub opaque: u16,
    /// By storage pixel, the depth word behind which fragments do not reach the scheme; empty: all of them do.
    pub culling: Vec<u32>,
    /// Whether lists go as soon as they are composited: nobody wants more than the picture.
    pub picture_only: bool,
    /// What the frames before have left for this one.
    pub kit: &'a Kit,
}

impl Job<'_> {
    /// Whether fragments are kept from a pass of the program: those behind their pixel's bound. A method that chooses
    /// k by the number of fragments counts all of them.
    #[must_use]
    pub fn culls(&self, pass: usize) -> bool {
        let kind = self.contract.program.passes[pass].kind;
        let counts = kind == PassKind::Prepare && self.contract.keeps == Keeps::NearestChosen;
        !self.culling.is_empty() && !counts
    }

    /// Leave out of a batch what does not reach such a pass, and give the bits of that.
    #[inline]
    pub fn cull(&self, batch: &mut Batch) -> u64 {
        batch.reject(|f| f.depth > self.culling[f.pixel as usize])
    }
}
