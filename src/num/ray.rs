//! Compositing front to back, in 16-bit fixed point.
//!
//! With colour c and opacity a of a linear, straight-alpha RGBA8 word, and transmittance T from 65,535 downwards:
//! C += (T a c + 32,512) / 65,025, then T = (T (255 - a) + 127) / 255; last the background b: C += (T b + 32,767) /
//! 65,535. Division truncates, sums saturate at 65,535. What was gathered behind passes like the background.

use super::color::srgb;

/// Light gathered along one ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ray {
    /// Red, green and blue so far, 0 to 65,535.
    pub color: [u32; 3],
    /// The share of what is behind that passes, 0 to 65,535.
    pub transmittance: u32,
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
        let [r, g, b, alpha] = word.to_le_bytes().map(u32::from);
        // At most 65,535 x 255 x 255 + 32,512 < 2^32.
        let weight = self.transmittance * alpha;
        for (sum, c) in self.color.iter_mut().zip([r, g, b]) {
            *sum = (*sum + (weight * c + 32_512) / 65_025).min(65_535);
        }
        self.transmittance = (self.transmittance * (255 - alpha) + 127) / 255;
    }

    /// Pass what another ray has gathered behind this one.
    #[inline]
    pub fn through(&mut self, behind: Self) {
        let pass = |light: u32| {
            ((u64::from(self.transmittance) * u64::from(light) + 32_767) / 65_535) as u32
        };
        for (sum, c) in self.color.iter_mut().zip(behind.color) {
            *sum = (*sum + pass(c)).min(65_535);
        }
        self.transmittance = pass(behind.transmittance);
    }

    /// What is seen of this ray behind a surface.
    #[inline]
    #[must_use]
    pub fn behind(self, word: u32) -> Self {
        let mut ray = Self::default();
        ray.over(word);
        ray.through(self);
        ray
    }

    /// In one word: red, green, blue and transmittance, 16 bits each, red lowest.
    #[inline]
    #[must_use]
    pub fn to_word(self) -> u64 {
        let [r, g, b] = self.color.map(u64::from);
        r | g << 16 | b << 32 | u64::from(self.transmittance) << 48
    }

    /// From one word.
    #[inline]
    #[must_use]
    pub fn of_word(word: u64) -> Self {
        let part = |i: u32| (word >> (16 * i)) as u32 & 0xFFFF;
        Self { color: [part(0), part(1), part(2)], transmittance: part(3) }
    }

    /// The mean of rays, each part rounded to the nearest integer, halves up; the mean of equal rays is that ray. No
    /// ray gives one that has met nothing.
    #[must_use]
    pub fn mean(rays: impl Iterator<Item = Self>) -> Self {
        let (mut sums, mut count) = ([0_u64; 4], 0);
        for Self { color: [r, g, b], transmittance } in rays {
            for (sum, part) in sums.iter_mut().zip([r, g, b, transmittance]) {
                *sum += u64::from(part);
            }
            count += 1;
        }
        if count == 0 {
            return Self::default();
        }
        let [r, g, b, transmittance] = sums.map(|sum| ((2 * sum + count) / (2 * count)) as u32);
        Self { color: [r, g, b], transmittance }
    }

    /// Meet the background: the linear light that reaches the eye.
    #[inline]
    #[must_use]
    pub fn before(self, background: [u16; 3]) -> [u16; 3] {
        std::array::from_fn(|i| {
            let behind =
                (u64::from(self.transmittance) * u64::from(background[i]) + 32_767) / 65_535;
            (self.color[i] + behind as u32).min(65_535) as u16
        })
    }

    /// Without a background: the linear light that reaches the eye, and the opacity, all there is less the transmittance.
    #[inline]
    #[must_use]
    pub fn alone(self) -> [u16; 4] {
        let [r, g, b] = self.color.map(|light| light as u16);
        [r, g, b, 65_535 - self.transmittance as u16]
    }

    /// Meet the background, and encode to an opaque sRGB pixel.
    #[inline]
    #[must_use]
    pub fn finish(self, background: [u16; 3]) -> [u8; 4] {
        let [r, g, b] = self.before(background);
        [srgb(r), srgb(g), srgb(b), 255]
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

    #[test]
    fn a_mean_of_equal_rays_is_that_ray() {
        let ray = Ray { color: [1, 65_535, 7], transmittance: 3 };
        assert_eq!(Ray::mean([ray; 37].into_iter()), ray);
        let other = Ray { color: [2, 65_535, 10], transmittance: 0 };
        let mean = Ray { color: [2, 65_535, 9], transmittance: 2 };
        assert_eq!(Ray::mean([ray, other].into_iter()), mean);
    }

    /// An opacity of a / 255 is one of 257 a / 65,535, and there is that share of a colour's light.
    #[test]
    fn one_surface_alone_has_its_opacity() {
        assert_eq!(Ray::default().alone(), [0; 4]);
        for (alpha, c) in (0..=255_u8).flat_map(|alpha| (0..=255_u8).map(move |c| (alpha, c))) {
            let mut ray = Ray::default();
            ray.over(u32::from_le_bytes([c, 255, 0, alpha]));
            let opacity = 257 * u16::from(alpha);
            let light = (2 * 257 * u32::from(alpha) * u32::from(c) + 255) / (2 * 255);
            assert_eq!(ray.alone(), [light as u16, opacity, 0, opacity], "{alpha} {c}");
        }
    }

    #[test]
    fn two_surfaces_alone_are_less_transparent_than_one() {
        let mut ray = Ray::default();
        ray.over(u32::from_le_bytes([0, 0, 0, 51]));
        ray.over(u32::from_le_bytes([255, 0, 0, 102]));
        // 1 - 4/5 3/5 = 13/25, and the red of 4/5 2/5 = 8/25.
        assert_eq!(ray.alone(), [20_971, 0, 0, 34_078]);
    }

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
