//! What a record that merges on arrival holds: the mix operator (section 3.3.2, equations 6 to 8) as sums.
//!
//! Three 64-bit words of two halves each, so that they can be written as six words. The upper half of the last counts
//! fragments, for the accounting. [`Integers`] do not depend on the order in which fragments come in:
//!
//! ```text
//! [ Σ a r | Σ a g ]  [ Σ a b | Σ a ]  [ Σ -log2(1 - α) | fragments ]
//! ```
//!
//! a, r, g, b are bytes and α = a / 255. Σ a c is exact up to 66,051 opaque white fragments, Σ a up to 16,843,009. The
//! logarithm has 24 bits after the point; of α = 1 it is taken as 17, which lets less light through than 16 bits of
//! transmittance can show. Every sum stops at its largest value instead of wrapping, which no order can change either.
//! Each logarithm is at most 2^-25 off, so that after n fragments 1 - A is right to the factor 2^(n 2^-25): 1.3e-6 of it
//! for 64 fragments. A record of one fragment is that fragment, exactly.

/// The words of a record's visibility.
pub type Sums = [u64; 3];

/// -log2(1 - α) of every opacity byte.
pub type Logarithms = [u32; 256];

/// Bits after the point of a logarithm.
const POINT: u32 = 24;

/// The logarithm of opacity 1.
const OPAQUE: f64 = 17.0;

/// By opacity byte a, what a sum of one fragment is multiplied by to divide it by a, above 24 bits: the sum is a times a
/// byte c, and the scale at most 1 above 2^24 / a, so that the product is c 2^24 and at most 65,025.
const SCALES: [u32; 256] = {
    let mut scales = [0; 256];
    let mut a = 1;
    while a < 256 {
        scales[a] = (1 << 24) / a as u32 + 1;
        a += 1;
    }
    scales
};

/// The table that [`Integers`] add from.
#[must_use]
pub fn logarithms() -> Box<Logarithms> {
    let scale = f64::from(1 << POINT);
    let of = |a: usize| match a {
        255 => OPAQUE * scale,
        a => libm::round(-libm::log2((255 - a) as f64 / 255.0) * scale),
    };
    Box::new(std::array::from_fn(|a| of(a) as u32))
}

/// How a record is kept.
pub trait Mix: Send + Sync + 'static {
    /// One fragment, by its colour word.
    fn one(data: u32, logarithms: &Logarithms) -> Sums;

    /// Two records, or a record and a fragment, as one.
    fn mix(stored: Sums, new: Sums) -> Sums;

    /// Premultiplied colour and opacity.
    fn rgba(sums: Sums) -> [f64; 4];

    /// The colour word of a record of one fragment, to tell what is farther at equal depth; of others, all ones.
    fn word(sums: Sums) -> u32;

    /// The colour word of a record of one fragment, if [`Self::rgba`] is that colour to the last bit.
    fn exact(_: Sums) -> Option<u32> {
        None
    }

    /// The last word as it is kept in memory: with the colour word, if that tells the other words.
    fn kept(sums: Sums) -> u64 {
        Self::exact(sums).map_or(sums[2], |word| pair(word, 1))
    }

    /// The same of one fragment, by its colour word, if that word is all that is kept of it.
    fn kept_single(_: u32) -> Option<u64> {
        None
    }

    /// The colour word, if the last word as it is kept is of one fragment and tells it.
    fn single(_: u64) -> Option<u32> {
        None
    }
}

/// The fragments that a record stands for.
#[inline]
#[must_use]
pub fn weight(sums: Sums) -> u32 {
    high(sums[2])
}

#[inline]
fn low(word: u64) -> u32 {
    word as u32
}

#[inline]
fn high(word: u64) -> u32 {
    (word >> 32) as u32
}

#[inline]
fn pair(low: u32, high: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

/// Both halves on their own, up to their largest value.
#[inline]
fn add(a: u64, b: u64) -> u64 {
    pair(low(a).saturating_add(low(b)), high(a).saturating_add(high(b)))
}

/// The fragments of both, above another half.
fn counted(half: u32, stored: Sums, new: Sums) -> u64 {
    pair(half, weight(stored).saturating_add(weight(new)))
}

/// Integer sums.
#[derive(Debug)]
pub struct Integers;

impl Mix for Integers {
    #[inline]
    fn one(data: u32, logarithms: &Logarithms) -> Sums {
        let (a, rest) = (data >> 24, data & 0xFF_FFFF);
        let (r, g, b) = (rest & 0xFF, rest >> 8 & 0xFF, rest >> 16);
        [pair(a * r, a * g), pair(a * b, a), pair(logarithms[a as usize], 1)]
    }

    #[inline]
    fn mix(stored: Sums, new: Sums) -> Sums {
        [add(stored[0], new[0]), add(stored[1], new[1]), add(stored[2], new[2])]
    }

    #[inline]
    fn rgba([rg, ba, log]: Sums) -> [f64; 4] {
        let (r, g, b) = (f64::from(low(rg)), f64::from(high(rg)), f64::from(low(ba)));
        let alphas = f64::from(high(ba));
        if high(log) == 1 {
            return [r / 65_025.0, g / 65_025.0, b / 65_025.0, alphas / 255.0];
        }
        mixed([r, g, b], alphas, low(log))
    }

    #[inline]
    fn word(sums: Sums) -> u32 {
        Self::exact(sums).unwrap_or(u32::MAX)
    }

    #[inline]
    fn kept_single(data: u32) -> Option<u64> {
        // What cannot be seen has no colour, as in the sums.
        Some(pair(if data >> 24 == 0 { 0 } else { data }, 1))
    }

    #[inline]
    fn single(last: u64) -> Option<u32> {
        (high(last) == 1).then_some(low(last))
    }

    #[inline]
    fn exact([rg, ba, log]: Sums) -> Option<u32> {
        if high(log) != 1 {
            return None;
        }
        let a = high(ba);
        let scale = u64::from(SCALES[a as u8 as usize]);
        let byte = |sum: u32| ((u64::from(sum) * scale) >> 24) as u8;
        Some(u32::from_le_bytes([byte(low(rg)), byte(high(rg)), byte(low(ba)), a as u8]))
    }
}

/// The colour and opacity of several fragments, from their sums (equations 6 and 7).
#[inline(never)]
fn mixed(colors: [f64; 3], alphas: f64, log: u32) -> [f64; 4] {
    if alphas == 0.0 {
        return [0.0; 4];
    }
    let through = libm::exp2(-f64::from(log) / f64::from(1 << POINT));
    let opacity = 1.0 - through;
    let [r, g, b] = colors.map(|c| c / (255.0 * alphas) * opacity);
    [r, g, b, opacity]
}

/// The recurrence (8) in single precision, as published: colour and opacity, and the sum of opacities.
#[derive(Debug)]
pub struct Floats;

/// A visibility in single precision, with its sum of opacities.
fn floats([rg, ba, sum]: Sums) -> ([f32; 3], f32, f32) {
    let of = f32::from_bits;
    ([of(low(rg)), of(high(rg)), of(low(ba))], of(high(ba)), of(low(sum)))
}

/// Equation (8); where the new one is a record, by its own sum of opacities.
fn recurrence(
    (stored, a, a_sum): ([f32; 3], f32, f32),
    (new, b, b_sum): ([f32; 3], f32, f32),
) -> ([f32; 3], f32, f32) {
    let opacity = 1.0 - (1.0 - a) * (1.0 - b);
    let sum = a_sum + b_sum;
    if sum <= 0.0 {
        return ([0.0; 3], opacity, sum);
    }
    let part = |c: f32, opacity: f32, sum: f32| if opacity > 0.0 { c / opacity * sum } else { 0.0 };
    let color = |i: usize| (part(stored[i], a, a_sum) + part(new[i], b, b_sum)) / sum * opacity;
    ([color(0), color(1), color(2)], opacity, sum)
}

impl Mix for Floats {
    fn one(data: u32, _: &Logarithms) -> Sums {
        let [r, g, b, a] = data.to_le_bytes().map(f32::from);
        let opacity = a / 255.0;
        let bits = |c: f32| (c / 255.0 * opacity).to_bits();
        let sum = pair(opacity.to_bits(), 1);
        [pair(bits(r), bits(g)), pair(bits(b), opacity.to_bits()), sum]
    }

    fn mix(stored: Sums, new: Sums) -> Sums {
        let ([r, g, b], a, sum) = recurrence(floats(stored), floats(new));
        let bits = f32::to_bits;
        [pair(bits(r), bits(g)), pair(bits(b), bits(a)), counted(bits(sum), stored, new)]
    }

    fn rgba(sums: Sums) -> [f64; 4] {
        let ([r, g, b], a, _) = floats(sums);
        [r, g, b, a].map(f64::from)
    }

    fn word(sums: Sums) -> u32 {
        low(sums[0])
    }
}

/// The same with colour and opacity stored as four bytes, as the authors' shaders do.
#[derive(Debug)]
pub struct Bytes;

fn unpacked([rgba, _, sum]: Sums) -> ([f32; 3], f32, f32) {
    let [r, g, b, a] = low(rgba).to_le_bytes().map(|byte| f32::from(byte) / 255.0);
    ([r, g, b], a, f32::from_bits(low(sum)))
}

fn packed(color: [f32; 3], opacity: f32) -> u64 {
    let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let [r, g, b] = color.map(byte);
    u64::from(u32::from_le_bytes([r, g, b, byte(opacity)]))
}

impl Mix for Bytes {
    fn one(data: u32, _: &Logarithms) -> Sums {
        let [r, g, b, a] = data.to_le_bytes().map(|byte| f32::from(byte) / 255.0);
        [packed([r * a, g * a, b * a], a), 0, pair(a.to_bits(), 1)]
    }

    fn mix(stored: Sums, new: Sums) -> Sums {
        let (color, opacity, sum) = recurrence(unpacked(stored), unpacked(new));
        [packed(color, opacity), 0, counted(sum.to_bits(), stored, new)]
    }

    fn rgba(sums: Sums) -> [f64; 4] {
        let ([r, g, b], a, _) = unpacked(sums);
        [r, g, b, a].map(f64::from)
    }

    fn word(sums: Sums) -> u32 {
        low(sums[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_of_one_fragment_is_that_fragment() {
        let logarithms = logarithms();
        for (a, c) in (0..=255u8).flat_map(|a| (0..=255u8).map(move |c| (a, c))) {
            let data = u32::from_le_bytes([c, 255 - c, c / 2, a]);
            let sums = Integers::one(data, &logarithms);
            let word = if a > 0 { data } else { 0 };
            assert_eq!(Integers::exact(sums), Some(word), "{data:x}");
            assert_eq!(Integers::exact(Integers::mix(sums, sums)), None);
            assert_eq!(Integers::kept_single(data), Some(Integers::kept(sums)));
            assert_eq!(Integers::single(Integers::kept(sums)), Some(word));
            assert_eq!(Integers::one(word, &logarithms), sums);
        }
    }
}
