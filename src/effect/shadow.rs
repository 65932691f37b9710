//! Translucent shadows: the lists of a frame seen from the light are a shadow map (HA-buffer paper, section 6.2).
//!
//! A surface of linear colour c and opacity a, both bytes, transmits (1 - a) (1 - a (1 - c)) of the light, per channel:
//! the share 1 - a passes, and the surface's unlit colour filters it as much as the surface is opaque. So glass casts
//! coloured shadows and an opaque surface black ones. Transmittances multiply from the light on, each rounded to 16
//! bits: T = (T (255 - a) (65,025 - a (255 - c)) + 8,290,687) / 16,581,375.
//!
//! A point of the view is in the shadow of what its pixel of the map holds at a distance from the light below the
//! point's own minus a bias, in world units; the bias keeps a surface from shadowing itself, since the map knows it
//! only at its pixels' centres. Points outside of the map are lit.
//!
//! The map of a Boolean combination (`csg`) holds only its surfaces, which are opaque. Other effects use the shadows of
//! all surfaces; media cast those of their faces, whatever their thickness.

use super::lens::Lens;
use crate::fragment::{data_of, depth_of};
use crate::num::depth::Format;
use crate::raster::Attenuation;
use crate::resolve::Lists;
use crate::scene::{Camera, Projection};

/// The default bias, in widths of the map's pixels: surfaces that the light meets at up to 70 degrees do not shadow
/// themselves (tan 70° * half a pixel's diagonal is 1.94).
pub const BIAS_PIXELS: f64 = 2.0;

/// What stands between the light and the view's fragments.
#[derive(Debug)]
pub struct ShadowMap {
    view: Lens,
    light: Lens,
    lists: Lists,
    /// By fragment of `lists`: what is left of the light behind it.
    behind: Vec<[u16; 3]>,
    bias: f64,
}

impl ShadowMap {
    /// A map for a view, from `lists` of colour words drawn from `light`, a parallel view; `bias` in world units.
    #[must_use]
    pub fn new(view: Lens, light: &Camera, format: Format, lists: Lists, bias: f64) -> Self {
        let mut behind = Vec::with_capacity(lists.entries.len());
        for ends in lists.offsets.windows(2) {
            let mut left = [65_535; 3];
            for &key in &lists.entries[ends[0] as usize..ends[1] as usize] {
                left = through(left, data_of(key));
                behind.push(left);
            }
        }
        let light = Lens::new(light, [lists.width, lists.height], format);
        Self { view, light, lists, behind, bias }
    }
}

/// The default bias of a map of `size` pixels, square, in world units.
#[must_use]
pub fn default_bias(light: &Camera, size: u32) -> f64 {
    match light.projection {
        Projection::Orthographic { height } => BIAS_PIXELS * height / f64::from(size),
        Projection::Perspective { .. } => 0.0,
    }
}

/// What a surface leaves of the light.
#[must_use]
pub fn through(light: [u16; 3], word: u32) -> [u16; 3] {
    let [r, g, b, alpha] = word.to_le_bytes().map(u64::from);
    let c = [r, g, b];
    std::array::from_fn(|i| {
        let share = (255 - alpha) * (65_025 - alpha * (255 - c[i]));
        ((u64::from(light[i]) * share + 8_290_687) / 16_581_375) as u16
    })
}

impl Attenuation for ShadowMap {
    fn transmittance(&self, x: u32, y: u32, depth: u32) -> [u16; 3] {
        let all = [65_535; 3];
        let Some(([x, y], distance)) = self.light.pixel(self.view.point(x, y, depth)) else {
            return all;
        };
        let pixel = y as usize * self.lists.width as usize + x as usize;
        let ends = [pixel, pixel + 1].map(|p| self.lists.offsets[p] as usize);
        let limit = distance - self.bias;
        let before = self.lists.entries[ends[0]..ends[1]]
            .partition_point(|&key| self.light.along(depth_of(key)) < limit);
        before.checked_sub(1).map_or(all, |last| self.behind[ends[0] + last])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_filter_light() {
        let all = [65_535; 3];
        let word = |r: u8, g, b, a| u32::from_le_bytes([r, g, b, a]);
        assert_eq!(through(all, word(255, 128, 0, 255)), [0; 3], "opaque");
        assert_eq!(through(all, word(0, 0, 0, 0)), all, "not there");
        // a = 0.2: 0.8 through white, 0.8 * 0.8 through black.
        assert_eq!(through(all, word(255, 255, 0, 51)), [52_428, 52_428, 41_942]);
        assert_eq!(through([0, 1, 65_535], word(255, 255, 255, 51)), [0, 1, 52_428]);
    }
}
