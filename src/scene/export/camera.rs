//! The camera in glTF.

use glam::DVec4;
use serde_json::{Value, json};

use super::super::{Camera, Projection};

/// A camera, and the image that it makes.
pub(super) struct Seen {
    pub(super) camera: Camera,
    pub(super) size: [u32; 2],
}

impl Seen {
    /// The camera itself.
    pub(super) fn gltf(&self) -> Value {
        let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
        let Camera { projection, near, far, .. } = self.camera;
        match projection {
            Projection::Perspective { fov_y } => json!({
                "name": "camera",
                "type": "perspective",
                "perspective": {
                    "yfov": fov_y.to_radians(), "aspectRatio": aspect, "znear": near, "zfar": far,
                },
            }),
            Projection::Orthographic { height } => json!({
                "name": "camera",
                "type": "orthographic",
                "orthographic": {
                    "xmag": height * 0.5 * aspect, "ymag": height * 0.5, "znear": near, "zfar": far,
                },
            }),
        }
    }

    /// Where it stands.
    pub(super) fn node(&self) -> Value {
        let [right, up, back] = self.camera.axes();
        let columns =
            [right.extend(0.0), up.extend(0.0), back.extend(0.0), self.camera.eye.extend(1.0)];
        let matrix: Vec<f64> = columns.iter().flat_map(DVec4::to_array).collect();
        json!({ "name": "camera", "camera": 0, "matrix": matrix })
    }
}
