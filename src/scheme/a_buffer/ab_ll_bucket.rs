//! A-buffer in per-pixel linked lists, one for each of four depth buckets (Vasilakis, Fudos, "Depth-fighting aware
//! methods for multifragment rendering", 2013; as the k+-buffer paper describes it in section 2).
//!
//! A first geometry pass finds each pixel's depth range by an atomic minimum and maximum. The store pass splits the
//! range uniformly, and puts every fragment into the list of its bucket: invocations of a pixel contend for four heads
//! instead of one, and resolve sorts four short lists, front to back, instead of a long one.
//!
//! The k+-buffer paper speaks of the scene's range. Here it is the pixel's, in integers: bucket
//! `4 (depth - near) / (far - near + 1)`, in 64 bits, which is 3 for the far end and 0 where near is far.

use std::marker::PhantomData;

use crate::fragment::{Fragment, depth_of};
use crate::memory::{Atomic, Layout, Memory, Order, Pixel, Snapshot, Words};
use crate::num::depth::EMPTY;
use crate::scheme::parts::list::Lists;
use crate::scheme::program::{Barrier, Pass, PassKind, Program};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// Lists of a pixel.
const BUCKETS: u32 = 4;

/// The pass that finds the range.
const RANGE: Pass = Pass::new("depth range", PassKind::Prepare, Barrier::Pixel);

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// Whether the far end belongs to the last bucket.
    const CLOSED: bool = true;
    /// Bits of depth that the range pass lacks.
    const COARSE: u32 = 0;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M16: the range pass computes depth by another formula, of 24 bits, so that a fragment lies behind its own range.
#[derive(Debug)]
pub enum OtherDepth {}

/// M17: nothing stands between the range pass and the store pass.
#[derive(Debug)]
pub enum NoBarrier {}

/// The range is divided by its length, as one does with real numbers: its far end is in bucket 4, of 4.
#[derive(Debug)]
pub enum OpenEnd {}

/// The method.
#[derive(Debug)]
pub struct AbBucketList<V = Correct> {
    near: Words<Pixel, Atomic, u32>,
    far: Words<Pixel, Atomic, u32>,
    lists: Lists,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "A-buffer in four linked lists per pixel, by uniform depth buckets",
    paper: "Vasilakis, Fudos 2013",
    section: "k+-buffer paper, 2",
    program: Program::of(&[RANGE, Pass::store(Barrier::Pixel)]),
    words: "6",
    needs: "32-bit atomic add, exchange, minimum and maximum, relaxed",
    wgsl: Some(
        "storage buffers; atomicAdd, atomicExchange, atomicMin, atomicMax; 64-bit arithmetic emulated",
    ),
    source: include_str!("ab_ll_bucket.rs"),
    ..super::linked("ab-ll-bucket")
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
}

impl Variant for OtherDepth {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll-bucket@M16",
        "Fault M16: the range pass computes depth by another formula",
        "depths have no more than 24 bits",
    );
    const COARSE: u32 = 8;
}

impl Variant for NoBarrier {
    const CONTRACT: Contract = Contract {
        program: Program::of(&[RANGE, Pass::store(Barrier::Missing)]),
        ..CONTRACT.fault(
            "ab-ll-bucket@M17",
            "Fault M17: no barrier between range pass and store pass",
            "no store begins before its pixel's range is known",
        )
    };
}

impl Variant for OpenEnd {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll-bucket@open-end",
        "Fault open-end: the far end of the range is in no bucket",
        "all fragments of a pixel are equally deep",
    );
    const CLOSED: bool = false;
}

impl<V: Variant> AbBucketList<V> {
    /// The bucket of a depth. Where the range does not hold it, as in faulty forms, it wraps as on a device.
    fn bucket(depth: u32, near: u32, far: u32) -> u32 {
        let length = u64::from(far.wrapping_sub(near));
        let length = if V::CLOSED { length + 1 } else { length.max(1) };
        (u64::from(BUCKETS) * u64::from(depth.wrapping_sub(near)) / length) as u32
    }
}

impl<V: Variant> Scheme for AbBucketList<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        Self {
            near: layout.named("near").pixel(1),
            far: layout.named("far").pixel(1),
            lists: Lists::new(BUCKETS, config, layout),
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        self.lists.clear_frame(mem).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.near.at(pixel, 0), EMPTY, Order::Relaxed).await;
        mem.store(self.far.at(pixel, 0), 0, Order::Relaxed).await;
        for bucket in 0..BUCKETS {
            self.lists.clear(mem, pixel, bucket).await;
        }
    }

    async fn prepare<M: Memory>(&self, mem: &M, _pass: usize, fragment: Fragment) {
        let depth = fragment.depth >> V::COARSE << V::COARSE;
        mem.min(self.near.at(fragment.pixel, 0), depth, Order::Relaxed).await;
        mem.max(self.far.at(fragment.pixel, 0), depth, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let (lists, pixel) = (self.lists, fragment.pixel);
        let node = lists.take(mem).await;
        if u64::from(node) >= lists.capacity() {
            return Outcome::Pool;
        }
        let near = mem.load(self.near.at(pixel, 0), Order::Relaxed).await;
        let far = mem.load(self.far.at(pixel, 0), Order::Relaxed).await;
        let bucket = Self::bucket(fragment.depth, near, far);
        lists.fill(mem, node, fragment).await;
        let next = lists.publish(mem, pixel, bucket, node, Order::Relaxed).await;
        mem.plain_store(lists.link(node), next).await;
        Outcome::Kept
    }

    /// In the end, lists end, and no list holds what belongs to another.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let range = [self.near, self.far].map(|word| words.get(word.at(pixel, 0)));
        let (Moment::Quiet, [Some(near), Some(far)]) = (moment, range) else { return Ok(()) };
        for bucket in 0..BUCKETS {
            for node in self.lists.nodes(words, pixel, bucket) {
                let depth = depth_of(node.map_err(|flaw| flaw.to_string())?.key);
                let own = Self::bucket(depth, near, far);
                if own != bucket {
                    return Err(format!("depth {depth:x} is in bucket {bucket} instead of {own}"));
                }
            }
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for bucket in 0..BUCKETS {
            self.lists.collect::<_, Self>(mem, pixel, bucket, keys).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fragment::key;
    use crate::num::depth::FARTHEST;
    use crate::scheme::parts::hand_made::HandMade;
    use crate::scheme::parts::list::{NONE, Node};

    #[test]
    fn buckets_are_uniform_and_hold_both_ends() {
        type List = AbBucketList;
        for (near, far) in [(0, FARTHEST), (0, 0), (FARTHEST, FARTHEST), (7, 8), (7, 10), (7, 90)] {
            assert_eq!(List::bucket(near, near, far), 0);
            assert!(List::bucket(far, near, far) < BUCKETS);
        }
        let buckets: Vec<u32> = (7..15).map(|depth| List::bucket(depth, 7, 14)).collect();
        assert_eq!(buckets, [0, 0, 1, 1, 2, 2, 3, 3]);
        assert_eq!(AbBucketList::<OpenEnd>::bucket(14, 7, 14), BUCKETS);
    }

    /// Depths 0 to 7, and a pool of 3 nodes: heads, and next and depth of each node.
    fn lists(heads: [u32; 4], nodes: &[(u32, u32)]) -> HandMade<AbBucketList> {
        let mut lists = HandMade::<AbBucketList>::new(None, 3);
        let (near, far) = (lists.scheme.near.at(0, 0), lists.scheme.far.at(0, 0));
        let all = lists.scheme.lists;
        lists.set(near, 0);
        lists.set(far, 7);
        for (bucket, head) in (0..).zip(heads) {
            lists.set(all.head(0, bucket), head);
        }
        for (number, &(next, depth)) in (0..).zip(nodes) {
            all.set(&mut lists, Node { number, next, key: key(depth, 0) });
        }
        lists
    }

    #[test]
    fn fragments_in_their_buckets_pass() {
        let right = lists([1, NONE, NONE, 2], &[(NONE, 1), (0, 0), (NONE, 7)]);
        assert_eq!(right.check(Moment::Quiet), Ok(()));
        assert_eq!(HandMade::<AbBucketList>::new(None, 3).check(Moment::Quiet), Ok(()));
    }

    #[test]
    fn others_and_lists_that_do_not_end_are_found() {
        let cases = [
            (lists([NONE, 0, NONE, NONE], &[(NONE, 7)]), "depth 7 is in bucket 1 instead of 3"),
            (lists([0, NONE, NONE, NONE], &[(0, 1)]), "does not end"),
            (lists([3, NONE, NONE, NONE], &[]), "node 3, of 3"),
            (
                lists([1, NONE, NONE, NONE], &[(NONE, 1)]),
                "node 1 is in the list but was not written",
            ),
        ];
        for (lists, words) in cases {
            let message = lists.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
