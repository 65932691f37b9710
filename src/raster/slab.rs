//! Slabs: how far each fragment reaches from its depth towards the eye, as a depth code.
//!
//! A multiple of the depth precision is a constant number of codes: P(z) is what 2^-24 of the depth range is at z, and
//! a code is 2^-32 of it. World units are subtracted from the distance; the near plane is as near as a slab gets.

use super::batch::bits;
use crate::num::depth::{self, Format};
use crate::num::planes::Planes;
use crate::scene::{Scene, Thickness};

/// Codes of one P(z).
pub const PRECISION: f64 = 256.0;

/// The thickness of every triangle of a scene.
#[derive(Clone, Debug)]
pub struct Slabs {
    planes: Planes,
    /// Where the triangles of each object begin, with their thickness; the screen's triangles come last.
    spans: Vec<(u32, Span)>,
}

/// A thickness, ready to be subtracted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Span {
    Codes(u32),
    World(f64),
}

impl Slabs {
    /// Every object's own thickness, else `thickness`.
    #[must_use]
    pub fn new(scene: &Scene, thickness: Thickness) -> Self {
        let span = |thickness: Thickness| match thickness {
            Thickness::World(units) if units > 0.0 => Span::World(units),
            Thickness::World(_) => Span::Codes(0),
            Thickness::Precision(times) => {
                Span::Codes((times * PRECISION).round_ties_even() as u32)
            }
        };
        let mut first = 0;
        let mut spans: Vec<(u32, Span)> = Vec::new();
        let objects = scene
            .objects
            .iter()
            .map(|object| (object.mesh.primitives() as u32, object.thickness.unwrap_or(thickness)));
        for (triangles, own) in objects.chain([(u32::MAX, thickness)]) {
            let own = span(own);
            if spans.last().is_none_or(|(_, last)| *last != own) {
                spans.push((first, own));
            }
            first = first.saturating_add(triangles);
        }
        Self { planes: scene.camera.planes(), spans }
    }

    /// The near end of a triangle's slabs, by depth code.
    #[inline]
    #[must_use]
    pub(super) fn of(&self, triangle: u32) -> Near {
        let at = self.spans.partition_point(|(first, _)| *first <= triangle);
        Near { planes: self.planes, span: self.spans[at.saturating_sub(1)].1 }
    }
}

/// The slabs of one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    planes: Planes,
    span: Span,
}

impl Near {
    /// The near ends of the slabs whose far ends have those codes, by the bits of a mask. What is not set is arbitrary.
    pub(super) fn codes(self, mask: u64, codes: &[u32; 64], nears: &mut [u32; 64]) {
        match self.span {
            Span::Codes(thick) => {
                for (near, code) in nears.iter_mut().zip(codes) {
                    *near = code.saturating_sub(thick);
                }
            }
            Span::World(_) => {
                for i in bits(mask).map(|bit| bit as usize) {
                    nears[i] = self.code(codes[i]);
                }
            }
        }
    }

    /// The near end of the slab whose far end has that code.
    #[inline]
    #[must_use]
    pub(super) fn code(self, code: u32) -> u32 {
        match self.span {
            Span::Codes(codes) => code.saturating_sub(codes),
            Span::World(units) => {
                let along = self.planes.along(Format::D32.decode(code)) - units;
                depth::code(self.planes.depth(along)).min(code)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(thickness: Thickness, planes: Planes, code: u32) -> u32 {
        let span = match thickness {
            Thickness::Precision(times) => Span::Codes((times * PRECISION) as u32),
            Thickness::World(units) => Span::World(units),
        };
        Near { planes, span }.code(code)
    }

    /// P(z) as the paper prints it (equation 9), in absolute value, is 256 codes at every distance.
    #[test]
    fn a_precision_is_256_codes() {
        let planes = Planes { near: 0.5, far: 80.0, parallel: false };
        for code in [1 << 20, 1 << 28, 1 << 30, 3 << 30] {
            let z = planes.along(Format::D32.decode(code));
            let b = planes.near * planes.far / (planes.near - planes.far);
            let precision = (b / (b / z - 1.0 / f64::from(1 << 24)) - z).abs();
            let back = near(Thickness::World(10.0 * precision), planes, code);
            let codes = f64::from(code - back);
            // Ten steps at once are not quite ten times one step: P(z) falls towards the eye.
            assert!((codes / 2_560.0 - 1.0).abs() < 1e-3, "{z}: {codes}");
            assert_eq!(near(Thickness::Precision(10.0), planes, code), code - 2_560);
        }
    }

    #[test]
    fn slabs_end_at_the_near_plane() {
        for parallel in [false, true] {
            let planes = Planes { near: 1.0, far: 3.0, parallel };
            assert_eq!(near(Thickness::World(5.0), planes, 1 << 31), 0);
            assert_eq!(near(Thickness::Precision(1e9), planes, 1 << 31), 0);
            assert_eq!(near(Thickness::World(1e-300), planes, 1 << 31), 1 << 31);
        }
        let planes = Planes { near: 1.0, far: 3.0, parallel: true };
        assert_eq!(near(Thickness::World(1.0), planes, depth::code(0.75)), depth::code(0.25));
    }
}
