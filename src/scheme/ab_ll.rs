//! A-buffer in per-pixel linked lists (Yang, Hensley, Grün, Thibieroz, "Real-time concurrent linked list construction on
//! the GPU", 2010).
//!
//! A global counter hands out nodes; an atomic exchange on the pixel's head publishes a node, and its old value becomes
//! the node's next. The node is written after it is published, which is harmless here: nobody reads it before the
//! barrier. The pool holds as many nodes as the scene has fragments.

use crate::fragment::{Fragment, key};
use crate::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Plain, Pool, Words};
use crate::scheme::contract::{Barriers, Demand, Form, Keeps};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// The end of a list.
const NONE: u32 = u32::MAX;

/// Words of a node: next, depth, data.
const NODE: u64 = 3;

/// The method.
#[derive(Debug)]
pub struct AbLinkedList {
    head: Words<Pixel, Atomic, u32>,
    pool: Pool,
    nodes: Words<Global, Plain, u32>,
    capacity: u64,
}

impl Scheme for AbLinkedList {
    const CONTRACT: Contract = Contract {
        name: "ab-ll",
        title: "A-buffer in per-pixel linked lists",
        paper: "Yang, Hensley, Grün, Thibieroz 2010",
        section: "k+-buffer paper, 2 (LL)",
        form: Form::Correct,
        passes: 1,
        words: "1, and 3F + 1 for the frame",
        keeps: Keeps::All,
        exact_when: "the pool holds F nodes (it does)",
        arrival_dependent: false,
        racy: false,
        ties: "all kept; canonical after resolve",
        overflow: "drop, counted",
        needs: "32-bit atomic add and exchange, relaxed",
        wgsl: Some("storage buffers; atomicAdd, atomicExchange"),
        depth_format: None,
        default_k: None,
        max_k: u32::MAX,
        demand: Demand::Generated,
        barriers: Barriers::ALL,
        source: include_str!("ab_ll.rs"),
    };

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let capacity = config.generated.min(u64::from(NONE));
        Self {
            head: layout.pixel(1),
            pool: layout.pool(),
            nodes: layout.global(NODE * capacity),
            capacity,
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
        let next = mem.exchange(self.head.at(fragment.pixel, 0), node, Order::Relaxed).await;
        let word = NODE * u64::from(node);
        mem.plain_store(self.nodes.at(word), next).await;
        mem.plain_store(self.nodes.at(word + 1), fragment.depth).await;
        mem.plain_store(self.nodes.at(word + 2), fragment.data).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut node = mem.load(self.head.at(pixel, 0), Order::Relaxed).await;
        while node != NONE {
            let word = NODE * u64::from(node);
            node = mem.plain_load(self.nodes.at(word)).await;
            let depth = mem.plain_load(self.nodes.at(word + 1)).await;
            keys.push(key(depth, mem.plain_load(self.nodes.at(word + 2)).await));
        }
    }
}
