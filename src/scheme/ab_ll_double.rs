//! A-buffer in doubly linked lists: reconstructed. Surveys name the variant; we know of no text that defines it, so this
//! is the plain extension of `ab-ll` (Yang et al. 2010).
//!
//! As there, an atomic exchange on the pixel's head publishes a node, and its old value becomes the node's next. The
//! new node is the first, so it has no previous one, and says so before it is published; the old head learns of its
//! previous afterwards, from the invocation that displaced it. That is the only word of a node that two invocations
//! write, one after the other, and so the exchange releases and acquires: or "none" might land last.
//!
//! Resolve walks to the end by `next`, and collects on the way back by `previous`, so that it depends on both.

use std::marker::PhantomData;

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Plain, Pool, Snapshot, Words};
use crate::scheme::contract::Demand;
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// No node.
const NONE: u32 = u32::MAX;

/// Words of a node: next, previous, depth, data.
const NODE: u64 = 4;

/// The correct form, or a fault in it.
pub trait Variant: Sync {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How the head is replaced.
    const PUBLISH: Order = Order::AcqRel;
    /// Whether a node's previous is written before it is published.
    const WRITTEN_FIRST: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M11: that a node has no previous one is written after it is published, when it may have got one.
#[derive(Debug)]
pub enum PublishedFirst {}

/// The exchange orders nothing: of the two writes to a node's previous, either may be the last.
#[derive(Debug)]
pub enum RelaxedPublication {}

/// The method.
#[derive(Debug)]
pub struct AbDoubleList<V = Correct> {
    head: Words<Pixel, Atomic, u32>,
    pool: Pool,
    nodes: Words<Global, Plain, u32>,
    capacity: u64,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    name: "ab-ll-double",
    title: "A-buffer in doubly linked lists (reconstructed)",
    paper: "none: a variant of Yang et al. 2010 that surveys name",
    section: "reconstructed",
    words: "1",
    frame_words: "4F + 1",
    exact_when: "the pool holds F nodes (it does)",
    overflow: "drop, counted",
    needs: "32-bit atomic add; atomic exchange with acquire and release",
    wgsl: None,
    demand: Demand::Generated,
    source: include_str!("ab_ll_double.rs"),
    ..Contract::BASE_ALL
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for PublishedFirst {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll-double@M11",
        "Fault M11: a node is published before its previous is written",
        "no two invocations of a pixel overlap",
    );
    const WRITTEN_FIRST: bool = false;
}

impl Variant for RelaxedPublication {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll-double@relaxed",
        "Fault relaxed: the head is replaced by a relaxed exchange",
        "under sequential consistency only",
    );
    const PUBLISH: Order = Order::Relaxed;
}

impl<V: Variant> Scheme for AbDoubleList<V> {
    const CONTRACT: Contract = V::CONTRACT;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let capacity = config.generated.min(u64::from(NONE));
        Self {
            head: layout.pixel(1),
            pool: layout.pool(),
            nodes: layout.global(NODE * capacity),
            capacity,
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
        let node = mem.take(self.pool).await;
        if u64::from(node) >= self.capacity {
            return Outcome::Pool;
        }
        let word = NODE * u64::from(node);
        mem.plain_store(self.nodes.at(word + 2), fragment.depth).await;
        mem.plain_store(self.nodes.at(word + 3), fragment.data).await;
        if V::WRITTEN_FIRST {
            mem.plain_store(self.nodes.at(word + 1), NONE).await;
        }
        let next = mem.exchange(self.head.at(fragment.pixel, 0), node, V::PUBLISH).await;
        mem.plain_store(self.nodes.at(word), next).await;
        if !V::WRITTEN_FIRST {
            mem.plain_store(self.nodes.at(word + 1), NONE).await;
        }
        let behind = mem.block();
        if next != NONE {
            mem.plain_store(self.nodes.at(NODE * u64::from(next) + 1), node).await;
        }
        mem.merge(behind).await;
        Outcome::Kept
    }

    /// In the end, both directions agree. No list for which that holds has a cycle, since its first node has no
    /// previous one and every other has one only.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let head = words.get(self.head.at(pixel, 0));
        let (Moment::Quiet, Some(mut node)) = (moment, head) else { return Ok(()) };
        let mut before = NONE;
        while node != NONE {
            if u64::from(node) >= self.capacity {
                return Err(format!("the list leads to node {node}, of {}", self.capacity));
            }
            let word = |i| words.get(self.nodes.at(NODE * u64::from(node) + i));
            let (Some(next), Some(previous)) = (word(0), word(1)) else {
                return Err(format!("nobody wrote where node {node} leads to"));
            };
            if previous != before {
                return Err(format!("node {node} leads back to {previous} instead of {before}"));
            }
            (before, node) = (node, next);
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut node = mem.load(self.head.at(pixel, 0), Order::Relaxed).await;
        let mut last = NONE;
        while node != NONE {
            last = node;
            node = mem.plain_load(self.nodes.at(NODE * u64::from(node))).await;
        }
        while last != NONE {
            let word = NODE * u64::from(last);
            last = mem.plain_load(self.nodes.at(word + 1)).await;
            let depth = mem.plain_load(self.nodes.at(word + 2)).await;
            keys.push(key(depth, mem.plain_load(self.nodes.at(word + 3)).await));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::hand_made::HandMade;

    /// A pool of 3 nodes: the head, and next and previous of each node.
    fn list(head: u32, links: &[(u32, u32)]) -> HandMade<AbDoubleList> {
        let mut list = HandMade::<AbDoubleList>::new(None, 3);
        let (at, nodes) = (list.scheme.head.at(0, 0), list.scheme.nodes);
        list.set(at, head);
        for (node, &(next, previous)) in (0..).zip(links) {
            list.set(nodes.at(NODE * node), next);
            list.set(nodes.at(NODE * node + 1), previous);
        }
        list
    }

    #[test]
    fn lists_that_agree_pass() {
        assert_eq!(list(NONE, &[]).check(Moment::Quiet), Ok(()));
        let right = list(2, &[(NONE, 1), (0, 2), (1, NONE)]);
        assert_eq!(right.check(Moment::Quiet), Ok(()));
        let wrong = list(1, &[(NONE, NONE), (0, NONE)]);
        assert_eq!(wrong.check(Moment::Always), Ok(()), "looked at in the end only");
    }

    #[test]
    fn lists_that_do_not_agree_are_found() {
        let cases = [
            (list(1, &[(NONE, NONE), (0, NONE)]), "node 0 leads back to 4294967295 instead of 1"),
            (list(0, &[(1, NONE), (0, 0)]), "node 0 leads back to 4294967295 instead of 1"),
            (list(3, &[]), "node 3, of 3"),
            (list(1, &[(NONE, NONE)]), "nobody wrote where node 1"),
        ];
        for (list, words) in cases {
            let message = list.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
