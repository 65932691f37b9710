//! Merging in resolve: a dynamic fragment buffer (`dfb`) with the near end of every slab, whose resolve sorts a pixel's
//! fragments and merges them.
//!
//! `dfb+sfm` merges smoothly, in depth order, by Algorithm 1; what has no room goes behind the last record by OVER.
//! `dfb+ofm` merges by overlap alone: what `skb+ofm` would give if it had room for everything. Both are functions of a
//! pixel's fragments.
//!
//! The form `@released` is that of the authors' shaders: visibilities are stored as four bytes, and β counts for the
//! front part of a cut slab alone.

use std::marker::PhantomData;

use super::components::{Stored, add, components, with_tail};
use super::slab::{Slab, merge_sorted};
use super::sums::{Integers, Logarithms, logarithms};
use super::{Blending, merging};
use crate::fragment::{Fragment, data_of, depth_of};
use crate::memory::{Atomic, Global, Inputs, Inside, Layout, Memory, Pixel, Plain, Words};
use crate::num::planes::Distances;
use crate::scheme::a_buffer::dfb::DynamicFragmentBuffer;
use crate::scheme::contract::{Form, Overflow};
use crate::scheme::parts::ranges;
use crate::scheme::{Config, Contract, Outcome, Record, Records, Scale, Scheme, Whole};

/// What resolve makes of a pixel's fragments.
pub trait Merge: Send + Sync + Sized + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// Slabs that touch overlap, and so may surfaces.
    const CLOSED: bool = false;

    /// From the configuration.
    fn new(config: &Config) -> Self;

    /// Add the records, at most `most`, of slabs in canonical order.
    fn merge(&self, slabs: &[Stored], most: u32, out: &mut Records);

    /// Add those that it is held to.
    fn promised(&self, slabs: &[Stored], most: u32, out: &mut Records) {
        self.merge(slabs, most, out);
    }
}

/// The method.
#[derive(Debug)]
pub struct DfbMerged<M> {
    store: DynamicFragmentBuffer,
    near: Words<Global, Plain, u32>,
    /// The most records of a pixel.
    most: u32,
    distances: Distances,
    merge: M,
}

const CONTRACT: Contract = {
    let counted = ranges::counted("", crate::scheme::Keeps::Merged);
    Contract {
        words: "3",
        frame_words: "3S + G + H",
        program: counted.program,
        needs: counted.needs,
        wgsl: None,
        demand: counted.demand,
        ties: "canonical: the smaller data word is nearer",
        overflow: Overflow::Drops("beyond 1024 at a pixel, drop by arrival, counted"),
        source: include_str!("dfb_merged.rs"),
        ..merging("")
    }
};

impl<M: Merge> Scheme for DfbMerged<M> {
    const CONTRACT: Contract = M::CONTRACT;

    type Holds = Records;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let store = DynamicFragmentBuffer::new(config, layout);
        let near = layout.named("near").global(config.bounded);
        let (most, distances) = (config.k.unwrap_or(8), config.distances);
        Self { store, near, most, distances, merge: M::new(config) }
    }

    async fn clear_frame<Mem: Memory>(&self, mem: &Mem) {
        self.store.clear_frame(&Inside::<_, Self>::new(mem)).await;
    }

    async fn clear<Mem: Memory>(&self, mem: &Mem, pixel: u32) {
        self.store.clear(&Inside::<_, Self>::new(mem), pixel).await;
    }

    async fn prepare<Mem: Memory>(&self, mem: &Mem, pass: usize, fragment: Fragment) {
        self.store.prepare(&Inside::<_, Self>::new(mem), pass, fragment).await;
    }

    fn counts(&self, pass: usize) -> Option<Words<Pixel, Atomic, u32>> {
        self.store.counts(pass)
    }

    async fn screen<Mem: Memory>(&self, mem: &Mem, pass: usize, pixel: u32) {
        self.store.screen(&Inside::<_, Self>::new(mem), pass, pixel).await;
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.store.invocations(pass)
    }

    async fn frame<Mem: Memory>(&self, mem: &Mem, pass: usize, index: u32) {
        self.store.frame(&Inside::<_, Self>::new(mem), pass, index).await;
    }

    /// Whatever it is merged with later, a fragment is stored: resolve counts what it merges.
    async fn store<Mem: Memory>(&self, mem: &Mem, fragment: Fragment) -> Outcome {
        match self.store.place::<_, Self>(mem, fragment.pixel).await {
            Ok(record) => {
                mem.plain_store(self.store.records().at(record), fragment.key()).await;
                mem.plain_store(self.near.at(record), fragment.extra).await;
                Outcome::Kept
            }
            Err(outcome) => outcome,
        }
    }

    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Records> {
        let mut records = Records { scale: Scale(self.distances), ..Records::default() };
        self.merge.promised(&stored(generated), self.most, &mut records);
        Some(records)
    }

    async fn resolve<Mem: Memory>(&self, mem: &Mem, pixel: u32, out: &mut Records) {
        let range = self.store.range(&Inside::<_, Self>::new(mem), pixel).await;
        // Where the pool is too small, a range may begin behind its end: it is empty.
        let length = range.end.saturating_sub(range.start) as usize;
        for record in range {
            let key = mem.plain_load(self.store.records().at(record)).await;
            let near = mem.plain_load(self.near.at(record)).await;
            if near < depth_of(key) || M::CLOSED {
                // Room for all at once, and none where all are surfaces.
                out.wholes.reserve(length - out.wholes.len());
                out.wholes.push(Whole { key, near });
            } else {
                out.surfaces.push(key);
            }
        }
        self.reduce(out);
    }
}

impl<M: Merge> DfbMerged<M> {
    /// Merge a pixel's fragments. Where all lie apart, each stays a record as long as there is room: the last record is
    /// for all that have none. A surface overlaps nothing.
    #[inline]
    fn reduce(&self, out: &mut Records) {
        let most = self.most as usize;
        if out.wholes.is_empty() && out.surfaces.len() <= most {
            return;
        }
        out.scale = Scale(self.distances);
        if out.wholes.is_empty() {
            out.surfaces.sort_unstable();
            let rest = out.surfaces.drain(most - 1..).map(|key| Whole::surface(key).into());
            let rest: Vec<Stored> = rest.collect();
            return self.merge_rest(&rest, 1, out);
        }
        out.unite();
        out.wholes.sort_unstable();
        let apart = |two: &[Whole]| depth_of(two[0].key) <= two[1].near;
        let apart = !M::CLOSED && out.wholes.windows(2).all(apart);
        let (stay, room) = match apart {
            true if out.wholes.len() <= most => return,
            true => (most - 1, 1),
            false => (0, most),
        };
        let mut rest: Vec<Stored> = out.wholes.drain(stay..).map(Stored::from).collect();
        rest.sort_unstable();
        self.merge_rest(&rest, room, out);
    }

    /// Out of line, so that pixels where nothing merges do not carry it.
    #[inline(never)]
    fn merge_rest(&self, rest: &[Stored], room: usize, out: &mut Records) {
        self.merge.merge(rest, room as u32, out);
    }
}

impl From<Whole> for Stored {
    fn from(Whole { key, near }: Whole) -> Self {
        Self { depth: depth_of(key), data: data_of(key), near }
    }
}

/// Fragments in canonical order, as they are stored.
pub(super) fn stored(generated: &[Fragment]) -> Vec<Stored> {
    let slab = |f: &Fragment| Stored { depth: f.depth, data: f.data, near: f.extra };
    generated.iter().map(slab).collect()
}

/// By overlap.
#[derive(Debug)]
pub struct Overlapping {
    distances: Distances,
    logarithms: Box<Logarithms>,
}

impl Merge for Overlapping {
    const CONTRACT: Contract = Contract {
        name: "dfb+ofm",
        title: "dynamic fragment buffer; resolve merges overlapping slabs, whatever their order",
        section: "3.2.2, 3.3.2; the components of the overlap are ours",
        exact_when: "k >= f(p) and no slabs overlap",
        wgsl: ranges::counted("", crate::scheme::Keeps::Merged).wgsl,
        ..CONTRACT
    };

    fn new(config: &Config) -> Self {
        Self { distances: config.distances, logarithms: logarithms() }
    }

    fn merge(&self, slabs: &[Stored], most: u32, out: &mut Records) {
        let all = components::<Integers>(slabs, &self.logarithms);
        let all = with_tail::<Integers>(all, most);
        all.iter().for_each(|merged| add::<Integers>(out, merged, &self.distances));
    }
}

/// How a form of smooth merging differs from the right one.
pub trait Smoothing: Send + Sync + Sized + 'static {
    /// What it promises.
    const CONTRACT: Contract;

    /// How slabs are put together; β is the run's.
    const BLENDING: Blending;
}

/// Smoothly, in depth order.
#[derive(Debug)]
pub struct Smooth<S = Correct> {
    distances: Distances,
    blending: Blending,
    form: PhantomData<S>,
}

impl<S: Smoothing> Merge for Smooth<S> {
    const CONTRACT: Contract = S::CONTRACT;
    const CLOSED: bool = S::BLENDING.closed;

    fn new(config: &Config) -> Self {
        let blending = Blending { beta: config.merging.beta, ..S::BLENDING };
        Self { distances: config.distances, blending, form: PhantomData }
    }

    fn merge(&self, slabs: &[Stored], most: u32, out: &mut Records) {
        self.merge_by(&self.blending, slabs, most, out);
    }

    /// A fault is held to what the right form gives.
    fn promised(&self, slabs: &[Stored], most: u32, out: &mut Records) {
        let right = Blending { beta: self.blending.beta, ..RIGHT };
        let faulty = S::CONTRACT.form == Form::Mutation;
        self.merge_by(if faulty { &right } else { &self.blending }, slabs, most, out);
    }
}

impl<S> Smooth<S> {
    fn merge_by(&self, blending: &Blending, slabs: &[Stored], most: u32, out: &mut Records) {
        let mut all: Vec<Slab> = Vec::new();
        let sorted = slabs.iter().map(|s| Slab::of(&self.distances, s.depth, s.near, s.data));
        merge_sorted(sorted, most as usize, blending, &mut all);
        out.list.extend(all.iter().map(Record::from));
        out.merged += (slabs.len() - all.len()) as u32;
    }
}

/// As it must be.
const RIGHT: Blending = Blending {
    beta: 1.0,
    closed: false,
    front_only: false,
    eight_bits: false,
    mixed_tail: false,
    squared: false,
};

const SMOOTH: Contract = Contract {
    name: "dfb+sfm",
    title: "dynamic fragment buffer; resolve merges overlapping slabs smoothly",
    section: "3.2.1, 3.3, 4.3, Algorithm 1",
    exact_when: "k >= f(p) and no slabs overlap",
    ..CONTRACT
};

macro_rules! smoothings {
    ($($(#[$doc:meta])* $name:ident: $contract:expr, $blending:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name;

        impl Smoothing for $name {
            const CONTRACT: Contract = $contract;
            const BLENDING: Blending = $blending;
        }
    )*};
}

const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract { name, title, form: Form::Mutation, ..SMOOTH }
}

smoothings! {
    /// The method.
    Correct: SMOOTH, RIGHT;
    /// As in the authors' shaders.
    Released: Contract {
        name: "dfb+sfm@released",
        title: "as the authors' shaders: four bytes, and beta for the front part alone",
        section: "the authors' shaders",
        form: Form::Published,
        ..SMOOTH
    }, Blending { eight_bits: true, front_only: true, ..RIGHT };
    /// Four bytes in mid-stream.
    EightBits: fault("dfb+sfm@M15", "Fault M15: visibilities are rounded to 8 bits in mid-stream"),
        Blending { eight_bits: true, ..RIGHT };
    /// Slabs that touch are merged.
    Closed: fault("dfb+sfm@closed", "Fault closed: slabs that only touch are merged"),
        Blending { closed: true, ..RIGHT };
    /// β on one part only.
    FrontOnly: fault("dfb+sfm@front-beta", "Fault front-beta: beta counts for the front part alone"),
        Blending { front_only: true, ..RIGHT };
    /// Thickness squared instead of split.
    Squared: fault("dfb+sfm@squared", "Fault squared: shares of the thickness are squared"),
        Blending { squared: true, ..RIGHT };
    /// The tail is mixed where OVER is due.
    MixedTail: fault("dfb+sfm@mixed-tail", "Fault mixed-tail: the tail is mixed, not put behind"),
        Blending { mixed_tail: true, ..RIGHT };
}
