//! Compositing front to back, in 16-bit fixed point.
//!
//! With colour c and opacity a of a linear, straight-alpha RGBA8 word, and transmittance T from 65,535 downwards:
//! C += (T a c + 32,512) / 65,025, then T = (T (255 - a) + 127) / 255; last the background b: C += (T b + 32,767) /
//! 65,535. Division truncates, sums saturate at 65,535.
//!
//! Merged records are composited by the same rule from their real-valued colours: each product is rounded to the
//! nearest integer. For a record that is one surface of an RGBA8 colour, this is the same integer (65,025 and 255 are
//! odd, so no product lies half-way between two, and a half is much farther away than f64 errs).

use crate::num::color::srgb;
use crate::scheme::{Light, Record};

/// All light, in 16 bits.
const ALL: f64 = 65_535.0;

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

    /// Pass the next merged record.
    #[inline]
    pub fn over_record(&mut self, record: &Record) {
        let [r, g, b, alpha] = record.rgba;
        let light = f64::from(self.transmittance);
        for (sum, c) in self.color.iter_mut().zip([r, g, b]) {
            *sum = sum.saturating_add(whole(light * c)).min(65_535);
        }
        self.transmittance = whole(light * (1.0 - alpha));
    }

    /// A ray with the colour and transmittance of `light`.
    #[inline]
    #[must_use]
    pub fn of_light(light: &Light) -> Self {
        Self {
            color: light.color.map(|c| whole(c * ALL)),
            transmittance: whole(light.transmittance * ALL),
        }
    }

    /// The colour and transmittance so far.
    #[must_use]
    pub fn light(&self) -> Light {
        let color = self.color.map(|c| f64::from(c) / ALL);
        Light { color, transmittance: f64::from(self.transmittance) / ALL, kept: 0 }
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

/// The nearest integer of 16 bits; 0 for NaN.
#[inline]
fn whole(x: f64) -> u32 {
    (x + 0.5).clamp(0.0, ALL + 0.5) as u32
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_record_of_one_surface_is_that_surface(words in prop::collection::vec(any::<u32>(), 1..9)) {
            let (mut surfaces, mut records) = (Ray::default(), Ray::default());
            for word in words {
                surfaces.over(word);
                records.over_record(&Record::surface(0, word));
                prop_assert_eq!(surfaces, records);
            }
            prop_assert_eq!(Ray::of_light(&surfaces.light()), surfaces);
        }
    }

    /// Every transmittance, with the factors that come closest to a half.
    #[test]
    fn no_transmittance_rounds_otherwise() {
        for transmittance in 0..=65_535 {
            for word in
                [0x0101_0101, 0x8080_8080, 0x7F7F_7F7F, 0xFEFE_FEFE, 0x01FF_FE80, 0xFFFF_FFFF]
            {
                let [mut one, mut other] = [Ray { color: [0; 3], transmittance }; 2];
                one.over(word);
                other.over_record(&Record::surface(0, word));
                assert_eq!(one, other, "{transmittance} {word:x}");
            }
        }
    }

    #[test]
    fn what_is_no_colour_is_black_or_white_and_no_panic() {
        let light = Light { color: [f64::NAN, 2.0, -1.0], transmittance: f64::NAN, kept: 0 };
        let ray = Ray::of_light(&light);
        assert_eq!((ray.color, ray.transmittance), ([0, 65_535, 0], 0));
    }

    #[test]
    fn a_mean_of_equal_rays_is_that_ray() {
        let ray = Ray { color: [1, 65_535, 7], transmittance: 3 };
        assert_eq!(Ray::mean([ray; 37].into_iter()), ray);
        let other = Ray { color: [2, 65_535, 10], transmittance: 0 };
        let mean = Ray { color: [2, 65_535, 9], transmittance: 2 };
        assert_eq!(Ray::mean([ray, other].into_iter()), mean);
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
