//! Colour words, the two conversions every image goes through, and the way back from sRGB.
//!
//! * A *data word* is linear, straight-alpha RGBA8 with R in the low byte.
//! * Real colour in 0..1 becomes 8 bits by `floor(clamp(c) * 255 + 0.5)`.
//! * A linear 16-bit channel becomes an sRGB byte by a table of 65,536 entries, computed once with the
//!   `libm` crate: the byte nearest to the sRGB transfer function (IEC 61966-2-1), halves up. Another such table gives
//!   the nearest 16-bit value.

use std::sync::LazyLock;

/// `c` clamped to 0..1 and rounded to 8 bits, halves up. NaN gives 0.
#[must_use]
pub fn byte(c: f32) -> u8 {
    (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// `c` clamped to 0..1 and rounded to 16 bits, halves up. NaN gives 0.
#[must_use]
pub fn word16(c: f32) -> u16 {
    (f64::from(c.clamp(0.0, 1.0)) * 65_535.0 + 0.5) as u16
}

/// The data word of a linear colour and opacity, each 0..1.
#[must_use]
pub fn rgba8(rgb: [f32; 3], alpha: f32) -> u32 {
    u32::from_le_bytes([byte(rgb[0]), byte(rgb[1]), byte(rgb[2]), byte(alpha)])
}

/// The sRGB byte of a linear 16-bit channel.
#[inline]
#[must_use]
pub fn srgb(linear: u16) -> u8 {
    srgb_table()[usize::from(linear)]
}

/// [`srgb`] of every channel, for loops: to ask whether the table is there costs more than to look something up in it.
#[inline]
#[must_use]
pub fn srgb_table() -> &'static [u8; 65_536] {
    &SRGB
}

/// The 16-bit sRGB value of a linear 16-bit channel.
#[must_use]
pub fn srgb16(linear: u16) -> u16 {
    SRGB16[usize::from(linear)]
}

/// From sRGB to linear, both 0..1 (IEC 61966-2-1).
#[must_use]
pub fn linear(c: f64) -> f64 {
    if c <= 0.040_45 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

/// The linear value of an sRGB byte, 0..1, from a table.
#[must_use]
pub fn linear_of(byte: u8) -> f64 {
    LINEAR[usize::from(byte)]
}

static LINEAR: LazyLock<[f64; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f64 / 255.0)));

static SRGB: LazyLock<[u8; 65_536]> =
    LazyLock::new(|| std::array::from_fn(|c| (encoded(c as u16) * 255.0 + 0.5) as u8));

static SRGB16: LazyLock<Vec<u16>> =
    LazyLock::new(|| (0..=u16::MAX).map(|c| (encoded(c) * 65_535.0 + 0.5) as u16).collect());

/// From linear to sRGB.
fn encoded(linear: u16) -> f64 {
    encode(f64::from(linear) / 65_535.0)
}

/// From linear to sRGB, both 0..1 (IEC 61966-2-1).
#[must_use]
pub fn encode(c: f64) -> f64 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_round_halves_up_and_clamp() {
        assert_eq!(
            [byte(-1.0), byte(0.0), byte(0.5), byte(1.0), byte(2.0), byte(f32::NAN)],
            [0, 0, 128, 255, 255, 0]
        );
    }

    #[test]
    fn srgb_is_monotone_and_hits_its_ends() {
        assert_eq!((srgb(0), srgb(u16::MAX)), (0, 255));
        assert!((1..=u16::MAX).all(|c| srgb(c - 1) <= srgb(c)));
        let there_and_back = |byte: u8| srgb((linear_of(byte) * 65_535.0 + 0.5) as u16);
        assert!((64..=255).all(|byte| there_and_back(byte) == byte));
        assert_eq!((srgb(14_027), srgb(14_028)), (127, 128), "sRGB 0.5 is linear 0.214041");
    }

    #[test]
    fn sixteen_bits_round_to_the_same_byte_or_the_next() {
        assert_eq!((srgb16(0), srgb16(u16::MAX)), (0, u16::MAX));
        assert_eq!([1, 205, 14_027].map(srgb16), [13, 2_649, 32_767], "12.92 c, and the curve");
        assert!((1..=u16::MAX).all(|c| srgb16(c - 1) <= srgb16(c)));
        for c in 0..=u16::MAX {
            let rounded = (u32::from(srgb16(c)) + 128) / 257;
            assert!(rounded.abs_diff(srgb(c).into()) <= 1, "{c}");
        }
    }
}
