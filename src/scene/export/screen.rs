//! Triangles given in pixels, in a world whose unit is a pixel.

use serde_json::json;

use glam::DVec3;

use super::super::{Camera, Projection, Scene, ScreenTriangle, Shading};
use super::Document;
use crate::error::Result;

/// Half the guard band in pixels: corners are at most that far from the upper left corner.
const FARTHEST: f64 = 32_768.0;

/// A camera that shows pixels: the middle of the image is the middle of what it sees.
pub(super) fn camera(size: [u32; 2]) -> Camera {
    let [width, height] = size.map(f64::from);
    let eye = DVec3::new(width * 0.5, height * 0.5, 0.0);
    Camera {
        eye,
        target: eye - DVec3::Z,
        up: DVec3::Y,
        projection: Projection::Orthographic { height },
        near: 0.0,
        far: 1.0,
    }
}

impl Document {
    /// All triangles in pixels: a primitive for each run of one colour, in their order.
    pub(super) fn screen(&mut self, scene: &Scene, sub_pixel_bits: u32) -> Result<()> {
        let steps = f64::from(1u32 << sub_pixel_bits);
        let snapped = |v: f64| ((v * steps).round_ties_even() / steps).clamp(-FARTHEST, FARTHEST);
        let height = f64::from(scene.size[1]);
        let mut primitives = Vec::new();
        let mut materials: Vec<[u32; 4]> = Vec::new();
        for run in scene.screen.chunk_by(|a, b| a.color == b.color) {
            let Some(ScreenTriangle { color, .. }) = run.first() else { continue };
            let corners = run.iter().flat_map(|triangle| triangle.points);
            let places: Vec<[f64; 3]> =
                corners.map(|[x, y, z]| [snapped(x), height - snapped(y), -z]).collect();
            let key = color.map(f32::to_bits);
            let known = materials.iter().position(|known| *known == key);
            let material = match known {
                Some(known) => known,
                None => {
                    materials.push(key);
                    let [r, g, b, alpha] = *color;
                    self.plain_material("screen", [r, g, b], alpha, Shading::Flat)
                }
            };
            let position = self.positions(&places);
            primitives.push(json!({
                "attributes": { "POSITION": position },
                "material": material,
                "mode": 4,
            }));
        }
        self.meshes.push(json!({ "name": "screen", "primitives": primitives }));
        self.nodes.push(json!({ "name": "screen", "mesh": 0 }));
        Ok(())
    }
}
