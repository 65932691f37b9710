//! Cameras: the matrix from world to clip space, a default view that frames what is drawn, and the default light.
//!
//! Conventions: column vectors, right-handed world, clip space with y up and z from 0 (near) to w (far). All of
//! it is + - * / and square roots in f64, with `libm` for the tangent, so that every machine gets the same
//! matrix to the last bit.

use std::f64::consts::PI;

use glam::{DMat4, DVec3, DVec4};

use super::{Bounds, Camera, Light, Projection};
use crate::error::{Error, Result};
use crate::num::planes::Planes;

/// The vertical field of view of default cameras, degrees.
pub const FOV_Y: f64 = 40.0;

/// From the scene's middle towards the default eye: a three-quarter view from slightly above.
pub(super) const VIEW_FROM: DVec3 = DVec3::new(0.55, 0.4, 1.0);

/// How much room default views leave: distances are larger than necessary by this factor.
const MARGIN: f64 = 1.05;

/// The share of ambient light where a scene gives none.
pub const AMBIENT: f32 = 0.2;

/// How a camera that shows all of a scene projects.
#[derive(Clone, Copy, Debug)]
pub(super) enum Framing {
    /// With this vertical field of view, in degrees.
    Perspective(f64),
    /// With parallel rays.
    Parallel,
}

impl Camera {
    /// From world space to the camera's: x right, y up, looking along -z.
    #[must_use]
    pub fn view(&self) -> DMat4 {
        let [right, up, back] = self.axes();
        let row = |axis: DVec3| DVec4::new(axis.x, axis.y, axis.z, -axis.dot(self.eye));
        DMat4::from_cols(row(right), row(up), row(back), DVec4::W).transpose()
    }

    /// How depths stand for distances.
    #[must_use]
    pub fn planes(&self) -> Planes {
        let parallel = matches!(self.projection, Projection::Orthographic { .. });
        Planes { near: self.near, far: self.far, parallel }
    }

    /// From the camera's space to clip space, for an image of `size` pixels.
    #[must_use]
    pub fn projection_matrix(&self, size: [u32; 2]) -> DMat4 {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let depth = self.far - self.near;
        let (scale, z, w) = match self.projection {
            Projection::Perspective { fov_y } => (
                1.0 / half_tangent(fov_y),
                DVec4::new(0.0, 0.0, -self.far / depth, -1.0),
                DVec4::new(0.0, 0.0, -(self.near * self.far) / depth, 0.0),
            ),
            Projection::Orthographic { height } => (
                2.0 / height,
                DVec4::new(0.0, 0.0, -1.0 / depth, 0.0),
                DVec4::new(0.0, 0.0, -self.near / depth, 1.0),
            ),
        };
        DMat4::from_cols(DVec4::X * (scale / aspect), DVec4::Y * scale, z, w)
    }

    /// From world space to clip space, for an image of `size` pixels: [`Camera::projection_matrix`] after
    /// [`Camera::view`].
    #[must_use]
    pub fn view_projection(&self, size: [u32; 2]) -> DMat4 {
        self.projection_matrix(size) * self.view()
    }

    /// A view from the front, right and slightly above that shows all of `bounds` in an image of `size` pixels,
    /// with near and far planes close around it. A single point is treated as a box of unit size.
    #[must_use]
    pub fn frame(bounds: Bounds, size: [u32; 2]) -> Self {
        Self::framed(bounds, size, VIEW_FROM, DVec3::Y, Framing::Perspective(FOV_Y))
    }

    /// The same from another direction: `from` points from the middle towards the eye.
    pub(super) fn framed(
        bounds: Bounds,
        size: [u32; 2],
        from: DVec3,
        up: DVec3,
        framing: Framing,
    ) -> Self {
        let bounds = bounds.thickened();
        let target = bounds.center();
        let mut camera = Self {
            eye: target + from * bounds.diagonal(),
            target,
            up,
            projection: Projection::Orthographic { height: 1.0 },
            near: 1.0,
            far: 2.0,
        };
        match framing {
            Framing::Perspective(fov_y) => {
                camera.projection = Projection::Perspective { fov_y };
                let back = camera.axes()[2];
                let distance = camera.distance_to_fit(bounds, size, fov_y) * MARGIN;
                camera.eye = target + back * distance;
            }
            Framing::Parallel => {
                let [right, up, _] = camera.axes();
                let aspect = f64::from(size[0]) / f64::from(size[1]);
                let reach = |corner: DVec3| {
                    let offset = corner - target;
                    (right.dot(offset).abs() / aspect).max(up.dot(offset).abs())
                };
                let reach = bounds.corners().into_iter().map(reach).fold(0.0, f64::max);
                camera.projection = Projection::Orthographic { height: 2.0 * reach * MARGIN };
            }
        }
        (camera.near, camera.far) = camera.planes_around(bounds);
        camera
    }

    /// A parallel view from a directional light, whose unit vector `towards` points to it, that shows all of `bounds`
    /// in a square image, with near and far planes close around it. A single point is treated as a box of unit size.
    #[must_use]
    pub fn of_light(bounds: Bounds, towards: DVec3) -> Self {
        let bounds = bounds.thickened();
        let (target, a) = (bounds.center(), towards.abs());
        // Any axis that is not along the light works; the one least along it is the safest.
        let up = match (a.x <= a.y && a.x <= a.z, a.y <= a.z) {
            (true, _) => DVec3::X,
            (_, true) => DVec3::Y,
            _ => DVec3::Z,
        };
        let mut camera = Self {
            eye: target + towards * bounds.diagonal(),
            target,
            up,
            projection: Projection::Orthographic { height: 1.0 },
            near: 0.0,
            far: 1.0,
        };
        let [right, up, _] = camera.axes();
        let reach = |corner: DVec3| {
            let offset = corner - target;
            right.dot(offset).abs().max(up.dot(offset).abs())
        };
        let reach = bounds.corners().into_iter().map(reach).fold(0.0, f64::max);
        camera.projection = Projection::Orthographic { height: 2.0 * reach * MARGIN };
        (camera.near, camera.far) = camera.planes_around(bounds);
        camera
    }

    /// Half the width and half the height of what an image of `size` pixels shows: at distance 1 from a perspective's
    /// eye, and everywhere with parallel rays. World units.
    #[must_use]
    pub fn half_extent(&self, size: [u32; 2]) -> [f64; 2] {
        let half = match self.projection {
            Projection::Perspective { fov_y } => half_tangent(fov_y),
            Projection::Orthographic { height } => height * 0.5,
        };
        [half * (f64::from(size[0]) / f64::from(size[1])), half]
    }

    /// The near and far planes that enclose `bounds`, with margin. A perspective's near plane stays in front of
    /// the eye, at 1/10,000 of the far plane's distance or farther.
    #[must_use]
    pub fn planes_around(&self, bounds: Bounds) -> (f64, f64) {
        let bounds = bounds.thickened();
        let back = self.axes()[2];
        let depths = bounds.corners().map(|corner| back.dot(self.eye - corner));
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min);
        let farthest = depths.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let margin = (MARGIN - 1.0) * bounds.diagonal();
        let (near, far) = (nearest - margin, farthest + margin);
        match self.projection {
            Projection::Orthographic { .. } => (near, far),
            Projection::Perspective { .. } => {
                let far = if far > 0.0 { far } else { bounds.diagonal() };
                (near.max(far * 1e-4), far)
            }
        }
    }

    /// Light from the viewer's upper left, as a direction in the world, with the default ambient share.
    #[must_use]
    pub fn default_light(&self) -> Light {
        let [right, up, back] = self.axes();
        Light { towards: (back + up * 0.8 - right * 0.6).normalize(), ambient: AMBIENT }
    }

    /// Whether every field is usable, as messages: `place` is the file or scene.
    pub fn check(&self, place: &str) -> Result<()> {
        let wrong = |problem: &str| Err(Error::new(place, format!("camera.{problem}")));
        if !(self.eye.is_finite() && self.target.is_finite() && self.up.is_finite()) {
            return wrong("eye, camera.target and camera.up must be finite");
        }
        if !(self.target - self.eye).try_normalize().is_some_and(DVec3::is_finite) {
            return wrong("target: must be apart from camera.eye");
        }
        if !self.axes().into_iter().all(|axis| (axis.length() - 1.0).abs() < 1e-6) {
            return wrong("up: must not be zero or parallel to the line of sight");
        }
        match self.projection {
            Projection::Perspective { fov_y } if !(0.001..=179.0).contains(&fov_y) => {
                return wrong("fov_y: must be 0.001 to 179 degrees");
            }
            Projection::Perspective { .. } if self.near.is_nan() || self.near <= 0.0 => {
                return wrong("near: must be above 0 for a perspective");
            }
            Projection::Orthographic { height } if !(height.is_finite() && height > 0.0) => {
                return wrong("ortho_height: must be above 0");
            }
            _ => {}
        }
        if !(self.near.is_finite() && self.far.is_finite() && self.near < self.far) {
            return wrong("near: must be below camera.far, both finite");
        }
        if !self.view_projection([1, 1]).is_finite() {
            return wrong("eye: the view is too far or too narrow for 64-bit numbers");
        }
        Ok(())
    }

    /// Right, up and back: unit vectors in world space, or zero if `up` is parallel to the line of sight.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 3] {
        let back = (self.eye - self.target).normalize_or_zero();
        let right = self.up.normalize_or_zero().cross(back);
        // The sine of the angle between them: below this, rounding decides where right is.
        let right = if right.length() > 1e-9 { right.normalize() } else { DVec3::ZERO };
        [right, back.cross(right), back]
    }

    /// The smallest distance from the middle of `bounds` at which its box is inside the field of view.
    fn distance_to_fit(&self, bounds: Bounds, size: [u32; 2], fov_y: f64) -> f64 {
        let [right, up, back] = self.axes();
        let tan_y = half_tangent(fov_y);
        let tan_x = tan_y * f64::from(size[0]) / f64::from(size[1]);
        let need = |corner: DVec3| {
            let offset = corner - bounds.center();
            let sideways = (right.dot(offset).abs() / tan_x).max(up.dot(offset).abs() / tan_y);
            back.dot(offset) + sideways
        };
        bounds.corners().into_iter().map(need).fold(0.0, f64::max)
    }
}

/// The tangent of half an angle in degrees.
fn half_tangent(degrees: f64) -> f64 {
    libm::tan(degrees * (PI / 360.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [200, 100];

    fn camera(projection: Projection) -> Camera {
        let (eye, target, up) = (DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y);
        Camera { eye, target, up, projection, near: 1.0, far: 9.0 }
    }

    fn clip(camera: &Camera, point: [f64; 3]) -> DVec3 {
        let clip = camera.view_projection(SIZE) * DVec3::from(point).extend(1.0);
        clip.truncate() / clip.w
    }

    #[test]
    fn perspective_puts_planes_at_0_and_1_and_y_up() {
        let camera = camera(Projection::Perspective { fov_y: 90.0 });
        assert!(clip(&camera, [0.0, 0.0, 4.0]).z.abs() < 1e-12, "near");
        assert!((clip(&camera, [0.0, 0.0, -4.0]).z - 1.0).abs() < 1e-12, "far");
        let top_right = clip(&camera, [10.0, 5.0, 0.0]);
        assert!((top_right.x - 1.0).abs() < 1e-12 && (top_right.y - 1.0).abs() < 1e-12);
    }

    #[test]
    fn orthographic_shows_its_height() {
        let camera = camera(Projection::Orthographic { height: 2.0 });
        let corner = clip(&camera, [2.0, -1.0, 0.0]);
        assert!((corner - DVec3::new(1.0, -1.0, 0.5)).length() < 1e-12, "{corner}");
    }

    #[test]
    fn frames_fit_whatever_the_shape_of_box_and_image() {
        let boxes =
            [[1.0, 1.0, 1.0], [9.0, 0.0, 0.0], [0.0, 7.0, 0.1], [0.0, 0.0, 0.0], [1e-9, 1e9, 1.0]];
        for (extent, size) in
            boxes.iter().flat_map(|b| [[64, 64], [640, 48], [3, 900]].map(|s| (b, s)))
        {
            let extent = DVec3::from(*extent);
            let bounds = Bounds { min: DVec3::splat(3.0), max: DVec3::splat(3.0) + extent };
            let camera = Camera::frame(bounds, size);
            camera.check("frame").unwrap();
            for corner in bounds.corners() {
                let clip = camera.view_projection(size) * corner.extend(1.0);
                assert!(
                    clip.x.abs() <= clip.w && clip.y.abs() <= clip.w,
                    "{extent} {size:?}: {clip}"
                );
                assert!(clip.z >= 0.0 && clip.z <= clip.w, "{extent} {size:?}: {clip}");
            }
        }
    }

    #[test]
    fn a_light_sees_everything() {
        let sides = [DVec3::Y, DVec3::X, DVec3::NEG_Z, DVec3::new(0.48, 0.6, -0.64)];
        for (extent, towards) in [[1.0, 1.0, 1.0], [9.0, 0.0, 2.0]]
            .iter()
            .flat_map(|e| sides.map(|towards| (e, towards)))
        {
            let (min, extent) = (DVec3::splat(-2.0), DVec3::from(*extent));
            let bounds = Bounds { min, max: min + extent };
            let camera = Camera::of_light(bounds, towards);
            camera.check("light").unwrap();
            assert!((camera.axes()[2] - towards).length() < 1e-12);
            for corner in bounds.corners() {
                let clip = camera.view_projection([7, 7]) * corner.extend(1.0);
                assert!(clip.x.abs() <= 1.0 && clip.y.abs() <= 1.0, "{extent} {towards}: {clip}");
                assert!(clip.z > 0.0 && clip.z < 1.0, "{extent} {towards}: {clip}");
            }
        }
    }

    #[test]
    fn the_default_light_comes_from_the_upper_left() {
        let camera = camera(Projection::Perspective { fov_y: 40.0 });
        let towards = camera.default_light().towards;
        assert!(towards.x < 0.0 && towards.y > 0.0 && towards.z > 0.0);
        assert!((towards.length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn each_bad_field_is_named() {
        let good = camera(Projection::Perspective { fov_y: 40.0 });
        let ortho = |height| camera(Projection::Orthographic { height });
        let cases = [
            (Camera { eye: DVec3::NAN, ..good }, "camera.eye"),
            (Camera { target: good.eye, ..good }, "camera.target"),
            (Camera { up: DVec3::Z, ..good }, "camera.up"),
            (Camera { up: DVec3::ZERO, ..good }, "camera.up"),
            (Camera { near: 0.0, ..good }, "camera.near"),
            (Camera { near: 9.0, ..good }, "camera.near"),
            (Camera { far: f64::NAN, ..good }, "camera.near"),
            (camera(Projection::Perspective { fov_y: 180.0 }), "camera.fov_y"),
            (camera(Projection::Perspective { fov_y: f64::NAN }), "camera.fov_y"),
            (ortho(0.0), "camera.ortho_height"),
        ];
        for (camera, field) in cases {
            let error = camera.check("here").unwrap_err().to_string();
            assert!(error.starts_with(&format!("here: {field}")), "{error}");
        }
        good.check("here").unwrap();
    }
}
