//! Merged records: what one fragment, or several, contribute along the ray.

use std::cmp::Ordering;

use crate::fragment::{data_of, depth_of};
use crate::num::planes::Distances;

/// What one fragment, or several merged ones, contribute along the ray. Two are equal if their bits are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Record {
    /// The depth word of its far end, in the run's format.
    pub depth: u32,
    /// How far it reaches from there towards the eye, in world units; 0 for a surface.
    pub thickness: f64,
    /// Red, green and blue, linear and multiplied by the opacity, and the opacity: all 0 to 1.
    pub rgba: [f64; 4],
    /// How many fragments it stands for; of a fragment that was divided, its share.
    pub weight: f64,
}

/// A record of one fragment of any thickness, in few bytes; in the canonical order of their records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Whole {
    /// The depth of its far end, and its colour word.
    pub key: u64,
    /// The depth word of its near end, at most that of its far end.
    pub near: u32,
}

/// How depth words stand for distances, for records that keep their ends as depth words. It is the same for all records
/// of a run, so that no comparison looks at it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scale(pub Distances);

/// A record of one fragment, in few bytes: its key with the colour word, and its near end if it may be thick.
pub trait Single: Copy + Ord {
    /// It may be thick.
    const THICK: bool;

    /// Its depth and colour word.
    fn key(self) -> u64;

    /// The depth word of its near end.
    fn near(self) -> u32;

    /// Spelt out.
    #[inline]
    fn record(self, scale: Scale) -> Record {
        let thickness = scale.between(self.near(), depth_of(self.key()));
        Record { thickness, ..Record::of_key(self.key()) }
    }
}

impl Whole {
    /// One fragment that is a surface: a key with a colour word.
    #[inline]
    #[must_use]
    pub fn surface(key: u64) -> Self {
        Self { key, near: depth_of(key) }
    }
}

impl PartialOrd for Whole {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Whole {
    /// What cannot be seen has no colour; what is nearer at its near end is thicker.
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        let seen = |key: u64| Some(data_of(key)).filter(|word| word >> 24 != 0);
        let rest = || {
            let colors = seen(self.key).cmp(&seen(other.key));
            let nears = || other.near.cmp(&self.near).then_with(|| self.key.cmp(&other.key));
            colors.then_with(nears)
        };
        depth_of(self.key).cmp(&depth_of(other.key)).then_with(rest)
    }
}

impl Scale {
    /// World units from a near end to a far end, both depth words.
    #[inline]
    #[must_use]
    pub fn between(self, near: u32, depth: u32) -> f64 {
        if near < depth { self.0.along(depth) - self.0.along(near) } else { 0.0 }
    }
}

impl PartialEq for Scale {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Scale {}

impl PartialOrd for Scale {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Scale {
    fn cmp(&self, _: &Self) -> Ordering {
        Ordering::Equal
    }
}

impl std::hash::Hash for Scale {
    fn hash<H: std::hash::Hasher>(&self, _: &mut H) {}
}

impl Single for Whole {
    const THICK: bool = true;

    #[inline]
    fn key(self) -> u64 {
        self.key
    }

    #[inline]
    fn near(self) -> u32 {
        self.near
    }
}

/// A surface.
impl Single for u64 {
    const THICK: bool = false;

    #[inline]
    fn key(self) -> u64 {
        self
    }

    #[inline]
    fn near(self) -> u32 {
        depth_of(self)
    }
}

impl Record {
    fn bits(&self) -> [u64; 7] {
        let [r, g, b, a] = self.rgba.map(f64::to_bits);
        [self.depth.into(), self.thickness.to_bits(), r, g, b, a, self.weight.to_bits()]
    }

    /// By depth. Surfaces of one depth have the canonical order of their fragments: by colour word.
    #[inline]
    fn order(&self, other: &Self) -> Ordering {
        self.depth.cmp(&other.depth).then_with(|| {
            self.color().cmp(&other.color()).then_with(|| self.bits().cmp(&other.bits()))
        })
    }

    /// One fragment as a surface: a stored depth and a colour word (RGBA8).
    #[inline]
    #[must_use]
    pub fn surface(depth: u32, color: u32) -> Self {
        let [r, g, b, a] = color.to_le_bytes();
        let alpha = f64::from(a);
        let premultiplied = |c: u8| alpha * f64::from(c) / 65_025.0;
        let rgba = [premultiplied(r), premultiplied(g), premultiplied(b), alpha / 255.0];
        Self { depth, thickness: 0.0, rgba, weight: 1.0 }
    }

    /// One fragment as a surface: a key with a colour word.
    #[inline]
    #[must_use]
    pub fn of_key(key: u64) -> Self {
        Self::surface(depth_of(key), data_of(key))
    }

    /// Its colour as a straight-alpha RGBA8 word, rounded.
    #[must_use]
    pub fn color(&self) -> u32 {
        let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        let [r, g, b, a] = self.rgba;
        let straight = |c: f64| if a > 0.0 { byte(c / a) } else { 0 };
        u32::from_le_bytes([straight(r), straight(g), straight(b), byte(a)])
    }
}

/// Two values are equal, and in order, by what their `bits` and `order` say.
macro_rules! compared_by_bits {
    ($($type:ty)*) => {$(
        impl PartialEq for $type {
            fn eq(&self, other: &Self) -> bool {
                self.bits() == other.bits()
            }
        }

        impl Eq for $type {}

        impl PartialOrd for $type {
            fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
                Some(self.cmp(other))
            }
        }

        impl Ord for $type {
            fn cmp(&self, other: &Self) -> Ordering {
                self.order(other)
            }
        }

        impl std::hash::Hash for $type {
            fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
                self.bits().hash(state);
            }
        }
    )*};
}

pub(super) use compared_by_bits;

compared_by_bits! { Record }

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_word_comes_back_from_a_surface() {
        for word in [0xFF01_80FF, 0x8000_FF01, 0x01FF_FFFF, 0x0000_0000, 0xFFFF_FFFF] {
            assert_eq!(Record::surface(7, word).color(), word, "{word:x}");
        }
    }
}
