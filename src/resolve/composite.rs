//! Compositing merged records, and rays as real-valued light; surfaces are [`crate::num::ray`]'s.
//!
//! Merged records are composited by the same rule from their real-valued colours: each product is rounded to the
//! nearest integer. For a record that is one surface of an RGBA8 colour, this is the same integer (65,025 and 255 are
//! odd, so no product lies half-way between two, and a half is much farther away than f64 errs).

pub use crate::num::ray::Ray;
use crate::scheme::{Depth, Light, Record};

/// All light, in 16 bits.
const ALL: f64 = 65_535.0;

impl Ray {
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

    /// A ray that meets an opaque gray, the darker the farther; no depth is transparent.
    #[inline]
    #[must_use]
    pub fn of_depth(Depth(depth): Depth) -> Self {
        let mut ray = Self::default();
        if depth != u32::MAX {
            let [.., upper] = (!depth).to_le_bytes();
            ray.over(u32::from_le_bytes([upper, upper, upper, 255]));
        }
        ray
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
}
