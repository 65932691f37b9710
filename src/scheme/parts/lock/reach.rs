//! How the holder of a lock reaches the words that the lock guards: the ways that a mended form chooses from.
//!
//! The correct forms rely on the lock: its acquire and release order what its holders do, so that guarded words can be
//! plain. Where every atomic is relaxed, as in WGSL, nothing does. A holder then reads words as they were before the
//! last holder wrote them, and a GPU whose caches are not coherent for plain accesses shows it.
//!
//! ```text
//! way       guarded words           words that others read without the lock   lock
//! Plain     plain                   relaxed loads, ordered stores             acquire exchange, release store
//! Atomic    relaxed loads, stores   as above                                  as above
//! Updated   updates                 updates                                   relaxed exchanges
//! ```
//!
//! With [`Atomic`], there is no data race, and nothing more: without the orders of the lock, loads may be stale.
//!
//! With [`Updated`], no order is needed. Every access is a read-modify-write: a read is an `or` of 0, a write is an
//! exchange. So every write of a word in the store pass is an update, and an update reads the value that the update
//! before it left. The updates of a word are one chain, and a later one reads the last value.
//!
//! Let B take the lock after A. Could an access of B come before one of A in a word's chain? Then A has read, directly
//! or through others, what B wrote there. A releases the lock after that. B has read the release, directly or through
//! others, before it wrote. That is a cycle of program order and reads-from: load buffering.
//!
//! So this stands on one assumption: *no load buffering*. The explorer's relaxed memory makes it; C++, Vulkan and WGSL
//! allow such cycles for relaxed atomics. The WGSL twins therefore make the value that frees the lock depend on what
//! all updates under it gave, which a device can know only when they have been performed. It is a dependency that no
//! compiler can see through, and no promise of the language.

use std::fmt::Debug;
use std::future::Future;

use super::SpinLock;
use crate::memory::{Access, At, Atomic, Kind, Memory, Order, Plain, Space, Update, Word};
use crate::scheme::contract::Contract;

/// What a method needs that is mended by updates.
const NEEDS: &str =
    "32-bit atomic updates, relaxed; no load buffering; forward progress of the lock's holder";

/// How WGSL can express it.
const WGSL: Option<&str> = Some(
    "storage buffers; relaxed updates are enough, but that there is no load buffering is outside WGSL's guarantees",
);

/// A method where every access is an update.
#[must_use]
pub const fn updated(contract: Contract, name: &'static str, title: &'static str) -> Contract {
    Contract { needs: NEEDS, wgsl: WGSL, ..contract.mended(name, title) }
}

/// A way to reach guarded words. Its kind is that of the words that a lock alone guards.
pub trait Reach: Debug + Send + Sync + 'static {
    /// Plain or atomic.
    type Kind: Kind + Debug + Send + Sync + 'static;
    /// How the lock is taken, and how a counter that is written under it is read without it.
    const ACQUIRE: Order;
    /// How guarded words are accessed in other passes, which barriers order.
    const SETTLED: Access;

    /// Read a guarded word under the lock.
    #[track_caller]
    fn read<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Self::Kind, W>,
    ) -> impl Future<Output = W> + Unpin;

    /// Write a guarded word under the lock.
    #[track_caller]
    fn write<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Self::Kind, W>,
        value: W,
    ) -> impl Future<Output: Copy + Unpin> + Unpin;

    /// Read a word that may be read without the lock, in this order where an order counts.
    #[track_caller]
    fn load<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Atomic, W>,
        order: Order,
    ) -> impl Future<Output = W> + Unpin;

    /// Write such a word under the lock, in this order where an order counts.
    #[track_caller]
    fn store<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Atomic, W>,
        value: W,
        order: Order,
    ) -> impl Future<Output: Copy + Unpin> + Unpin;

    /// Release the lock.
    #[track_caller]
    fn release<M: Memory>(
        mem: &M,
        lock: SpinLock,
        pixel: u32,
    ) -> impl Future<Output: Copy + Unpin> + Unpin;
}

/// Every access is an update.
#[derive(Clone, Copy, Debug)]
pub enum Updated {}

/// The ways that differ in the access to guarded words alone.
macro_rules! ordered {
    ($kind:ty, $access:expr) => {
        #[allow(clippy::inline_always, reason = "see `Memory`")]
        impl Reach for $kind {
            type Kind = Self;
            const ACQUIRE: Order = Order::Acquire;
            const SETTLED: Access = $access;

            #[inline(always)]
            #[track_caller]
            fn read<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Self, W>,
            ) -> impl Future<Output = W> + Unpin {
                mem.read(at, $access)
            }

            #[inline(always)]
            #[track_caller]
            fn write<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Self, W>,
                value: W,
            ) -> impl Future<Output: Copy + Unpin> + Unpin {
                mem.write(at, value, $access)
            }

            #[inline(always)]
            #[track_caller]
            fn load<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Atomic, W>,
                order: Order,
            ) -> impl Future<Output = W> + Unpin {
                mem.load(at, order)
            }

            #[inline(always)]
            #[track_caller]
            fn store<M: Memory, S: Space, W: Word>(
                mem: &M,
                at: At<S, Atomic, W>,
                value: W,
                order: Order,
            ) -> impl Future<Output: Copy + Unpin> + Unpin {
                mem.store(at, value, order)
            }

            #[inline(always)]
            #[track_caller]
            fn release<M: Memory>(
                mem: &M,
                lock: SpinLock,
                pixel: u32,
            ) -> impl Future<Output: Copy + Unpin> + Unpin {
                lock.release(mem, pixel, Access::Atomic(Order::Release))
            }
        }
    };
}

ordered!(Plain, Access::Plain);
ordered!(Atomic, Access::Atomic(Order::Relaxed));

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl Reach for Updated {
    type Kind = Atomic;
    const ACQUIRE: Order = Order::Relaxed;
    const SETTLED: Access = Access::Atomic(Order::Relaxed);

    #[inline(always)]
    #[track_caller]
    fn read<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Atomic, W>,
    ) -> impl Future<Output = W> + Unpin {
        mem.update(at, Update::Or(W::default()), Order::Relaxed)
    }

    #[inline(always)]
    #[track_caller]
    fn write<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Atomic, W>,
        value: W,
    ) -> impl Future<Output: Copy + Unpin> + Unpin {
        mem.exchange(at, value, Order::Relaxed)
    }

    #[inline(always)]
    #[track_caller]
    fn load<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Atomic, W>,
        _: Order,
    ) -> impl Future<Output = W> + Unpin {
        Self::read(mem, at)
    }

    #[inline(always)]
    #[track_caller]
    fn store<M: Memory, S: Space, W: Word>(
        mem: &M,
        at: At<S, Atomic, W>,
        value: W,
        _: Order,
    ) -> impl Future<Output: Copy + Unpin> + Unpin {
        Self::write(mem, at, value)
    }

    #[inline(always)]
    #[track_caller]
    fn release<M: Memory>(
        mem: &M,
        lock: SpinLock,
        pixel: u32,
    ) -> impl Future<Output: Copy + Unpin> + Unpin {
        lock.exchange_free(mem, pixel, Order::Relaxed)
    }
}
