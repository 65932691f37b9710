//! The front end: a scene becomes primitives and bins.
//!
//! Triangles are set up in parallel in chunks of fixed size and joined in submission order, so that nothing depends
//! on the number of threads. A bin lists the primitives that may touch a tile, in submission order.

mod chunk;

use rayon::prelude::*;

pub use self::chunk::CullFace;
use self::chunk::{Chunk, Target};
use super::clip::{Polygon, Viewport};
use super::grid::Grid;
use super::place::Placed;
use super::primitive::{Primitive, Rect};
use super::shade::{Attenuation, Surface};
use super::slab::Slabs;
use crate::fragment::{BLOCK, Packet};
use crate::num::columns::Columns;
use crate::num::lanes::wide;
use crate::num::planes::Planes;
use crate::scene::Scene;

/// Triangles or discs per parallel chunk.
const CHUNK: usize = 4_096;

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
    primitives: Vec<Primitive>,
    surfaces: Vec<Surface>,
    /// Whether any surface is masked.
    masked: bool,
    /// By primitive: whether its back is seen. Kept apart, since few runs need it.
    backs: Vec<bool>,
    /// By primitive: its corners, if requested.
    outlines: Vec<Polygon>,
    /// The third word of fragments.
    pub(super) third: Third,
    /// The camera's planes.
    planes: Planes,
    /// What attenuates the light on its way.
    pub(super) attenuation: Option<Box<dyn Attenuation>>,
    /// Bin t is `binned[starts[t]..starts[t + 1]]`.
    starts: Vec<usize>,
    binned: Vec<u32>,
}

impl FrontEnd {
    /// Transform, clip, snap and bin every triangle and disc of a scene.
    #[must_use]
    pub fn new(scene: &Scene, grid: Grid, sub_pixel_bits: u32, cull: CullFace) -> Self {
        Self::attenuated(scene, grid, sub_pixel_bits, cull, None)
    }

    /// As [`FrontEnd::new`], with light that is attenuated on its way.
    #[must_use]
    pub fn attenuated(
        scene: &Scene,
        grid: Grid,
        sub_pixel_bits: u32,
        cull: CullFace,
        attenuation: Option<Box<dyn Attenuation>>,
    ) -> Self {
        let attenuated = attenuation.is_some();
        let viewport = Viewport { width: grid.width, height: grid.height, sub_pixel_bits };
        let target = Target { attenuated, ..Target::new(viewport, grid.image(), cull) };
        Self { attenuation, ..Self::of(scene, grid, target) }
    }

    /// As [`FrontEnd::new`], with the corners of every primitive ([`FrontEnd::outlines`]).
    #[must_use]
    pub fn outlined(scene: &Scene, grid: Grid, sub_pixel_bits: u32, cull: CullFace) -> Self {
        let viewport = Viewport { width: grid.width, height: grid.height, sub_pixel_bits };
        let target = Target { outlines: true, ..Target::new(viewport, grid.image(), cull) };
        Self::of(scene, grid, target)
    }

    /// As [`FrontEnd::new`], for runs that store triangle indices and ask for normals ([`FrontEnd::normal_of`]).
    #[must_use]
    pub fn with_normals(scene: &Scene, grid: Grid, sub_pixel_bits: u32, cull: CullFace) -> Self {
        let viewport = Viewport { width: grid.width, height: grid.height, sub_pixel_bits };
        let image = grid.image();
        Self::of(scene, grid, Target { normals: true, ..Target::new(viewport, image, cull) })
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
        self.surface(self.primitive_of(triangle)?).normal(x, y)
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

    fn of(scene: &Scene, grid: Grid, target: Target) -> Self {
        let view_projection = scene.camera.view_projection(scene.size);
        let mut chunks = Vec::new();
        let mut first = 0u32;
        for object in &scene.objects {
            let placed = Placed::new(object, scene, view_projection, &target.viewport);
            let triangles = &object.mesh.triangles;
            chunks.par_extend(triangles.par_chunks(CHUNK).enumerate().map(|(i, part)| {
                Chunk::of_object(&placed, part, first + (i * CHUNK) as u32, target)
            }));
            first += triangles.len() as u32;
            let discs = &object.mesh.discs;
            chunks.par_extend(discs.par_chunks(CHUNK).enumerate().map(|(i, part)| {
                Chunk::of_discs(&placed, part, first + (i * CHUNK) as u32, target)
            }));
            first += discs.len() as u32;
        }
        chunks.push(Chunk::of_screen(&scene.screen, first, target));
        let triangles = u64::from(first) + scene.screen.len() as u64;
        Self { planes: scene.camera.planes(), ..Self::join(grid, triangles, chunks) }
    }

    fn join(grid: Grid, triangles: u64, chunks: Vec<Chunk>) -> Self {
        let count = chunks.iter().map(|c| c.primitives.len()).sum();
        let mut primitives: Vec<Primitive> = Vec::with_capacity(count);
        let (mut surfaces, mut backs) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut outlines = Vec::new();
        let mut degenerate = 0;
        for mut chunk in chunks {
            let base = surfaces.len() as u32;
            chunk.primitives.iter_mut().for_each(|p| p.surface += base);
            primitives.append(&mut chunk.primitives);
            surfaces.append(&mut chunk.surfaces);
            backs.append(&mut chunk.backs);
            outlines.append(&mut chunk.outlines);
            degenerate += chunk.degenerate;
        }
        let (starts, binned) = bin(&primitives, &grid);
        Self {
            grid,
            triangles,
            degenerate,
            primitives,
            masked: surfaces.iter().any(Surface::is_masked),
            surfaces,
            backs,
            outlines,
            third: Third::Nothing,
            planes: Planes::default(),
            attenuation: None,
            starts,
            binned,
        }
    }

    /// The primitives in submission order.
    #[must_use]
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The corners of every primitive, snapped, in their order; empty unless requested.
    #[must_use]
    pub fn outlines(&self) -> &[Polygon] {
        &self.outlines
    }

    /// What lies on a primitive.
    #[inline]
    #[must_use]
    pub fn surface(&self, primitive: &Primitive) -> &Surface {
        &self.surfaces[primitive.surface as usize]
    }

    /// The primitive of a global triangle index, if it is visible.
    #[must_use]
    pub fn primitive_of(&self, triangle: u32) -> Option<&Primitive> {
        self.index_of(triangle).map(|i| &self.primitives[i])
    }

    /// Whether a global triangle index is seen from its back, if it is visible.
    #[must_use]
    pub fn is_back(&self, triangle: u32) -> Option<bool> {
        self.index_of(triangle).map(|i| self.backs[i])
    }

    fn index_of(&self, triangle: u32) -> Option<usize> {
        self.primitives.binary_search_by_key(&triangle, |p| p.triangle).ok()
    }

    /// Call `emit` for every packet of a tile, in submission order.
    #[inline]
    pub fn packets(&self, tile: usize, mut emit: impl FnMut(Packet)) {
        let window = self.grid.tile_rect(tile);
        wide(
            #[inline(always)]
            || {
                for &index in &self.binned[self.starts[tile]..self.starts[tile + 1]] {
                    self.primitive_packets(index, window, &mut emit);
                }
            },
        );
    }

    /// Call `emit` for every packet of the whole image, in submission order of primitives.
    pub fn packets_in_order(&self, mut emit: impl FnMut(Packet)) {
        let window = self.grid.image();
        for index in 0..self.primitives.len() as u32 {
            self.primitive_packets(index, window, &mut emit);
        }
    }

    /// Call `emit` for every packet of one primitive inside `window`, row by row.
    #[allow(clippy::inline_always, reason = "see `lanes`")]
    #[inline(always)]
    pub fn primitive_packets(&self, index: u32, window: Rect, mut emit: impl FnMut(Packet)) {
        let primitive = &self.primitives[index as usize];
        let masked = self.masked.then(|| self.surface(primitive)).filter(|s| s.is_masked());
        primitive.blocks(window, |x, y, mut mask| {
            if let Some(surface) = masked {
                mask = left(surface, [x, y], mask);
                if mask == 0 {
                    return;
                }
            }
            let (column, row) = ((x / 8) as u16, (y / 8) as u16);
            emit(Packet { primitive: index, column, row, mask });
        });
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

/// Bins in CSR form: starts per tile, then primitive indices in submission order.
fn bin(primitives: &[Primitive], grid: &Grid) -> (Vec<usize>, Vec<u32>) {
    let mut starts = vec![0usize; grid.tiles() + 1];
    for primitive in primitives {
        grid.tiles_touching(primitive.bounds, |tile| starts[tile + 1] += 1);
    }
    for tile in 0..grid.tiles() {
        starts[tile + 1] += starts[tile];
    }
    let mut next = starts.clone();
    let mut binned = vec![0u32; starts[grid.tiles()]];
    for (index, primitive) in (0u32..).zip(primitives) {
        grid.tiles_touching(primitive.bounds, |tile| {
            binned[next[tile]] = index;
            next[tile] += 1;
        });
    }
    (starts, binned)
}
