//! k-buffer in a depth-sorted linked list per pixel (Yu, Yang, Hensley, Harada, Yu, "A framework for rendering complex
//! scattering effects on hair", I3D 2012; KB-LL).
//!
//! A fragment walks its pixel's list from the front. Behind k nodes it is culled; else its node goes before the first
//! that is farther, by a compare-exchange on its predecessor's link. Nodes never leave the list, they only fall behind
//! the k-th, where resolve does not look. Hence:
//! * a predecessor stays one: an invocation that loses a compare-exchange goes on from that node, not from the front;
//! * nodes counted in front stay in front, so that no fragment of the k nearest is culled;
//! * each failure means that another got in, so that insertions end without waiting.
//!
//! Walkers read nodes while others insert. A node is complete before the compare-exchange that publishes it, which
//! releases; links are read by acquire loads. Depth and data can then be plain: what made a node happens before any
//! read that reaches it, through however many other nodes.
//!
//! Data words decide among equal depths. An invocation cannot know whether its fragment displaces another: two that
//! insert into a list of k - 1 nodes at the same time both saw room, and both find k + 1 afterwards. So none reports
//! it, and the accounting compares lists.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Atomic, Layout, Memory, Order, Plain, Snapshot};
use crate::scheme::contract::{Accounting, Demand, Keeps, Overflow};
use crate::scheme::parts::list::{Flaw, Halves, Lists, NONE, NodeKeys, Whole};
use crate::scheme::parts::lock::reach::{Reach, Updated, updated};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How links are reached.
    type Reach: Reach;
    /// How nodes hold their keys.
    type Keys: NodeKeys;
    /// How a node is published.
    const PUBLISH: Order = Order::Release;
    /// Whether depth and data are in the node before it is published.
    const WRITTEN_FIRST: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M11: a node is published before it is written. Others that walk meanwhile read words that were never written.
#[derive(Debug)]
pub enum PublishedFirst {}

/// The compare-exchange orders nothing, so that others may see a node without what is in it.
#[derive(Debug)]
pub enum RelaxedPublication {}

/// The method.
#[derive(Debug)]
pub struct KNearestList<V: Variant = Correct> {
    k: u32,
    lists: Lists<Atomic, V::Keys>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "k-buffer in a sorted linked list, by compare-exchange",
    paper: "Yu, Yang, Hensley, Harada, Yu 2012",
    section: "k+-buffer paper, 2 (KB-LL)",
    words: "1",
    frame_words: "3F + 1",
    overflow: Overflow::Never("nodes behind the k-th stay in the pool, which holds F"),
    needs: "compare-exchange with release, acquire loads; 32-bit atomic add",
    wgsl: Some(
        "storage buffers; a publication is outside WGSL's guarantees (relaxed atomics only)",
    ),
    demand: Demand::Generated,
    source: include_str!("kb_ll.rs"),
    accounting: Accounting::Judged,
    ..Contract::new("kb-ll", Keeps::Nearest)
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
    type Reach = Plain;
    type Keys = Whole;
}

impl Variant for Atomic {
    const CONTRACT: Contract =
        CONTRACT.mended("kb-ll@atomic", "k-buffer in a sorted linked list, all words atomic");
    type Reach = Self;
    type Keys = Halves<Self>;
}

impl Variant for Updated {
    const CONTRACT: Contract = Contract {
        needs: "32-bit atomic updates, relaxed; no load buffering",
        ..updated(CONTRACT, "kb-ll@rmw", "k-buffer in a sorted linked list, nodes by updates")
    };
    type Reach = Self;
    type Keys = Halves<Self>;
    const PUBLISH: Order = Order::Relaxed;
}

impl Variant for PublishedFirst {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-ll@M11",
        "Fault M11: a node is published before it is written",
        "no two invocations of a pixel overlap",
    );
    type Reach = Plain;
    type Keys = Whole;
    const WRITTEN_FIRST: bool = false;
}

impl Variant for RelaxedPublication {
    const CONTRACT: Contract = CONTRACT.fault(
        "kb-ll@relaxed",
        "Fault relaxed: a node is published by a relaxed compare-exchange",
        "under sequential consistency only",
    );
    type Reach = Plain;
    type Keys = Whole;
    const PUBLISH: Order = Order::Relaxed;
}

impl<V: Variant> Scheme for KNearestList<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let lists = Lists::new(1, config, layout);
        Self { k: config.k.unwrap_or(8), lists, variant: PhantomData }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.lists.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lists.clear(mem, pixel, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let lists = self.lists;
        let head = lists.head(fragment.pixel, 0);
        let (mut previous, mut nearer, mut own) = (NONE, 0, NONE);
        let _walk = mem.block();
        loop {
            mem.here(&[previous.into(), nearer.into(), own.into()]);
            let step = mem.block();
            let next = if previous == NONE {
                mem.load(head, V::Reach::ACQUIRE).await
            } else {
                V::Reach::load(mem, lists.link(previous), Order::Acquire).await
            };
            let passes = next != NONE && V::Keys::of(lists.read(mem, next).await) <= fragment.key();
            if passes {
                previous = next;
                nearer += 1;
                if nearer == self.k {
                    return Outcome::Culled;
                }
            } else {
                if own == NONE {
                    own = lists.take(mem).await;
                    if u64::from(own) >= lists.capacity() {
                        return Outcome::Pool;
                    }
                    if V::WRITTEN_FIRST {
                        lists.fill(mem, own, fragment).await;
                    }
                }
                V::Reach::store(mem, lists.link(own), next, Order::Relaxed).await;
                let found = if previous == NONE {
                    mem.compare_exchange(head, next, own, V::PUBLISH).await
                } else {
                    mem.compare_exchange(lists.link(previous), next, own, V::PUBLISH).await
                };
                if found == next {
                    if !V::WRITTEN_FIRST {
                        lists.fill(mem, own, fragment).await;
                    }
                    return Outcome::Kept;
                }
            }
            mem.merge(step).await;
        }
    }

    /// At any time, the list is in order, as far as it is written, and within the pool; in the end it ends.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let mut last = 0;
        for node in self.lists.nodes(words, pixel, 0) {
            let node = match node {
                Ok(node) => node,
                // An invocation that reads it finds that out.
                Err(Flaw::Unwritten(_)) if moment == Moment::Always => return Ok(()),
                Err(flaw) => return Err(flaw.to_string()),
            };
            if node.key < last {
                return Err(format!("node {} is nearer than the one before", node.number));
            }
            last = node.key;
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut node = mem.load(self.lists.head(pixel, 0), Order::Relaxed).await;
        for _ in 0..self.k {
            if node == NONE {
                break;
            }
            keys.push(V::Keys::of(self.lists.settled(mem, node).await));
            node = mem.load(self.lists.link(node), Order::Relaxed).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::parts::hand_made::HandMade;
    use crate::scheme::parts::list::Node;

    /// A pool of 3 nodes: the head, and next and key of each node.
    fn list(head: u32, nodes: &[(u32, u64)]) -> HandMade<KNearestList> {
        let mut list = HandMade::<KNearestList>::new(Some(2), 3);
        let lists = list.scheme.lists;
        list.set(lists.head(0, 0), head);
        for (number, &(next, key)) in (0..).zip(nodes) {
            lists.set(&mut list, Node { number, next, key });
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
            (list(0, &[(1, 5)]), "node 1 is in the list but was not written"),
        ];
        for (list, words) in cases {
            let message = list.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
