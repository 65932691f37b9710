//! The share of light that is absorbed on the way from the eye: 1 minus the transmittance.

use crate::scheme::Record;

/// Something on the ray that absorbs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    /// Where it begins, in world units from the eye.
    near: f64,
    /// Where it ends.
    far: f64,
    /// The share of light that it absorbs.
    opacity: f64,
}

/// `x` within 0..1; 0 for NaN.
pub(super) fn share(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

impl Slab {
    /// A surface of an RGBA8 colour.
    pub(super) fn surface(distance: f64, color: u32) -> Self {
        let [.., alpha] = color.to_le_bytes();
        Self { near: distance, far: distance, opacity: f64::from(alpha) / 255.0 }
    }

    /// A merged record whose far end is at this distance.
    pub(super) fn record(distance: f64, record: &Record) -> Self {
        let near = distance - record.thickness;
        let near = if near.is_finite() && near < distance { near } else { distance };
        Self { near, far: distance, opacity: share(record.rgba[3]) }
    }
}

/// The corners of the absorbance along slabs that end ever farther from the eye, and what they absorb together. Where
/// slabs overlap, a slab begins where the one before ends, so that the function has one value at every distance.
pub(super) fn along(slabs: impl Iterator<Item = Slab>) -> (Vec<[f64; 2]>, f64) {
    let (mut corners, mut transmittance) = (Vec::new(), 1.0);
    let mut reached = f64::MIN;
    for slab in slabs {
        corners.push([slab.near.max(reached), 1.0 - transmittance]);
        reached = slab.far.max(reached);
        transmittance *= 1.0 - slab.opacity;
        corners.push([reached, 1.0 - transmittance]);
    }
    (corners, 1.0 - transmittance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_make_steps_and_records_make_slopes() {
        let half = Slab::surface(1.0, 0xFF00_0000);
        let record = Record { thickness: 0.5, rgba: [0.0, 0.0, 0.0, 0.5], ..Record::default() };
        let slab = Slab::record(3.0, &record);
        let (corners, absorbed) = along([slab].into_iter());
        assert_eq!((corners, absorbed), (vec![[2.5, 0.0], [3.0, 0.5]], 0.5));
        let (corners, _) = along([half].into_iter());
        assert_eq!(corners, [[1.0, 0.0], [1.0, 1.0]]);
        let near = Slab { near: 2.75, far: 3.5, opacity: 0.5 };
        let (corners, absorbed) = along([slab, near].into_iter());
        assert_eq!(corners, [[2.5, 0.0], [3.0, 0.5], [3.0, 0.5], [3.5, 0.75]]);
        assert_eq!(absorbed, 0.75);
    }

    #[test]
    fn what_is_no_number_absorbs_nothing_and_has_no_thickness() {
        let wrong = Record { thickness: f64::NAN, rgba: [f64::NAN; 4], ..Record::default() };
        let slab = Slab::record(3.0, &wrong);
        assert_eq!(along([slab].into_iter()), (vec![[3.0, 0.0], [3.0, 0.0]], 0.0));
    }
}
