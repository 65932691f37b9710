//! Setting up part of a scene, by one thread.

use super::super::clip::{Polygon, Snapped, Viewport, doubled_area_of};
use super::super::grid::Grid;
use super::super::place::Placed;
use super::super::primitive::{Primitive, Rect, Setup};
use super::super::shade::{Seen, Surface};
use super::PART;
use super::bins::Rows;
use super::pieces::{Piece, Source};
use crate::num::color;
use crate::scene::{Disc, ScreenTriangle};

/// Which faces are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum CullFace {
    /// Draw both.
    #[default]
    None,
    /// Leave out front faces: those seen counter-clockwise, or clockwise where their object is mirrored.
    Front,
    /// Leave out back faces: the others.
    Back,
}

impl CullFace {
    fn leaves_out(self, back: bool) -> bool {
        match self {
            Self::None => false,
            Self::Front => !back,
            Self::Back => back,
        }
    }
}

/// Part of a scene, set up by one thread: of each primitive what its coverage and depth take, what lies on it, and
/// whether its back is seen.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) primitives: Vec<Primitive>,
    /// Of primitives of which only the first half is set up: their carriers.
    carriers: Vec<[Snapped; 3]>,
    pub(super) surfaces: Vec<Surface>,
    /// Kept apart, since few runs need it.
    pub(super) backs: Vec<bool>,
    /// The corners, if requested.
    pub(super) outlines: Vec<Polygon>,
    pub(super) degenerate: u64,
    /// Whether any surface is masked.
    pub(super) masked: bool,
    /// By row of tiles.
    pub(super) rows: Rows,
}

impl Part {
    /// Set up at most [`PART`] triangles and discs in an empty part.
    pub(super) fn fill(mut self, pieces: &[Piece<'_>], target: Target) -> Self {
        let part = &mut self;
        part.primitives.reserve_exact(PART);
        part.surfaces.reserve_exact(PART);
        part.backs.reserve_exact(PART);
        part.carriers.reserve_exact(PART);
        for &Piece { source, first } in pieces {
            match source {
                Source::Triangles(placed, triangles) => {
                    part.add_triangles(placed, triangles, first, target);
                }
                Source::Discs(placed, discs) => part.add_discs(placed, discs, first, target),
                Source::Screen(triangles) => part.add_screen(triangles, first, target),
            }
        }
        for (primitive, carrier) in part.primitives.iter_mut().zip(part.carriers.drain(..)) {
            primitive.finish(carrier);
        }
        part.masked = part.surfaces.iter().any(Surface::is_masked);
        part.rows.sort(&part.primitives, &target.grid);
        self
    }

    fn add_triangles(
        &mut self,
        placed: &Placed<'_>,
        triangles: &[[u32; 3]],
        first: u32,
        target: Target,
    ) {
        let Target { viewport, .. } = target;
        let own = target.of(placed);
        for (index, &triangle) in (first..).zip(triangles) {
            let Some(corners) = placed.corners(triangle) else {
                self.degenerate += 1;
                continue;
            };
            let surface = |turned, bounds| {
                placed.surface(triangle, &corners, target.seen(turned), &viewport, bounds)
            };
            match placed.screen(&corners) {
                Some(vertices) => self.add(own, index, &vertices, surface),
                None => match placed.clip(&corners) {
                    None => self.degenerate += 1,
                    Some(clip) => {
                        self.add(own, index, viewport.clip(clip).vertices(), surface);
                    }
                },
            }
        }
    }

    fn add_discs(&mut self, placed: &Placed<'_>, discs: &[Disc], first: u32, target: Target) {
        let Target { viewport, .. } = target;
        for (index, disc) in (first..).zip(discs) {
            match placed.disc(disc) {
                None => self.degenerate += 1,
                Some(lying) => {
                    let polygon = viewport.clip(lying.octagon());
                    self.add(target.of(placed), index, polygon.vertices(), |turned, bounds| {
                        placed.disc_surface(disc, &lying, target.seen(turned), &viewport, bounds)
                    });
                }
            }
        }
    }

    fn add_screen(&mut self, triangles: &[ScreenTriangle], first: u32, target: Target) {
        for (index, triangle) in (first..).zip(triangles) {
            let [a, b, c] = triangle.points;
            let snap = |[x, y, z]: [f64; 3]| target.viewport.snap(x, y, z);
            let vertices = [snap(a), snap(b), snap(c)];
            let [r, g, b, alpha] = triangle.color;
            let word = color::rgba8([r, g, b], alpha);
            self.add(target, index, &vertices, |_, _| Surface::Uniform(word));
        }
    }

    /// Set up one polygon; `surface(turned, bounds)` is called only if it is drawn, with whether its corners are seen
    /// clockwise.
    #[allow(clippy::inline_always, reason = "three vertices, known to be three, take no loop")]
    #[inline(always)]
    fn add(
        &mut self,
        target: Target,
        index: u32,
        vertices: &[Snapped],
        surface: impl FnOnce(bool, Rect) -> Surface,
    ) {
        match Primitive::begin(vertices, index, target.grid.image()) {
            Setup::Degenerate => self.degenerate += 1,
            Setup::Nothing => {}
            Setup::Visible((primitive, carrier)) => {
                // y points down, so a positive area is clockwise: the back, unless mirrored.
                let turned = doubled_area_of(vertices) > 0;
                let back = turned != target.mirrored;
                if !target.cull.leaves_out(back) {
                    self.surfaces.push(surface(turned, primitive.bounds));
                    self.primitives.push(primitive);
                    self.carriers.push(carrier);
                    self.backs.push(back);
                    if target.outlines {
                        self.outlines.push(Polygon::new(vertices));
                    }
                }
            }
        }
    }

    /// Nothing, in the same room.
    pub(super) fn emptied(mut self) -> Self {
        self.primitives.clear();
        self.surfaces.clear();
        self.backs.clear();
        self.outlines.clear();
        Self { degenerate: 0, masked: false, ..self }
    }
}

/// The settings for triangles.
#[derive(Clone, Copy)]
pub(super) struct Target {
    pub(super) viewport: Viewport,
    pub(super) grid: Grid,
    pub(super) cull: CullFace,
    /// Whether light is attenuated.
    pub(super) attenuated: bool,
    /// Whether corners are kept.
    pub(super) outlines: bool,
    /// Whether normals are.
    pub(super) normals: bool,
    /// Whether clockwise faces are front faces.
    pub(super) mirrored: bool,
}

impl Target {
    pub(super) fn new(viewport: Viewport, grid: Grid, cull: CullFace) -> Self {
        let (attenuated, outlines, normals, mirrored) = (false, false, false, false);
        Self { viewport, grid, cull, attenuated, outlines, normals, mirrored }
    }

    /// For an object in place.
    fn of(self, placed: &Placed<'_>) -> Self {
        Self { mirrored: placed.is_mirrored(), ..self }
    }

    fn seen(&self, turned: bool) -> Seen {
        Seen { turned, attenuated: self.attenuated, normals: self.normals }
    }
}
