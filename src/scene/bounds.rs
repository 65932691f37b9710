//! Axis-aligned boxes around what is drawn.

use glam::DVec3;
use rayon::prelude::*;

use super::{Disc, Object};

/// An axis-aligned box in world space; empty while `min` is above `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub min: DVec3,
    /// The largest coordinates.
    pub max: DVec3,
}

/// Triangles that a thread looks at at once.
const BLOCK: usize = 1 << 14;

impl Bounds {
    /// No point at all.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Around the corners of all triangles of `objects`, and all their discs; vertices that no triangle uses do not count.
    #[must_use]
    pub fn of(objects: &[Object]) -> Self {
        let corners = objects.iter().fold(Self::EMPTY, |bounds, object| {
            let around = |triangles: &[[u32; 3]]| {
                let mut bounds = Self::EMPTY;
                for &vertex in triangles.as_flattened() {
                    let point = object.mesh.positions[vertex as usize];
                    bounds = bounds.with(object.transform.transform_point3(DVec3::from(point)));
                }
                bounds
            };
            let triangles = &object.mesh.triangles;
            let own = match triangles.len() > BLOCK {
                true => {
                    let parts = triangles.par_chunks(BLOCK).map(around);
                    parts.reduce(|| Self::EMPTY, Self::and)
                }
                false => around(triangles),
            };
            bounds.and(own)
        });
        let discs =
            objects.iter().flat_map(|object| object.mesh.discs.iter().map(move |d| (object, d)));
        discs.flat_map(|(object, disc)| rim(object, disc)).fold(corners, Self::with)
    }

    /// This box, grown to hold `point`. A point that is not a number makes the box infinite.
    #[must_use]
    pub fn with(self, point: DVec3) -> Self {
        if point.is_nan() {
            return Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        }
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Around both.
    fn and(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle.
    #[must_use]
    pub fn center(self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The length of the diagonal.
    #[must_use]
    pub fn diagonal(self) -> f64 {
        (self.max - self.min).length()
    }

    /// The eight corners.
    #[must_use]
    pub fn corners(self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick =
                |axis: usize| if i >> axis & 1 == 0 { self.min[axis] } else { self.max[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// This box, or one around its middle where it is empty or too small for its distance from the origin to be
    /// distinguished from a point.
    #[must_use]
    pub(super) fn thickened(self) -> Self {
        if self.min.x > self.max.x {
            return Self { min: DVec3::splat(-0.5), max: DVec3::splat(0.5) };
        }
        let center = self.center();
        let reach = center.abs().max_element();
        if self.diagonal() > reach * 1e-9 {
            return self;
        }
        let half = DVec3::splat(if reach > 0.0 { reach * 1e-3 } else { 0.5 });
        Self { min: center - half, max: center + half }
    }
}

/// Two opposite corners of the smallest box around a disc in the world: along each axis, the ellipse reaches as far as
/// its half axes do together, by Pythagoras.
fn rim(object: &Object, disc: &Disc) -> [DVec3; 2] {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let center = object.transform.transform_point3(DVec3::from(disc.center));
    let [a, b] = disc.axes.map(|axis| object.transform.transform_vector3(wide(axis)));
    let reach = DVec3::from(std::array::from_fn(|i| (a[i] * a[i] + b[i] * b[i]).sqrt()));
    [center - reach, center + reach]
}
