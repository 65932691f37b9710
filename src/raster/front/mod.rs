//! The front end: a scene becomes primitives and bins.
//!
//! Triangles and discs are set up in parallel, in parts of a fixed number, and the parts stay as they are: nothing is
//! joined or moved, and nothing depends on the number of threads. The index of a primitive is its part and its place
//! there, so that indices grow in submission order, with gaps. A bin lists the primitives that may touch a tile, in
//! submission order (`bins`).

mod bins;
mod part;
mod pieces;
mod room;
mod set_up;

use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use self::bins::Bins;
use self::part::{Part, Target};
use super::clip::{Polygon, Viewport};
use super::grid::Grid;
use super::primitive::{Primitive, Rect};
use super::shade::{Attenuation, Surface};
use super::slab::Slabs;
use crate::fragment::{BLOCK, Packet};
use crate::num::columns::Columns;
use crate::num::lanes::explicit;
use crate::num::planes::Planes;
use crate::scene::Scene;

pub use self::part::CullFace;
pub use self::room::Room;

/// A part has at most 2^12 primitives.
const PART_BITS: u32 = 12;

/// Triangles and discs of a part.
const PART: usize = 1 << PART_BITS;

/// What a fragment's third word is.
#[derive(Debug)]
pub(super) enum Third {
    /// 0, or a rank that the executor gives it.
    Nothing,
    /// The near end of its slab: how thick surfaces are.
    Near(Slabs),
    /// The number of its triangle.
    Primitive,
}

/// A scene's primitives, binned by tile.
#[derive(Debug)]
pub struct FrontEnd {
    /// The image and its tiles.
    pub grid: Grid,
    /// Triangles and discs in the scene.
    pub triangles: u64,
    /// Those of zero area, before or after snapping.
    pub degenerate: u64,
    /// In submission order. None of them is empty.
    parts: Vec<Part>,
    /// Whether any surface is masked.
    masked: bool,
    /// The third word of fragments.
    pub(super) third: Third,
    /// The camera's planes.
    planes: Planes,
    /// What attenuates the light on its way.
    pub(super) attenuation: Option<Box<dyn Attenuation>>,
    bins: Bins,
}

impl FrontEnd {
    /// Transform, clip, snap and bin every triangle and disc of a scene.
    #[must_use]
    pub fn new(scene: &Scene, grid: Grid, sub_pixel_bits: u32, cull: CullFace) -> Self {
        Self::attenuated(scene, grid, sub_pixel_bits, cull, None, &Room::default())
    }

    /// As [`FrontEnd::new`], with light that is attenuated on its way, in room that earlier ones have left.
    #[must_use]
    pub fn attenuated(
        scene: &Scene,
        grid: Grid,
        sub_pixel_bits: u32,
        cull: CullFace,
        attenuation: Option<Box<dyn Attenuation>>,
        room: &Room,
    ) -> Self {
        let attenuated = attenuation.is_some();
        let viewport = Viewport { width: grid.width, height: grid.height, sub_pixel_bits };
        let target = Target { attenuated, ..Target::new(viewport, grid, cull) };
        Self { attenuation, ..Self::of(scene, target, room) }
    }

    /// As [`FrontEnd::new`], with the corners of every primitive ([`FrontEnd::outline`]).
    #[must_use]
    pub fn outlined(scene: &Scene, grid: Grid, sub_pixel_bits: u32, cull: CullFace) -> Self {
        let viewport = Viewport { width: grid.width, height: grid.height, sub_pixel_bits };
        let target = Target { outlines: true, ..Target::new(viewport, grid, cull) };
        Self::of(scene, target, &Room::default())
    }

    /// As [`FrontEnd::new`], for runs that store triangle indices and ask for normals ([`FrontEnd::normal_of`]).
    #[must_use]
    pub fn with_normals(scene: &Scene, grid: Grid, sub_pixel_bits: u32, cull: CullFace) -> Self {
        let viewport = Viewport { width: grid.width, height: grid.height, sub_pixel_bits };
        let target = Target { normals: true, ..Target::new(viewport, grid, cull) };
        Self::of(scene, target, &Room::default())
    }

    fn of(scene: &Scene, target: Target, room: &Room) -> Self {
        let (parts, triangles) = set_up::set_up(scene, target, room);
        let degenerate = parts.iter().map(|part| part.degenerate).sum();
        let (parts, empty): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|part| !part.primitives.is_empty());
        room.keep_parts(empty);
        let rows: Vec<_> = parts.iter().map(|part| &part.rows).collect();
        let bins = Bins::new(&rows, &target.grid, || room.row());
        Self {
            grid: target.grid,
            triangles,
            degenerate,
            masked: parts.iter().any(|part| part.masked),
            bins,
            parts,
            third: Third::Nothing,
            planes: scene.camera.planes(),
            attenuation: None,
        }
    }

    /// Leave the room that it took to the next one.
    pub fn leave(self, room: &Room) {
        room.keep_parts(self.parts);
        room.keep_rows(self.bins.leave());
        room.tidy();
    }

    /// Make fragments slabs: their third word is the near end.
    #[must_use]
    pub fn thick(mut self, slabs: Slabs) -> Self {
        self.third = Third::Near(slabs);
        self
    }

    /// Make the third word of fragments the number of their triangle.
    #[must_use]
    pub fn numbered(mut self) -> Self {
        self.third = Third::Primitive;
        self
    }

    /// Whether the third word of fragments is the number of their triangle.
    pub(super) fn is_numbered(&self) -> bool {
        matches!(self.third, Third::Primitive)
    }

    /// How depths stand for distances.
    #[must_use]
    pub fn planes(&self) -> Planes {
        self.planes
    }

    /// How thick surfaces are, if fragments are slabs.
    #[must_use]
    pub fn slabs(&self) -> Option<&Slabs> {
        match &self.third {
            Third::Near(slabs) => Some(slabs),
            Third::Nothing | Third::Primitive => None,
        }
    }

    /// The unit normal of a triangle at a pixel, towards the viewer, in world space; `None` for triangles given in
    /// pixels, those that are not visible, and without [`FrontEnd::with_normals`].
    #[must_use]
    pub fn normal_of(&self, triangle: u32, x: u32, y: u32) -> Option<[f32; 3]> {
        self.surface(self.index_of(triangle)?).normal(x, y)
    }

    /// By storage pixel, how many fragments it has.
    #[must_use]
    pub fn counts(&self) -> Vec<u32> {
        let tiles = (0..self.grid.tiles()).into_par_iter().map(|tile| self.counts_of(tile));
        tiles.collect::<Vec<_>>().concat()
    }

    /// By pixel of a tile, how many fragments it has.
    #[must_use]
    pub fn counts_of(&self, tile: usize) -> Vec<u32> {
        let mut counts = Columns::new(self.grid.pixels_per_tile() / 64);
        self.packets(tile, |p| counts.add(self.grid.local_block(p) as usize, p.mask));
        counts.counts()
    }

    /// The indices of all primitives, in submission order: they grow, with gaps.
    #[must_use]
    pub fn indices(&self) -> Vec<u32> {
        let of_part = |(part, at): (&Part, u32)| {
            let first = at << PART_BITS;
            first..first + part.primitives.len() as u32
        };
        self.parts.iter().zip(0..).flat_map(of_part).collect()
    }

    /// The primitives in submission order.
    pub fn primitives(&self) -> impl Iterator<Item = &Primitive> {
        self.parts.iter().flat_map(|part| &part.primitives)
    }

    /// How many primitives there are.
    #[must_use]
    pub fn visible(&self) -> usize {
        self.parts.iter().map(|part| part.primitives.len()).sum()
    }

    #[inline]
    fn part(&self, index: u32) -> (&Part, usize) {
        (&self.parts[(index >> PART_BITS) as usize], index as usize % PART)
    }

    /// The primitive with an index, as packets and [`FrontEnd::indices`] have it.
    ///
    /// # Panics
    /// There is none.
    #[inline]
    #[must_use]
    pub fn primitive(&self, index: u32) -> &Primitive {
        let (part, at) = self.part(index);
        &part.primitives[at]
    }

    /// What lies on the primitive with an index.
    ///
    /// # Panics
    /// There is none.
    #[inline]
    #[must_use]
    pub fn surface(&self, index: u32) -> &Surface {
        let (part, at) = self.part(index);
        &part.surfaces[at]
    }

    /// The corners of the primitive with an index, snapped; `None` unless requested ([`FrontEnd::outlined`]).
    #[must_use]
    pub fn outline(&self, index: u32) -> Option<&Polygon> {
        let (part, at) = self.part(index);
        part.outlines.get(at)
    }

    /// Whether a global triangle index is seen from its back, if it is visible.
    #[must_use]
    pub fn is_back(&self, triangle: u32) -> Option<bool> {
        let (part, at) = self.part(self.index_of(triangle)?);
        Some(part.backs[at])
    }

    /// The index of the primitive that a global triangle index has, if it is visible.
    #[must_use]
    pub fn index_of(&self, triangle: u32) -> Option<u32> {
        let begins = |part: &Part| part.primitives[0].triangle <= triangle;
        let at = self.parts.partition_point(begins).checked_sub(1)?;
        let found =
            self.parts[at].primitives.binary_search_by_key(&triangle, |p| p.triangle).ok()?;
        Some(((at as u32) << PART_BITS) + found as u32)
    }

    /// Call `emit` for every packet of a tile, in submission order.
    #[inline]
    pub fn packets(&self, tile: usize, emit: impl FnMut(Packet)) {
        self.each_packet(self.bins.of(tile), self.grid.tile_rect(tile), emit);
    }

    /// Call `emit` for every packet of the whole image, in submission order of primitives.
    pub fn packets_in_order(&self, emit: impl FnMut(Packet)) {
        self.each_packet(&self.indices(), self.grid.image(), emit);
    }

    /// Call `emit` for every packet of one primitive inside `window`, row by row.
    pub fn primitive_packets(&self, index: u32, window: Rect, emit: impl FnMut(Packet)) {
        self.each_packet(&[index], window, emit);
    }

    #[inline]
    fn each_packet(&self, indices: &[u32], window: Rect, emit: impl FnMut(Packet)) {
        explicit(Packets { front: self, indices, window, emit });
    }

    /// Fragments of each tile in one geometry pass, without generating them.
    #[must_use]
    pub fn count_fragments(&self) -> Vec<u64> {
        let tile = |t: usize| {
            let mut sum = 0;
            self.packets(t, |p| sum += u64::from(p.mask.count_ones()));
            sum
        };
        (0..self.grid.tiles()).into_par_iter().map(tile).collect()
    }

    /// The depth-complexity histogram: for every number of fragments, how many storage pixels have it. Its length is
    /// the largest number at any pixel, plus one.
    #[must_use]
    pub fn depth_complexity(&self) -> Vec<u64> {
        let tile = |t: usize| {
            let counts = self.counts_of(t);
            let mut histogram = vec![0u64; counts.iter().max().map_or(0, |&f| f as usize) + 1];
            counts.iter().for_each(|&f| histogram[f as usize] += 1);
            histogram
        };
        let join = |mut a: Vec<u64>, b: Vec<u64>| {
            a.resize(a.len().max(b.len()), 0);
            a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
            a
        };
        (0..self.grid.tiles()).into_par_iter().map(tile).reduce(|| vec![0], join)
    }

    /// The largest number of fragments at any pixel.
    #[must_use]
    pub fn max_depth_complexity(&self) -> u32 {
        self.depth_complexity().len() as u32 - 1
    }
}

/// The packets of some primitives.
struct Packets<'a, F> {
    front: &'a FrontEnd,
    indices: &'a [u32],
    window: Rect,
    emit: F,
}

impl<F: FnMut(Packet)> WithSimd for Packets<'_, F> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "see `lanes`")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { front, indices, window, mut emit } = self;
        for &primitive in indices {
            let masked = front.masked.then(|| front.surface(primitive)).filter(|s| s.is_masked());
            front.primitive(primitive).each_block(simd, window, |x, y, mut mask| {
                if let Some(surface) = masked {
                    mask = left(surface, [x, y], mask);
                    if mask == 0 {
                        return;
                    }
                }
                let (column, row) = ((x / BLOCK) as u16, (y / BLOCK) as u16);
                emit(Packet { primitive, column, row, mask });
            });
        }
    }
}

/// What a mask leaves of a block's pixels, the first of which is `from`.
fn left(surface: &Surface, from: [u32; 2], mask: u64) -> u64 {
    let mut left = mask;
    let mut bits = mask;
    while bits != 0 {
        let bit = bits.trailing_zeros();
        bits &= bits - 1;
        if surface.is_cut(from[0] + bit % BLOCK, from[1] + bit / BLOCK) {
            left &= !(1 << bit);
        }
    }
    left
}
