//! From depths to distances and back: what a camera's two planes say. All of it is f64 in the order written.

use super::depth::Format;

/// The planes of a camera.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    /// Distance of the near plane, above 0 for a perspective.
    pub near: f64,
    /// Distance of the far plane, above `near`.
    pub far: f64,
    /// The rays are parallel: depth grows evenly with distance. Otherwise it is a perspective.
    pub parallel: bool,
}

impl Default for Planes {
    /// A perspective from 0.1 to 100.
    fn default() -> Self {
        Self { near: 0.1, far: 100.0, parallel: false }
    }
}

impl PartialEq for Planes {
    fn eq(&self, other: &Self) -> bool {
        let bits = |planes: &Self| [planes.near.to_bits(), planes.far.to_bits()];
        (bits(self), self.parallel) == (bits(other), other.parallel)
    }
}

impl Eq for Planes {}

impl Planes {
    /// The distance from the eye's plane along the line of sight, in world units, of a depth of 0..1.
    #[inline]
    #[must_use]
    pub fn along(self, z: f64) -> f64 {
        let Self { near, far, parallel } = self;
        if parallel { near + z * (far - near) } else { (near * far) / (far - z * (far - near)) }
    }

    /// The depth, 0..1, of a distance along the line of sight. Distances beyond the planes are those of the planes.
    #[inline]
    #[must_use]
    pub fn depth(self, along: f64) -> f64 {
        let Self { near, far, parallel } = self;
        let along = along.clamp(near, far);
        let depth = if parallel {
            (along - near) / (far - near)
        } else {
            (far - (near * far) / along) / (far - near)
        };
        depth.clamp(0.0, 1.0)
    }
}

/// How the depth words of a run stand for distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Distances {
    /// The camera's planes.
    pub planes: Planes,
    /// How depths are stored.
    pub format: Format,
}

impl Distances {
    /// The distance of a depth word along the line of sight, in world units.
    #[inline]
    #[must_use]
    pub fn along(&self, word: u32) -> f64 {
        self.planes.along(self.format.decode(word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::depth::{FARTHEST, Format, code};

    #[test]
    fn depths_come_back() {
        for planes in [Planes::default(), Planes { parallel: true, ..Planes::default() }] {
            for word in [0, 1, 255, 1 << 16, 1 << 31, u32::MAX / 3 * 2, FARTHEST - 1, FARTHEST] {
                let along = planes.along(Format::D32.decode(word));
                assert!((planes.near..=planes.far).contains(&along), "{along}");
                assert_eq!(code(planes.depth(along)), word, "{planes:?}");
            }
            assert_eq!([planes.depth(0.0), planes.depth(-1.0), planes.depth(1e9)], [0.0, 0.0, 1.0]);
        }
    }
}
