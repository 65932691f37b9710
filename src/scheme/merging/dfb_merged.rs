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

use super::components::{Stored, components, put_all, with_tail};
use super::slab::{Slab, merge_sorted};
use super::sums::{Integers, Logarithms, logarithms};
use super::{Blending, merging};
use crate::fragment::sort::Sort;
use crate::fragment::{Fragment, data_of, depth_of};
use crate::memory::{Atomic, Global, Inputs, Inside, Layout, Memory, Pixel, Plain, Words};
use crate::num::planes::Distances;
use crate::num::ray::Ray;
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

    /// Add the records, at most `most`, of slabs in canonical order. `before` are those in front that stay as they are.
    fn merge(&self, before: &[Stored], slabs: &[Stored], most: u32, out: &mut Records);

    /// Add those that it is held to, of all slabs.
    fn promised(&self, slabs: &[Stored], most: u32, out: &mut Records) {
        self.merge(&[], slabs, most, out);
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
        self.store.clear_frame(Inside::<_, Self>::of(mem)).await;
    }

    async fn clear<Mem: Memory>(&self, mem: &Mem, pixel: u32) {
        self.store.clear(Inside::<_, Self>::of(mem), pixel).await;
    }

    async fn prepare<Mem: Memory>(&self, mem: &Mem, pass: usize, fragment: Fragment) {
        self.store.prepare(Inside::<_, Self>::of(mem), pass, fragment).await;
    }

    fn counts(&self, pass: usize) -> Option<Words<Pixel, Atomic, u32>> {
        self.store.counts(pass)
    }

    async fn screen<Mem: Memory>(&self, mem: &Mem, pass: usize, pixel: u32) {
        self.store.screen(Inside::<_, Self>::of(mem), pass, pixel).await;
    }

    fn invocations(&self, pass: usize) -> u32 {
        self.store.invocations(pass)
    }

    async fn frame<Mem: Memory>(&self, mem: &Mem, pass: usize, index: u32) {
        self.store.frame(Inside::<_, Self>::of(mem), pass, index).await;
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
        let mut records = Records::at(Scale(self.distances));
        self.merge.promised(&stored(generated), self.most, &mut records);
        Some(records)
    }

    async fn resolve<Mem: Memory>(&self, mem: &Mem, pixel: u32, out: &mut Records) {
        out.scale = Scale(self.distances);
        let range = self.store.range::<_, Self>(mem, pixel).await;
        // Where the pool is too small, a range may begin behind its end: it is empty.
        let first = out.spread(range.end.saturating_sub(range.start) as usize);
        let mut surfaces = !M::CLOSED;
        for (place, record) in (first..).zip(range) {
            let key = mem.plain_load(self.store.records().at(record)).await;
            let near = mem.plain_load(self.near.at(record)).await;
            out.put(place, Whole { key, near });
            surfaces &= near >= depth_of(key);
        }
        self.reduce(out, first, surfaces);
    }
}

impl<M: Merge> DfbMerged<M> {
    /// Merge a pixel's fragments, which are the records from `first` on. Where all lie apart, each stays a record as long
    /// as there is room: the last record is for all that have none. `surfaces` overlap nothing.
    #[inline]
    fn reduce(&self, out: &mut Records, first: usize, surfaces: bool) {
        let (most, places) = (self.most as usize, first..out.len());
        if surfaces && places.len() <= most {
            return;
        }
        out.arrange(places.clone(), |keys| Sort::Fastest.keys(keys));
        let apart = surfaces || (!M::CLOSED && out.are_apart(places.clone()));
        if !apart || places.len() > most {
            self.merge_rest(out, first, if apart { most - 1 } else { 0 });
        }
    }

    /// Merge all but the first `stay`. Out of line, so that pixels where nothing merges do not carry it.
    #[inline(never)]
    fn merge_rest(&self, out: &mut Records, first: usize, stay: usize) {
        let all = (first..out.len()).map(|place| out.single(place).into());
        let mut before: Vec<Stored> = all.collect();
        let mut rest = before.split_off(stay);
        rest.sort_unstable();
        out.truncate(first + stay);
        self.merge.merge(&before, &rest, self.most - stay as u32, out);
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

    fn merge(&self, _: &[Stored], slabs: &[Stored], most: u32, out: &mut Records) {
        let all = components::<Integers>(slabs, &self.logarithms);
        let all = with_tail::<Integers>(all, most);
        put_all::<Integers>(out, &all, &self.distances);
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

    fn merge(&self, before: &[Stored], slabs: &[Stored], most: u32, out: &mut Records) {
        self.merge_by(&self.blending, before, slabs, most, out);
    }

    /// A fault is held to what the right form gives.
    fn promised(&self, slabs: &[Stored], most: u32, out: &mut Records) {
        let right = Blending { beta: self.blending.beta, ..RIGHT };
        let faulty = S::CONTRACT.form == Form::Mutation;
        self.merge_by(if faulty { &right } else { &self.blending }, &[], slabs, most, out);
    }
}

impl<S> Smooth<S> {
    fn merge_by(
        &self,
        blending: &Blending,
        before: &[Stored],
        slabs: &[Stored],
        most: u32,
        out: &mut Records,
    ) {
        let mut all: Vec<Slab> = Vec::new();
        let sorted = slabs.iter().map(|s| Slab::of(&self.distances, s.depth, s.near, s.data));
        merge_sorted(sorted, most as usize, blending, &mut all);
        let mut records: Vec<Record> = all.iter().map(Record::from).collect();
        let apart = |all: &[Stored]| !all.iter().any(Stored::is_thick);
        let exact = !(blending.eight_bits || blending.mixed_tail || blending.closed);
        if let [.., tail] = &mut records[..]
            && slabs.len() > most as usize
            && exact
            && apart(before)
            && apart(slabs)
        {
            let (front, behind) = slabs.split_at(most as usize - 1);
            tail.rgba = behind_surfaces(before.iter().chain(front), behind).unwrap_or(tail.rgba);
        }
        out.merged += (slabs.len() - all.len()) as u32;
        records.into_iter().for_each(|record| out.push(record));
    }
}

/// What surfaces look like together, behind others, if they are composited one by one: so that where nothing is thick,
/// a tail looks as its fragments do, to the last bit. `None` if no light passes the others.
fn behind_surfaces<'a>(
    front: impl Iterator<Item = &'a Stored>,
    behind: &[Stored],
) -> Option<[f64; 4]> {
    let mut before = Ray::default();
    front.for_each(|surface| before.over(surface.data));
    let mut ray = before;
    behind.iter().for_each(|surface| ray.over(surface.data));
    let light = f64::from(before.transmittance);
    let share = |part: u32| f64::from(part) / light;
    let [r, g, b] = [0, 1, 2].map(|i| share(ray.color[i] - before.color[i]));
    let opacity = share(before.transmittance - ray.transmittance);
    (before.transmittance > 0).then_some([r, g, b, opacity])
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
