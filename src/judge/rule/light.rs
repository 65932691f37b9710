//! From a pixel's fragments in their order to the bytes of the picture.

use std::sync::LazyLock;

use crate::num::color::{byte, encode, linear, srgb};

/// How fragments are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::judge) enum Blending {
    /// Over, in linear light.
    #[default]
    Right,
    /// Over, in the numbers of sRGB.
    Encoded,
    /// Over, with colours that are not multiplied by their opacity.
    Unmultiplied {
        /// Light above full is cut off after every fragment, and not only at the end.
        cut: bool,
    },
    /// Over, with colours that are multiplied by their opacity twice.
    Twice,
    /// The sum of all.
    Added,
    /// Their weighted average, as opaque as so many fragments of average opacity.
    Average,
    /// Their weighted average, as opaque as all are together.
    AverageCovered,
    /// The nearest is opaque.
    Off,
    /// Over, into a target of 8 bits, from back to front.
    Bytes {
        /// It holds sRGB, and not linear light.
        encoded: bool,
    },
}

/// What is behind all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::judge) enum Background {
    /// The scene's.
    #[default]
    Right,
    /// No light.
    Black,
    /// Full light.
    White,
    /// The scene's, encoded as sRGB once too often.
    Encoded,
    /// The scene's, taken for sRGB.
    Decoded,
}

/// How light becomes bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::judge) enum Encoding {
    /// As sRGB.
    #[default]
    Right,
    /// Not at all.
    None,
    /// As sRGB, twice.
    Twice,
    /// By a power of 1/2.2.
    Power,
    /// As sRGB, with red and blue exchanged.
    Swapped,
}

/// sRGB numbers of linear bytes.
static ENCODED: LazyLock<[f64; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| encode(byte as f64 / 255.0)));

/// Bytes of a power of 1/2.2, of linear light in 16 bits.
static POWER: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let of = |c: u16| libm::pow(f64::from(c) / 65_535.0, 1.0 / 2.2) * 255.0 + 0.5;
    (0..=u16::MAX).map(|c| of(c) as u8).collect()
});

fn word(light: f64) -> u16 {
    (light.clamp(0.0, 1.0) * 65_535.0 + 0.5) as u16
}

/// A fragment's colour and opacity as parts of 1.
fn parts(color: u32) -> ([f64; 3], f64) {
    let [r, g, b, a] = color.to_le_bytes().map(|byte| f64::from(byte) / 255.0);
    ([r, g, b], a)
}

impl Background {
    /// Linear light.
    pub(in crate::judge) fn of(self, scene: [f32; 3]) -> [f64; 3] {
        scene.map(|c| {
            let c = f64::from(c);
            match self {
                Self::Right => c,
                Self::Black => 0.0,
                Self::White => 1.0,
                Self::Encoded => encode(c),
                Self::Decoded => linear(c),
            }
        })
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Right => "",
            Self::Black => "the background were black",
            Self::White => "the background were white",
            Self::Encoded => "the background were encoded as sRGB twice",
            Self::Decoded => "the background were not encoded as sRGB",
        }
    }
}

impl Blending {
    /// Blend colour words front to back before a background of linear light: linear light, or with
    /// [`Blending::is_encoded`] numbers of sRGB, 0 to 1 or beyond.
    pub(in crate::judge) fn blend(
        self,
        words: impl DoubleEndedIterator<Item = u32> + Clone,
        background: [f64; 3],
    ) -> [f64; 3] {
        match self {
            Self::Right => over(words, background, |c, a| c * a),
            Self::Twice => over(words, background, |c, a| c * a * a),
            Self::Unmultiplied { cut: false } => over(words, background, |c, _| c),
            Self::Unmultiplied { cut: true } => behind(words, background, |light, word| {
                let (color, a) = parts(word);
                let one = |i: usize| (color[i] + light[i] * (1.0 - a)).min(1.0);
                [one(0), one(1), one(2)]
            }),
            Self::Encoded => {
                let (mut sum, mut passes) = ([0.0; 3], 1.0);
                for word in words {
                    let [r, g, b, a] = word.to_le_bytes();
                    let a = f64::from(a) / 255.0;
                    for (sum, c) in sum.iter_mut().zip([r, g, b]) {
                        *sum += passes * a * ENCODED[usize::from(c)];
                    }
                    passes *= 1.0 - a;
                }
                let one = |i: usize| sum[i] + passes * encode(background[i]);
                [one(0), one(1), one(2)]
            }
            Self::Added => words.fold(background, |sum, word| {
                let (color, a) = parts(word);
                let one = |i: usize| sum[i] + a * color[i];
                [one(0), one(1), one(2)]
            }),
            Self::Average | Self::AverageCovered => self.average(words, background),
            Self::Off => words.take(1).fold(background, |_, word| parts(word).0),
            Self::Bytes { encoded: false } => {
                behind(words, bytes(background), |light, word| bytes(mixed(light, word)))
            }
            Self::Bytes { encoded: true } => {
                let start = background.map(|c| f64::from(srgb(word(c))) / 255.0);
                behind(words, start, |stored, word_| {
                    mixed(stored.map(linear), word_).map(|c| f64::from(srgb(word(c))) / 255.0)
                })
            }
        }
    }

    /// What comes out is numbers of sRGB.
    pub(in crate::judge) fn is_encoded(self) -> bool {
        matches!(self, Self::Encoded | Self::Bytes { encoded: true })
    }

    fn average(self, words: impl Iterator<Item = u32>, background: [f64; 3]) -> [f64; 3] {
        let (mut sum, mut weight, mut passes, mut count) = ([0.0; 3], 0.0, 1.0, 0_i32);
        for word in words {
            let (color, a) = parts(word);
            for (sum, c) in sum.iter_mut().zip(color) {
                *sum += a * c;
            }
            weight += a;
            passes *= 1.0 - a;
            count += 1;
        }
        if weight == 0.0 {
            return background;
        }
        if self == Self::Average {
            let mean = 1.0 - weight / f64::from(count);
            passes = (0..count).fold(1.0, |product, _| product * mean);
        }
        let one = |i: usize| sum[i] / weight * (1.0 - passes) + background[i] * passes;
        [one(0), one(1), one(2)]
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Right => "",
            Self::Encoded => "sRGB numbers were blended instead of light",
            Self::Unmultiplied { cut: false } => {
                "straight colours were taken for premultiplied ones"
            }
            Self::Unmultiplied { cut: true } => {
                "straight colours were taken for premultiplied ones, and cut at full light after \
                 each fragment"
            }
            Self::Twice => "colours were multiplied by opacity twice",
            Self::Added => "fragments were added up",
            Self::Average => "fragments were averaged by opacity",
            Self::AverageCovered => "fragments were averaged by opacity, and together as opaque",
            Self::Off => "blending were off",
            Self::Bytes { encoded: false } => {
                "linear light were rounded to 8 bits after each fragment"
            }
            Self::Bytes { encoded: true } => "sRGB were rounded to 8 bits after each fragment",
        }
    }
}

/// Front to back; `weigh` gives what a fragment of a colour and an opacity adds.
fn over(
    words: impl Iterator<Item = u32>,
    background: [f64; 3],
    weigh: impl Fn(f64, f64) -> f64,
) -> [f64; 3] {
    let (mut sum, mut passes) = ([0.0; 3], 1.0);
    for word in words {
        let (color, a) = parts(word);
        for (sum, c) in sum.iter_mut().zip(color) {
            *sum += passes * weigh(c, a);
        }
        passes *= 1.0 - a;
    }
    let one = |i: usize| sum[i] + passes * background[i];
    [one(0), one(1), one(2)]
}

/// Back to front.
fn behind(
    words: impl DoubleEndedIterator<Item = u32>,
    background: [f64; 3],
    blend: impl Fn([f64; 3], u32) -> [f64; 3],
) -> [f64; 3] {
    words.rev().fold(background, blend)
}

fn mixed(light: [f64; 3], word: u32) -> [f64; 3] {
    let (color, a) = parts(word);
    let one = |i: usize| a * color[i] + (1.0 - a) * light[i];
    [one(0), one(1), one(2)]
}

fn bytes(light: [f64; 3]) -> [f64; 3] {
    light.map(|c| f64::from(byte(c as f32)) / 255.0)
}

impl Encoding {
    /// The picture's bytes of linear light, or with `encoded` of numbers of sRGB.
    pub(in crate::judge) fn bytes(self, values: [f64; 3], is_encoded: bool) -> [u8; 3] {
        if is_encoded && matches!(self, Self::Right | Self::Swapped) {
            let [r, g, b] = values.map(|c| byte(c as f32));
            return if self == Self::Right { [r, g, b] } else { [b, g, r] };
        }
        let values = if is_encoded { values.map(|c| linear(c.clamp(0.0, 1.0))) } else { values };
        let [r, g, b] = values.map(|c| match self {
            Self::Right | Self::Swapped => srgb(word(c)),
            Self::None => byte(c as f32),
            Self::Twice => srgb(word(encode(c.clamp(0.0, 1.0)))),
            Self::Power => POWER[usize::from(word(c))],
        });
        if self == Self::Swapped { [b, g, r] } else { [r, g, b] }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Right => "",
            Self::None => "light were not encoded as sRGB",
            Self::Twice => "light were encoded as sRGB twice",
            Self::Power => "light were encoded by a power of 1/2.2 instead of sRGB",
            Self::Swapped => "red and blue were exchanged",
        }
    }
}
