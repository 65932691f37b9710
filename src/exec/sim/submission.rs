//! A scene's fragments in submission order, one at a time.

use crate::exec::Job;
use crate::fragment::{Fragment, Packet};
use crate::raster::Batch;
use crate::raster::batch::bits;

/// Pulls fragments out of a scene: primitive by primitive over the whole image, block by block.
pub(super) struct Submission<'a> {
    job: &'a Job<'a>,
    /// Fragments so far at each pixel, if the caller counts them.
    generated: Option<&'a mut [u32]>,
    /// Those that reached the scheme, if they must know their rank.
    entered: Vec<u32>,
    /// Whether some do not.
    culls: bool,
    /// Primitives that are still to come.
    primitives: std::vec::IntoIter<u32>,
    packets: Vec<Packet>,
    next_packet: usize,
    batch: Batch,
    /// Bits of the batch whose fragments are still to come.
    left: u64,
}

impl<'a> Submission<'a> {
    /// The fragments of a store pass; counts what is generated, from zero.
    pub(super) fn new(job: &'a Job<'a>, pass: usize, generated: &'a mut [u32]) -> Self {
        generated.fill(0);
        Self { generated: Some(generated), ..Self::uncounted(job, pass) }
    }

    /// The fragments of another geometry pass.
    pub(super) fn uncounted(job: &'a Job<'a>, pass: usize) -> Self {
        let pixels =
            if job.contract.is_interlocked() { job.front.grid.storage_pixels() } else { 0 };
        Self {
            job,
            generated: None,
            entered: vec![0; pixels],
            culls: job.culls(pass),
            primitives: job.front.indices().into_iter(),
            packets: Vec::new(),
            next_packet: 0,
            batch: Batch::default(),
            left: 0,
        }
    }

    /// Fill the batch with the next packet's fragments; `false` at the end of the scene.
    fn refill(&mut self) -> bool {
        let front = self.job.front;
        while self.next_packet == self.packets.len() {
            let Some(primitive) = self.primitives.next() else { return false };
            self.packets.clear();
            self.next_packet = 0;
            let packets = &mut self.packets;
            front.primitive_packets(primitive, front.grid.image(), |p| packets.push(p));
        }
        let packet = self.packets[self.next_packet];
        self.next_packet += 1;
        front.fragments(packet, self.job.record, front.grid.first_pixel(packet), &mut self.batch);
        if let Some(generated) = &mut self.generated {
            self.batch.iter().for_each(|f| generated[f.pixel as usize] += 1);
        }
        if self.culls {
            self.job.cull(&mut self.batch);
        }
        self.left = self.batch.mask();
        true
    }
}

impl Iterator for Submission<'_> {
    type Item = Fragment;

    fn next(&mut self) -> Option<Fragment> {
        while self.left == 0 {
            if !self.refill() {
                return None;
            }
        }
        let mut fragment = self.batch.get(self.left.trailing_zeros());
        self.left &= self.left - 1;
        if let Some(entered) = self.entered.get_mut(fragment.pixel as usize) {
            fragment.extra = *entered;
            *entered += 1;
        }
        Some(fragment)
    }
}

/// By storage pixel, how many fragments do not reach a pass.
pub(super) fn rejected(job: &Job<'_>, pass: usize) -> Vec<u32> {
    let mut counts = vec![0; job.front.grid.storage_pixels()];
    if job.culls(pass) {
        let mut batch = Batch::default();
        job.front.packets_in_order(|packet| {
            let first = job.front.grid.first_pixel(packet);
            job.front.fragments(packet, job.record, first, &mut batch);
            let rejected = job.cull(&mut batch);
            bits(rejected).for_each(|bit| counts[(first + bit) as usize] += 1);
        });
    }
    counts
}
