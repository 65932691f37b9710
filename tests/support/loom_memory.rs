//! loom's memory: the same schemes on loom's atomics, so that it explores their interleavings *and* the weak outcomes
//! of their orderings.
//!
//! Plain words are relaxed atomics here: loom then shows stale values where a happens-before edge is missing, and a
//! check sees them as wrong contents. A thread that has waited `patience` times explores no further alternatives
//! (`loom::skip_branch`): without that, three threads at one lock have no end. So models hold for waiters that fail
//! at most `patience` times.

use std::cell::Cell;
use std::future::{Future, ready};

use fragloom::memory::layout::Sizes;
use fragloom::memory::{
    Access, At, Atomic, InputAt, Kind, Layout, Mark, Memory, Order, Space, Update, Word,
};
use loom::sync::atomic::{AtomicU64, Ordering};

/// The words of a few pixels and of the frame.
pub(crate) struct Storage {
    pixel: Arena,
    global: Arena,
}

struct Arena {
    words32: Vec<AtomicU64>,
    words64: Vec<AtomicU64>,
    stride: Sizes,
}

impl Arena {
    fn new(sizes: Sizes, records: u64) -> Self {
        let make = |count: u64| (0..count * records).map(|_| AtomicU64::new(GARBAGE)).collect();
        Self { words32: make(sizes.words32), words64: make(sizes.words64), stride: sizes }
    }
}

/// What words hold before the clear pass.
const GARBAGE: u64 = 0xDEAD_BEEF;

impl Storage {
    /// For `pixels` pixels.
    pub(crate) fn new(layout: &Layout, pixels: u64) -> Self {
        Self {
            pixel: Arena::new(layout.per_pixel(), pixels),
            global: Arena::new(layout.per_frame(), 1),
        }
    }

    fn cell<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>) -> &AtomicU64 {
        let arena = if S::GLOBAL { &self.global } else { &self.pixel };
        let (words, stride) = match W::BITS {
            64 => (&arena.words64, arena.stride.words64),
            _ => (&arena.words32, arena.stride.words32),
        };
        &words[(u64::from(at.pixel) * stride + at.word) as usize]
    }
}

/// One thread's handle.
pub(crate) struct Loom<'a> {
    storage: &'a Storage,
    patience: u32,
    spins: Cell<u32>,
}

impl<'a> Loom<'a> {
    pub(crate) fn new(storage: &'a Storage, patience: u32) -> Self {
        Self { storage, patience, spins: Cell::new(0) }
    }
}

/// An exchange that writes nothing where it finds its own value. loom keeps modification order partial: it would let a
/// waiter read its own failed exchange forever, past the unlock (tokio-rs/loom#254). Leaving that write out changes no
/// value that any thread can read.
fn exchange(cell: &AtomicU64, new: u64, success: Ordering, failure: Ordering) -> u64 {
    let mut expected = 0;
    loop {
        match cell.compare_exchange(expected, new, success, failure) {
            Ok(old) => return old,
            Err(old) if old == new => return old,
            Err(old) => expected = old,
        }
    }
}

impl Memory for Loom<'_> {
    fn read<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        access: Access,
    ) -> impl Future<Output = W> + Unpin {
        let order = match access {
            Access::Plain => Ordering::Relaxed,
            Access::Atomic(order) => order.for_load(),
        };
        ready(W::from_u64(self.storage.cell(at).load(order)))
    }

    fn write<S: Space, K: Kind, W: Word>(
        &self,
        at: At<S, K, W>,
        value: W,
        access: Access,
    ) -> impl Future<Output = ()> + Unpin {
        let order = match access {
            Access::Plain => Ordering::Relaxed,
            Access::Atomic(order) => order.for_store(),
        };
        self.storage.cell(at).store(value.to_u64(), order);
        ready(())
    }

    fn update<S: Space, W: Word>(
        &self,
        at: At<S, Atomic, W>,
        update: Update<W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin {
        let (cell, ordering) = (self.storage.cell(at), order.for_update());
        let old = match update {
            Update::Exchange(v) => exchange(cell, v.to_u64(), ordering, order.for_load()),
            Update::CompareExchange { expected, new } => {
                let (expected, new) = (expected.to_u64(), new.to_u64());
                match cell.compare_exchange(expected, new, ordering, order.for_load()) {
                    Ok(old) | Err(old) => old,
                }
            }
            // Words are kept zero-extended, so that a 32-bit sum must not carry.
            Update::Add(v) if W::BITS == 64 => cell.fetch_add(v.to_u64(), ordering),
            Update::Add(v) => {
                let add = |old: u64| Some(u64::from((old as u32).wrapping_add(v.to_u64() as u32)));
                match cell.fetch_update(ordering, order.for_load(), add) {
                    Ok(old) | Err(old) => old,
                }
            }
            Update::And(v) => cell.fetch_and(v.to_u64(), ordering),
            Update::Or(v) => cell.fetch_or(v.to_u64(), ordering),
            Update::Min(v) => cell.fetch_min(v.to_u64(), ordering),
            Update::Max(v) => cell.fetch_max(v.to_u64(), ordering),
        };
        ready(W::from_u64(old))
    }

    fn input(&self, _: InputAt) -> u32 {
        unreachable!("no model here has inputs")
    }

    fn spin(&self, _: Mark) -> impl Future<Output = ()> + Unpin {
        self.spins.set(self.spins.get() + 1);
        if self.spins.get() > self.patience {
            loom::skip_branch();
        }
        loom::thread::yield_now();
        ready(())
    }
}
