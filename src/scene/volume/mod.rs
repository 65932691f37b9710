//! Volumes: grids of numbers in a box, and what the numbers do to light.
//!
//! A voxel stands for the middle of its cell, x grows fastest; in the world, x, y and z of the grid go along the axes
//! of the box. Between the middles a value is interpolated, trilinearly, and beyond the outermost middles it stays.
//! The range of values becomes 0 to 1, and the transfer function makes a colour and an opacity of that.

mod format;
mod grid;
mod procedural;
mod table;
mod transfer;

use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::Bounds;

pub use self::format::{npy, nrrd};
pub use self::grid::{Grid, Interpolation, MAX_VOXELS};
pub use self::procedural::{Generator, generators};
pub(super) use self::table::VolumeTable;
pub use self::transfer::{NAMED, Transfer};

/// The most steps along the diagonal of a volume.
pub const MAX_STEPS: f64 = 1_048_576.0;

/// A grid somewhere in the world, validated: every number is finite, and the box is not flat.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Shared, since scenes are copied.
    pub grid: Arc<Grid>,
    /// From the box 0..1 along each axis to the world.
    pub place: DMat4,
    /// What values look like.
    pub transfer: Transfer,
    /// Multiplies what the transfer function takes from light: 0 or more.
    pub density: f64,
    /// The world units over which the transfer function's opacities hold, above 0.
    pub step_unit: f64,
    /// World units between samples along a ray, above 0.
    pub step: f64,
    /// How values are found between voxels.
    pub interpolation: Interpolation,
}

impl Volume {
    /// The straight colour and opacity per step unit at a point of the box, 0 to 1 along each axis.
    #[inline]
    #[must_use]
    pub fn at(&self, point: DVec3) -> [f64; 4] {
        self.transfer.at(self.grid.at(point.to_array(), self.interpolation))
    }

    /// Around it.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        grown(Bounds::EMPTY, std::slice::from_ref(self))
    }

    /// The opacity of a length, in world units, of an opacity per step unit.
    #[inline]
    #[must_use]
    pub fn opacity(&self, opacity: f64, length: f64) -> f64 {
        1.0 - libm::pow(1.0 - opacity, self.density * length / self.step_unit)
    }
}

/// A box, grown to hold volumes.
pub(super) fn grown(bounds: Bounds, volumes: &[Volume]) -> Bounds {
    let unit = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
    let corners =
        volumes.iter().flat_map(|v| unit.corners().map(|corner| v.place.transform_point3(corner)));
    corners.fold(bounds, Bounds::with)
}
