//! A disc as a polygon: an octagon with its corners on the rim, in homogeneous coordinates, so that it is right in
//! perspective, too. All of it is f64 in the order written here.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DVec3, DVec4};

/// A disc in clip space.
#[derive(Clone, Copy, Debug)]
pub struct Lying {
    /// Its centre.
    pub center: DVec4,
    /// From there to the rim.
    pub axes: [DVec4; 2],
    /// In world space, towards the viewer's side once `turned` is applied; need not be unit length.
    pub normal: DVec3,
}

impl Lying {
    /// Eight points of its rim, in order, from the end of the first axis to that of the second and on.
    #[must_use]
    pub fn octagon(&self) -> [DVec4; 8] {
        let [a, b] = self.axes;
        let (c, d) = ((a + b) * FRAC_1_SQRT_2, (b - a) * FRAC_1_SQRT_2);
        [a, c, b, d, -a, -c, -b, -d].map(|from_center| self.center + from_center)
    }
}
