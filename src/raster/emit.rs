//! From packets to fragments: depth by the plane, data by the surface.

use super::front::FrontEnd;
use super::primitive::Rect;
use super::shade::Surface;
use crate::fragment::{Data, Fragment, Packet};
use crate::num::depth::Format;

/// What a run stores in a fragment's two words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The depth word.
    pub depth: Format,
    /// The data word.
    pub data: Data,
}

/// The fragments of one packet.
#[derive(Debug)]
pub struct Batch {
    fragments: [Fragment; 64],
    len: usize,
}

impl Default for Batch {
    fn default() -> Self {
        Self { fragments: [Fragment::default(); 64], len: 0 }
    }
}

impl Batch {
    /// The fragments, in the order of the mask's bits.
    #[inline]
    #[must_use]
    pub fn fragments(&self) -> &[Fragment] {
        &self.fragments[..self.len]
    }

    /// Number the fragments, in an order that `rank` knows by pixel.
    #[inline]
    pub fn rank(&mut self, mut rank: impl FnMut(u32) -> u32) {
        for fragment in &mut self.fragments[..self.len] {
            fragment.extra = rank(fragment.pixel);
        }
    }

    /// Leave out those for which `is_rejected` is true, and name the pixel of each.
    #[inline]
    pub fn reject(
        &mut self,
        is_rejected: impl Fn(&Fragment) -> bool,
        mut rejected: impl FnMut(u32),
    ) {
        let mut left = 0;
        for i in 0..self.len {
            let fragment = self.fragments[i];
            if is_rejected(&fragment) {
                rejected(fragment.pixel);
            } else {
                self.fragments[left] = fragment;
                left += 1;
            }
        }
        self.len = left;
    }

    #[inline]
    fn push(&mut self, fragment: Fragment) {
        // The mask has 64 bits, so the index never wraps; the mask only spares the check.
        self.fragments[self.len & 63] = fragment;
        self.len += 1;
    }
}

impl FrontEnd {
    /// Replace a batch by a packet's fragments; their pixels count from `first_pixel`, the place of the block's first
    /// pixel.
    pub fn fragments(&self, packet: Packet, record: Record, first_pixel: u32, batch: &mut Batch) {
        let primitive = &self.primitives()[packet.primitive as usize];
        match (record.data, self.surface(primitive), &self.attenuation) {
            (Data::Nothing, ..) => {
                self.emit(packet, record.depth, first_pixel, batch, |_, _, _| 0);
            }
            (Data::Primitive, ..) => {
                let word = primitive.triangle;
                self.emit(packet, record.depth, first_pixel, batch, |_, _, _| word);
            }
            (Data::Color, Surface::Uniform(word), _) => {
                self.emit(packet, record.depth, first_pixel, batch, |_, _, _| *word);
            }
            (Data::Color, surface, None) => {
                self.emit(packet, record.depth, first_pixel, batch, |x, y, _| surface.at(x, y));
            }
            (Data::Color, surface, Some(light)) => {
                self.emit(packet, record.depth, first_pixel, batch, |x, y, depth| {
                    surface.attenuated(x, y, light.transmittance(x, y, depth))
                });
            }
        }
    }

    #[inline]
    fn emit(
        &self,
        packet: Packet,
        format: Format,
        first_pixel: u32,
        batch: &mut Batch,
        data: impl Fn(u32, u32, u32) -> u32,
    ) {
        let primitive = &self.primitives()[packet.primitive as usize];
        let plane = primitive.plane;
        let near = self.slabs().map(|slabs| slabs.of(primitive.triangle));
        let number = if self.is_numbered() { primitive.triangle } else { 0 };
        let (x, y) = (u32::from(packet.column) * 8, u32::from(packet.row) * 8);
        let origin = plane.at(x, y);
        batch.len = 0;
        let mut mask = packet.mask;
        while mask != 0 {
            let bit = mask.trailing_zeros();
            mask &= mask - 1;
            let (dx, dy) = (bit & 7, bit >> 3);
            let code = plane.code(plane.step(origin, dx, dy));
            let depth = format.encode(code);
            let extra = near.map_or(number, |near| format.encode(near.code(code)));
            let (pixel, data) = (first_pixel + bit, data(x + dx, y + dy, depth));
            batch.push(Fragment { pixel, depth, data, extra });
        }
    }

    /// Call `emit` for every fragment of pixel (x, y), with its global triangle index, in submission order. The
    /// fragments' storage pixel is 0.
    pub fn fragments_of_pixel(
        &self,
        [x, y]: [u32; 2],
        record: Record,
        mut emit: impl FnMut(u32, Fragment),
    ) {
        let window = Rect { x0: x, y0: y, x1: x + 1, y1: y + 1 };
        let mut batch = Batch::default();
        for (index, primitive) in (0..).zip(self.primitives()) {
            self.primitive_packets(index, window, |packet| {
                self.fragments(packet, record, 0, &mut batch);
                for fragment in batch.fragments() {
                    emit(primitive.triangle, Fragment { pixel: 0, ..*fragment });
                }
            });
        }
    }

    /// The RGBA8 word of a triangle at a pixel and a stored depth, for runs that store triangle indices; 0
    /// (transparent) if that triangle is not visible.
    #[must_use]
    pub fn color_of(&self, triangle: u32, x: u32, y: u32, depth: u32) -> u32 {
        let Some(primitive) = self.primitive_of(triangle) else { return 0 };
        match (self.surface(primitive), &self.attenuation) {
            (Surface::Uniform(word), _) => *word,
            (surface, None) => surface.at(x, y),
            (surface, Some(light)) => surface.attenuated(x, y, light.transmittance(x, y, depth)),
        }
    }
}
