//! Adaptive transparency (Salvi, Montgomery, Lefohn, HPG 2011): the visibility function of a pixel in k nodes, by a first
//! geometry pass; a second one sums every fragment's colour times the visibility in front of it.
//!
//! A node is (`d_i`, `T_i`), `T_i` being what passes up to behind `d_i`. Where one too many comes, the node i that changes the
//! function least goes, by (`d_i` - d_{i-1}) (T_{i-1} - `T_i`); never the first. Its predecessor takes `T_i`, so that visibility
//! is underestimated between both. d is the distance along the line of sight.
//!
//! Here a node has what passes *at* it, `t_i` = `T_i` / T_{i-1}, in 16 bits; `T_i` is the product from the front, rounded as
//! compositing rounds ([`Ray`]). So a fragment multiplies one node and not all behind it, what was inserted does not
//! depend on the order of insertions, and with k for all fragments the picture is the exact one, as long as no two of
//! them are wholly alike (those see the same visibility).
//!
//! It depends on arrival where more than one node is removed. Up to k + 1 fragments give the same in every order.
//!
//! * `adaptive@over`: what the removed node stops is stopped by its successor, so that visibility is overestimated.
//! * `adaptive@keeps-last`: the last node is never removed either.

use std::marker::PhantomData;

use super::{approximate, arrivals};
use crate::fragment::{Fragment, data_of, depth_of, key};
use crate::memory::{Access, Atomic, Inputs, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::planes::Distances;
use crate::num::ray::Ray;
use crate::scheme::contract::{Dependence, Limit};
use crate::scheme::parts::lock::{self, FREE, SpinLock};
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// Which form it is.
pub trait Variant: Send + Sync + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// Whether visibility is overestimated where a node was removed.
    const OVER: bool = false;
    /// Whether the last node is never removed, either.
    const KEEPS_LAST: bool = false;
}

/// The method.
#[derive(Debug)]
pub struct Adaptive<V = Under> {
    k: u32,
    distances: Distances,
    lock: SpinLock,
    count: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
    passes: Words<Pixel, Plain, u32>,
    sums: Words<Pixel, Atomic, u32>,
    variant: PhantomData<V>,
}

/// The key of a fragment, and the share of light that passes there, of 65,535.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Node {
    key: u64,
    passes: u32,
}

/// A product of shares.
fn times(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b) + 32_767) / 65_535) as u32
}

impl Node {
    fn new(fragment: Fragment) -> Self {
        Self { key: fragment.key(), passes: 257 * (255 - (fragment.data >> 24)) }
    }
}

/// Put a node into its place.
fn insert(nodes: &mut Vec<Node>, new: Node) {
    let place = nodes.partition_point(|node| node.key <= new.key);
    nodes.insert(place, new);
}

/// What a fragment of that key adds to the colour.
fn terms(nodes: impl Iterator<Item = Node>, key: u64) -> [u32; 3] {
    let seen = nodes.take_while(|node| node.key < key);
    let transmittance = seen.fold(65_535, |all, node| times(all, node.passes));
    let mut ray = Ray { transmittance, ..Ray::default() };
    ray.over(data_of(key));
    ray.color
}

fn light(sums: [u32; 3], nodes: impl Iterator<Item = Node>) -> Light {
    let transmittance = nodes.fold(65_535, |all, node| times(all, node.passes));
    Ray { color: sums.map(|sum| sum.min(65_535)), transmittance }.light()
}

impl<V: Variant> Adaptive<V> {
    /// Remove the node that changes visibility least, the first of several, if there are more than k.
    fn shorten(&self, nodes: &mut Vec<Node>) {
        let n = nodes.len();
        if n <= self.k as usize {
            return;
        }
        let along = |node: &Node| self.distances.along(depth_of(node.key));
        let (mut before, mut least, mut place) = (nodes[0].passes, f64::INFINITY, n - 1);
        let end = if V::KEEPS_LAST && n > 2 { n - 1 } else { n };
        for i in 1..end {
            let behind = times(before, nodes[i].passes);
            let width = along(&nodes[i]) - along(&nodes[i - 1]);
            let error = width * f64::from(before - behind);
            if error < least {
                (least, place) = (error, i);
            }
            before = behind;
        }
        let gone = nodes.remove(place);
        let takes = if V::OVER && place < nodes.len() { place } else { place - 1 };
        nodes[takes].passes = times(nodes[takes].passes, gone.passes);
    }

    /// What fragments in this order of arrival give.
    fn arrived(&self, fragments: &[Fragment]) -> Light {
        let mut nodes = Vec::new();
        for &fragment in fragments {
            insert(&mut nodes, Node::new(fragment));
            self.shorten(&mut nodes);
        }
        let mut sums = [0; 3];
        for fragment in fragments {
            let terms = terms(nodes.iter().copied(), fragment.key());
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        light(sums, nodes.into_iter())
    }

    async fn node<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> Node {
        let depth = mem.plain_load(self.depth.at(pixel, i)).await;
        let data = mem.plain_load(self.data.at(pixel, i)).await;
        let passes = mem.plain_load(self.passes.at(pixel, i)).await;
        Node { key: key(depth, data), passes }
    }

    async fn nodes<M: Memory>(&self, mem: &M, pixel: u32) -> Vec<Node> {
        let count = mem.plain_load(self.count.at(pixel, 0)).await;
        let mut nodes = Vec::with_capacity(count as usize + 1);
        for i in 0..count {
            nodes.push(self.node(mem, pixel, i).await);
        }
        nodes
    }
}

impl<V: Variant> Scheme for Adaptive<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(DEFAULT_K);
        let mut of_node = |name| layout.named(name).pixel(u64::from(k));
        let [depth, data, passes] = ["depth", "data", "passes"].map(&mut of_node);
        Self {
            k,
            distances: config.distances,
            lock: SpinLock::new(layout),
            count: layout.named("count").pixel(1),
            depth,
            data,
            passes,
            sums: layout.named("sums").pixel(3),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.plain_store(self.count.at(pixel, 0), 0).await;
        for i in 0..3 {
            mem.store(self.sums.at(pixel, i), 0, Order::Relaxed).await;
        }
    }

    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        let pixel = fragment.pixel;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
                let old = self.nodes(mem, pixel).await;
                let mut new = old.clone();
                insert(&mut new, Node::new(fragment));
                self.shorten(&mut new);
                for (i, node) in (0..).zip(&new) {
                    if old.get(i as usize) != Some(node) {
                        mem.plain_store(self.depth.at(pixel, i), depth_of(node.key)).await;
                        mem.plain_store(self.data.at(pixel, i), data_of(node.key)).await;
                        mem.plain_store(self.passes.at(pixel, i), node.passes).await;
                    }
                }
                mem.plain_store(self.count.at(pixel, 0), new.len() as u32).await;
                self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                return;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let nodes = self.nodes(mem, fragment.pixel).await;
        for (i, term) in (0..).zip(terms(nodes.into_iter(), fragment.key())) {
            mem.add(self.sums.at(fragment.pixel, i), term, Order::Relaxed).await;
        }
        Outcome::Merged
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        let mut sums = [0; 3];
        for (i, sum) in (0..).zip(&mut sums) {
            *sum = mem.load(self.sums.at(pixel, i), Order::Relaxed).await;
        }
        *held = light(sums, self.nodes(mem, pixel).await.into_iter());
    }

    /// Where arrival does not matter.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        if generated.len() > self.k as usize + 1 {
            return None;
        }
        Some(self.arrived(generated))
    }

    fn possible(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Vec<Light> {
        arrivals(generated).map(|order| self.arrived(&order)).collect()
    }
}

/// Nodes, as in the paper's pictures.
const DEFAULT_K: u32 = 8;

const CONTRACT: Contract = Contract {
    title: "adaptive transparency: two passes, the visibility function in k nodes",
    paper: "Salvi, Montgomery, Lefohn 2011",
    section: "3.1, 3.2",
    program: Program::of(&[
        Pass::new("visibility", PassKind::Prepare, Barrier::Pixel),
        Pass::store(Barrier::Pixel),
    ]),
    words: "3k + 5",
    published_words: Some("2k"),
    exact_when: "k >= f(p) and no two fragments are wholly alike",
    ties: "canonical: the smaller data word is nearer",
    dependence: Dependence::Arrival,
    needs: "acquire and release on a 32-bit word; forward progress of the lock's holder; two geometry passes",
    wgsl: lock::WGSL,
    default_k: Some(DEFAULT_K),
    max_k: u32::MAX / 16,
    source: include_str!("adaptive.rs"),
    ..approximate("adaptive", Limit::Nowhere)
};

/// Visibility is underestimated.
#[derive(Debug)]
pub struct Under;

/// Visibility is overestimated.
#[derive(Debug)]
pub struct Over;

/// The last node stays.
#[derive(Debug)]
pub struct KeepsLast;

impl Variant for Under {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for Over {
    const CONTRACT: Contract = Contract {
        name: "adaptive@over",
        title: "adaptive transparency that overestimates visibility where nodes are removed",
        section: "variants of public code",
        ..CONTRACT
    };
    const OVER: bool = true;
}

impl Variant for KeepsLast {
    const CONTRACT: Contract = Contract {
        name: "adaptive@keeps-last",
        title: "adaptive transparency that never removes the last node",
        section: "variants of public code",
        ..CONTRACT
    };
    const KEEPS_LAST: bool = true;
}
