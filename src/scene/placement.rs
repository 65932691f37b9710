//! Where a scene file puts something: scale, then rotation, then translation.

use glam::{DMat4, DVec3, DVec4};

use super::model::Unplaced;

/// A place as written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Placement {
    pub(super) translate: Option<[f64; 3]>,
    pub(super) rotate: Option<[f64; 4]>,
    pub(super) scale: Option<f64>,
}

impl Placement {
    /// Whether it says anything.
    pub(super) fn is_given(&self) -> bool {
        self.translate.is_some() || self.rotate.is_some() || self.scale.is_some()
    }

    /// Scale, then rotation, then translation.
    pub(super) fn transform(&self) -> Unplaced<DMat4> {
        let scale = self.scale.unwrap_or(1.0);
        if !scale.is_finite() || scale == 0.0 {
            return Err(format!("scale: {scale} must be finite and not 0"));
        }
        let translate = self.translate.map_or(DVec3::ZERO, DVec3::from);
        if !translate.is_finite() {
            return Err("translate: must be finite".to_owned());
        }
        let rotation = match self.rotate {
            Some([x, y, z, degrees]) => rotation(DVec3::new(x, y, z), degrees)?,
            None => DMat4::IDENTITY,
        };
        Ok(DMat4::from_translation(translate) * rotation * DMat4::from_scale(DVec3::splat(scale)))
    }
}

/// A rotation about an axis, anticlockwise seen against it (Rodrigues' formula).
fn rotation(axis: DVec3, degrees: f64) -> Unplaced<DMat4> {
    let axis = axis.try_normalize().filter(|axis| axis.is_finite());
    let axis = axis.ok_or("rotate: the axis must be finite and not zero")?;
    if !degrees.is_finite() {
        return Err("rotate: the angle must be finite".to_owned());
    }
    let (s, c) = libm::sincos(degrees * (std::f64::consts::PI / 180.0));
    let turn = |v: DVec3| {
        let turned = v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c));
        turned.extend(0.0)
    };
    Ok(DMat4::from_cols(turn(DVec3::X), turn(DVec3::Y), turn(DVec3::Z), DVec4::W))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_follow_the_right_hand() {
        let quarter = rotation(DVec3::Z * 5.0, 90.0).unwrap();
        assert!((quarter.transform_point3(DVec3::X) - DVec3::Y).length() < 1e-15);
        assert!(rotation(DVec3::ZERO, 90.0).is_err());
        assert!(rotation(DVec3::X, f64::NAN).is_err());
    }
}
