//! Compositing front to back, in 16-bit fixed point.
//!
//! With colour c and opacity a of a linear, straight-alpha RGBA8 word, and transmittance T from 65,535 downwards:
//! C += (T a c + 32,512) / 65,025, then T = (T (255 - a) + 127) / 255; last the background b: C += (T b + 32,767) /
//! 65,535. Division truncates, sums saturate at 65,535.

use crate::num::color::srgb;

/// Light gathered along one ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ray {
    color: [u32; 3],
    transmittance: u32,
}

impl Default for Ray {
    fn default() -> Self {
        Self { color: [0; 3], transmittance: 65_535 }
    }
}

impl Ray {
    /// Pass the next surface.
    #[inline]
    pub fn over(&mut self, word: u32) {
        let [r, g, b, alpha] = word.to_le_bytes().map(u64::from);
        let weight = u64::from(self.transmittance) * alpha;
        for (sum, c) in self.color.iter_mut().zip([r, g, b]) {
            *sum = (*sum + ((weight * c + 32_512) / 65_025) as u32).min(65_535);
        }
        self.transmittance = (self.transmittance * (255 - alpha as u32) + 127) / 255;
    }

    /// Meet the background, and encode to an opaque sRGB pixel.
    #[inline]
    #[must_use]
    pub fn finish(self, background: [u16; 3]) -> [u8; 4] {
        let channel = |i: usize| {
            let behind =
                (u64::from(self.transmittance) * u64::from(background[i]) + 32_767) / 65_535;
            srgb((self.color[i] + behind as u32).min(65_535) as u16)
        };
        [channel(0), channel(1), channel(2), 255]
    }

    /// Nothing behind can be seen any more.
    #[inline]
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.transmittance == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: u16 = 65_535;

    #[test]
    fn an_opaque_surface_hides_the_rest() {
        let mut ray = Ray::default();
        ray.over(u32::from_le_bytes([255, 0, 128, 255]));
        assert!(ray.is_opaque());
        let alone = ray;
        ray.over(u32::from_le_bytes([9, 255, 9, 255]));
        assert_eq!(ray, alone);
        assert_eq!(ray.finish([WHITE; 3]), [255, 0, srgb(128 * 257), 255]);
    }

    #[test]
    fn nothing_shows_the_background() {
        let mut ray = Ray::default();
        assert_eq!(ray.finish([WHITE, 0, 14_028]), [255, 0, 128, 255]);
        ray.over(u32::from_le_bytes([200, 200, 200, 0]));
        assert_eq!(ray, Ray::default(), "a surface of no opacity changes nothing");
    }
}
