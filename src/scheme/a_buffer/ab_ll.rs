//! A-buffer in per-pixel linked lists (Yang, Hensley, Grün, Thibieroz, "Real-time concurrent linked list construction
//! on the GPU", 2010).
//!
//! A global counter hands out nodes; an atomic exchange on the pixel's head publishes a node, and its old value becomes
//! the node's next, which can only be written afterwards. That is harmless here: no invocation reads a node before the
//! barrier. The pool holds as many nodes as the scene has fragments.

use std::marker::PhantomData;

use crate::fragment::Fragment;
use crate::memory::{Layout, Memory, Order, OwnedBlock, Snapshot};
use crate::raster::Batch;
use crate::scheme::parts::list::Lists;
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Outcomes, Scheme};

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether the head is replaced by one atomic operation.
    const ATOMIC_HEAD: bool = true;
    /// Whether the fragment is written before its node is published.
    const WRITTEN_FIRST: bool = true;
    /// Whether the first node beyond the pool is refused.
    const BOUNDED: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M11: a node is published before anything of it is written. Expected to be equivalent: no invocation reads a node
/// before the barrier.
#[derive(Debug)]
pub enum PublishedFirst {}

/// M14: the bound test lets one node too many through. It shows only where the pool is too small, which ours is not.
#[derive(Debug)]
pub enum OneTooMany {}

/// The head is replaced by a load and a store: of two invocations that read the same head, one loses its node.
#[derive(Debug)]
pub enum PlainHead {}

/// Lists are long if a frame has more fragments than this by pixel: with 8, storing block by block is no gain, and with 13
/// it is. The nodes of a tile of 64x64 pixels then take 600 kB.
const LONG: u64 = 12;

/// The method.
#[derive(Debug)]
pub struct AbLinkedList<V = Correct> {
    lists: Lists,
    /// Whether lists are long.
    long: bool,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "A-buffer in per-pixel linked lists",
    paper: "Yang, Hensley, Grün, Thibieroz 2010",
    section: "k+-buffer paper, 2 (LL)",
    needs: "32-bit atomic add and exchange, relaxed",
    wgsl: Some("storage buffers; atomicAdd, atomicExchange"),
    source: include_str!("ab_ll.rs"),
    ..super::linked("ab-ll")
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for PublishedFirst {
    const CONTRACT: Contract = Contract {
        dependence: CONTRACT.dependence,
        ..CONTRACT.fault(
            "ab-ll@M11",
            "Fault M11: a node is published before it is written (equivalent here)",
            CONTRACT.exact_when,
        )
    };
    const WRITTEN_FIRST: bool = false;
}

impl Variant for OneTooMany {
    const CONTRACT: Contract = Contract {
        dependence: CONTRACT.dependence,
        ..CONTRACT.fault(
            "ab-ll@M14",
            "Fault M14: the bound test lets one node too many through",
            CONTRACT.exact_when,
        )
    };
    const BOUNDED: bool = false;
}

impl Variant for PlainHead {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll@plain-head",
        "Fault plain-head: the head is replaced by a load and a store",
        "no two invocations of a pixel overlap",
    );
    const ATOMIC_HEAD: bool = false;
}

impl<V: Variant> Scheme for AbLinkedList<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let long = config.generated > LONG * u64::from(config.pixels);
        Self { lists: Lists::new(1, config, layout), long, variant: PhantomData }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.lists.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lists.clear(mem, pixel, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (lists, pixel) = (self.lists, fragment.pixel);
        let last = if V::BOUNDED { lists.capacity() } else { lists.capacity() + 1 };
        let node = lists.take(mem).await;
        if u64::from(node) >= last {
            return Outcome::Pool;
        }
        if V::WRITTEN_FIRST {
            lists.fill(mem, node, fragment).await;
        }
        let next = if V::ATOMIC_HEAD {
            lists.publish(mem, pixel, 0, node, Order::Relaxed).await
        } else {
            let next = mem.load(lists.head(pixel, 0), Order::Relaxed).await;
            mem.store(lists.head(pixel, 0), node, Order::Relaxed).await;
            next
        };
        mem.plain_store(lists.link(node), next).await;
        if !V::WRITTEN_FIRST {
            lists.fill(mem, node, fragment).await;
        }
        Outcome::Kept
    }

    /// Every form: without others, and where there are nodes enough, they do the same.
    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        let stored = self.lists.push_block(block, batch);
        if stored {
            outcomes.assign([]);
        }
        stored
    }

    /// Nodes of a block are taken one after another, so a tile that stores blocks one after another has a list's nodes
    /// near each other.
    fn together(&self) -> usize {
        usize::from(self.long)
    }

    /// In the end, the list ends: within the pool, and without a cycle.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        if moment == Moment::Quiet {
            for node in self.lists.nodes(words, pixel, 0) {
                node.map_err(|flaw| flaw.to_string())?;
            }
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        self.lists.collect::<_, Self>(mem, pixel, 0, keys).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::parts::hand_made::HandMade;
    use crate::scheme::parts::list::{NONE, Node};

    /// A pool of 3 nodes: the head, and where each node leads to.
    fn list(head: u32, next: &[u32]) -> HandMade<AbLinkedList> {
        let mut list = HandMade::<AbLinkedList>::new(None, 3);
        let lists = list.scheme.lists;
        list.set(lists.head(0, 0), head);
        for (number, &next) in (0..).zip(next) {
            lists.set(&mut list, Node { number, next, key: 7 });
        }
        list
    }

    #[test]
    fn lists_that_end_pass() {
        assert_eq!(HandMade::<AbLinkedList>::new(None, 3).check(Moment::Quiet), Ok(()));
        assert_eq!(list(NONE, &[]).check(Moment::Quiet), Ok(()));
        assert_eq!(list(2, &[NONE, 0, 1]).check(Moment::Quiet), Ok(()));
        assert_eq!(list(0, &[1, 0]).check(Moment::Always), Ok(()), "checked in the end only");
    }

    #[test]
    fn lists_that_do_not_end_are_found() {
        let cases = [
            (list(0, &[1, 0]), "does not end"),
            (list(3, &[NONE, NONE, NONE]), "node 3, of 3"),
            (list(1, &[NONE]), "node 1 is in the list but was not written"),
        ];
        for (list, words) in cases {
            let message = list.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
