//! From packets to fragments: depth by the plane, data by the surface.

use super::batch::{Batch, bits};
use super::front::FrontEnd;
use super::primitive::Rect;
use super::shade::Surface;
use crate::fragment::{BLOCK, Data, Fragment, Packet};
use crate::num::depth::Format;

/// What a run stores in a fragment's two words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The depth word.
    pub depth: Format,
    /// The data word.
    pub data: Data,
}

impl FrontEnd {
    /// Replace a batch by a packet's fragments; their pixels count from `first_pixel`, the place of the block's first
    /// pixel.
    pub fn fragments(&self, packet: Packet, record: Record, first_pixel: u32, batch: &mut Batch) {
        let primitive = self.primitive(packet.primitive);
        let Packet { mask, .. } = packet;
        let (x, y) = (u32::from(packet.column) * BLOCK, u32::from(packet.row) * BLOCK);
        batch.first = first_pixel;
        batch.mask = mask;
        let format = record.depth;
        // Near ends are of codes, not of what is stored of them.
        primitive.plane.codes([x, y], mask, &mut batch.depths);
        match self.slabs().map(|slabs| slabs.of(primitive.triangle)) {
            None => batch.extras.fill(if self.is_numbered() { primitive.triangle } else { 0 }),
            Some(near) => {
                let extras = batch.extras.lanes();
                near.codes(mask, &batch.depths, extras);
                format.encode_all(extras);
            }
        }
        format.encode_all(&mut batch.depths);
        match (record.data, self.surface(packet.primitive), &self.attenuation) {
            (Data::Nothing, ..) => batch.data.fill(0),
            (Data::Primitive, ..) => batch.data.fill(primitive.triangle),
            (Data::Color, Surface::Uniform(word), _) => batch.data.fill(*word),
            (Data::Color, surface, None) => {
                let lanes = batch.data.lanes();
                for bit in bits(mask) {
                    lanes[bit as usize] = surface.at(x + bit % BLOCK, y + bit / BLOCK);
                }
            }
            (Data::Color, surface, Some(light)) => {
                let lanes = batch.data.lanes();
                for bit in bits(mask) {
                    let (i, x, y) = (bit as usize, x + bit % BLOCK, y + bit / BLOCK);
                    let reaches = light.transmittance(x, y, batch.depths[i]);
                    lanes[i] = surface.attenuated(x, y, reaches);
                }
            }
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
        for index in self.indices() {
            let triangle = self.primitive(index).triangle;
            self.primitive_packets(index, window, |packet| {
                self.fragments(packet, record, 0, &mut batch);
                for fragment in batch.iter() {
                    emit(triangle, Fragment { pixel: 0, ..fragment });
                }
            });
        }
    }

    /// The RGBA8 word of a triangle at a pixel and a stored depth, for runs that store triangle indices; 0
    /// (transparent) if that triangle is not visible.
    #[must_use]
    pub fn color_of(&self, triangle: u32, x: u32, y: u32, depth: u32) -> u32 {
        let Some(index) = self.index_of(triangle) else { return 0 };
        match (self.surface(index), &self.attenuation) {
            (Surface::Uniform(word), _) => *word,
            (surface, None) => surface.at(x, y),
            (surface, Some(light)) => surface.attenuated(x, y, light.transmittance(x, y, depth)),
        }
    }
}
