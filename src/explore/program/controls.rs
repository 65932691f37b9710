//! Faults that a check must find, each in a form of one small method: what is wrong with it is not what it does with
//! fragments, but of a kind that a check could overlook. They are in the kill matrix, not in the catalogue: some of
//! them could not be drawn with.
//!
//! The method keeps the k nearest fragments in entries that are lowered by 64-bit atomic minima, as `kb-mdt64` does.

use std::sync::{Mutex, PoisonError};

use super::subject::Subject;
use crate::catalogue::Catalogue;
use crate::catalogue::faults::{Mutation, built_in};
use crate::error::Result;
use crate::exec::Method;
use crate::fragment::{Fragment, depth_of};
use crate::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Update, Words};
use crate::scheme::contract::Form;
use crate::scheme::{Config, Contract, Keeps, Keys, Outcome, Scheme};

/// What an entry holds while it is empty.
const EMPTY: u64 = u64::MAX;

/// Every form: its number, and its name.
macro_rules! forms {
    ($($form:ident = $name:literal,)*) => {
        forms!(@numbers 0; $($form)*);
        const NAMES: &[&str] = &[$($name,)*];
        const METHODS: &[Method] = &[$(Method::interpreted::<Control<$form>>(),)*];
    };
    (@numbers $number:expr; $form:ident $($rest:ident)*) => {
        const $form: usize = $number;
        forms!(@numbers $number + 1; $($rest)*);
    };
    (@numbers $number:expr;) => {};
}

forms! {
    RIGHT = "control",
    FORGETS = "control@forgets",
    SHARED_CLEAR = "control@shared-clear",
    SHARED_RESOLVE = "control@shared-resolve",
    UPPER_BITS = "control@upper-bits",
    AS_FLOAT = "control@as-float",
    DATA_ZERO = "control@data-zero",
    FOURTH = "control@fourth",
    NO_FRAGMENT = "control@no-fragment",
    LAZY = "control@lazy",
    LAZY_RELAXED = "control@lazy-relaxed",
    PANICS = "control@panics",
    ENDLESS = "control@endless",
    HOST_STATE = "control@host-state",
}

/// The faults, as `fragloom mutations` lists them.
pub const CONTROLS: &[Mutation] = &[
    built_in("forgets", "a word that clear forgets, and only resolve reads", &["control@forgets"]),
    built_in(
        "shared-word",
        "a clear or a resolve that goes through a word of all pixels",
        &["control@shared-clear", "control@shared-resolve"],
    ),
    built_in(
        "values",
        "depths compared by their upper 24 bits or as f32; a data word of 0 taken for none",
        &["control@upper-bits", "control@as-float", "control@data-zero"],
    ),
    built_in("fourth", "only the fourth entry is not atomic", &["control@fourth"]),
    built_in(
        "no-fragment",
        "a pixel without fragments returns what clear has left",
        &["control@no-fragment"],
    ),
    built_in(
        "lazy-relaxed",
        "the first invocation sets up the entries, and tells the others by a relaxed store",
        &["control@lazy-relaxed"],
    ),
    built_in("panics", "code that panics when an entry is taken", &["control@panics"]),
    built_in("endless", "a loop that waits without saying so", &["control@endless"]),
    built_in("host-state", "a counter outside of memory", &["control@host-state"]),
];

/// The forms without fault.
pub const GREEN: [&str; 2] = ["control", "control@lazy"];

/// The form of that name.
#[must_use]
pub fn control(name: &str) -> Option<Subject> {
    let method = METHODS.iter().find(|method| method.name() == name)?;
    Subject::new(*method).ok()
}

/// A method of the catalogue, or a control. `place` is where the name was given, for the message.
///
/// # Errors
/// There is none of that name, or it is the oracle.
pub fn find(catalogue: &Catalogue, place: &str, name: &str) -> Result<Subject> {
    match control(name) {
        Some(control) => Ok(control),
        None => Subject::new(catalogue.find(place, name)?),
    }
}

/// The method, or a fault in it.
struct Control<const FORM: usize> {
    k: u32,
    entries: Words<Pixel, Atomic, u64>,
    /// Whether the pixel is shown.
    shown: Words<Pixel, Atomic, u32>,
    /// 0: nobody has set up the entries; 1: somebody does; 2: they are ready.
    state: Words<Pixel, Atomic, u32>,
    scratch: Words<Global, Atomic, u32>,
    /// What no scheme may have.
    host: Mutex<u32>,
}

impl<const FORM: usize> Control<FORM> {
    const IS_LAZY: bool = FORM == LAZY || FORM == LAZY_RELAXED;

    /// Set up the entries, or wait until they are.
    async fn set_up<M: Memory>(&self, mem: &M, pixel: u32) {
        let (release, acquire) = match FORM {
            LAZY => (Order::Release, Order::Acquire),
            _ => (Order::Relaxed, Order::Relaxed),
        };
        let state = self.state.at(pixel, 0);
        let first = Update::CompareExchange { expected: 0, new: 1 };
        if mem.update(state, first, Order::Relaxed).await == 0 {
            for i in 0..self.k {
                mem.store(self.entries.at(pixel, i), EMPTY, Order::Relaxed).await;
            }
            mem.store(state, 2, release).await;
            return;
        }
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if mem.load(state, acquire).await == 2 {
                return;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }
}

impl<const FORM: usize> Scheme for Control<FORM> {
    const CONTRACT: Contract = Contract {
        title: "the k nearest by atomic minima, to check the checker with",
        form: if FORM == RIGHT || FORM == LAZY { Form::Correct } else { Form::Mutation },
        words: "2k + 2",
        default_k: Some(8),
        ..Contract::new(NAMES[FORM], Keeps::Nearest)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        let entries = layout.pixel(u64::from(k));
        let (shown, state, scratch) = (layout.pixel(1), layout.pixel(1), layout.global(1));
        Self { k, entries, shown, state, scratch, host: Mutex::new(0) }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        if FORM != SHARED_CLEAR {
            mem.store(self.scratch.at(0), 0, Order::Relaxed).await;
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        let mut cleared = pixel;
        if FORM == SHARED_CLEAR {
            mem.store(self.scratch.at(0), pixel, Order::Relaxed).await;
            cleared = mem.load(self.scratch.at(0), Order::Relaxed).await;
        }
        for i in 0..self.k {
            if !Self::IS_LAZY {
                mem.store(self.entries.at(cleared, i), EMPTY, Order::Relaxed).await;
            }
        }
        mem.store(self.state.at(pixel, 0), 0, Order::Relaxed).await;
        if FORM != FORGETS {
            mem.store(self.shown.at(pixel, 0), 1, Order::Relaxed).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        if Self::IS_LAZY {
            self.set_up(mem, pixel).await;
        }
        if FORM == ENDLESS && mem.exchange(self.state.at(pixel, 0), 1, Order::Relaxed).await == 1 {
            while mem.load(self.state.at(pixel, 0), Order::Relaxed).await != 0 {}
        }
        let mut carried = fragment.key();
        if FORM == HOST_STATE {
            let mut count = self.host.lock().unwrap_or_else(PoisonError::into_inner);
            *count += 1;
            if count.is_multiple_of(4) {
                return Outcome::Culled;
            }
        }
        if matches!(FORM, UPPER_BITS | AS_FLOAT) {
            let last = mem.load(self.entries.at(pixel, self.k - 1), Order::Relaxed).await;
            let is_farther = match FORM {
                UPPER_BITS => fragment.depth >> 8 >= depth_of(last) >> 8,
                _ => fragment.depth as f32 >= depth_of(last) as f32,
            };
            // Equal depths are compared as they should be: close ones are not.
            if is_farther && fragment.depth != depth_of(last) && last != EMPTY {
                return Outcome::Culled;
            }
        }
        for i in 0..self.k {
            let entry = self.entries.at(pixel, i);
            let old = if FORM == FOURTH && i == 3 {
                let old = mem.load(entry, Order::Relaxed).await;
                mem.store(entry, old.min(carried), Order::Relaxed).await;
                old
            } else {
                mem.min(entry, carried, Order::Relaxed).await
            };
            assert!(FORM != PANICS || old == EMPTY, "an entry was taken");
            carried = carried.max(old);
            if carried == EMPTY {
                if FORM == ENDLESS {
                    mem.store(self.state.at(pixel, 0), 0, Order::Relaxed).await;
                }
                return Outcome::Kept;
            }
        }
        if FORM == ENDLESS {
            mem.store(self.state.at(pixel, 0), 0, Order::Relaxed).await;
        }
        if carried == fragment.key() { Outcome::Culled } else { Outcome::Evicted }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        if mem.load(self.shown.at(pixel, 0), Order::Relaxed).await != 1 {
            return;
        }
        if Self::IS_LAZY && mem.load(self.state.at(pixel, 0), Order::Relaxed).await == 0 {
            return;
        }
        let mut from = pixel;
        if FORM == SHARED_RESOLVE {
            mem.store(self.scratch.at(0), pixel, Order::Relaxed).await;
            from = mem.load(self.scratch.at(0), Order::Relaxed).await;
        }
        for i in 0..self.k {
            let entry = mem.load(self.entries.at(from, i), Order::Relaxed).await;
            let is_empty = match FORM {
                DATA_ZERO => entry == EMPTY || entry as u32 == 0,
                NO_FRAGMENT => entry == EMPTY && i > 0,
                _ => entry == EMPTY,
            };
            if is_empty {
                return;
            }
            keys.push(entry);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_has_its_name() {
        let variants = CONTROLS.iter().flat_map(|fault| fault.variants.iter().copied());
        let mut names: Vec<&str> = variants.chain(GREEN).collect();
        names.sort_unstable();
        let mut all = NAMES.to_vec();
        all.sort_unstable();
        assert_eq!(names, all);
        for &name in NAMES {
            let subject = control(name).expect("a form");
            assert_eq!(subject.contract.name, name);
            let is_fault = subject.contract.form == Form::Mutation;
            assert_eq!(is_fault, !GREEN.contains(&name), "{name}");
        }
    }
}
