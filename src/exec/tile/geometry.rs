//! A geometry pass of one tile: packet by packet as primitives come; or block by block, where that is better for a scheme
//! ([`Scheme::together`](crate::scheme::Scheme::together)).

use crate::exec::Job;
use crate::exec::account::Tally;
use crate::exec::drive::Pipeline;
use crate::exec::frame::PixelCounts;
use crate::fragment::Packet;
use crate::memory::exclusive::Exclusive;
use crate::num::columns::Columns;
use crate::raster::Batch;
use crate::scheme::Outcomes;

/// What a geometry pass counts, block by block.
#[derive(Debug, Default)]
pub(super) struct Counting {
    generated: Columns,
    gone: Columns,
    /// What has reached the scheme so far, with an interlock.
    entered: Columns,
}

impl Counting {
    fn reset(&mut self, blocks: usize) {
        for counts in [&mut self.generated, &mut self.gone, &mut self.entered] {
            counts.reset(blocks);
        }
    }

    pub(super) fn of_pixels(&self) -> PixelCounts {
        PixelCounts { generated: self.generated.counts(), gone: self.gone.counts() }
    }
}

/// What a worker keeps from one pass to the next.
#[derive(Debug, Default)]
pub(super) struct Room {
    pub(super) counts: Counting,
    pub(super) reports: Tally,
    batch: Batch,
    /// The packets of each block, in the order of primitives, where a block's are stored together.
    blocks: Vec<Vec<Packet>>,
    batches: Vec<Batch>,
    outcomes: Vec<Outcomes>,
}

/// A pass in progress.
pub(super) struct Geometry<'a, O> {
    pub(super) scheme: &'a dyn for<'b> Pipeline<Exclusive<'b, O>>,
    pub(super) job: &'a Job<'a>,
    pub(super) mem: Exclusive<'a, O>,
    pub(super) tile: usize,
    /// Its number in the program.
    pub(super) number: usize,
    /// Whether it is the store pass.
    pub(super) stores: bool,
    /// Whether fragments are culled before it.
    pub(super) culls: bool,
    /// Whether fragments are ranked.
    pub(super) interlock: bool,
    /// Whether operations are counted.
    pub(super) counted: bool,
    /// The storage place of the tile's first pixel.
    pub(super) first: u32,
}

impl<O> Geometry<'_, O> {
    /// Run it. The reports of an earlier round's store pass are dropped.
    pub(super) fn run(&self, room: &mut Room) {
        let (job, grid) = (self.job, &self.job.front.grid);
        let blocks = grid.pixels_per_tile() / 64;
        room.counts.reset(blocks);
        room.reports = Tally::default();
        // What is counted one by one must be done one by one.
        let one_by_one = self.stores || self.culls || self.counted;
        if !one_by_one && self.scheme.count(&self.mem, self.number, self.first, &[]) {
            let generated = &mut room.counts.generated;
            job.front.packets(self.tile, |packet| {
                generated.add(grid.local_block(packet) as usize, packet.mask);
            });
            self.scheme.count(&self.mem, self.number, self.first, &generated.counts());
            return;
        }
        // Where a pool may be too small, the order decides what is dropped.
        let ordered = !self.stores || !job.whole_pools;
        let together = if ordered { 0 } else { self.scheme.together(&self.mem, self.first) };
        if together > 0 {
            return self.block_by_block(room, together);
        }
        let Room { counts, reports, batch, .. } = room;
        let mut outcomes = Outcomes::default();
        job.front.packets(self.tile, |packet| {
            let block = self.fragments(packet, batch, counts, reports);
            if self.stores {
                self.scheme.store(&self.mem, batch, &mut outcomes);
                stored(block, &outcomes, counts, reports);
            } else {
                self.scheme.prepare(&self.mem, self.number, batch);
            }
        });
    }

    fn block_by_block(&self, room: &mut Room, together: usize) {
        let (job, grid) = (self.job, &self.job.front.grid);
        let Room { counts, reports, blocks, batches, outcomes, .. } = room;
        blocks.resize_with(grid.pixels_per_tile() / 64, Vec::new);
        job.front.packets(self.tile, |packet| {
            blocks[grid.local_block(packet) as usize].push(packet);
        });
        batches.resize_with(together, Batch::default);
        outcomes.resize_with(together, Outcomes::default);
        for (block, packets) in blocks.iter_mut().enumerate() {
            for some in packets.chunks(together) {
                let (batches, outcomes) = (&mut batches[..some.len()], &mut outcomes[..some.len()]);
                for (&packet, batch) in some.iter().zip(&mut *batches) {
                    self.fragments(packet, batch, counts, reports);
                }
                self.scheme.store_together(&self.mem, batches, outcomes);
                outcomes.iter().for_each(|outcomes| stored(block, outcomes, counts, reports));
            }
            packets.clear();
        }
    }

    /// Make a packet's fragments, without those that are culled, and give the number of its block.
    #[inline]
    fn fragments(
        &self,
        packet: Packet,
        batch: &mut Batch,
        counts: &mut Counting,
        reports: &mut Tally,
    ) -> usize {
        let job = self.job;
        let block = job.front.grid.local_block(packet);
        job.front.fragments(packet, job.record, self.first + block * 64, batch);
        let block = block as usize;
        counts.generated.add(block, packet.mask);
        if self.culls {
            let rejected = job.cull(batch);
            counts.gone.add(block, rejected);
            reports.reject(rejected.count_ones());
        }
        if self.interlock {
            batch.rank(|bit| counts.entered.get(block, bit));
            counts.entered.add(block, batch.mask());
        }
        block
    }
}

/// What became of a block's fragments.
#[inline]
fn stored(block: usize, outcomes: &Outcomes, counts: &mut Counting, reports: &mut Tally) {
    let gone = outcomes.gone();
    if gone != 0 {
        counts.gone.add(block, gone);
        reports.reports(outcomes);
    }
}
