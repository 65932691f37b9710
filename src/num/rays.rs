//! Eight rays at once, by the arithmetic of [`super::ray`].

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes, all of the same length, become vectors"
)]

use super::color::srgb_table;
use super::ray::Ray;

/// How many.
pub const RAYS: usize = 8;

/// The linear light of eight, channel by channel.
pub type Lights = [[u16; RAYS]; 3];

/// The opaque sRGB pixels of linear light. They are apart from what makes the light, since a loop with both in it
/// becomes no vectors.
#[inline]
pub fn pixels(all: &[Lights]) -> impl Iterator<Item = [[u8; 4]; RAYS]> + '_ {
    let srgb = srgb_table();
    all.iter().map(|lights| {
        let mut pixels = [[255; 4]; RAYS];
        for i in 0..RAYS {
            for c in 0..3 {
                pixels[i][c] = srgb[usize::from(lights[c][i])];
            }
        }
        pixels
    })
}

/// Eight rays, part by part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rays {
    color: [[u32; RAYS]; 3],
    transmittance: [u32; RAYS],
}

impl Default for Rays {
    fn default() -> Self {
        let Ray { color, transmittance } = Ray::default();
        Self { color: color.map(|c| [c; RAYS]), transmittance: [transmittance; RAYS] }
    }
}

#[allow(clippy::inline_always, reason = "see `super::lanes`")]
impl Rays {
    /// Pass the next surface of each; a surface of opacity 0 is none.
    #[inline(always)]
    pub fn over(&mut self, words: [u32; RAYS]) {
        let mut weight = [0; RAYS];
        for i in 0..RAYS {
            weight[i] = self.transmittance[i] * (words[i] >> 24);
        }
        for (c, sums) in self.color.iter_mut().enumerate() {
            for i in 0..RAYS {
                let light = weight[i] * (words[i] >> (8 * c) & 0xFF);
                sums[i] = (sums[i] + (light + 32_512) / 65_025).min(65_535);
            }
        }
        for i in 0..RAYS {
            let passes = 255 - (words[i] >> 24);
            self.transmittance[i] = (self.transmittance[i] * passes + 127) / 255;
        }
    }

    /// Nothing behind can be seen any more, by none of them.
    #[inline(always)]
    #[must_use]
    pub fn are_opaque(&self) -> bool {
        self.transmittance.iter().fold(0, |all, t| all | t) == 0
    }

    /// Meet the background: the linear light that reaches the eye, channel by channel.
    #[inline(always)]
    #[must_use]
    pub fn before(&self, background: [u16; 3]) -> Lights {
        let mut lights = [[0; RAYS]; 3];
        for c in 0..3 {
            let behind = u32::from(background[c]);
            for i in 0..RAYS {
                // At most 65,535 x 65,535 + 32,767 < 2^32.
                let passes = (self.transmittance[i] * behind + 32_767) / 65_535;
                lights[c][i] = (self.color[c][i] + passes).min(65_535) as u16;
            }
        }
        lights
    }

    /// One of them.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, i: usize) -> Ray {
        Ray { color: [0, 1, 2].map(|c| self.color[c][i]), transmittance: self.transmittance[i] }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::num::lanes::wide;

    proptest! {
        #[test]
        fn as_one_ray_after_another(
            lists in prop::collection::vec(prop::array::uniform8(any::<u32>()), 0..12),
            opaque in any::<bool>(),
        ) {
            let words = |i: usize| lists[i].map(|word| if opaque { word | 0xFF00_0000 } else { word });
            let mut one = [Ray::default(); RAYS];
            let (mut narrow, mut all) = (Rays::default(), Rays::default());
            for i in 0..lists.len() {
                one.iter_mut().zip(words(i)).for_each(|(ray, word)| ray.over(word));
                narrow.over(words(i));
                wide(|| all.over(words(i)));
            }
            prop_assert_eq!(narrow, all);
            for (i, ray) in one.into_iter().enumerate() {
                prop_assert_eq!(all.ray(i), ray);
                let lights = [all.before([0, 14_028, 65_535])];
                let pixels: Vec<_> = pixels(&lights).collect();
                prop_assert_eq!(pixels[0][i], ray.finish([0, 14_028, 65_535]));
            }
            prop_assert_eq!(all.are_opaque(), one.iter().all(Ray::is_opaque));
        }
    }
}
