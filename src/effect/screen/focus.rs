//! Depth of field from rays over layers (Lee, Eisemann, Seidel, "Depth-of-field rendering with multiview synthesis",
//! 2009).
//!
//! The lens is a disc of the aperture's diameter in the plane of the eye. Every pixel has the same samples of it: a
//! Hammersley set, made round by Shirley and Chiu's map. From each, a ray goes through the pixel's point in focus, which
//! is where its centre looks at the focus distance. In the image, such a ray runs along a line through the pixel's
//! centre: for a lens sample L, it is L (1/z - 1/f) off at distance z of a perspective, for the focus distance f, and L
//! (1 - z/f) off with parallel rays, which have a lens at every pixel. It visits every pixel on that line, each
//! between the distances where it enters and leaves it, and passes the layers that the pixel has there, front to back: a
//! layer is a square that faces the eye. Beyond the image's edge, the pixels at the edge go on.
//!
//! A record thicker than 10 P(z) is a slab: a ray passes the part of it that it goes through.
//!
//! Each ray is composited in 16 bits, as pixels are, and a pixel is the mean of its rays in whole numbers. So with an
//! aperture of 0 it is the picture of the layers to the bit, as it is where all layers lie in focus, or are the same
//! everywhere. What the model cannot see is what no list holds: surfaces seen edge-on. A surface steeper than the rays
//! that meet it lets some of them through, or stops them twice.

use rayon::prelude::*;

use crate::effect::layers::{Layers, ends};
use crate::error::{Error, Result};
use crate::image::Image;
use crate::num::color::word16;
use crate::resolve::Lists;
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::Record;
use crate::scheme::merging::Blending;
use crate::scheme::merging::slab::{Slab, Visibility};

/// The most lens samples.
pub const MAX_SAMPLES: u32 = 4_096;

/// A lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// The diameter of the lens in world units, 0 or more; `None` is a fortieth of the distance.
    pub aperture: Option<f64>,
    /// Where it is sharp: world units from the eye's plane along the line of sight, above 0; `None` is the camera's
    /// target.
    pub distance: Option<f64>,
    /// Rays for each pixel, 1 to [`MAX_SAMPLES`].
    pub samples: u32,
}

impl Default for Focus {
    fn default() -> Self {
        Self { aperture: None, distance: None, samples: 64 }
    }
}

impl Focus {
    pub(super) fn check(&self) -> Result<()> {
        if let Some(aperture) = self.aperture.filter(|a| !(a.is_finite() && *a >= 0.0)) {
            let problem = format!("is {aperture}, but must be 0 or more world units, and finite");
            return Err(Error::new("--aperture", problem));
        }
        if let Some(distance) = self.distance.filter(|d| !(d.is_finite() && *d > 0.0)) {
            let problem = format!("is {distance}, but must be above 0 world units, and finite");
            return Err(Error::new("--focus", problem));
        }
        if !(1..=MAX_SAMPLES).contains(&self.samples) {
            let problem = format!("is {}, but must be 1 to {MAX_SAMPLES}", self.samples);
            return Err(Error::new("--dof-samples", problem));
        }
        Ok(())
    }

    /// The picture of these lists.
    pub(super) fn draw(&self, layers: &Layers<'_>, lists: &Lists<Record>, beta: f64) -> Image {
        let scene = layers.scene;
        let lens = layers.lens();
        let (planes, format) = (lens.planes(), layers.format);
        let slab = |record: &Record| {
            let [near, far] = ends(record, planes, format);
            let visibility = Visibility::new(record.rgba);
            let (sum, depth, weight) = (visibility.opacity, record.depth, record.weight);
            Slab { near, far, visibility, sum, depth, weight }
        };
        let slabs: Vec<Slab> = lists.entries.par_iter().map(slab).collect();
        // A minimum and a maximum are the same in any order.
        let nearest = slabs.par_iter().map(|s| s.near).reduce(|| f64::INFINITY, f64::min);
        let farthest = slabs.par_iter().map(|s| s.far).reduce(|| f64::NEG_INFINITY, f64::max);
        let distance = self.distance.unwrap_or_else(|| to_target(scene));
        let diameter = self.aperture.unwrap_or(distance / 40.0);
        let pixels = lens.pixels();
        let offset =
            |[x, y]: [f64; 2]| [x * diameter * 0.5 * pixels[0], -(y * diameter * 0.5 * pixels[1])];
        let rays = disc(self.samples).into_iter().map(offset).collect();
        let parallel = lens.is_parallel();
        let blending = Blending { beta, ..Blending::default() };
        let span = [nearest, farthest];
        let blur = Blur { lists, slabs, span, distance, parallel, rays, blending };
        let background = scene.background.map(word16);
        let row = |y: u32| (0..lists.width).map(move |x| [x, y]);
        let pixels = (0..lists.height).into_par_iter().flat_map_iter(row);
        let color =
            |at| Ray::mean(blur.rays.iter().map(|&ray| blur.trace(at, ray))).finish(background);
        Image { width: lists.width, height: lists.height, pixels: pixels.map(color).collect() }
    }
}

/// The distance of the camera's target along the line of sight.
fn to_target(scene: &Scene) -> f64 {
    (scene.camera.target - scene.camera.eye).length()
}

/// Points of the unit disc, evenly spread; a single one is its centre.
fn disc(samples: u32) -> Vec<[f64; 2]> {
    let point = |i: u32| {
        let across = (f64::from(i) + 0.5) / f64::from(samples);
        // Below 1: of n samples, the last one is at 1 - 1/m, where m is the power of 2 from n on, which is below 2 n.
        let down = f64::from(i.reverse_bits()) / 4_294_967_296.0 + 0.5 / f64::from(samples);
        let [x, y] = [2.0 * across - 1.0, 2.0 * down - 1.0];
        if x == 0.0 && y == 0.0 {
            return [0.0, 0.0];
        }
        let quarter = std::f64::consts::FRAC_PI_4;
        let (radius, angle) =
            if x.abs() > y.abs() { (x, quarter * (y / x)) } else { (y, quarter * (2.0 - x / y)) };
        let (sin, cos) = libm::sincos(angle);
        [radius * cos, radius * sin]
    };
    (0..samples).map(point).collect()
}

/// A frame, ready for rays.
struct Blur<'a> {
    lists: &'a Lists<Record>,
    slabs: Vec<Slab>,
    /// The nearest and farthest distances of any layer.
    span: [f64; 2],
    distance: f64,
    parallel: bool,
    /// For each lens sample, how many pixels its ray is off for each unit of [`Blur::off`].
    rays: Vec<[f64; 2]>,
    blending: Blending,
}

impl Blur<'_> {
    /// How far rays are off at a distance; it falls with the distance, and is 0 in focus.
    fn off(&self, along: f64) -> f64 {
        if self.parallel { 1.0 - along / self.distance } else { 1.0 / along - 1.0 / self.distance }
    }

    /// The distance where rays are so far off.
    fn along(&self, off: f64) -> f64 {
        if self.parallel { self.distance * (1.0 - off) } else { 1.0 / (off + 1.0 / self.distance) }
    }

    /// The layers of a pixel, or of the nearest one in the image.
    fn of(&self, cell: [i64; 2]) -> &[Slab] {
        let Lists { width, height, offsets, .. } = self.lists;
        let x = cell[0].clamp(0, i64::from(*width) - 1) as usize;
        let y = cell[1].clamp(0, i64::from(*height) - 1) as usize;
        let pixel = y * *width as usize + x;
        &self.slabs[offsets[pixel] as usize..offsets[pixel + 1] as usize]
    }

    /// One ray of a pixel.
    fn trace(&self, [x, y]: [u32; 2], ray: [f64; 2]) -> Ray {
        let mut light = Ray::default();
        let [nearest, farthest] = self.span;
        if nearest > farthest {
            return light;
        }
        let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let (first, last) = (self.off(nearest), self.off(farthest));
        let size = [self.lists.width, self.lists.height].map(i64::from);
        // Beyond the image, all cells are the one at its edge.
        let mut cell: [i64; 2] = std::array::from_fn(|i| {
            ((centre[i] + ray[i] * first).floor() as i64).clamp(-1, size[i])
        });
        let mut from = f64::NEG_INFINITY;
        let mut off = first;
        loop {
            // As the distance grows, `off` falls: the next border is the one with the largest.
            let border = |i: usize| {
                let (edge, last) =
                    if ray[i] < 0.0 { (cell[i] + 1, size[i]) } else { (cell[i], -1) };
                if ray[i] == 0.0 || cell[i] == last {
                    return f64::NEG_INFINITY;
                }
                ((edge as f64 - centre[i]) / ray[i]).min(off)
            };
            let borders = [border(0), border(1)];
            let axis = usize::from(borders[1] > borders[0]);
            let ends = borders[axis] <= last;
            let to = if ends { f64::INFINITY } else { self.along(borders[axis]) };
            self.pass(cell, [from, to], &mut light);
            if ends || light.is_opaque() {
                return light;
            }
            (from, off) = (to, borders[axis]);
            cell[axis] += if ray[axis] < 0.0 { 1 } else { -1 };
        }
    }

    /// Pass the layers of a pixel between two distances.
    fn pass(&self, cell: [i64; 2], [from, to]: [f64; 2], light: &mut Ray) {
        for slab in self.of(cell) {
            let [near, far] = [slab.near.max(from), slab.far.min(to)];
            let visibility = if slab.near >= slab.far {
                (from <= slab.far && slab.far < to).then_some(slab.visibility)
            } else if near <= slab.near && far >= slab.far {
                Some(slab.visibility)
            } else {
                (near < far).then(|| slab.part(near, far, &self.blending).0)
            };
            if let Some(visibility) = visibility {
                light.over_record(&Record { rgba: visibility.rgba(), ..Record::default() });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lens_samples_fill_a_disc_evenly() {
        for samples in [1, 64, 1_000] {
            let points = disc(samples);
            assert!(points.iter().all(|[x, y]| x * x + y * y <= 1.0));
            let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / f64::from(samples);
            assert!(mean(0).abs() < 0.02 && mean(1).abs() < 0.02, "{samples}");
        }
        assert_eq!(disc(1), [[0.0, 0.0]]);
        let inner = disc(1_000).iter().filter(|[x, y]| x * x + y * y <= 0.25).count();
        assert!((240..=260).contains(&inner), "a quarter of the area: {inner}");
    }

    /// A ray visits pixels in order, and their distances join without a gap.
    #[test]
    fn a_ray_meets_each_plane_once() {
        let offsets = (0..=64_u64).map(|i| i * 3).collect();
        let planes = [2.0, 4.0, 7.0];
        let slab = |far: f64| {
            let visibility = Visibility { color: [0.0; 3], opacity: 0.5 };
            Slab { near: far, far, visibility, ..Slab::default() }
        };
        let lists = Lists { width: 8, height: 8, offsets, entries: vec![] };
        for parallel in [false, true] {
            let blur = Blur {
                lists: &lists,
                slabs: (0..64).flat_map(|_| planes.map(slab)).collect(),
                span: [2.0, 7.0],
                distance: 3.5,
                parallel,
                rays: vec![],
                blending: Blending::default(),
            };
            let mut straight = Ray::default();
            blur.pass([3, 3], [f64::NEG_INFINITY, f64::INFINITY], &mut straight);
            for ray in [[0.0, 0.0], [17.0, -5.0], [-0.1, 30.0], [0.0, 9.0], [1e4, 1.0]] {
                assert_eq!(blur.trace([3, 4], ray), straight, "{ray:?} {parallel}");
            }
        }
    }
}
