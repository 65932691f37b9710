//! Strands: thin tubes along a path.

use glam::DVec3;

use super::super::super::Mesh;
use super::super::shape::{on_circle, place, point};
use crate::num::random::Random;

/// A tube's cross-section.
pub(super) struct Tube {
    /// Sides of it, at least 3.
    pub(super) sides: u32,
    /// At its root.
    pub(super) radius: f64,
    /// By which share it is thinner at its tip.
    pub(super) taper: f64,
}

/// A uniformly random unit vector, by rejection.
pub(super) fn direction(random: &mut Random) -> DVec3 {
    loop {
        let v = DVec3::from([(); 3].map(|()| random.range(-1.0, 1.0)));
        let square = v.length_squared();
        if square > 1e-4 && square <= 1.0 {
            return v / libm::sqrt(square);
        }
    }
}

impl Tube {
    /// Adds a tube along a path of at least two points. Its cross-section is carried along without twist.
    pub(super) fn add(&self, path: &[DVec3], mesh: &mut Mesh) {
        let first = mesh.positions.len() as u32;
        let mut across = (path[1] - path[0]).any_orthogonal_vector();
        for (i, &center) in path.iter().enumerate() {
            let part = i as f64 / (path.len() - 1) as f64;
            let radius = self.radius * (1.0 - self.taper * part);
            let ends = [path[i.saturating_sub(1)], path[(i + 1).min(path.len() - 1)]];
            let along = (ends[1] - ends[0]).normalize_or(DVec3::Y);
            across =
                (across - along * along.dot(across)).normalize_or(along.any_orthonormal_vector());
            let other = along.cross(across);
            for (c, s) in (0..self.sides).map(|side| on_circle(side, self.sides)) {
                let normal = across * c + other * s;
                mesh.positions.push(place(center + normal * radius));
                mesh.normals.push(point(normal));
            }
        }
        for ring in 0..path.len() as u32 - 1 {
            let start = first + ring * self.sides;
            for side in 0..self.sides {
                let [a, b] = [start + side, start + (side + 1) % self.sides];
                let [c, d] = [a + self.sides, b + self.sides];
                mesh.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
}
