//! A grid of numbers, and the value at a place.

use crate::scene::model::Unplaced;

/// The most voxels of a grid.
pub const MAX_VOXELS: u64 = 1 << 28;

/// Values on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Voxels along x, y and z: each at least 1, at most [`MAX_VOXELS`] in all.
    size: [usize; 3],
    /// x fastest; finite.
    values: Vec<f32>,
    /// The values that become 0 and 1; the second is above the first.
    range: [f64; 2],
    /// How far voxels are apart, in world units, where the file says so.
    spacing: Option<[f64; 3]>,
}

/// How values are found between the middles of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// From the eight nearest.
    #[default]
    Linear,
    /// The value of the cell.
    Nearest,
}

impl Grid {
    /// A grid of `size` voxels. Its range is from the smallest to the largest value; values that are all the same
    /// count as 1.
    ///
    /// # Errors
    /// A number of values that does not fit, with both numbers; a value that is not finite.
    pub fn new(size: [usize; 3], values: Vec<f32>) -> Unplaced<Self> {
        let [x, y, z] = size;
        let count = voxels(size.map(|n| n as u64))?;
        if values.len() != count {
            return Err(format!("{} values for {x} x {y} x {z} voxels", values.len()));
        }
        if let Some(i) = values.iter().position(|value| !value.is_finite()) {
            let place = [i % x, i / x % y, i / (x * y)];
            return Err(format!("voxel {place:?}: {} is not finite", values[i]));
        }
        let ends = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
            [low.min(value.into()), high.max(value.into())]
        });
        let range =
            if ends[0] < ends[1] { ends } else { [ends[0] - ends[0].abs().max(1.0), ends[1]] };
        Ok(Self { size, values, range, spacing: None })
    }

    /// With another range of values.
    ///
    /// # Errors
    /// Ends that are not finite, or in the wrong order.
    pub fn ranged(mut self, range: [f64; 2]) -> Unplaced<Self> {
        let [low, high] = range;
        if !(low < high && (high - low).is_finite()) {
            return Err(format!("range: {low} must be below {high}, both finite"));
        }
        self.range = range;
        Ok(self)
    }

    /// With a distance between voxels.
    ///
    /// # Errors
    /// A distance that is not above 0 and finite.
    pub fn spaced(mut self, spacing: [f64; 3]) -> Unplaced<Self> {
        if !spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
            return Err(format!("spacings: {spacing:?} must be above 0, and finite"));
        }
        self.spacing = Some(spacing);
        Ok(self)
    }

    /// Voxels along x, y and z.
    #[must_use]
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// All values, x fastest.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The values that become 0 and 1.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// The size of the box where nothing else is said: by the file's spacing, or with a longest edge of 1.
    #[must_use]
    pub fn extent(&self) -> [f64; 3] {
        let size = self.size.map(|n| n as f64);
        let longest = size.into_iter().fold(1.0, f64::max);
        let spacing = self.spacing.unwrap_or([1.0 / longest; 3]);
        std::array::from_fn(|i| size[i] * spacing[i])
    }

    /// The value at a point of the box, 0 to 1 along each axis, from 0 to 1.
    #[inline]
    #[must_use]
    pub fn at(&self, point: [f64; 3], interpolation: Interpolation) -> f64 {
        let value = match interpolation {
            Interpolation::Nearest => {
                let cell =
                    |i: usize| ((point[i] * self.size[i] as f64) as usize).min(self.size[i] - 1);
                self.value([cell(0), cell(1), cell(2)])
            }
            Interpolation::Linear => self.linear(point),
        };
        let [low, high] = self.range;
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    fn linear(&self, point: [f64; 3]) -> f64 {
        let axis = |i: usize| {
            let last = self.size[i] - 1;
            let at = (point[i] * self.size[i] as f64 - 0.5).clamp(0.0, last as f64);
            let cell = (at as usize).min(last);
            (cell, (cell + 1).min(last), at - cell as f64)
        };
        let [(x0, x1, fx), (y0, y1, fy), (z0, z1, fz)] = [axis(0), axis(1), axis(2)];
        let between = |a: f64, b: f64, share: f64| a + (b - a) * share;
        let row = |y, z| between(self.value([x0, y, z]), self.value([x1, y, z]), fx);
        let plane = |z| between(row(y0, z), row(y1, z), fy);
        between(plane(z0), plane(z1), fz)
    }

    #[inline]
    fn value(&self, [x, y, z]: [usize; 3]) -> f64 {
        self.values[(z * self.size[1] + y) * self.size[0] + x].into()
    }
}

/// The number of voxels of a size, if it is one that is read.
pub(super) fn voxels(size: [u64; 3]) -> Unplaced<usize> {
    let [x, y, z] = size;
    let product = x.checked_mul(y).and_then(|n| n.checked_mul(z));
    let product = product.filter(|n| (1..=MAX_VOXELS).contains(n));
    let wrong = || format!("size: {x} x {y} x {z} is not 1 to {MAX_VOXELS} voxels");
    product.and_then(|n| usize::try_from(n).ok()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid::new([2, 1, 3], vec![0.0, 1.0, 2.0, 3.0, 4.0, 8.0]).unwrap()
    }

    #[test]
    fn voxels_stand_in_the_middle_of_their_cells() {
        let grid = grid();
        for (i, value) in grid.values().iter().enumerate() {
            let middle = [(i % 2) as f64 * 0.5 + 0.25, 0.5, ((i / 2) as f64 + 0.5) / 3.0];
            for interpolation in [Interpolation::Linear, Interpolation::Nearest] {
                let found = grid.at(middle, interpolation) * 8.0;
                assert!((found - f64::from(*value)).abs() < 1e-15, "{i} {found}");
            }
        }
        assert_eq!(grid.at([0.0; 3], Interpolation::Linear), 0.0, "it stays beyond the outermost");
        assert_eq!(grid.at([1.0; 3], Interpolation::Linear), 1.0);
        assert_eq!(grid.at([1.0; 3], Interpolation::Nearest), 1.0);
        assert_eq!(grid.at([0.5, 0.5, 1.0], Interpolation::Linear), 0.75);
    }

    /// Trilinear interpolation keeps a linear field, to rounding.
    #[test]
    fn a_linear_field_stays_linear() {
        let field = |x: f64, y: f64, z: f64| 3.0 + x * 2.0 - y + z * 0.5;
        let [w, h, d] = [5, 4, 7];
        let at = |i: usize| field((i % w) as f64, (i / w % h) as f64, (i / (w * h)) as f64) as f32;
        let grid = Grid::new([w, h, d], (0..w * h * d).map(at).collect()).unwrap();
        let grid = grid.ranged([-10.0, 22.0]).unwrap();
        for point in [[0.2, 0.3, 0.4], [0.5; 3], [0.85, 0.7, 0.1]] {
            let [x, y, z] = point;
            let expected = field(x * 5.0 - 0.5, y * 4.0 - 0.5, z * 7.0 - 0.5);
            let found = grid.at(point, Interpolation::Linear) * 32.0 - 10.0;
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }

    #[test]
    fn what_does_not_fit_is_told() {
        assert!(Grid::new([2, 2, 2], vec![0.0; 7]).unwrap_err().starts_with("7 values for 2 x 2"));
        let nan = Grid::new([1, 2, 2], vec![0.0, 1.0, f32::NAN, 1.0]).unwrap_err();
        assert!(nan.starts_with("voxel [0, 0, 1]: NaN"), "{nan}");
        assert!(Grid::new([0, 2, 2], vec![]).is_err());
        assert!(voxels([u64::MAX, u64::MAX, 2]).is_err());
        assert!(voxels([1 << 10, 1 << 10, 1 << 9]).is_err());
        assert!(grid().ranged([1.0, 1.0]).is_err());
        assert!(grid().ranged([f64::MIN, f64::MAX]).is_err());
        assert!(grid().spaced([1.0, 0.0, 1.0]).is_err());
    }

    #[test]
    fn extents_and_ranges() {
        assert_eq!(grid().extent(), [2.0 / 3.0, 1.0 / 3.0, 1.0]);
        assert_eq!(grid().spaced([0.5, 2.0, 1.0]).unwrap().extent(), [1.0, 2.0, 3.0]);
        let same = Grid::new([1; 3], vec![7.0]).unwrap();
        assert_eq!(same.at([0.5; 3], Interpolation::Linear), 1.0);
        for value in [0.0, -0.5, 1e-40, -7e20, f32::MAX, f32::MIN] {
            let same = Grid::new([1; 3], vec![value]).unwrap();
            assert_eq!(same.at([0.5; 3], Interpolation::Nearest), 1.0, "{value}");
        }
    }
}
