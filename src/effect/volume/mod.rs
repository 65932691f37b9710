//! Volumes between a frame's surfaces ("Fragment merging with z-thickness", section 5.3).
//!
//! The surfaces are drawn, resolved and merged first. Then each pixel's ray goes through the scene's volumes, front to
//! back, from the near to the far plane. Where it enters or leaves a box, a new row of steps begins: steps of the
//! shortest `step` of the volumes that it is in, in world units along the ray, the last one shorter. A sample is taken
//! in the middle of each step (`path`). A value of opacity A per s0 world units stops 1 - (1 - A)^(density s / s0) of
//! the light; where several volumes are, their extinctions add up, and colours mix by opacity.
//!
//! A sample is a slab as thick as its step. It meets the pixel's layers by smooth fragment merging (`merge`), or, if
//! that is turned off, stands behind those that end before it does.
//!
//! A ray ends where less than `until` of the light is left, so no channel is off by more than that. A pixel whose ray
//! meets nothing in the volumes keeps its picture to the bit. All others are composited in f64, in the order written,
//! and rounded to 16 bits once.

mod merge;
mod path;

use rayon::prelude::*;

use self::merge::Meeting;
use self::path::Path;
use super::lens::Lens;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::num::color::word16;
use crate::num::depth::Format;
use crate::resolve::composite::Ray;
use crate::scene::volume::MAX_STEPS;
use crate::scene::{Scene, Volume};
use crate::scheme::merging::Blending;
use crate::scheme::merging::slab::{Slab, Visibility};
use crate::scheme::{Light, Record};

/// The share of light at which rays end unless another is given: less than half of what 16 bits can show.
pub const UNTIL: f64 = 1.0 / 131_072.0;

/// How rays go through volumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marching {
    /// Samples and layers meet by smooth merging; otherwise one is in front of the other.
    pub merge: bool,
    /// The share of light at which rays end, 0 to 1.
    pub until: f64,
    /// World units between samples, for all volumes, above 0; `None` is each volume's own.
    pub step: Option<f64>,
}

impl Default for Marching {
    fn default() -> Self {
        Self { merge: true, until: UNTIL, step: None }
    }
}

impl Marching {
    /// Check numbers, and the step against the scene's volumes.
    ///
    /// # Errors
    /// The option that is out of range.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        if !(0.0..=1.0).contains(&self.until) {
            let problem = format!("is {}, but must be a share of light from 0 to 1", self.until);
            return Err(Error::new("--volume-until", problem));
        }
        let Some(step) = self.step else { return Ok(()) };
        if !(step.is_finite() && step > 0.0) {
            let problem = format!("is {step}, but must be above 0 world units, and finite");
            return Err(Error::new("--volume-step", problem));
        }
        let diagonal = |volume: &Volume| {
            let place = &volume.place;
            let axes = [place.x_axis, place.y_axis, place.z_axis];
            axes.iter().fold(0.0, |sum, axis| sum + axis.truncate().length_squared()).sqrt()
        };
        let longest = scene.volumes.iter().map(diagonal).fold(0.0, f64::max);
        if longest / step > MAX_STEPS {
            let problem = format!("is {step}, which makes more than {MAX_STEPS} steps");
            return Err(Error::new("--volume-step", problem));
        }
        Ok(())
    }
}

/// What stands before the eye besides the volumes.
pub(super) struct Scenery<'a, R> {
    pub(super) scene: &'a Scene,
    pub(super) format: Format,
    /// β, where slabs are cut.
    pub(super) beta: f64,
    /// Adds the layers of a pixel, front to back.
    pub(super) layers: R,
}

impl<R: Fn(u32, u32, &mut Vec<Record>) + Sync> Scenery<'_, R> {
    /// Draw the scene's volumes over the picture of the layers alone.
    pub(super) fn draw(&self, marching: &Marching, picture: &mut Image) {
        let scene = self.scene;
        let lens = Lens::new(&scene.camera, scene.size, self.format);
        let path = Path::new(&scene.volumes, lens.planes(), marching.step);
        let blending = Blending { beta: self.beta, ..Blending::default() };
        let background = scene.background.map(word16);
        let width = (picture.width as usize).max(1);
        let rows = picture.pixels.par_chunks_mut(width).enumerate();
        rows.for_each(|(y, row)| {
            let (mut records, mut slabs, mut passages) = (Vec::new(), Vec::new(), Vec::new());
            for (x, pixel) in (0..).zip(row) {
                let sight = lens.sight(x, y as u32);
                path.enter(sight, &mut passages);
                if passages.is_empty() {
                    continue;
                }
                records.clear();
                slabs.clear();
                (self.layers)(x, y as u32, &mut records);
                slabs.extend(records.iter().map(|record| slab(record, &lens)));
                let mut meeting = Meeting::new(&slabs, blending);
                path.walk(sight, &passages, |sample| {
                    if marching.merge {
                        meeting.merge(&sample);
                    } else {
                        meeting.pass(&sample);
                    }
                    meeting.through() >= marching.until && meeting.through() > 0.0
                });
                if let Some(Visibility { color, opacity }) = meeting.finish(marching.until) {
                    let light = Light { color, transmittance: 1.0 - opacity, kept: 0 };
                    *pixel = Ray::of_light(&light).finish(background);
                }
            }
        });
    }
}

/// A record as a slab.
fn slab(record: &Record, lens: &Lens) -> Slab {
    let Record { depth, thickness, rgba, weight } = *record;
    let far = lens.along(depth);
    let visibility = Visibility::new(rgba);
    Slab { near: far - thickness, far, visibility, sum: visibility.opacity, depth, weight }
}
