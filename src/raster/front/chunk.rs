//! Setting up part of a scene, by one thread.

use super::super::clip::{Polygon, Viewport};
use super::super::place::Placed;
use super::super::primitive::{Primitive, Rect, Setup};
use super::super::shade::{Seen, Surface};
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

/// Part of a scene, set up by one thread.
#[derive(Default)]
pub(super) struct Chunk {
    pub(super) primitives: Vec<Primitive>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) backs: Vec<bool>,
    pub(super) outlines: Vec<Polygon>,
    pub(super) degenerate: u64,
}

impl Chunk {
    pub(super) fn of_object(
        placed: &Placed<'_>,
        part: &[[u32; 3]],
        first: u32,
        target: Target,
    ) -> Self {
        let mut chunk = Self::default();
        for (index, triangle) in (first..).zip(part) {
            match placed.corners(*triangle) {
                None => chunk.degenerate += 1,
                Some(corners) => {
                    let polygon = placed.polygon(*triangle, &corners, &target.viewport);
                    chunk.add(target.of(placed), index, &polygon, |turned, bounds| {
                        placed.surface(&corners, target.seen(turned), &target.viewport, bounds)
                    });
                }
            }
        }
        chunk
    }

    pub(super) fn of_discs(placed: &Placed<'_>, part: &[Disc], first: u32, target: Target) -> Self {
        let mut chunk = Self::default();
        for (index, disc) in (first..).zip(part) {
            match placed.disc(disc) {
                None => chunk.degenerate += 1,
                Some(lying) => {
                    let polygon = target.viewport.clip(lying.octagon());
                    chunk.add(target.of(placed), index, &polygon, |turned, bounds| {
                        placed.disc_surface(
                            disc,
                            &lying,
                            target.seen(turned),
                            &target.viewport,
                            bounds,
                        )
                    });
                }
            }
        }
        chunk
    }

    pub(super) fn of_screen(triangles: &[ScreenTriangle], first: u32, target: Target) -> Self {
        let mut chunk = Self::default();
        for (index, triangle) in (first..).zip(triangles) {
            let polygon =
                Polygon::new(&triangle.points.map(|[x, y, z]| target.viewport.snap(x, y, z)));
            let [r, g, b, alpha] = triangle.color;
            let word = color::rgba8([r, g, b], alpha);
            chunk.add(target, index, &polygon, |_, _| Surface::Uniform(word));
        }
        chunk
    }

    /// Set up one triangle; `surface(turned, bounds)` is called only if the triangle is drawn, with whether its corners
    /// are seen clockwise.
    fn add(
        &mut self,
        target: Target,
        index: u32,
        polygon: &Polygon,
        surface: impl FnOnce(bool, Rect) -> Surface,
    ) {
        match Primitive::new(polygon, index, target.image) {
            Setup::Degenerate => self.degenerate += 1,
            Setup::Nothing => {}
            Setup::Visible(mut primitive) => {
                // y points down, so a positive area is clockwise: the back, unless mirrored.
                let turned = polygon.doubled_area() > 0;
                let back = turned != target.mirrored;
                if !target.cull.leaves_out(back) {
                    primitive.surface = self.surfaces.len() as u32;
                    self.surfaces.push(surface(turned, primitive.bounds));
                    self.primitives.push(primitive);
                    self.backs.push(back);
                    if target.outlines {
                        self.outlines.push(*polygon);
                    }
                }
            }
        }
    }
}

/// The settings for triangles.
#[derive(Clone, Copy)]
pub(super) struct Target {
    pub(super) viewport: Viewport,
    pub(super) image: Rect,
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
    pub(super) fn new(viewport: Viewport, image: Rect, cull: CullFace) -> Self {
        let (attenuated, outlines, normals, mirrored) = (false, false, false, false);
        Self { viewport, image, cull, attenuated, outlines, normals, mirrored }
    }

    /// For an object in place.
    fn of(self, placed: &Placed<'_>) -> Self {
        Self { mirrored: placed.is_mirrored(), ..self }
    }

    fn seen(&self, turned: bool) -> Seen {
        Seen { turned, attenuated: self.attenuated, normals: self.normals }
    }
}
