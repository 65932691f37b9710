//! The k-buffer as published (Bavoil, Callahan, Lefohn, Comba, Silva, "Multi-fragment effects on the GPU using the
//! k-buffer", 2007): read the k entries, insert in registers, write all k back. There is no synchronisation, so
//! invocations of the same pixel that overlap lose, double or tear fragments; one after another they keep the k
//! nearest.
//!
//! Depth and data are separate 32-bit words, as a shading language without 8-byte atomicity leaves them: that is where
//! torn records come from. Entries are sorted front to back; empty ones hold the largest key and stay last.

use crate::fragment::{Fragment, data_of, depth_of, key};
use crate::memory::{Layout, Memory, OwnedBlock, Pixel, Plain, Snapshot, Words};
use crate::num::depth::EMPTY;
use crate::raster::Batch;
use crate::raster::batch::bits;
use crate::scheme::contract::{Dependence, Form, Keeps};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Outcomes, Scheme};

/// Registers for entries: 4 times what eight render targets held in 2007.
const MAX_K: usize = 64;

/// Insert into sorted entries; the key that no longer fits.
#[inline]
pub(super) fn insert(entries: &mut [u64], mut carried: u64) -> u64 {
    for entry in entries {
        if carried < *entry {
            std::mem::swap(&mut carried, entry);
        }
    }
    carried
}

/// What became of a fragment, by the key that no longer fits.
fn outcome(pushed_out: u64, own: u64) -> Outcome {
    if pushed_out == own {
        Outcome::Culled
    } else if depth_of(pushed_out) == EMPTY {
        Outcome::Kept
    } else {
        Outcome::Evicted
    }
}

/// The method.
#[derive(Debug)]
pub struct KBuffer {
    k: u32,
    depth: Words<Pixel, Plain, u32>,
    data: Words<Pixel, Plain, u32>,
}

impl Scheme for KBuffer {
    const CONTRACT: Contract = Contract {
        title: "k-buffer without synchronisation",
        paper: "Bavoil, Callahan, Lefohn, Comba, Silva 2007",
        section: "k+-buffer paper, 2 (KB)",
        form: Form::Published,
        words: "2k",
        published_words: Some("2k"),
        exact_when: "no two invocations of a pixel overlap",
        ties: "canonical, one after another",
        needs: "nothing it could get",
        wgsl: Some("storage buffers; a data race"),
        max_k: MAX_K as u32,
        source: include_str!("kb.rs"),
        dependence: Dependence::Interleaving,
        ..Contract::new("kb", Keeps::Nearest)
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let k = config.k.unwrap_or(8);
        Self {
            k,
            depth: layout.named("depth").pixel(u64::from(k)),
            data: layout.named("data").pixel(u64::from(k)),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        for i in 0..self.k {
            mem.plain_store(self.depth.at(pixel, i), EMPTY).await;
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        with_entries!(self.k, MOST => mem.part(self.insert::<_, MOST>(mem, fragment)).await)
    }

    fn store_block(&self, block: &OwnedBlock<'_>, batch: &Batch, outcomes: &mut Outcomes) -> bool {
        with_entries!(self.k, MOST => self.insert_all::<MOST>(block, batch, outcomes))
    }

    /// In the end, entries are sorted front to back and empty ones come last. Invocations that overlap break that too:
    /// each writes its own sorted entries, and what remains is a mixture.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        if moment == Moment::Always {
            return Ok(());
        }
        let (mut last, mut empty) = (0, None);
        for i in 0..self.k {
            let depth = words.get(self.depth.at(pixel, i));
            if depth == Some(EMPTY) {
                empty = empty.or(Some(i));
                continue;
            }
            let (Some(depth), Some(data)) = (depth, words.get(self.data.at(pixel, i))) else {
                continue;
            };
            if let Some(empty) = empty {
                return Err(format!("entry {empty} is empty, and entry {i} behind it is not"));
            }
            if key(depth, data) < last {
                return Err(format!("entry {i} is nearer than one in front of it"));
            }
            last = key(depth, data);
        }
        Ok(())
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        for i in 0..self.k {
            let depth = mem.plain_load(self.depth.at(pixel, i)).await;
            if depth != EMPTY {
                keys.push(key(depth, mem.plain_load(self.data.at(pixel, i)).await));
            }
        }
    }
}

#[allow(
    clippy::needless_range_loop,
    reason = "an iterator would point into the invocation's state; a block's loops look like those"
)]
impl KBuffer {
    /// The store pass with room for `MOST` entries: fewer than [`MAX_K`] are k itself.
    async fn insert<M: Memory, const MOST: usize>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let k = if MOST < MAX_K { MOST } else { self.k as usize };
        let mut entries = [0; MOST];
        for i in 0..k {
            let depth = mem.plain_load(self.depth.at(fragment.pixel, i as u32)).await;
            let data = mem.plain_load(self.data.at(fragment.pixel, i as u32)).await;
            entries[i] = key(depth, data);
        }
        let pushed_out = insert(&mut entries[..k], fragment.key());
        for i in 0..k {
            mem.plain_store(self.depth.at(fragment.pixel, i as u32), depth_of(entries[i])).await;
            mem.plain_store(self.data.at(fragment.pixel, i as u32), data_of(entries[i])).await;
        }
        outcome(pushed_out, fragment.key())
    }

    /// The same of a whole block.
    fn insert_all<const MOST: usize>(
        &self,
        block: &OwnedBlock<'_>,
        batch: &Batch,
        outcomes: &mut Outcomes,
    ) -> bool {
        let k = if MOST < MAX_K { MOST } else { self.k as usize };
        let (Some(depths), Some(data)) = (block.rows(self.depth), block.rows(self.data)) else {
            return false;
        };
        let [mut culled, mut evicted] = [0; 2];
        for bit in bits(batch.mask()) {
            let (depths, data) = (&depths.of(bit)[..k], &data.of(bit)[..k]);
            let mut entries = [0; MOST];
            for i in 0..k {
                entries[i] = key(depths[i].get(), data[i].get());
            }
            let own = batch.get(bit).key();
            let outcome = outcome(insert(&mut entries[..k], own), own);
            for i in 0..k {
                depths[i].set(depth_of(entries[i]));
                data[i].set(data_of(entries[i]));
            }
            culled |= u64::from(outcome == Outcome::Culled) << bit;
            evicted |= u64::from(outcome == Outcome::Evicted) << bit;
        }
        outcomes.assign([(culled, Outcome::Culled), (evicted, Outcome::Evicted)]);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::parts::hand_made::HandMade;

    fn pixel(entries: &[u64]) -> HandMade<KBuffer> {
        let mut pixel = HandMade::<KBuffer>::new(Some(4), 0);
        for (i, &entry) in (0..).zip(entries) {
            let (depth, data) = (pixel.scheme.depth.at(0, i), pixel.scheme.data.at(0, i));
            pixel.set(depth, depth_of(entry));
            pixel.set(data, data_of(entry));
        }
        pixel
    }

    #[test]
    fn sorted_entries_pass() {
        let empty = key(EMPTY, 7);
        for entries in [&[][..], &[5, 5, 6, 9], &[key(1, 3), key(2, 1), empty, key(EMPTY, 2)]] {
            assert_eq!(pixel(entries).check(Moment::Quiet), Ok(()));
        }
        assert_eq!(pixel(&[6, 5]).check(Moment::Always), Ok(()), "checked in the end only");
    }

    #[test]
    fn unsorted_entries_are_found() {
        let message = pixel(&[key(2, 1), key(1, 3)]).check(Moment::Quiet).unwrap_err();
        assert!(message.contains("entry 1 is nearer"), "{message}");
        let message = pixel(&[5, key(EMPTY, 0), 9]).check(Moment::Quiet).unwrap_err();
        assert!(message.contains("entry 1 is empty"), "{message}");
    }
}
