//! Words by their places: numbered, and looked at from outside.

use super::{At, Kind, Layout, Sizes, Space};
use crate::memory::word::Word;

/// Where a word is, without its type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Address {
    /// The pixel; `None` for the frame.
    pub pixel: Option<u32>,
    /// The word within the record of its width.
    pub word: u64,
    /// 32 or 64.
    pub bits: u32,
}

impl<S: Space, K: Kind, W: Word> At<S, K, W> {
    /// The same place without its type.
    #[inline]
    #[must_use]
    pub fn address(self) -> Address {
        let pixel = (!S::GLOBAL).then_some(self.pixel);
        Address { pixel, word: self.word, bits: W::BITS }
    }
}

/// The words of a few pixels and of the frame, numbered: the frame's first, then pixel by pixel; 32-bit words before
/// 64-bit ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numbering {
    frame: Sizes,
    pixel: Sizes,
    pixels: u32,
}

impl Numbering {
    /// Numbers from here on stand for words that do not exist. There is one for each buffer that an access can miss:
    /// 32 and 64-bit words of the frame, then of pixels.
    const OUTSIDE: u32 = u32::MAX - 3;

    /// The words of a layout for this many pixels.
    #[must_use]
    pub fn new(layout: &Layout, pixels: u32) -> Self {
        Self { frame: layout.per_frame(), pixel: layout.per_pixel(), pixels }
    }

    fn of(sizes: Sizes) -> u64 {
        sizes.words32 + sizes.words64
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        Self::of(self.frame) + Self::of(self.pixel) * u64::from(self.pixels)
    }

    /// The number of a word, or of what is outside of the buffer that it should be in.
    #[must_use]
    pub fn number(&self, address: Address) -> u32 {
        let (record, base) = match address.pixel {
            None => (self.frame, 0),
            Some(pixel) => {
                (self.pixel, Self::of(self.frame) + Self::of(self.pixel) * u64::from(pixel))
            }
        };
        let (first, count) = match address.bits {
            64 => (record.words32, record.words64),
            _ => (0, record.words32),
        };
        let inside = address.word < count && address.pixel.is_none_or(|pixel| pixel < self.pixels);
        if inside {
            return (base + first + address.word) as u32;
        }
        let (pixels, wide) = (address.pixel.is_some(), address.bits == 64);
        Self::OUTSIDE + 2 * u32::from(pixels) + u32::from(wide)
    }

    /// Whether a number stands for a word that does not exist.
    #[inline]
    #[must_use]
    pub fn is_outside(number: u32) -> bool {
        number >= Self::OUTSIDE
    }

    /// The last word of the buffer that an access missed, by the number that it has: a robust device may clamp it to
    /// that. `None` if the buffer has no words.
    #[must_use]
    pub fn end(&self, outside: u32) -> Option<u32> {
        let buffer = outside.checked_sub(Self::OUTSIDE)?;
        let (pixels, wide) = (buffer & 2 != 0, buffer & 1 != 0);
        let record = if pixels { self.pixel } else { self.frame };
        let word = if wide { record.words64 } else { record.words32 }.checked_sub(1)?;
        let pixel = if pixels { Some(self.pixels.checked_sub(1)?) } else { None };
        Some(self.number(Address { pixel, word, bits: if wide { 64 } else { 32 } }))
    }

    /// What a number stands for.
    #[must_use]
    pub fn address(&self, number: u32) -> Address {
        let (frame, record) = (Self::of(self.frame), Self::of(self.pixel).max(1));
        let number = u64::from(number);
        let (pixel, sizes, word) = if number < frame {
            (None, self.frame, number)
        } else {
            let pixel = (number - frame) / record;
            (Some(pixel as u32), self.pixel, (number - frame) % record)
        };
        if word < sizes.words32 {
            Address { pixel, word, bits: 32 }
        } else {
            Address { pixel, word: word - sizes.words32, bits: 64 }
        }
    }
}

/// Words at one moment, to be inspected, not computed with.
pub struct Snapshot<'a> {
    /// A word's value; `None` while nothing has been written to it.
    pub value: &'a dyn Fn(Address) -> Option<u64>,
}

impl Snapshot<'_> {
    /// The word's value; `None` while nothing has been written to it.
    #[must_use]
    pub fn get<S: Space, K: Kind, W: Word>(&self, at: At<S, K, W>) -> Option<W> {
        (self.value)(at.address()).map(W::from_u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::layout::{Atomic, Global, Pixel, Plain, Words};

    #[test]
    fn numbers_and_addresses_are_each_others_inverse() {
        let mut layout = Layout::default();
        let _: Words<Global, Atomic, u32> = layout.global(3);
        let _: Words<Global, Plain, u64> = layout.global(2);
        let _: Words<Pixel, Atomic, u32> = layout.pixel(2);
        let _: Words<Pixel, Plain, u64> = layout.pixel(1);
        let numbering = Numbering::new(&layout, 4);
        assert_eq!(numbering.count(), 5 + 4 * 3);
        for number in 0..numbering.count() as u32 {
            assert_eq!(numbering.number(numbering.address(number)), number);
        }
        let last = |pixel, word, bits| Address { pixel, word, bits };
        for (address, end) in [
            (last(None, 3, 32), last(None, 2, 32)),
            (last(None, 2, 64), last(None, 1, 64)),
            (last(Some(0), 2, 32), last(Some(3), 1, 32)),
            (last(Some(4), 0, 32), last(Some(3), 1, 32)),
            (last(Some(0), 1, 64), last(Some(3), 0, 64)),
        ] {
            let number = numbering.number(address);
            assert!(Numbering::is_outside(number), "{address:?}");
            assert_eq!(numbering.end(number), Some(numbering.number(end)), "{address:?}");
        }
    }

    #[test]
    fn a_buffer_without_words_has_no_end() {
        let mut layout = Layout::default();
        let _: Words<Pixel, Plain, u32> = layout.pixel(1);
        let numbering = Numbering::new(&layout, 1);
        for address in [
            Address { pixel: None, word: 0, bits: 32 },
            Address { pixel: None, word: 0, bits: 64 },
            Address { pixel: Some(0), word: 0, bits: 64 },
        ] {
            let number = numbering.number(address);
            assert!(Numbering::is_outside(number), "{address:?}");
            assert_eq!(numbering.end(number), None, "{address:?}");
        }
        assert_eq!(numbering.end(0), None, "it is inside");
    }
}
