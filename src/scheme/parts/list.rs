//! The linked lists that pixels share a pool for (Yang, Hensley, Grün, Thibieroz, "Real-time concurrent linked list
//! construction on the GPU", 2010): the heads of a pixel's lists, a counter that hands out nodes, and nodes of a link
//! and a key.
//!
//! Each use says how a node gets into its list, since that is where methods differ: by an exchange on the head, the old
//! value of which becomes the node's link afterwards ([`Lists::publish`]), or by a compare-exchange on the link before
//! it. The first kind reads no link before the barrier, so its links can be plain.

use std::fmt;
use std::future::Future;
use std::marker::PhantomData;

use super::lock::reach::Reach;
use crate::fragment::{Fragment, data_of, depth_of, key, pair_key};
use crate::memory::{
    At, Atomic, Global, Kind, Layout, Memory, Order, OwnedBlock, Pixel, Plain, Pool, Snapshot,
    Words, both,
};
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::{Config, Keys};

/// No node: the end of a list.
pub const NONE: u32 = u32::MAX;

/// Lists of every pixel, whose links are plain or atomic.
#[derive(Debug)]
pub struct Lists<L = Plain, K = Whole> {
    heads: Words<Pixel, Atomic, u32>,
    pool: Pool,
    links: Words<Global, L, u32>,
    keys: K,
}

impl<L, K: Copy> Clone for Lists<L, K> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L, K: Copy> Copy for Lists<L, K> {}

/// How the nodes of a pool hold their keys.
pub trait NodeKeys: Copy + fmt::Debug + Send + Sync + 'static {
    /// What is read of one.
    type Read: Copy + Unpin;

    /// Declare so many.
    fn new(count: u64, layout: &mut Layout) -> Self;

    /// Write a node's, before it is published.
    #[track_caller]
    fn write<M: Memory>(self, mem: &M, node: u64, key: u64) -> impl Future;

    /// Read that of a node that was published.
    #[track_caller]
    fn read<M: Memory>(self, mem: &M, node: u64) -> impl Future<Output = Self::Read>;

    /// Read one after a barrier.
    #[track_caller]
    fn settled<M: Memory>(self, mem: &M, node: u64) -> impl Future<Output = Self::Read>;

    /// The key that was read.
    fn of(read: Self::Read) -> u64;

    /// One, for an invariant.
    fn seen(self, words: &Snapshot<'_>, node: u64) -> Option<u64>;
}

/// Plain keys of one word.
pub type Whole = Words<Global, Plain, u64>;

#[allow(clippy::inline_always, reason = "see `Memory`")]
impl NodeKeys for Whole {
    type Read = u64;

    fn new(count: u64, layout: &mut Layout) -> Self {
        layout.named("keys").global(count)
    }

    #[inline(always)]
    #[track_caller]
    fn write<M: Memory>(self, mem: &M, node: u64, key: u64) -> impl Future {
        mem.plain_store(self.at(node), key)
    }

    #[inline(always)]
    #[track_caller]
    fn read<M: Memory>(self, mem: &M, node: u64) -> impl Future<Output = u64> {
        mem.plain_load(self.at(node))
    }

    #[inline(always)]
    #[track_caller]
    fn settled<M: Memory>(self, mem: &M, node: u64) -> impl Future<Output = u64> {
        mem.plain_load(self.at(node))
    }

    #[inline(always)]
    fn of(key: u64) -> u64 {
        key
    }

    fn seen(self, words: &Snapshot<'_>, node: u64) -> Option<u64> {
        words.get(self.at(node))
    }
}

/// Keys of two atomic words, depth and data, reached in one of the ways of mended forms.
#[derive(Clone, Copy, Debug)]
pub struct Halves<R> {
    depth: Words<Global, Atomic, u32>,
    data: Words<Global, Atomic, u32>,
    reach: PhantomData<R>,
}

impl<R: Reach<Kind = Atomic> + Copy> NodeKeys for Halves<R> {
    type Read = (u32, u32);

    fn new(count: u64, layout: &mut Layout) -> Self {
        Self {
            depth: layout.named("depth").global(count),
            data: layout.named("data").global(count),
            reach: PhantomData,
        }
    }

    #[track_caller]
    fn write<M: Memory>(self, mem: &M, node: u64, key: u64) -> impl Future {
        both(
            R::write(mem, self.depth.at(node), depth_of(key)),
            R::write(mem, self.data.at(node), data_of(key)),
        )
    }

    #[track_caller]
    fn read<M: Memory>(self, mem: &M, node: u64) -> impl Future<Output = (u32, u32)> {
        both(R::read(mem, self.depth.at(node)), R::read(mem, self.data.at(node)))
    }

    #[track_caller]
    fn settled<M: Memory>(self, mem: &M, node: u64) -> impl Future<Output = (u32, u32)> {
        both(
            mem.load(self.depth.at(node), Order::Relaxed),
            mem.load(self.data.at(node), Order::Relaxed),
        )
    }

    fn of(halves: (u32, u32)) -> u64 {
        pair_key(halves)
    }

    fn seen(self, words: &Snapshot<'_>, node: u64) -> Option<u64> {
        Some(pair_key((words.get(self.depth.at(node))?, words.get(self.data.at(node))?)))
    }
}

/// A written node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Which one.
    pub number: u32,
    /// Where it leads to.
    pub next: u32,
    /// The key of its fragment.
    pub key: u64,
}

/// Why a list cannot be followed to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// It leads to a node that the pool does not have.
    Outside {
        /// Which one.
        node: u32,
        /// How many nodes there are.
        of: u64,
    },
    /// It leads to a node that is not, or not wholly, written.
    Unwritten(u32),
    /// It leads through more nodes than there are, so it has a cycle.
    Endless(u64),
}

impl fmt::Display for Flaw {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside { node, of } => write!(out, "the list leads to node {node}, of {of}"),
            Self::Unwritten(node) => write!(out, "node {node} is in the list but was not written"),
            Self::Endless(of) => write!(out, "the list does not end within the pool's {of} nodes"),
        }
    }
}

impl<L: Kind, K: NodeKeys> Lists<L, K> {
    /// Declare so many lists per pixel, and a pool of as many nodes as the scene has fragments.
    #[must_use]
    pub fn new(lists: u32, config: &Config, layout: &mut Layout) -> Self {
        let capacity = config.generated.min(u64::from(NONE));
        Self {
            heads: layout.named("heads").pixel(lists.into()),
            pool: layout.named("pool").pool(),
            links: layout.named("links").global(capacity),
            keys: K::new(capacity, layout),
        }
    }

    /// Nodes of the pool.
    #[inline(always)]
    #[must_use]
    pub fn capacity(self) -> u64 {
        self.links.count()
    }

    /// Where a pixel's list begins.
    #[inline(always)]
    #[must_use]
    pub fn head(self, pixel: u32, list: u32) -> At<Pixel, Atomic, u32> {
        self.heads.at(pixel, list)
    }

    /// Where a node leads to.
    #[inline(always)]
    #[must_use]
    pub fn link(self, node: u32) -> At<Global, L, u32> {
        self.links.at(node.into())
    }

    /// Give all nodes back, in the clear pass.
    #[inline(always)]
    #[track_caller]
    pub fn clear_frame<M: Memory>(self, mem: &M) -> impl Future<Output = ()> + Unpin {
        mem.store(self.pool.counter(), 0, Order::Relaxed)
    }

    /// Empty a pixel's list, in the clear pass.
    #[inline(always)]
    #[track_caller]
    pub fn clear<M: Memory>(
        self,
        mem: &M,
        pixel: u32,
        list: u32,
    ) -> impl Future<Output = ()> + Unpin {
        mem.store(self.head(pixel, list), NONE, Order::Relaxed)
    }

    /// Take a node from the pool; a number from [`Self::capacity`] on means that the pool is empty.
    #[inline(always)]
    #[track_caller]
    pub fn take<M: Memory>(self, mem: &M) -> impl Future<Output = u32> + Unpin {
        mem.take(self.pool)
    }

    /// Write the fragment into a node.
    #[inline(always)]
    #[track_caller]
    pub fn fill<M: Memory>(self, mem: &M, node: u32, fragment: Fragment) -> impl Future {
        self.keys.write(mem, node.into(), fragment.key())
    }

    /// Read the key of a node that others may be filling: [`NodeKeys::of`] makes one of it.
    #[inline(always)]
    #[track_caller]
    pub fn read<M: Memory>(self, mem: &M, node: u32) -> impl Future<Output = K::Read> {
        self.keys.read(mem, node.into())
    }

    /// The same after a barrier.
    #[inline(always)]
    #[track_caller]
    pub fn settled<M: Memory>(self, mem: &M, node: u32) -> impl Future<Output = K::Read> {
        self.keys.settled(mem, node.into())
    }

    /// Make a node the first of its list, by an exchange. Gives what the node must lead to.
    #[inline(always)]
    #[track_caller]
    pub fn publish<M: Memory>(
        self,
        mem: &M,
        pixel: u32,
        list: u32,
        node: u32,
        order: Order,
    ) -> impl Future<Output = u32> + Unpin {
        mem.exchange(self.head(pixel, list), node, order)
    }

    /// The nodes of a list, in its order, up to its end or its first flaw.
    pub fn nodes<'w>(
        self,
        words: &'w Snapshot<'_>,
        pixel: u32,
        list: u32,
    ) -> impl Iterator<Item = Result<Node, Flaw>> + 'w
    where
        L: 'w,
    {
        let (mut node, mut seen) = (words.get(self.head(pixel, list)).unwrap_or(NONE), 0);
        std::iter::from_fn(move || {
            let number = node;
            if number == NONE {
                return None;
            }
            node = NONE;
            if u64::from(number) >= self.capacity() {
                return Some(Err(Flaw::Outside { node: number, of: self.capacity() }));
            }
            if seen == self.capacity() {
                return Some(Err(Flaw::Endless(seen)));
            }
            let written = (words.get(self.link(number)), self.keys.seen(words, number.into()));
            let (Some(next), Some(key)) = written else {
                return Some(Err(Flaw::Unwritten(number)));
            };
            (node, seen) = (next, seen + 1);
            Some(Ok(Node { number, next, key }))
        })
    }
}

impl Lists {
    /// Give each fragment of a block a node that becomes the first of its pixel's only list, in the order of their bits
    /// ([`Scheme::store_block`](crate::scheme::Scheme::store_block)). Gives whether it did so: if the worker has the
    /// nodes.
    pub fn push_block(self, block: &OwnedBlock<'_>, batch: &Batch) -> bool {
        let (mask, depths, data) = (batch.mask(), batch.depths(), batch.data());
        let count = mask.count_ones();
        let taken = block.pixels(self.heads).and_then(|heads| {
            let first = block.next(self.pool, count)?;
            let (from, many) = (first.into(), count.into());
            let (links, keys) =
                (block.run(self.links, from, many)?, block.run(self.keys, from, many)?);
            Some((heads, first, links, keys))
        });
        let Some((heads, first, links, keys)) = taken else { return false };
        block.take(self.pool, count);
        let mut nodes = (first..).zip(links.writers().zip(keys.writers()));
        let mut push = |bit: usize| {
            if let Some((node, (link, own))) = nodes.next() {
                own(key(depths[bit], data[bit]));
                link(heads[bit].replace(node));
            }
        };
        if mask == u64::MAX {
            (0..64).for_each(push);
        } else {
            bits(mask).for_each(|bit| push(bit as usize & 63));
        }
        true
    }
}

impl<L: Kind> Lists<L> {
    /// The key of a node's fragment.
    #[inline(always)]
    #[track_caller]
    pub fn key<M: Memory>(self, mem: &M, node: u32) -> impl Future<Output = u64> + Unpin {
        mem.plain_load(self.keys.at(node.into()))
    }

    /// A node as a test wants it.
    #[cfg(test)]
    pub(in crate::scheme) fn set<S>(self, memory: &mut super::hand_made::HandMade<S>, node: Node)
    where
        S: crate::scheme::Scheme,
    {
        memory.set(self.link(node.number), node.next);
        memory.set(self.keys.at(node.number.into()), node.key);
    }
}

impl Lists<Plain> {
    /// Follow a list, in resolve.
    #[allow(clippy::extra_unused_type_parameters, reason = "see `Inside`")]
    pub async fn collect<M: Memory, Caller>(self, mem: &M, pixel: u32, list: u32, keys: &mut Keys) {
        let mut node = mem.load(self.head(pixel, list), Order::Relaxed).await;
        while node != NONE {
            keys.push(self.key(mem, node).await);
            node = mem.plain_load(self.link(node)).await;
        }
    }
}
