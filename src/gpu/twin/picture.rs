//! A scene as devices draw it: its primitives, its colours, and how it is cut.

use std::ops::Range;

use crate::num::color::{srgb, word16};
use crate::raster::slab::Slabs;
use crate::raster::{CullFace, FrontEnd, Grid};
use crate::scene::{Scene, Thickness};
use crate::scheme::approximate::Approximation;
use crate::scheme::hash_table::table::DEFAULT_LOAD;

/// Tile edge: small, so that bands can be small.
pub(super) const TILE: u32 = 16;

/// Fragments of a band, unless one row of tiles has more.
const FRAGMENTS: u64 = 1 << 23;

/// A scene, ready to be drawn by devices of the same sub-pixel precision.
#[derive(Debug)]
pub struct Picture {
    /// Its primitives, with corners.
    pub front: FrontEnd,
    /// The background, linear 16-bit.
    pub background: [u16; 3],
    /// The table in which a device looks up colours: the 256 linear 16-bit values at which sRGB bytes begin; then a
    /// colour for every triangle, its own at one of its pixels.
    pub palette: Vec<u32>,
    /// What methods that approximate must know.
    pub approximation: Approximation,
    /// The share of a hash table's cells to be filled, in per cent.
    pub(super) load: u32,
    /// The rows of tiles of each band.
    pub(super) bands: Vec<Range<usize>>,
}

impl Picture {
    /// Set a scene up.
    #[must_use]
    pub fn new(scene: &Scene, sub_pixel_bits: u32) -> Self {
        let grid = Grid { width: scene.size[0], height: scene.size[1], tile: TILE };
        let front = FrontEnd::outlined(scene, grid, sub_pixel_bits, CullFace::None);
        let front = front.thick(Slabs::new(scene, Thickness::default()));
        let mut palette: Vec<u32> = vec![0; 256];
        for linear in (1..=u16::MAX).filter(|&linear| srgb(linear) > srgb(linear - 1)) {
            palette[usize::from(srgb(linear))] = linear.into();
        }
        palette.resize(256 + front.triangles as usize, 0);
        for primitive in front.primitives() {
            let (x, y) = (primitive.bounds.x0, primitive.bounds.y0);
            let depth = primitive.plane.code(primitive.plane.at(x, y));
            let color = front.color_of(primitive.triangle, x, y, depth);
            palette[256 + primitive.triangle as usize] = color;
        }
        let bands = bands(&front);
        let approximation = Approximation::default();
        let background = scene.background.map(word16);
        Self { front, background, palette, approximation, load: DEFAULT_LOAD, bands }
    }

    /// How thick surfaces are that do not say so themselves, for methods whose fragments are slabs.
    #[must_use]
    pub fn thick(self, scene: &Scene, thickness: Thickness) -> Self {
        Self { front: self.front.thick(Slabs::new(scene, thickness)), ..self }
    }

    /// With hash tables of which so many per cent are to be filled, 1 to 100.
    #[must_use]
    pub fn loaded(self, load: u32) -> Self {
        Self { load, ..self }
    }

    /// For methods that approximate, in this way.
    #[must_use]
    pub fn approximate(self, approximation: Approximation) -> Self {
        Self { approximation, ..self }
    }
}

/// Rows of tiles with at most [`FRAGMENTS`] fragments, but at least one row.
fn bands(front: &FrontEnd) -> Vec<Range<usize>> {
    let columns = front.grid.columns() as usize;
    let rows: Vec<u64> =
        front.count_fragments().chunks(columns).map(|row| row.iter().sum()).collect();
    let mut bands: Vec<Range<usize>> = Vec::new();
    let mut sum = 0;
    for (row, &count) in rows.iter().enumerate() {
        sum += count;
        match bands.last_mut() {
            Some(band) if sum <= FRAGMENTS => band.end = row + 1,
            _ => {
                bands.push(row..row + 1);
                sum = count;
            }
        }
    }
    bands
}
