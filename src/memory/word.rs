//! The two widths of a word.

use std::cell::Cell;
use std::fmt::Debug;
use std::hash::Hash;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use super::{Order, Update};

mod sealed {
    pub trait Sealed {}
    impl Sealed for u32 {}
    impl Sealed for u64 {}
}

/// 32-bit and 64-bit words that one thread owns.
pub(super) type Cells<'a> = (&'a [Cell<u32>], &'a [Cell<u64>]);

/// 32-bit and 64-bit words that threads share.
pub(super) type Atomics<'a> = (&'a [AtomicU32], &'a [AtomicU64]);

/// `u32` or `u64`.
#[allow(private_interfaces, reason = "the hidden functions are for this module's memories alone")]
pub trait Word:
    Copy + Send + Sync + Unpin + Ord + Hash + Debug + Default + sealed::Sealed + 'static
{
    /// 32 or 64.
    const BITS: u32;

    /// Zero-extended.
    fn to_u64(self) -> u64;

    /// The low bits.
    fn from_u64(bits: u64) -> Self;

    #[doc(hidden)]
    fn wrapping_add(self, other: Self) -> Self;
    #[doc(hidden)]
    fn and(self, other: Self) -> Self;
    #[doc(hidden)]
    fn or(self, other: Self) -> Self;
    #[doc(hidden)]
    type Shared: Debug + Sync;
    #[doc(hidden)]
    fn shared(atomics: Atomics<'_>) -> &[Self::Shared];
    #[doc(hidden)]
    fn put(word: &Self::Shared, value: Self);
    #[doc(hidden)]
    fn peek(word: &Self::Shared) -> Self;
    #[doc(hidden)]
    fn owned(cells: Cells<'_>) -> &[Cell<Self>];
    #[doc(hidden)]
    fn shared_load(atomics: Atomics<'_>, index: usize, ordering: Ordering) -> Option<Self>;
    #[doc(hidden)]
    fn shared_store(
        atomics: Atomics<'_>,
        index: usize,
        value: Self,
        ordering: Ordering,
    ) -> Option<()>;
    #[doc(hidden)]
    fn shared_update(
        atomics: Atomics<'_>,
        index: usize,
        update: Update<Self>,
        order: Order,
    ) -> Option<Self>;
}

macro_rules! word {
    ($word:ty, $bits:literal, $atomic:ty, $half:tt) => {
        #[allow(clippy::inline_always, reason = "see `Memory`")]
        impl Word for $word {
            const BITS: u32 = $bits;

            #[inline(always)]
            fn to_u64(self) -> u64 {
                u64::from(self)
            }

            #[inline(always)]
            fn from_u64(bits: u64) -> Self {
                bits as $word
            }

            #[inline(always)]
            fn wrapping_add(self, other: Self) -> Self {
                <$word>::wrapping_add(self, other)
            }

            #[inline(always)]
            fn and(self, other: Self) -> Self {
                self & other
            }

            #[inline(always)]
            fn or(self, other: Self) -> Self {
                self | other
            }

            type Shared = $atomic;

            #[inline(always)]
            fn shared(atomics: Atomics<'_>) -> &[$atomic] {
                atomics.$half
            }

            #[inline(always)]
            fn put(word: &$atomic, value: Self) {
                word.store(value, Ordering::Relaxed);
            }

            #[inline(always)]
            fn peek(word: &$atomic) -> Self {
                word.load(Ordering::Relaxed)
            }

            #[inline(always)]
            fn owned(cells: Cells<'_>) -> &[Cell<Self>] {
                cells.$half
            }

            #[inline(always)]
            fn shared_load(atomics: Atomics<'_>, index: usize, ordering: Ordering) -> Option<Self> {
                Some(atomics.$half.get(index)?.load(ordering))
            }

            #[inline(always)]
            fn shared_store(
                atomics: Atomics<'_>,
                index: usize,
                value: Self,
                ordering: Ordering,
            ) -> Option<()> {
                atomics.$half.get(index)?.store(value, ordering);
                Some(())
            }

            #[inline(always)]
            fn shared_update(
                atomics: Atomics<'_>,
                index: usize,
                update: Update<Self>,
                order: Order,
            ) -> Option<Self> {
                let cell: &$atomic = atomics.$half.get(index)?;
                let ordering = order.for_update();
                Some(match update {
                    Update::Exchange(v) => cell.swap(v, ordering),
                    Update::CompareExchange { expected, new } => {
                        match cell.compare_exchange(expected, new, ordering, order.for_load()) {
                            Ok(old) | Err(old) => old,
                        }
                    }
                    Update::Add(v) => cell.fetch_add(v, ordering),
                    Update::And(v) => cell.fetch_and(v, ordering),
                    Update::Or(v) => cell.fetch_or(v, ordering),
                    // What does not change a word need not be written, where nothing else hangs on the order.
                    Update::Min(v) if order == Order::Relaxed => {
                        let seen = cell.load(Ordering::Relaxed);
                        if seen <= v { seen } else { cell.fetch_min(v, ordering) }
                    }
                    Update::Max(v) if order == Order::Relaxed => {
                        let seen = cell.load(Ordering::Relaxed);
                        if seen >= v { seen } else { cell.fetch_max(v, ordering) }
                    }
                    Update::Min(v) => cell.fetch_min(v, ordering),
                    Update::Max(v) => cell.fetch_max(v, ordering),
                })
            }
        }
    };
}

word!(u32, 32, AtomicU32, 0);
word!(u64, 64, AtomicU64, 1);

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl Order {
    /// As std's ordering of a read-modify-write.
    #[inline(always)]
    #[must_use]
    pub fn for_update(self) -> Ordering {
        match self {
            Self::Relaxed => Ordering::Relaxed,
            Self::Acquire => Ordering::Acquire,
            Self::Release => Ordering::Release,
            Self::AcqRel => Ordering::AcqRel,
        }
    }

    /// The part of it that a read can have.
    #[inline(always)]
    #[must_use]
    pub fn for_load(self) -> Ordering {
        match self {
            Self::Relaxed | Self::Release => Ordering::Relaxed,
            Self::Acquire | Self::AcqRel => Ordering::Acquire,
        }
    }

    /// The part of it that a write can have.
    #[inline(always)]
    #[must_use]
    pub fn for_store(self) -> Ordering {
        match self {
            Self::Relaxed | Self::Acquire => Ordering::Relaxed,
            Self::Release | Self::AcqRel => Ordering::Release,
        }
    }
}
