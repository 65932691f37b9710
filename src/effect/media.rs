//! Translucent media: what light loses inside of objects (HA-buffer paper, section 6.2: in/out pairs of fragments).
//!
//! A ray enters an object where it meets one of its faces from outside, and leaves it where as many front as back faces
//! have been passed. In between, the winding number (+1 for a front face and -1 for a back face) is not 0. So
//! overlapping parts count once, a cavity is empty, and it does not matter which way a mesh is wound. The thickness d
//! is the distance along the ray between the two, in world units (`lens`).
//!
//! A medium of colour c and opacity a transmits, per channel and world unit, t = (1 - a) (1 - a (1 - c)): the share
//! 1 - a passes, and the colour filters it as much as the matter is dense. By the law of Beer and Lambert it transmits
//! exp(-sigma d) with sigma = -ln(t) * density; several media on a ray, also nested ones, multiply: the sums of sigma d
//! are taken in the order in which objects are left. The colour is the background's, or that of the first opaque
//! surface (opacity byte 255), times the transmittance, which is rounded to 16 bits: (T L + 32,767) / 65,535. Logarithm
//! and exponential are `libm`'s, in f64. Media neither scatter nor emit light, their faces are not drawn, and vertex
//! colours are ignored. An object still open where an opaque surface ends the ray ends there; one that is never left is
//! not counted at all.

use rayon::prelude::*;

use super::lens::Lens;
use super::solids::{Part, Solids};
use super::{Made, Stage, sums};
use crate::fragment::{data_of, depth_of};
use crate::num::color::{byte, srgb};
use crate::scene::Material;

/// How the material of an object acts on light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matter {
    /// It ends every ray.
    Opaque,
    /// It absorbs, per channel and world unit.
    Medium([f64; 3]),
}

impl Matter {
    /// Of a material, at a density.
    #[must_use]
    pub fn new(material: &Material, density: f64) -> Self {
        if byte(material.alpha) == 255 {
            return Self::Opaque;
        }
        let a = f64::from(material.alpha);
        Self::Medium(material.color.map(|c| {
            let transmitted = (1.0 - a) * (1.0 - a * (1.0 - f64::from(c)));
            -libm::log(transmitted) * density
        }))
    }
}

/// An object that a ray has met.
struct Met {
    solid: usize,
    winding: i64,
    /// Where it was entered, and the material there.
    entered: f64,
    sigma: [f64; 3],
}

/// One ray, front to back.
#[derive(Default)]
struct Ray {
    met: Vec<Met>,
    /// The sum of sigma d.
    depth: [f64; 3],
    /// What an opaque surface shows at its end.
    end: Option<[u16; 3]>,
}

impl Ray {
    fn clear(&mut self) {
        self.met.clear();
        (self.depth, self.end) = ([0.0; 3], None);
    }

    fn absorb(depth: &mut [f64; 3], met: &Met, at: f64) {
        let thickness = at - met.entered;
        for (sum, sigma) in depth.iter_mut().zip(met.sigma) {
            *sum += sigma * thickness;
        }
    }

    /// Pass a face of an object.
    fn pass(&mut self, solid: usize, back: bool, sigma: [f64; 3], at: f64) {
        let known = self.met.iter().position(|met| met.solid == solid);
        let place = known.unwrap_or_else(|| {
            self.met.push(Met { solid, winding: 0, entered: at, sigma });
            self.met.len() - 1
        });
        let met = &mut self.met[place];
        let before = met.winding;
        met.winding += if back { -1 } else { 1 };
        if before == 0 {
            (met.entered, met.sigma) = (at, sigma);
        } else if met.winding == 0 && self.end.is_none() {
            Self::absorb(&mut self.depth, met, at);
        }
    }

    /// Meet an opaque surface. The faces behind it are only counted.
    fn stop(&mut self, at: f64, color: impl FnOnce() -> u32) {
        if self.end.is_none() {
            for met in self.met.iter().filter(|met| met.winding != 0) {
                Self::absorb(&mut self.depth, met, at);
            }
            let [r, g, b, _] = color().to_le_bytes().map(|byte| u16::from(byte) * 257);
            self.end = Some([r, g, b]);
        }
    }

    fn color(&self, background: [u16; 3]) -> [u8; 4] {
        let behind = self.end.unwrap_or(background);
        let channel = |i: usize| {
            let share = (libm::exp(-self.depth[i]) * 65_535.0 + 0.5) as u64;
            srgb(((share * u64::from(behind[i]) + 32_767) / 65_535) as u16)
        };
        [channel(0), channel(1), channel(2), 255]
    }
}

/// Draw the scene's objects as media.
pub(super) fn draw(stage: &Stage<'_>, density: f64) -> Made {
    let scene = stage.scene;
    let solids = Solids::new(scene);
    let matter: Vec<Matter> =
        scene.materials.iter().map(|material| Matter::new(material, density)).collect();
    let lens = Lens::new(&scene.camera, scene.size, stage.format);
    let background = stage.background();
    let row = |y: u32| {
        let (mut ray, mut colors) = (Ray::default(), Vec::new());
        let mut open = vec![0; solids.names().len()];
        for x in 0..stage.lists.width {
            ray.clear();
            let sight = lens.sight(x, y);
            for &key in stage.lists.pixel(x, y) {
                let (triangle, depth) = (data_of(key), depth_of(key));
                let at = lens.distance(sight, depth);
                let color = || stage.front.color_of(triangle, x, y, depth);
                match solids.part(triangle).map(|part| (part, matter[part.material])) {
                    Some((Part { solid, .. }, Matter::Medium(sigma))) => {
                        let back = stage.front.is_back(triangle).unwrap_or_default();
                        ray.pass(solid, back, sigma, at);
                    }
                    Some((_, Matter::Opaque)) => ray.stop(at, color),
                    // A triangle in pixels encloses nothing.
                    None if color() >> 24 == 255 => ray.stop(at, color),
                    None => {}
                }
            }
            for met in ray.met.iter().filter(|met| met.winding != 0) {
                open[met.solid] += 1;
            }
            colors.push(ray.color(background));
        }
        (colors, open)
    };
    let rows: Vec<_> = (0..stage.lists.height).into_par_iter().map(row).collect();
    let mut made = Made::default();
    let open = sums(rows.iter().map(|(_, open)| open), solids.names().len());
    for (name, pixels) in solids.names().iter().zip(open) {
        made.open(name, pixels, "more front than back faces, or fewer");
    }
    if scene.screen.iter().any(|triangle| byte(triangle.color[3]) < 255) {
        let problem =
            "media: translucent triangles given in pixels enclose nothing, and are not drawn";
        made.warnings.push(problem.to_owned());
    }
    made.picture(stage, rows.into_iter().flat_map(|(colors, _)| colors).collect());
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMA: [f64; 3] = [1.0, 2.0, 4.0];

    /// The optical depth of the first channel after these faces: object, back, distance.
    fn depth(faces: &[(usize, bool, f64)]) -> f64 {
        let mut ray = Ray::default();
        faces.iter().for_each(|&(solid, back, at)| ray.pass(solid, back, SIGMA, at));
        ray.depth[0]
    }

    #[test]
    fn thickness_is_between_in_and_out() {
        assert_eq!(depth(&[(0, false, 1.0), (0, true, 3.5)]), 2.5);
        assert_eq!(depth(&[(0, true, 1.0), (0, false, 3.5)]), 2.5, "wound the other way");
        let overlapping = [(0, false, 1.0), (0, false, 2.0), (0, true, 3.0), (0, true, 5.0)];
        assert_eq!(depth(&overlapping), 4.0);
        let shell = [(0, false, 1.0), (0, true, 2.0), (0, false, 3.0), (0, true, 5.0)];
        assert_eq!(depth(&shell), 3.0);
        let nested = [(0, false, 1.0), (1, false, 2.0), (1, true, 3.0), (0, true, 5.0)];
        assert_eq!(depth(&nested), 5.0);
        assert_eq!(depth(&[(0, false, 1.0)]), 0.0, "an in without an out");
    }

    #[test]
    fn an_opaque_surface_ends_what_is_open() {
        let mut ray = Ray::default();
        ray.pass(0, false, SIGMA, 1.0);
        ray.stop(2.0, || 0xFF00_0000);
        ray.pass(0, true, SIGMA, 9.0);
        ray.stop(10.0, || 0xFFFF_FFFF);
        assert_eq!((ray.depth, ray.end), (SIGMA, Some([0; 3])));
    }

    #[test]
    fn matter() {
        let material = |color, alpha| Material::new("", color, alpha);
        assert_eq!(Matter::new(&material([0.5; 3], 1.0), 1.0), Matter::Opaque);
        assert_eq!(Matter::new(&material([0.5; 3], 0.0), 7.0), Matter::Medium([0.0; 3]));
        let Matter::Medium(sigma) = Matter::new(&material([1.0, 0.5, 0.0], 0.5), 2.0) else {
            panic!("opaque")
        };
        for (sigma, transmitted) in sigma.into_iter().zip([0.25_f64, 0.140_625, 0.0625]) {
            assert!((libm::exp(-sigma) - transmitted).abs() < 1e-15);
        }
    }
}
