//! From a pixel and a stored depth back to the world.
//!
//! All of it is f64 in the order written here. With u = 2 (x + 1/2) / width - 1, v = 1 - 2 (y + 1/2) / height and a
//! depth z of 0..1, the distance along the line of sight is near + z (far - near) for parallel rays, and near far /
//! (far - z (far - near)) for a perspective, whose rays are longer than that by sqrt((1 + h²) + w²), where w and h are
//! u and v times half the image's extent at distance 1.

use glam::DVec3;

use crate::num::depth::Format;
use crate::num::planes::Planes;
use crate::scene::{Camera, Projection};

/// A camera with an image and a depth format.
#[derive(Clone, Debug)]
pub struct Lens {
    camera: Camera,
    axes: [DVec3; 3],
    half: [f64; 2],
    size: [f64; 2],
    planes: Planes,
    format: Format,
}

/// What a pixel's centre looks along.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    origin: DVec3,
    /// As long as one step along the line of sight.
    direction: DVec3,
    length: f64,
}

impl Sight {
    /// Where it begins, and one step along the line of sight.
    #[must_use]
    pub fn ray(self) -> [DVec3; 2] {
        [self.origin, self.direction]
    }

    /// How much longer the ray is than the distance along the line of sight.
    #[must_use]
    pub fn length(self) -> f64 {
        self.length
    }

    /// The unit vector from what is seen to the eye.
    #[must_use]
    pub fn towards_eye(self) -> [f64; 3] {
        (-self.direction * (1.0 / self.length)).to_array()
    }
}

impl Lens {
    /// For an image of `size` pixels whose depths are stored in `format`.
    #[must_use]
    pub fn new(camera: &Camera, size: [u32; 2], format: Format) -> Self {
        Self {
            camera: *camera,
            axes: camera.axes(),
            half: camera.half_extent(size),
            size: size.map(f64::from),
            planes: camera.planes(),
            format,
        }
    }

    /// The ray through the centre of pixel (x, y).
    #[inline]
    #[must_use]
    pub fn sight(&self, x: u32, y: u32) -> Sight {
        let [right, up, back] = self.axes;
        let [w, h] = self.aside(x, y);
        let sideways = right * w + up * h;
        match self.camera.projection {
            Projection::Perspective { .. } => {
                let length = ((1.0 + h * h) + w * w).sqrt();
                Sight { origin: self.camera.eye, direction: sideways - back, length }
            }
            Projection::Orthographic { .. } => {
                Sight { origin: self.camera.eye + sideways, direction: -back, length: 1.0 }
            }
        }
    }

    /// How far right and up a pixel's centre is: at distance 1 for a perspective, and everywhere with parallel rays.
    #[inline]
    fn aside(&self, x: u32, y: u32) -> [f64; 2] {
        let u = (f64::from(x) + 0.5) * 2.0 / self.size[0] - 1.0;
        let v = 1.0 - (f64::from(y) + 0.5) * 2.0 / self.size[1];
        [u * self.half[0], v * self.half[1]]
    }

    /// What a pixel's centre sees at a distance along the line of sight, by the eye's own axes: right, up, and along.
    #[inline]
    #[must_use]
    pub fn from_eye(&self, x: u32, y: u32, along: f64) -> DVec3 {
        let [w, h] = self.aside(x, y);
        let scale = if self.is_parallel() { 1.0 } else { along };
        DVec3::new(w * scale, h * scale, along)
    }

    /// Pixels that a world unit takes to the right and up: at distance 1 for a perspective, and everywhere with parallel
    /// rays.
    #[must_use]
    pub fn pixels(&self) -> [f64; 2] {
        std::array::from_fn(|i| self.size[i] / (2.0 * self.half[i]))
    }

    /// All rays go the same way.
    #[inline]
    #[must_use]
    pub fn is_parallel(&self) -> bool {
        self.planes.parallel
    }

    /// The near and the far plane.
    #[must_use]
    pub fn planes(&self) -> Planes {
        self.planes
    }

    /// The distance from the eye's plane along the line of sight, in world units. Grows with the word.
    #[inline]
    #[must_use]
    pub fn along(&self, depth: u32) -> f64 {
        self.planes.along(self.format.decode(depth))
    }

    /// The distance along the ray itself, in world units.
    #[inline]
    #[must_use]
    pub fn distance(&self, sight: Sight, depth: u32) -> f64 {
        self.along(depth) * sight.length
    }

    /// The point in the world that pixel (x, y) sees at a stored depth.
    #[inline]
    #[must_use]
    pub fn point(&self, x: u32, y: u32, depth: u32) -> DVec3 {
        let sight = self.sight(x, y);
        sight.origin + sight.direction * self.along(depth)
    }

    /// The pixel of a parallel view in which a point of the world lies, if any does, and the point's distance from the
    /// eye's plane.
    #[inline]
    #[must_use]
    pub fn pixel(&self, point: DVec3) -> Option<([u32; 2], f64)> {
        let [right, up, back] = self.axes;
        let offset = point - self.camera.eye;
        let x = (right.dot(offset) / self.half[0] * 0.5 + 0.5) * self.size[0];
        let y = (0.5 - up.dot(offset) / self.half[1] * 0.5) * self.size[1];
        let inside = x >= 0.0 && y >= 0.0 && x < self.size[0] && y < self.size[1];
        inside.then(|| ([x as u32, y as u32], -back.dot(offset)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::depth;

    const SIZE: [u32; 2] = [64, 48];

    fn camera(projection: Projection) -> Camera {
        let (eye, target) = (DVec3::new(3.0, 2.0, 5.0), DVec3::new(0.5, 0.25, 0.0));
        Camera { eye, target, up: DVec3::Y, projection, near: 2.0, far: 11.0 }
    }

    /// There and back: a point's pixel and depth, by the matrix that draws, lead to the point.
    #[test]
    fn points_come_back() {
        for projection in
            [Projection::Perspective { fov_y: 50.0 }, Projection::Orthographic { height: 4.0 }]
        {
            let camera = camera(projection);
            let lens = Lens::new(&camera, SIZE, Format::D32);
            for (x, y, z) in [(0, 0, 0.0), (63, 47, 1.0), (10, 40, 0.25), (31, 7, 0.875)] {
                let word = Format::D32.encode(depth::code(z));
                let point = lens.point(x, y, word);
                let clip = camera.view_projection(SIZE) * point.extend(1.0);
                let [px, py] = [clip.x / clip.w, clip.y / clip.w];
                assert!(((px * 0.5 + 0.5) * 64.0 - (f64::from(x) + 0.5)).abs() < 1e-9);
                assert!(((0.5 - py * 0.5) * 48.0 - (f64::from(y) + 0.5)).abs() < 1e-9);
                assert!((clip.z / clip.w - z).abs() < 1e-8, "{z}: {clip}");
                let distance = lens.distance(lens.sight(x, y), word);
                if matches!(projection, Projection::Perspective { .. }) {
                    assert!(((point - camera.eye).length() - distance).abs() < 1e-9);
                } else {
                    let (pixel, along) = lens.pixel(point).unwrap();
                    assert_eq!(pixel, [x, y]);
                    assert!((along - distance).abs() < 1e-9);
                }
            }
        }
    }
}
