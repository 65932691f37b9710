//! Your own method, and the whole tool with it in the catalogue: an A-buffer in per-pixel lists, pushed by
//! compare-exchange (Treiber's stack).
//!
//! ```text
//! cargo run --release --example user_scheme -- render cubes -m cas-list -o a.png
//! cargo run --release --example user_scheme -- check cas-list
//! cargo run --release --example user_scheme -- check cas-list@broken
//! cargo run --release --example user_scheme -- replay TOKEN
//! ```
//!
//! The broken twin replaces the head whatever it is by then. That loses fragments: `check` refutes it with a schedule
//! that shows the loss, as a token for `replay`, and exits with code 1.

use std::process::ExitCode;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::fragment::{Fragment, key};
use fragloom::memory::{Atomic, Global, Layout, Memory, Order, Pixel, Plain, Pool, Update, Words};
use fragloom::scheme::contract::{Demand, Form, Keeps, Overflow};
use fragloom::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// The end of a list.
const NONE: u32 = u32::MAX;

/// A list by compare-exchange, or its broken twin.
pub(crate) struct CasList<const BROKEN: bool> {
    head: Words<Pixel, Atomic, u32>,
    pool: Pool,
    /// Three words per node: next, depth, data.
    nodes: Words<Global, Plain, u32>,
    capacity: u64,
}

impl<const BROKEN: bool> Scheme for CasList<BROKEN> {
    const CONTRACT: Contract = Contract {
        title: "A-buffer in per-pixel lists, pushed by compare-exchange",
        paper: "Treiber 1986",
        form: if BROKEN { Form::Mutation } else { Form::Correct },
        words: "1",
        frame_words: "3F + 1",
        exact_when: "the pool holds F nodes",
        overflow: Overflow::Drops("drop, counted"),
        needs: "32-bit atomic add and compare-exchange, relaxed",
        wgsl: Some("storage buffers; atomicAdd, atomicCompareExchangeWeak"),
        demand: Demand::Generated,
        source: include_str!("user_scheme.rs"),
        ..Contract::new(if BROKEN { "cas-list@broken" } else { "cas-list" }, Keeps::All)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let capacity = config.generated;
        let (head, pool) = (layout.pixel(1), layout.pool());
        Self { head, pool, nodes: layout.global(3 * capacity), capacity }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        mem.store(self.pool.counter(), 0, Order::Relaxed).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.head.at(pixel, 0), NONE, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (node, head) = (mem.take(self.pool).await, self.head.at(fragment.pixel, 0));
        if u64::from(node) >= self.capacity {
            return Outcome::Pool;
        }
        let [next, depth, data] = [0, 1, 2].map(|i| self.nodes.at(3 * u64::from(node) + i));
        mem.plain_store(depth, fragment.depth).await;
        mem.plain_store(data, fragment.data).await;
        // A lane that succeeds leaves both blocks; where a warp comes together matters, and a check knows it by these.
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            let first = mem.load(head, Order::Relaxed).await;
            mem.plain_store(next, first).await;
            let push = match BROKEN {
                false => Update::CompareExchange { expected: first, new: node },
                true => Update::Exchange(node),
            };
            if mem.update(head, push, Order::Relaxed).await == first || BROKEN {
                return Outcome::Kept;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut node = mem.load(self.head.at(pixel, 0), Order::Relaxed).await;
        while node != NONE {
            let [next, depth, data] = [0, 1, 2].map(|i| self.nodes.at(3 * u64::from(node) + i));
            keys.push(key(mem.plain_load(depth).await, mem.plain_load(data).await));
            node = mem.plain_load(next).await;
        }
    }
}

fn main() -> ExitCode {
    let both = [Method::of::<CasList<false>>(), Method::of::<CasList<true>>()];
    let catalogue = both.into_iter().try_fold(Catalogue::built_in(), Catalogue::with);
    fragloom::cli::main(&catalogue.expect("no built-in method has these names"))
}
