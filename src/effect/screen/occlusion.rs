//! Ambient occlusion from the horizons of all layers (horizon-based, Bavoil and Sainz, "Multi-layer dual-resolution
//! screen-space ambient occlusion", 2009).
//!
//! Each layer of a pixel is a point P in the eye's space, with a normal from its neighbours: left or right, and above
//! or below, the layer whose front is nearest in depth; the normal looks at the eye. From there, `directions` go out evenly in
//! screen space, the first turned by a hash of the pixel, each with `steps` to where the radius r is at the distance of
//! P. At each step, every layer S of that pixel counts whose distance d from P is below r. The horizon is the largest
//! sine so far of the angle between S - P and the plane of the surface, from [`BIAS`] on; where it rises, the rise is
//! added, times 1 - d²/r². The layer's value is 1 less the mean over directions, and multiplies its colour.
//!
//! A record thicker than 10 P(z) has a front and a back. Both occlude; its own value is that of its front. How opaque a
//! layer is does not matter, as in the papers.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::effect::layers::{Layers, ends};
use crate::effect::lens::Lens;
use crate::error::{Error, Result};
use crate::num::random;
use crate::resolve::Lists;
use crate::scene::Scene;
use crate::scheme::Record;

/// The sine above which a horizon begins. Normals come from depths, so those of a plane differ from its own by what
/// rounding of depths makes of the slope from pixel to pixel, which this is far above.
pub const BIAS: f64 = 1.0 / 64.0;

/// Stream of the hash that turns directions.
const TURNS: u64 = 0xA0CC;

/// How to find what surrounds a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occlusion {
    /// World units within which layers occlude, 0 or more; `None` is a twentieth of the scene's diagonal.
    pub radius: Option<f64>,
    /// 1 to 64.
    pub directions: u32,
    /// 1 to 256.
    pub steps: u32,
    /// Of the hash.
    pub seed: u64,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { radius: None, directions: 8, steps: 8, seed: 0 }
    }
}

impl Occlusion {
    pub(super) fn check(&self) -> Result<()> {
        if let Some(radius) = self.radius.filter(|r| !(r.is_finite() && *r >= 0.0)) {
            let problem = format!("ao={radius}: must be 0 or more world units, and finite");
            return Err(Error::new("--effect", problem));
        }
        if !(1..=64).contains(&self.directions) {
            let problem = format!("is {}, but must be 1 to 64", self.directions);
            return Err(Error::new("--ao-directions", problem));
        }
        if !(1..=256).contains(&self.steps) {
            let problem = format!("is {}, but must be 1 to 256", self.steps);
            return Err(Error::new("--ao-steps", problem));
        }
        Ok(())
    }

    /// Multiply every record's colour by its value.
    pub(super) fn shade(&self, layers: &Layers<'_>, lists: &mut Lists<Record>) {
        let values = self.values(layers, lists);
        for (record, value) in lists.entries.iter_mut().zip(values) {
            record.rgba[..3].iter_mut().for_each(|c| *c *= value);
        }
    }

    /// The value of every record: 1 where nothing occludes.
    fn values(&self, layers: &Layers<'_>, lists: &Lists<Record>) -> Vec<f64> {
        let lens = layers.lens();
        let (planes, format) = (lens.planes(), layers.format);
        let bounds = lists.entries.par_iter().map(|r| ends(r, planes, format)).collect();
        let radius = self.radius.unwrap_or_else(|| default_radius(layers.scene));
        let field = Field { lens, lists, bounds, radius, occlusion: *self };
        let row = |y: u32| {
            let values = |x: u32| field.of(x, y).iter().map(move |&[near, _]| (x, near));
            let values = (0..lists.width).flat_map(values);
            values.map(|(x, along)| field.value(x, y, along)).collect::<Vec<f64>>()
        };
        let rows: Vec<_> = (0..lists.height).into_par_iter().map(row).collect();
        rows.into_iter().flatten().collect()
    }
}

/// A twentieth of the diagonal of what is drawn; of a scene given in pixels, of what is between the planes.
fn default_radius(scene: &Scene) -> f64 {
    let diagonal = scene.bounds().diagonal();
    let depth = scene.camera.far - scene.camera.near;
    0.05 * if scene.objects.is_empty() { depth } else { diagonal }
}

/// All layers of a frame as distances.
struct Field<'a> {
    lens: Lens,
    lists: &'a Lists<Record>,
    /// Where each record begins and ends.
    bounds: Vec<[f64; 2]>,
    radius: f64,
    occlusion: Occlusion,
}

impl Field<'_> {
    fn of(&self, x: u32, y: u32) -> &[[f64; 2]] {
        let pixel = y as usize * self.lists.width as usize + x as usize;
        &self.bounds[self.lists.offsets[pixel] as usize..self.lists.offsets[pixel + 1] as usize]
    }

    /// The pixel some way from another, if it is in the image.
    fn beside(&self, [x, y]: [u32; 2], [dx, dy]: [i64; 2]) -> Option<[u32; 2]> {
        let [x, y] = [i64::from(x) + dx, i64::from(y) + dy];
        let inside =
            (0..self.lists.width.into()).contains(&x) && (0..self.lists.height.into()).contains(&y);
        inside.then_some([x as u32, y as u32])
    }

    /// What is left of the ambient light at a distance.
    fn value(&self, x: u32, y: u32, along: f64) -> f64 {
        if self.radius <= 0.0 {
            return 1.0;
        }
        let point = self.lens.from_eye(x, y, along);
        let normal = self.normal([x, y], point);
        let scale = if self.lens.is_parallel() { 1.0 } else { along };
        let reach = self.lens.pixels().map(|pixels| self.radius * pixels / scale);
        let Occlusion { directions, seed, .. } = self.occlusion;
        let pixel = u64::from(y) * u64::from(self.lists.width) + u64::from(x);
        let turn = (random::bits(seed, TURNS, pixel) >> 11) as f64 / 9_007_199_254_740_992.0;
        let rises = (0..directions).map(|i| {
            let (sin, cos) = libm::sincos(TAU * (f64::from(i) + turn) / f64::from(directions));
            self.rise([x, y], point, normal, [cos * reach[0], sin * reach[1]])
        });
        let sum = rises.fold(0.0, |sum, rise| sum + rise);
        (1.0 - sum / f64::from(directions)).clamp(0.0, 1.0)
    }

    /// How much the horizon rises in a direction, which reaches so many pixels.
    fn rise(&self, at: [u32; 2], point: DVec3, normal: DVec3, [dx, dy]: [f64; 2]) -> f64 {
        let (mut horizon, mut rise, mut last) = (BIAS, 0.0, [0, 0]);
        for step in 1..=self.occlusion.steps {
            let share = f64::from(step) / f64::from(self.occlusion.steps);
            let offset = [dx * share, dy * share].map(|pixels| pixels.round() as i64);
            if offset == last {
                continue;
            }
            last = offset;
            let Some([x, y]) = self.beside(at, offset) else { break };
            for &[near, far] in self.of(x, y) {
                for along in std::iter::once(near).chain((near < far).then_some(far)) {
                    let to = self.lens.from_eye(x, y, along) - point;
                    let squared = to.length_squared();
                    let falloff = 1.0 - squared / (self.radius * self.radius);
                    if falloff <= 0.0 || squared <= 0.0 {
                        continue;
                    }
                    let sine = normal.dot(to) / squared.sqrt();
                    if sine > horizon {
                        rise += falloff * (sine - horizon);
                        horizon = sine;
                    }
                }
            }
        }
        rise
    }

    /// The normal of the surface at a point, towards the eye.
    fn normal(&self, at: [u32; 2], point: DVec3) -> DVec3 {
        let across = self.tangent(at, point, [1, 0]);
        let normal = across.cross(self.tangent(at, point, [0, 1]));
        let sight = if self.lens.is_parallel() { DVec3::Z } else { point };
        let normal = normal.try_normalize().unwrap_or(-DVec3::Z);
        if normal.dot(sight) > 0.0 { -normal } else { normal }
    }

    /// To the front that is nearest in depth among those of the two neighbours on an axis, turned towards its end; if
    /// there is none, along the image.
    fn tangent(&self, at: [u32; 2], point: DVec3, axis: [i64; 2]) -> DVec3 {
        let mut nearest: Option<(f64, DVec3)> = None;
        for sign in [1, -1] {
            let Some([x, y]) = self.beside(at, axis.map(|d| d * sign)) else { continue };
            for &[along, _] in self.of(x, y) {
                let apart = (along - point.z).abs();
                if nearest.is_none_or(|(least, _)| apart < least) {
                    let to = self.lens.from_eye(x, y, along) - point;
                    nearest = Some((apart, to * sign as f64));
                }
            }
        }
        nearest.map_or(DVec3::new(axis[0] as f64, -axis[1] as f64, 0.0), |(_, to)| to)
    }
}
