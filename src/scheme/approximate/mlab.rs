//! Multi-layer alpha blending (Salvi, Vaidyanathan, I3D 2014): k nodes in depth order; where one too many comes, the
//! last two become one, which keeps the nearer depth.
//!
//! A node is (depth, C, T). Two nodes merge as `C_i` += `T_i` C_{i+1}, `T_i` *= T_{i+1}. Here a node is a fragment and what was
//! put behind it since: its depth and colour word, and a colour and a transmittance of 16 bits each, which compositing
//! uses everywhere ([`Ray`]). So all of it is integers, a device gives the same bits, and with k for all fragments the
//! picture is the exact one.
//!
//! It depends on arrival by design: once two nodes are one, what lies between them comes too late. With k = 1, the
//! arrival 1, 3, 2 by depth puts 3 in front of 2. Up to k + 1 fragments give the same in every order.
//!
//! The paper needs pixel synchronisation, which may be unordered; here it is the spin lock of k-buffers. The paper's node
//! has 8 bytes (an RGBA8 colour); ours 16.

use std::marker::PhantomData;

use super::{approximate, arrivals};
use crate::fragment::{Fragment, data_of, depth_of, key};
use crate::memory::{Access, Inputs, Layout, Memory, Order, Pixel, Plain, Words};
use crate::num::ray::Ray;
use crate::scheme::contract::{Dependence, Form, Limit};
use crate::scheme::parts::lock::{self, FREE, SpinLock};
use crate::scheme::{Config, Contract, Light, Outcome, Scheme};

/// The method, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// What it promises.
    const CONTRACT: Contract;
    /// Whether transmittances are multiplied; otherwise opacities are added.
    const MULTIPLIED: bool = true;
    /// Whether a merged node keeps the nearer depth.
    const NEARER: bool = true;
}

/// The method.
#[derive(Debug)]
pub struct Mlab<V = Correct> {
    k: u32,
    lock: SpinLock,
    count: Words<Pixel, Plain, u32>,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
    behind: Words<Pixel, Plain, u64>,
    variant: PhantomData<V>,
}

/// A node: the key of its fragment, and what is behind it.
#[derive(Clone, Copy, Debug)]
struct Node {
    key: u64,
    behind: Ray,
}

impl Node {
    fn new(fragment: Fragment) -> Self {
        Self { key: fragment.key(), behind: Ray::default() }
    }

    /// With the next node behind it.
    fn merged<V: Variant>(self, next: Self) -> Self {
        let mut behind = self.behind;
        behind.over(data_of(next.key));
        behind.through(next.behind);
        if !V::MULTIPLIED {
            let mut rest = Ray::default();
            rest.over(data_of(next.key));
            rest.through(next.behind);
            let gone = 65_535 - rest.transmittance;
            behind.transmittance = self.behind.transmittance.saturating_sub(gone);
        }
        let depth = depth_of(if V::NEARER { self.key } else { next.key });
        Self { key: key(depth, data_of(self.key)), behind }
    }
}

/// Nodes, in order.
fn light(nodes: &[Node]) -> Light {
    let mut ray = Ray::default();
    for node in nodes {
        ray.over(data_of(node.key));
        ray.through(node.behind);
    }
    Light { kept: nodes.len() as u32, ..ray.light() }
}

impl<V: Variant> Mlab<V> {
    async fn node<M: Memory>(&self, mem: &M, pixel: u32, i: u32) -> Node {
        let depth = mem.plain_load(self.depth.at(pixel, i)).await;
        let data = mem.plain_load(self.data.at(pixel, i)).await;
        let behind = Ray::of_word(mem.plain_load(self.behind.at(pixel, i)).await);
        Node { key: key(depth, data), behind }
    }

    async fn put<M: Memory>(&self, mem: &M, pixel: u32, i: u32, node: Node) {
        mem.plain_store(self.depth.at(pixel, i), depth_of(node.key)).await;
        mem.plain_store(self.data.at(pixel, i), data_of(node.key)).await;
        mem.plain_store(self.behind.at(pixel, i), node.behind.to_word()).await;
    }

    /// Under the lock: compare and swap from the front; what is left over is put behind the last node.
    async fn insert<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let count = mem.plain_load(self.count.at(pixel, 0)).await;
        let mut carried = Node::new(fragment);
        let mut last = carried;
        for i in 0..count {
            let node = self.node(mem, pixel, i).await;
            last = node;
            if carried.key < node.key {
                last = carried;
                // The last of k nodes is written when it is merged.
                if i + 1 < self.k {
                    self.put(mem, pixel, i, carried).await;
                }
                carried = node;
            }
        }
        if count < self.k {
            self.put(mem, pixel, count, carried).await;
            mem.plain_store(self.count.at(pixel, 0), count + 1).await;
            return Outcome::Kept;
        }
        self.put(mem, pixel, self.k - 1, last.merged::<V>(carried)).await;
        Outcome::Merged
    }
}

impl<V: Variant> Scheme for Mlab<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Light;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(DEFAULT_K);
        Self {
            k,
            lock: SpinLock::new(layout),
            count: layout.named("count").pixel(1),
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
            behind: layout.named("behind").pixel(u64::from(k)),
            variant: PhantomData,
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.plain_store(self.count.at(pixel, 0), 0).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            if self.lock.try_acquire(mem, pixel, Order::Acquire).await == FREE {
                let outcome = self.insert(mem, fragment).await;
                self.lock.release(mem, pixel, Access::Atomic(Order::Release)).await;
                return outcome;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, held: &mut Light) {
        // More would be a fault, of a device for example.
        let count = mem.plain_load(self.count.at(pixel, 0)).await.min(self.k);
        let mut nodes = Vec::with_capacity(count as usize);
        for i in 0..count {
            nodes.push(self.node(mem, pixel, i).await);
        }
        *held = light(&nodes);
    }

    /// Where arrival does not matter. A fault is held to what the right form gives.
    fn expected(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Option<Light> {
        let k = self.k as usize;
        if generated.len() > k + 1 {
            return None;
        }
        let mut nodes = Vec::new();
        generated.iter().for_each(|&fragment| insert(&mut nodes, fragment, k));
        Some(light(&nodes))
    }

    fn possible(&self, _: &Inputs, _: u32, generated: &[Fragment]) -> Vec<Light> {
        let of = |order: Vec<Fragment>| {
            let mut nodes = Vec::new();
            order.into_iter().for_each(|f| insert(&mut nodes, f, self.k as usize));
            light(&nodes)
        };
        arrivals(generated).map(of).collect()
    }
}

/// Put a fragment into its place; the last two become one, if there are then more than k.
fn insert(nodes: &mut Vec<Node>, fragment: Fragment, k: usize) {
    let place = nodes.partition_point(|node| node.key <= fragment.key());
    nodes.insert(place, Node::new(fragment));
    if nodes.len() > k
        && let Some(last) = nodes.pop()
    {
        nodes[k - 1] = nodes[k - 1].merged::<Correct>(last);
    }
}

/// Nodes, as in the paper's measurements.
const DEFAULT_K: u32 = 4;

const CONTRACT: Contract = Contract {
    title: "multi-layer alpha blending: k nodes, the last two merged",
    paper: "Salvi, Vaidyanathan 2014",
    section: "3, algorithm 1",
    words: "4k + 2",
    published_words: Some("2k"),
    exact_when: "k >= f(p)",
    ties: "canonical: the smaller data word is nearer",
    dependence: Dependence::Arrival,
    needs: lock::NEEDS,
    wgsl: lock::WGSL,
    default_k: Some(DEFAULT_K),
    max_k: u32::MAX / 16,
    source: include_str!("mlab.rs"),
    ..approximate("mlab", Limit::EnoughK)
};

/// The method.
#[derive(Debug)]
pub struct Correct;

/// Opacities of merged nodes are added.
#[derive(Debug)]
pub struct OpacitySum;

/// A merged node keeps the farther depth.
#[derive(Debug)]
pub struct FartherDepth;

const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract { name, title, form: Form::Mutation, ..CONTRACT }
}

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for OpacitySum {
    const CONTRACT: Contract =
        fault("mlab@opacity-sum", "Fault opacity-sum: opacities of merged nodes are added");
    const MULTIPLIED: bool = false;
}

impl Variant for FartherDepth {
    const CONTRACT: Contract =
        fault("mlab@farther-depth", "Fault farther-depth: a merged node keeps the farther depth");
    const NEARER: bool = false;
}
