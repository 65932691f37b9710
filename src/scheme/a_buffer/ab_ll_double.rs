//! A-buffer in doubly linked lists: reconstructed. Surveys name the variant; we found no text that defines it, so this
//! is the plain extension of `ab-ll` (Yang et al. 2010).
//!
//! As there, an atomic exchange on the pixel's head publishes a node, and its old value becomes the node's next. The
//! new node is the first, so it has no previous one, and says so before it is published; the old head learns of its
//! previous afterwards, from the invocation that displaced it. That is the only word of a node that two invocations
//! write, one after the other. So the exchange releases and acquires: otherwise "none" might land last.
//!
//! Resolve walks to the end by `next`, and collects on the way back by `previous`, so that it depends on both.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Global, Layout, Memory, Order, Plain, Snapshot, Words};
use crate::scheme::parts::list::{Lists, NONE};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
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
    lists: Lists,
    previous: Words<Global, Plain, u32>,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "A-buffer in doubly linked lists (reconstructed)",
    paper: "none: a variant of Yang et al. 2010 that surveys name",
    section: "reconstructed",
    frame_words: "4F + 1",
    needs: "32-bit atomic add; atomic exchange with acquire and release",
    wgsl: Some(
        "storage buffers; the order of two writes to a node is outside WGSL's guarantees (relaxed atomics only)",
    ),
    source: include_str!("ab_ll_double.rs"),
    ..super::linked("ab-ll-double")
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

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let lists = Lists::new(1, config, layout);
        Self {
            lists,
            previous: layout.named("previous").global(lists.capacity()),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.lists.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lists.clear(mem, pixel, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let lists = self.lists;
        let node = lists.take(mem).await;
        if u64::from(node) >= lists.capacity() {
            return Outcome::Pool;
        }
        lists.fill(mem, node, fragment).await;
        if V::WRITTEN_FIRST {
            mem.plain_store(self.previous.at(node.into()), NONE).await;
        }
        let next = lists.publish(mem, fragment.pixel, 0, node, V::PUBLISH).await;
        mem.plain_store(lists.link(node), next).await;
        if !V::WRITTEN_FIRST {
            mem.plain_store(self.previous.at(node.into()), NONE).await;
        }
        let behind = mem.block();
        if next != NONE {
            mem.plain_store(self.previous.at(next.into()), node).await;
        }
        mem.merge(behind).await;
        Outcome::Kept
    }

    /// In the end, both directions agree. No list for which that holds has a cycle, since its first node has no
    /// previous one and every other has one only.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        if moment == Moment::Always {
            return Ok(());
        }
        let mut before = NONE;
        for node in self.lists.nodes(words, pixel, 0) {
            let number = node.map_err(|flaw| flaw.to_string())?.number;
            let previous = words.get(self.previous.at(number.into()));
            let previous =
                previous.ok_or_else(|| format!("node {number}'s previous was never written"))?;
            if previous != before {
                return Err(format!("node {number} leads back to {previous} instead of {before}"));
            }
            before = number;
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut node = mem.load(self.lists.head(pixel, 0), Order::Relaxed).await;
        let mut last = NONE;
        while node != NONE {
            last = node;
            node = mem.plain_load(self.lists.link(node)).await;
        }
        while last != NONE {
            keys.push(self.lists.key(mem, last).await);
            last = mem.plain_load(self.previous.at(last.into())).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::parts::hand_made::HandMade;
    use crate::scheme::parts::list::Node;

    /// A pool of 3 nodes: the head, and next and previous of each node.
    fn list(head: u32, links: &[(u32, u32)]) -> HandMade<AbDoubleList> {
        let mut list = HandMade::<AbDoubleList>::new(None, 3);
        let (lists, back) = (list.scheme.lists, list.scheme.previous);
        list.set(lists.head(0, 0), head);
        for (number, &(next, previous)) in (0..).zip(links) {
            lists.set(&mut list, Node { number, next, key: 7 });
            list.set(back.at(number.into()), previous);
        }
        list
    }

    #[test]
    fn lists_that_agree_pass() {
        assert_eq!(list(NONE, &[]).check(Moment::Quiet), Ok(()));
        let right = list(2, &[(NONE, 1), (0, 2), (1, NONE)]);
        assert_eq!(right.check(Moment::Quiet), Ok(()));
        let wrong = list(1, &[(NONE, NONE), (0, NONE)]);
        assert_eq!(wrong.check(Moment::Always), Ok(()), "checked in the end only");
    }

    #[test]
    fn lists_that_do_not_agree_are_found() {
        let cases = [
            (list(1, &[(NONE, NONE), (0, NONE)]), "node 0 leads back to 4294967295 instead of 1"),
            (list(0, &[(1, NONE), (0, 0)]), "node 0 leads back to 4294967295 instead of 1"),
            (list(3, &[]), "node 3, of 3"),
            (list(1, &[(NONE, NONE)]), "node 1 is in the list but was not written"),
        ];
        for (list, words) in cases {
            let message = list.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
