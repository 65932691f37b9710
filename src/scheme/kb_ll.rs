//! k-buffer in a depth-sorted linked list per pixel (Yu, Yang, Hensley, Harada, Yu, "A framework for rendering complex
//! scattering effects on hair", I3D 2012; KB-LL).
//!
//! A fragment walks its pixel's list from the front. Behind k nodes it is culled; else its node goes before the first
//! that is farther, by a compare-exchange on its predecessor's link. Nodes never leave the list, they only fall behind
//! the k-th, where resolve does not look. Hence
//! * a predecessor stays one: who loses a compare-exchange goes on from where it stands, and not from the front;
//! * nodes counted in front are in front for good, so that nobody is culled who belongs to the k nearest;
//! * each failure means that another got in, so that insertions end without waiting.
//!
//! Walkers read nodes while others insert. A node is complete before the compare-exchange that publishes it, which
//! releases; links are read by acquire loads. Depth and data can then be plain: whoever reaches a node through however
//! many others does so behind everything that made it.
//!
//! Data words decide among equal depths. Whether a fragment pushes another out, its
//! invocation cannot know: two that insert into a list of k - 1 nodes at the same time both saw room, and both find
//! k + 1 afterwards. So none says so, and the accounting compares lists.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Plain, Pool, Snapshot, Words};
use crate::scheme::contract::Demand;
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// No node: the end of a list, and what comes before its first.
const NONE: u32 = u32::MAX;

/// The correct form, or a fault in it.
pub trait Variant: Sync {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How a node is published.
    const PUBLISH: Order = Order::Release;
    /// Whether depth and data are in the node before it is published.
    const WRITTEN_FIRST: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M11: a node is published before it is written. Others that walk meanwhile read what nobody wrote.
#[derive(Debug)]
pub enum PublishedFirst {}

/// The compare-exchange orders nothing, so that others may see a node without what is in it.
#[derive(Debug)]
pub enum RelaxedPublication {}

/// The method.
#[derive(Debug)]
pub struct KNearestList<V = Correct> {
    k: u32,
    head: Words<Pixel, Atomic, u32>,
    pool: Pool,
    next: Words<Global, Atomic, u32>,
    key: Words<Global, Plain, u64>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    name: "kb-ll",
    title: "k-buffer in a sorted linked list, by compare-exchange",
    paper: "Yu, Yang, Hensley, Harada, Yu 2012",
    section: "k+-buffer paper, 2 (KB-LL)",
    words: "1",
    frame_words: "3F + 1",
    judged: true,
    overflow: "nodes behind the k-th stay in the pool, which holds F",
    needs: "compare-exchange with release, acquire loads; 32-bit atomic add",
    demand: Demand::Generated,
    source: include_str!("kb_ll.rs"),
    ..Contract::BASE
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for PublishedFirst {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-ll@M11",
        "Fault M11: a node is published before it is written",
        "no two invocations of a pixel overlap",
    );
    const WRITTEN_FIRST: bool = false;
}

impl Variant for RelaxedPublication {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-ll@relaxed",
        "Fault relaxed: a node is published by a relaxed compare-exchange",
        "under sequential consistency only",
    );
    const PUBLISH: Order = Order::Relaxed;
}

impl<V: Variant> Scheme for KNearestList<V> {
    const CONTRACT: Contract = V::CONTRACT;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let capacity = config.generated.min(u64::from(NONE));
        Self {
            k: config.k.unwrap_or(8),
            head: layout.pixel(1),
            pool: layout.pool(),
            next: layout.global(capacity),
            key: layout.global(capacity),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        mem.store(self.pool.counter(), 0, Order::Relaxed).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.head.at(pixel, 0), NONE, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let head = self.head.at(fragment.pixel, 0);
        let (mut previous, mut nearer, mut own) = (NONE, 0, NONE);
        let _walk = mem.block();
        loop {
            let step = mem.block();
            let next = if previous == NONE {
                mem.load(head, Order::Acquire).await
            } else {
                mem.load(self.next.at(previous.into()), Order::Acquire).await
            };
            let passes =
                next != NONE && mem.plain_load(self.key.at(next.into())).await <= fragment.key();
            if passes {
                previous = next;
                nearer += 1;
                if nearer == self.k {
                    return Outcome::Culled;
                }
            } else {
                if own == NONE {
                    own = mem.take(self.pool).await;
                    if u64::from(own) >= self.next.count() {
                        return Outcome::Pool;
                    }
                    if V::WRITTEN_FIRST {
                        mem.plain_store(self.key.at(own.into()), fragment.key()).await;
                    }
                }
                mem.store(self.next.at(own.into()), next, Order::Relaxed).await;
                let found = if previous == NONE {
                    mem.compare_exchange(head, next, own, V::PUBLISH).await
                } else {
                    let link = self.next.at(previous.into());
                    mem.compare_exchange(link, next, own, V::PUBLISH).await
                };
                if found == next {
                    if !V::WRITTEN_FIRST {
                        mem.plain_store(self.key.at(own.into()), fragment.key()).await;
                    }
                    return Outcome::Kept;
                }
            }
            mem.merge(step).await;
        }
    }

    /// At any time, the list is in order, as far as it is written, and within the pool; in the end it ends.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let mut node = words.get(self.head.at(pixel, 0)).unwrap_or(NONE);
        let mut last = 0;
        for _ in 0..=self.next.count() {
            if node == NONE {
                return Ok(());
            }
            let at = u64::from(node);
            if at >= self.next.count() {
                return Err(format!("the list leads to node {node}, of {}", self.next.count()));
            }
            let (Some(key), Some(next)) = (words.get(self.key.at(at)), words.get(self.next.at(at)))
            else {
                // That is for those to find out who read it.
                let unwritten = format!("node {node} is in the list, and nobody wrote it");
                return if moment == Moment::Quiet { Err(unwritten) } else { Ok(()) };
            };
            if key < last {
                return Err(format!("node {node} is nearer than the one before"));
            }
            (last, node) = (key, next);
        }
        Err(format!("the list does not end within the pool's {} nodes", self.next.count()))
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut node = mem.load(self.head.at(pixel, 0), Order::Relaxed).await;
        for _ in 0..self.k {
            if node == NONE {
                break;
            }
            keys.push(mem.plain_load(self.key.at(node.into())).await);
            node = mem.load(self.next.at(node.into()), Order::Relaxed).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::hand_made::HandMade;

    /// A pool of 3 nodes: the head, and next and key of each node.
    fn list(head: u32, nodes: &[(u32, u64)]) -> HandMade<KNearestList> {
        let mut list = HandMade::<KNearestList>::new(Some(2), 3);
        let (at, next) = (list.scheme.head.at(0, 0), list.scheme.next);
        let keys = list.scheme.key;
        list.set(at, head);
        for (node, &(to, key)) in (0..).zip(nodes) {
            list.set(next.at(node), to);
            list.set(keys.at(node), key);
        }
        list
    }

    #[test]
    fn sorted_lists_pass() {
        assert_eq!(HandMade::<KNearestList>::new(Some(2), 3).check(Moment::Always), Ok(()));
        assert_eq!(list(NONE, &[]).check(Moment::Quiet), Ok(()));
        assert_eq!(list(1, &[(2, 5), (0, 4), (NONE, 5)]).check(Moment::Always), Ok(()));
        assert_eq!(list(0, &[(1, 5)]).check(Moment::Always), Ok(()), "not written yet");
    }

    #[test]
    fn others_are_found() {
        let cases = [
            (list(0, &[(1, 5), (NONE, 4)]), "node 1 is nearer than the one before"),
            (list(0, &[(1, 5), (0, 5)]), "does not end"),
            (list(3, &[]), "node 3, of 3"),
            (list(0, &[(1, 5)]), "node 1 is in the list, and nobody wrote it"),
        ];
        for (list, words) in cases {
            let message = list.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
