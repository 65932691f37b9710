//! Depth peeling by bucket sort (Liu, Huang, Liu, Wu, "Efficient depth peeling via bucket sort", 2009): uniform buckets
//! over a pixel's depth range, each peeled from both ends, so that a round finds up to twice as many layers as there
//! are buckets, and several rounds resolve what collides in one bucket.
//!
//! *Reconstructed* from what the k+-buffer paper and surveys say of it: a first geometry pass for the depth range, the
//! nearest and the farthest depth of every bucket by blending with a minimum and a maximum, and further rounds for
//! collisions. A bucket is peeled as in `depth-peel-dual` until it is empty, which makes the result exact. The original
//! had 16 buckets in eight render targets; here there are 4.

use crate::fragment::Fragment;
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Words};
use crate::num::depth::EMPTY;
use crate::scheme::contract::Keeps;
use crate::scheme::parts::ends::Ends;
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keys, Outcome, Scheme};

/// Buckets of a pixel.
const BUCKETS: u32 = 4;

/// The bucket of a depth within a range, both ends included.
fn bucket(depth: u32, [near, far]: [u32; 2]) -> u32 {
    let [depth, near, far] = [depth, near, far].map(u64::from);
    ((depth - near) * u64::from(BUCKETS) / (far - near + 1)) as u32
}

/// The method.
#[derive(Debug)]
pub struct BucketPeel {
    near: Words<Pixel, Atomic, u32>,
    far: Words<Pixel, Atomic, u32>,
    ends: Ends,
}

impl Scheme for BucketPeel {
    const CONTRACT: Contract = Contract {
        title: "Depth peeling by bucket sort, two layers of each of 4 buckets a round (reconstructed)",
        paper: "Liu, Huang, Liu, Wu 2009b",
        program: Program::repeated(&[
            Pass::new("depth range", PassKind::Prepare, Barrier::Pixel),
            Pass::store(Barrier::Pixel),
        ]),
        words: "42",
        needs: "64-bit atomic min and max, 32-bit atomic add, min and max, relaxed; a query whether any pixel goes on",
        wgsl: Some(
            "64-bit atomicMin and atomicMax where there are; atomicAdd, atomicMin, atomicMax",
        ),
        source: include_str!("depth_peel_bucket.rs"),
        ..super::peeled("depth-peel-bucket", Keeps::All)
    };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        let ends = Ends::new(layout, u64::from(BUCKETS));
        Self { near: layout.named("near").pixel(1), far: layout.named("far").pixel(1), ends }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.near.at(pixel, 0), EMPTY, Order::Relaxed).await;
        mem.store(self.far.at(pixel, 0), 0, Order::Relaxed).await;
        for run in 0..BUCKETS {
            self.ends.clear(mem, pixel, run).await;
        }
    }

    /// The depth range; later rounds find the same.
    async fn prepare<M: Memory>(&self, mem: &M, _: usize, fragment: Fragment) {
        mem.min(self.near.at(fragment.pixel, 0), fragment.depth, Order::Relaxed).await;
        mem.max(self.far.at(fragment.pixel, 0), fragment.depth, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let near = mem.load(self.near.at(fragment.pixel, 0), Order::Relaxed).await;
        let far = mem.load(self.far.at(fragment.pixel, 0), Order::Relaxed).await;
        self.ends.peel::<_, Self>(mem, bucket(fragment.depth, [near, far]), fragment, true).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for run in 0..BUCKETS {
            self.ends.resolve(mem, pixel, run, keys).await;
        }
    }

    async fn again<M: Memory>(&self, mem: &M, pixel: u32) -> bool {
        let mut any = false;
        for run in 0..BUCKETS {
            any |= self.ends.again(mem, pixel, run).await;
        }
        any
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::depth::FARTHEST;

    #[test]
    fn buckets_are_uniform_and_include_both_ends() {
        assert_eq!([10, 11, 12, 13].map(|d| bucket(d, [10, 13])), [0, 1, 2, 3]);
        assert_eq!([10, 11, 12].map(|d| bucket(d, [10, 12])), [0, 1, 2]);
        assert_eq!(bucket(7, [7, 7]), 0, "one depth");
        let ends = [0, FARTHEST];
        assert_eq!(
            [0, FARTHEST / 4, FARTHEST / 4 + 1, FARTHEST].map(|d| bucket(d, ends)),
            [0, 0, 1, 3]
        );
    }

    #[test]
    fn buckets_rise_with_depth() {
        for far in 0..40 {
            let all: Vec<u32> = (0..=far).map(|depth| bucket(depth, [0, far])).collect();
            assert!(all.is_sorted() && all.iter().all(|&b| b < BUCKETS), "{all:?}");
        }
    }
}
