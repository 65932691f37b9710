//! What the pixels of a frame hold as layers: merged records, or fragments as surfaces of no thickness.

use rayon::prelude::*;

use super::lens::Lens;
use crate::fragment::{Data, data_of, depth_of};
use crate::num::depth::Format;
use crate::num::planes::Planes;
use crate::raster::FrontEnd;
use crate::raster::slab::PRECISION;
use crate::resolve::{Kept, Lists};
use crate::scene::Scene;
use crate::scheme::Record;

/// From this many P(z) on, a record has a front and a back (section 5.4 of the paper).
const THICK: f64 = 10.0;

/// A frame's layers.
#[derive(Clone, Copy, Debug)]
pub struct Layers<'a> {
    /// What is drawn.
    pub scene: &'a Scene,
    /// Its primitives.
    pub front: &'a FrontEnd,
    /// How depths are stored.
    pub format: Format,
    /// What is stored beside them.
    pub data: Data,
    /// What the pixels hold.
    pub kept: &'a Kept,
}

impl Layers<'_> {
    /// The camera that they are seen from.
    #[must_use]
    pub fn lens(&self) -> Lens {
        Lens::new(&self.scene.camera, self.scene.size, self.format)
    }

    /// Add a pixel's layers, front to back. A method that gives no lists has none.
    pub fn pixel(&self, x: u32, y: u32, out: &mut Vec<Record>) {
        match self.kept {
            Kept::Fragments(lists) => {
                out.extend(lists.pixel(x, y).iter().map(|&key| self.surface(key, x, y)));
            }
            Kept::Records(lists) => out.extend_from_slice(lists.pixel(x, y)),
            Kept::Color(_) | Kept::Depths(_) | Kept::Gone(_) => {}
        }
    }

    fn surface(&self, key: u64, x: u32, y: u32) -> Record {
        let (depth, data) = (depth_of(key), data_of(key));
        let color = match self.data {
            Data::Color | Data::Nothing => data,
            Data::Primitive => self.front.color_of(data, x, y, depth),
        };
        Record::surface(depth, color)
    }

    /// All of them.
    #[must_use]
    pub fn lists(&self) -> Lists<Record> {
        let [width, height] = self.scene.size;
        let row = |y: u32| {
            let (mut entries, mut ends) = (Vec::new(), Vec::new());
            for x in 0..width {
                self.pixel(x, y, &mut entries);
                ends.push(entries.len() as u64);
            }
            (entries, ends)
        };
        let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
        let (mut offsets, mut entries) = (vec![0], Vec::new());
        for (row, ends) in rows {
            let before = entries.len() as u64;
            offsets.extend(ends.into_iter().map(|end| before + end));
            entries.extend(row);
        }
        Lists { width, height, offsets, entries }
    }
}

/// Where a record begins and ends on the line of sight: at the same distance if it is at most 10 P(z) thick.
#[must_use]
pub fn ends(record: &Record, planes: Planes, format: Format) -> [f64; 2] {
    let depth = format.decode(record.depth);
    let far = planes.along(depth);
    let near = far - record.thickness;
    let codes = (depth - planes.depth(near)) * f64::from(u32::MAX);
    if record.thickness > 0.0 && codes > THICK * PRECISION { [near, far] } else { [far, far] }
}
