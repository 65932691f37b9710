//! A scene's fragments in submission order, one at a time.

use crate::exec::Job;
use crate::fragment::{Fragment, Packet};
use crate::raster::Batch;

/// Pulls fragments out of a scene: primitive by primitive over the whole image, block by block.
pub(super) struct Submission<'a> {
    job: &'a Job<'a>,
    /// Fragments so far at each pixel.
    generated: Counts<'a>,
    primitive: u32,
    packets: Vec<Packet>,
    next_packet: usize,
    batch: Batch,
    next_fragment: usize,
}

/// The caller's counts, or own ones if needed.
enum Counts<'a> {
    Given(&'a mut [u32]),
    Own(Vec<u32>),
}

impl<'a> Submission<'a> {
    /// The fragments of the store pass; counts what is generated, from zero.
    pub(super) fn new(job: &'a Job<'a>, generated: &'a mut [u32]) -> Self {
        generated.fill(0);
        Self::from(job, Counts::Given(generated))
    }

    /// The fragments of another geometry pass.
    pub(super) fn uncounted(job: &'a Job<'a>) -> Self {
        let pixels =
            if job.contract.is_interlocked() { job.front.grid.storage_pixels() } else { 0 };
        Self::from(job, Counts::Own(vec![0; pixels]))
    }

    fn from(job: &'a Job<'a>, generated: Counts<'a>) -> Self {
        Self {
            job,
            generated,
            primitive: 0,
            packets: Vec::new(),
            next_packet: 0,
            batch: Batch::default(),
            next_fragment: 0,
        }
    }

    /// Fill the batch with the next packet's fragments; `false` at the end of the scene.
    fn refill(&mut self) -> bool {
        let front = self.job.front;
        while self.next_packet == self.packets.len() {
            if self.primitive as usize == front.primitives().len() {
                return false;
            }
            self.packets.clear();
            self.next_packet = 0;
            let packets = &mut self.packets;
            front.primitive_packets(self.primitive, front.grid.image(), |p| packets.push(p));
            self.primitive += 1;
        }
        let packet = self.packets[self.next_packet];
        self.next_packet += 1;
        self.next_fragment = 0;
        front.fragments(packet, self.job.record, front.grid.first_pixel(packet), &mut self.batch);
        true
    }
}

impl Iterator for Submission<'_> {
    type Item = Fragment;

    fn next(&mut self) -> Option<Fragment> {
        if self.next_fragment == self.batch.fragments().len() && !self.refill() {
            return None;
        }
        let mut fragment = self.batch.fragments()[self.next_fragment];
        self.next_fragment += 1;
        let count = match &mut self.generated {
            Counts::Given(counts) => counts.get_mut(fragment.pixel as usize),
            Counts::Own(counts) => counts.get_mut(fragment.pixel as usize),
        };
        if let Some(count) = count {
            if self.job.contract.is_interlocked() {
                fragment.rank = *count;
            }
            *count += 1;
        }
        Some(fragment)
    }
}
