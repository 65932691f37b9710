//! A method that merges fragments, and the whole tool with it in the catalogue: an A-buffer in per-pixel linked lists
//! whose resolve merges the two nearest fragments of a pixel into one record.
//!
//! ```text
//! cargo run --release --example merge_two -- render cubes -m merge-two -o merged.png
//! cargo run --release --example merge_two -- check merge-two
//! ```
//!
//! What is new, compared with a method that keeps fragments: a pixel holds [`Records`], and [`Scheme::expected`] says
//! what they must be, as a function of the pixel's fragments. Drawings and checks are held to that.

use std::process::ExitCode;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::fragment::{Fragment, data_of, depth_of};
use fragloom::memory::{Inputs, Layout, Memory, Order, Plain};
use fragloom::render::Data;
use fragloom::scheme::contract::{Demand, Overflow};
use fragloom::scheme::parts::list::{Lists, NONE};
use fragloom::scheme::{Config, Contract, Keeps, Outcome, Record, Records, Scheme};

/// The method.
pub(crate) struct MergeTwo {
    lists: Lists<Plain>,
}

/// What a pixel with these fragments, nearest first, must hold.
fn merged(fragments: &[u64]) -> Records {
    let surface = |&key: &u64| Record::surface(depth_of(key), data_of(key));
    let mut list: Vec<Record> = fragments.iter().map(surface).collect();
    let merged = u32::from(list.len() >= 2);
    if merged == 1 {
        let nearest = list.remove(0);
        list[0] = over(&nearest, &list[0]);
    }
    Records::of(list, merged)
}

/// One record in front of another, as one: colours are premultiplied, so what is behind is weighted by 1 minus the
/// front's opacity. It stands at the farther depth.
fn over(front: &Record, back: &Record) -> Record {
    let rest = 1.0 - front.rgba[3];
    let rgba = std::array::from_fn(|i| front.rgba[i] + rest * back.rgba[i]);
    Record { depth: back.depth, thickness: 0.0, rgba, weight: front.weight + back.weight }
}

impl Scheme for MergeTwo {
    const CONTRACT: Contract = Contract {
        title: "A-buffer whose two nearest fragments are merged",
        words: "1",
        frame_words: "3F + 1",
        overflow: Overflow::Drops("drop, counted"),
        data: Some(Data::Color),
        demand: Demand::Generated,
        source: include_str!("merge_two.rs"),
        ..Contract::new("merge-two", Keeps::Merged)
    };

    type Holds = Records;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self { lists: Lists::new(1, config, layout) }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.lists.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lists.clear(mem, pixel, 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let node = self.lists.take(mem).await;
        if u64::from(node) >= self.lists.capacity() {
            return Outcome::Pool;
        }
        self.lists.fill(mem, node, fragment).await;
        let next = self.lists.publish(mem, fragment.pixel, 0, node, Order::Relaxed).await;
        mem.plain_store(self.lists.link(node), next).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, records: &mut Records) {
        let mut keys = Vec::new();
        let mut node = mem.load(self.lists.head(pixel, 0), Order::Relaxed).await;
        while node != NONE {
            keys.push(self.lists.key(mem, node).await);
            node = mem.plain_load(self.lists.link(node)).await;
        }
        keys.sort_unstable();
        records.append(&merged(&keys));
    }

    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Records> {
        let keys: Vec<u64> = generated.iter().map(|fragment| fragment.key()).collect();
        Some(merged(&keys))
    }
}

fn main() -> ExitCode {
    let catalogue = Catalogue::built_in().with(Method::of::<MergeTwo>());
    fragloom::cli::main(&catalogue.expect("no built-in method has this name"))
}
