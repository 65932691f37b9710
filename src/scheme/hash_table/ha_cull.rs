//! HA-buffer with early culling (Lefebvre, Hornus, Lasram 2013, section 5): a walk that passes enough opaque fragments
//! of its own pixel ends, since its fragment cannot be seen.
//!
//! A walk meets its pixel's fragments front to back, and lets light pass them one by one. The paper says that this is
//! conservative. As published it is not: while invocation A walks from age i to i + 1, another may put a fragment at
//! age i and move the one that A has just counted to i + 1, where A counts it a second time (claim C11). And with equal
//! depths, "in front" is the order of data words, which need not be that of blending.
//!
//! Here a fragment is counted only if it is strictly nearer, and comes after all that were counted before, in the
//! table's order (depth, then the larger data word). So none is counted twice, and what is counted is a part of what is
//! really in front. A part lets no less light pass than the whole, also in fixed point
//! ([`crate::scheme::parts::visible`]): a culled fragment cannot be seen, under any interleaving.
//!
//! Which of the hidden fragments are culled depends on which come first; what can be seen does not.
//!
//! The published loop ends after `MAX_ITER` turns at the latest. Ours ends by itself, since cells only grow.

use std::marker::PhantomData;

use super::ha::{self, Bits64, HaBuffer, Record};
use super::table::Table;
use crate::fragment::{Data, Fragment, depth_of};
use crate::memory::{Event, Inside, Layout, Memory, Order, Snapshot};
use crate::num::depth::Format;
use crate::scheme::contract::{Alike, Dependence, Form, Keeps};
use crate::scheme::parts::visible::{CLEAR, behind};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Readback, Scheme};

/// A form of the method.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether a fragment is counted only if it is strictly nearer and was not counted before.
    const ONCE: bool = true;
    /// Whether the age grows at the end of every turn, whatever happened in it.
    const BRACES: bool = false;
}

/// Conservative under every interleaving.
#[derive(Debug)]
pub enum Correct {}

/// As published, by the prose.
#[derive(Debug)]
pub enum Published {}

/// As the listing's braces have it: the age grows once more after every insertion, so that ages are left out.
#[derive(Debug)]
pub enum Braces {}

/// The method.
#[derive(Debug)]
pub struct HaCull<V = Correct> {
    base: HaBuffer<Bits64>,
    opaque: u32,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "HA-buffer that culls what is behind opaque fragments",
    paper: "Lefebvre, Hornus, Lasram 2013",
    section: "HA-buffer paper, 5",
    program: ha::PROGRAM,
    exact_when: "for what is seen; all, where no opacity reaches the threshold",
    depth_format: Some(Format::D24),
    depth_bits: 24,
    data: Some(Data::Color),
    source: include_str!("ha_cull.rs"),
    alike: Alike::Once,
    dependence: Dependence::Arrival,
    ties: super::TIES,
    ..super::hashed("ha64-cull", Keeps::Visible)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Published {
    const CONTRACT: Contract = Contract {
        name: "ha64-cull@published",
        title: "HA-buffer with early culling as published: a fragment may be counted twice",
        form: Form::Published,
        exact_when: "no two invocations overlap",
        dependence: CONTRACT.dependence.racy(),
        ..CONTRACT
    };
    const ONCE: bool = false;
}

impl Variant for Braces {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64-cull@braces",
        "Fault braces: the age grows at the end of every turn, as the listing's braces have it",
        "no record is displaced",
    );
    const ONCE: bool = false;
    const BRACES: bool = true;
}

/// What is known to be in front of the carried fragment.
#[derive(Clone, Copy)]
struct Front {
    light: u32,
    /// The last that was counted, in the table's order, where more is nearer.
    last: u64,
}

impl Front {
    const NOTHING: Self = Self { light: CLEAR, last: u64::MAX };

    /// A fragment in front of the carried one.
    #[inline(always)]
    fn count<V: Variant>(&mut self, met: u64, own: u64) {
        let place = Bits64::pack(0, met);
        if !V::ONCE || (place < self.last && depth_of(met) < depth_of(own)) {
            self.light = behind(self.light, met as u32);
            self.last = place;
        }
    }
}

impl<V: Variant> HaCull<V> {
    #[inline(always)]
    fn table(&self) -> &Table<u64> {
        self.base.table()
    }
}

impl<V: Variant> Scheme for HaCull<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let opaque = config.table.opaque.into();
        Self { base: HaBuffer::new(config, layout), opaque, variant: PhantomData }
    }

    async fn clear<M: Memory>(&self, _mem: &M, _pixel: u32) {}

    fn invocations(&self, pass: usize) -> u32 {
        self.base.invocations(pass)
    }

    async fn frame<M: Memory>(&self, mem: &M, pass: usize, index: u32) {
        self.base.frame(Inside::<_, Self>::of(mem), pass, index).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let table = self.table();
        let (mut place, mut age, mut own) = (table.place(fragment.pixel), 1, fragment.key());
        let mut front = Front::NOTHING;
        let _walk = mem.block();
        loop {
            let step = mem.block();
            let Front { light, last } = front;
            mem.here(&[place[0].into(), place[1].into(), age.into(), own, light.into(), last]);
            if age > table.ages() {
                return Outcome::Age;
            }
            let (record, cell) = (Bits64::pack(age, own), table.cell(place, age));
            mem.note(Event::Probe);
            let old = mem.max(table.word(cell), record, Order::Relaxed).await;
            if old == record {
                return Outcome::Duplicate;
            }
            let theirs = Bits64::age(old);
            let inserted = mem.block();
            if old < record {
                mem.max(table.largest(place), age, Order::Relaxed).await;
                if old == 0 {
                    return Outcome::Kept;
                }
                mem.note(Event::Eviction);
                (place, own) = (table.origin(cell, theirs), Bits64::key(old));
                if theirs != age {
                    // It may be of another pixel.
                    front = Front::NOTHING;
                    age = theirs + 1;
                }
                // Else it is tried again at this age, where it meets the record that displaced it.
                age += u32::from(V::BRACES);
            } else {
                if theirs == age {
                    front.count::<V>(Bits64::key(old), own);
                    if front.light < self.opaque {
                        return Outcome::Culled;
                    }
                }
                age += 1;
            }
            mem.merge(inserted).await;
            mem.merge(step).await;
        }
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        self.base.invariant(words, pixel, moment)
    }

    fn owner(&self, bits: u32, word: u64, value: u64) -> Option<u32> {
        self.base.owner(bits, word, value)
    }

    fn readback(&self) -> Option<Readback> {
        self.base.readback()
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        self.base.resolve(Inside::<_, Self>::of(mem), pixel, keys).await;
    }
}
