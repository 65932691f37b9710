//! Depth codes: a real depth in 0..1 as a 32-bit integer, and the formats a scheme may store.
//!
//! Codes go from 0 (near) to [`FARTHEST`] = 2^32 - 2; [`EMPTY`] = 2^32 - 1 means "no fragment", so a fragment
//! on the far plane is never mistaken for a clear value.

/// No fragment: the value a clear pass writes.
pub const EMPTY: u32 = u32::MAX;

/// The code of the far plane.
pub const FARTHEST: u32 = u32::MAX - 1;

/// The code of a depth in 0..1: `min(round_half_even(z * (2^32 - 1)), 2^32 - 2)`. Values outside are clamped.
#[inline]
#[must_use]
pub fn code(z: f64) -> u32 {
    let scaled = round_ties_even(z.clamp(0.0, 1.0) * f64::from(u32::MAX));
    (scaled as u32).min(FARTHEST)
}

/// 1.5 * 2^52: f64 has no fraction bits from 2^52 to 2^53.
const SHIFT: f64 = 6_755_399_441_055_744.0;

/// The nearest integer, halves to even, of a value within ±2^51. The same as [`f64::round_ties_even`], but for the sign
/// of zero; that one is a call on machines without an instruction for it, to which x86-64 in general belongs.
#[inline]
#[must_use]
pub fn round_ties_even(v: f64) -> f64 {
    (v + SHIFT) - SHIFT
}

/// What a scheme stores for a depth code. Every format keeps the order of codes, and never makes [`EMPTY`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// The code itself.
    #[default]
    D32,
    /// The upper 24 bits of the code.
    D24,
    /// The bits of the code's value rounded to the nearest f32 (so 0 to 2^32, in steps that grow with depth).
    F32,
}

impl Format {
    /// All formats, finest first.
    pub const ALL: [Self; 3] = [Self::D32, Self::F32, Self::D24];

    /// The stored word of a depth code.
    #[inline]
    #[must_use]
    pub fn encode(self, code: u32) -> u32 {
        match self {
            Self::D32 => code,
            Self::D24 => code >> 8,
            Self::F32 => (code as f32).to_bits(),
        }
    }

    /// The stored words of depth codes, in their place.
    #[inline]
    pub fn encode_all(self, codes: &mut [u32]) {
        match self {
            Self::D32 => {}
            Self::D24 => codes.iter_mut().for_each(|code| *code = Self::D24.encode(*code)),
            Self::F32 => codes.iter_mut().for_each(|code| *code = Self::F32.encode(*code)),
        }
    }

    /// Bits of the stored word that can differ.
    #[must_use]
    pub fn bits(self) -> u32 {
        match self {
            Self::D32 | Self::F32 => 32,
            Self::D24 => 24,
        }
    }

    /// The depth, 0..1, of a stored word: in the middle of the codes that have it, where there are several. It keeps
    /// the order of words.
    #[inline]
    #[must_use]
    pub fn decode(self, word: u32) -> f64 {
        let code = match self {
            Self::D32 => f64::from(word),
            Self::D24 => f64::from(word) * 256.0 + 127.5,
            Self::F32 => f64::from(f32::from_bits(word)),
        };
        (code / f64::from(u32::MAX)).min(1.0)
    }

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::D32 => "d32",
            Self::D24 => "d24",
            Self::F32 => "f32",
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LIMIT: f64 = 2_251_799_813_685_248.0;

    proptest! {
        #[test]
        fn is_that_of_the_standard_library(v in -LIMIT..LIMIT, whole in -1_000i32..1_000) {
            let halves = f64::from(whole) * 0.5;
            for v in [v, v / 3e9, halves, halves + f64::EPSILON, LIMIT, -LIMIT, LIMIT - 0.5] {
                prop_assert!(round_ties_even(v) == v.round_ties_even(), "{v}");
            }
        }
    }

    #[test]
    fn keeps_what_is_not_a_number() {
        assert!(round_ties_even(f64::NAN).is_nan());
    }

    #[test]
    fn codes_round_half_to_even_and_leave_empty_free() {
        assert_eq!(code(0.0), 0);
        assert_eq!(code(1.0), FARTHEST);
        assert_eq!(code(0.5), 1 << 31, "2^31 - 0.5 is a tie, and 2^31 is even");
        assert_eq!(code(-3.0), 0);
        assert_eq!(code(7.0), FARTHEST);
    }

    #[test]
    fn formats_keep_the_order_and_are_never_empty() {
        let codes = [0, 1, 255, 256, 1 << 24, (1 << 24) + 1, 1 << 31, FARTHEST - 1, FARTHEST];
        for format in Format::ALL {
            let stored = codes.map(|c| format.encode(c));
            assert!(stored.is_sorted(), "{format:?}: {stored:?}");
            let mut together = codes;
            format.encode_all(&mut together);
            assert_eq!(together, stored);
            assert!(stored.iter().all(|&s| s != EMPTY));
        }
    }

    #[test]
    fn decoding_is_within_half_a_step() {
        let codes = [0, 1, 255, 256, 1 << 24, (1 << 24) + 1, 1 << 31, FARTHEST - 1, FARTHEST];
        for (format, step) in [(Format::D32, 0.0), (Format::D24, 128.0), (Format::F32, 128.0)] {
            let depths = codes.map(|code| format.decode(format.encode(code)));
            assert!(depths.is_sorted() && depths[8] <= 1.0, "{format:?}: {depths:?}");
            for (code, depth) in codes.into_iter().zip(depths) {
                let apart = (depth * f64::from(u32::MAX) - f64::from(code)).abs();
                assert!(apart <= step + 1e-3, "{format:?} {code}: {apart}");
            }
        }
    }
}
