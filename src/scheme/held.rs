//! What a pixel holds after resolve: a list of fragments, a list of merged records, or a colour or a depth and no list.

use std::cmp::Ordering;

use super::record::{Record, compared_by_bits};
use super::records::Records;
use crate::num::ray::Ray;

/// Fragments as keys (depth in the upper half, data in the lower), in any order.
pub type Keys = Vec<u64>;

/// A pixel's colour, where no list is left. Two are equal if their bits are.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Red, green and blue that reach the eye, linear, 0 to 1.
    pub color: [f64; 3],
    /// The share of the background's light that passes, 0 to 1.
    pub transmittance: f64,
    /// Fragments that were stored one by one until resolve: those that no store invocation has reported as gone.
    pub kept: u32,
}

impl Default for Light {
    fn default() -> Self {
        Self { color: [0.0; 3], transmittance: 1.0, kept: 0 }
    }
}

/// A pixel's depth word, where that is all it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Depth(pub u32);

impl Default for Depth {
    /// Farther than any fragment.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

/// All light of a ray.
const ALL: f64 = 65_535.0;

impl Ray {
    /// The colour and transmittance so far.
    #[must_use]
    pub fn light(&self) -> Light {
        let color = self.color.map(|c| f64::from(c) / ALL);
        Light { color, transmittance: f64::from(self.transmittance) / ALL, kept: 0 }
    }
}

impl Light {
    fn bits(&self) -> [u64; 5] {
        let [r, g, b] = self.color.map(f64::to_bits);
        [r, g, b, self.transmittance.to_bits(), self.kept.into()]
    }

    fn order(&self, other: &Self) -> Ordering {
        self.bits().cmp(&other.bits())
    }
}

compared_by_bits! { Light }

/// What a pixel holds after resolve, of whichever kind its scheme gives.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Held {
    /// Fragments.
    Keys(Keys),
    /// Merged records.
    Records(Records),
    /// A colour.
    Light(Light),
    /// A depth.
    Depth(Depth),
}

/// Which of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeldKind {
    /// A list of fragments.
    Fragments,
    /// A list of merged records.
    Records,
    /// A colour with a transmittance, and no list.
    Color,
    /// A depth, and no list.
    Depth,
}

impl HeldKind {
    /// Nothing yet, of this kind.
    #[must_use]
    pub fn empty(self) -> Held {
        match self {
            Self::Fragments => Held::Keys(Keys::new()),
            Self::Records => Held::Records(Records::default()),
            Self::Color => Held::Light(Light::default()),
            Self::Depth => Held::Depth(Depth::default()),
        }
    }

    /// It is a list.
    #[must_use]
    pub fn is_list(self) -> bool {
        matches!(self, Self::Fragments | Self::Records)
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fragments => "lists of fragments",
            Self::Records => "lists of merged records",
            Self::Color => "colours and no lists",
            Self::Depth => "depths and no lists",
        }
    }
}

/// What a scheme's resolve gives: [`Keys`], [`Records`], [`Light`] or [`Depth`].
pub trait Holds: Default + Send {
    /// Its kind.
    const KIND: HeldKind;

    /// The value of this type in `held`, which is made empty if it is of another kind.
    fn of(held: &mut Held) -> &mut Self;

    /// With its kind.
    fn into_held(self) -> Held;

    /// How many entries it has, if it is a list.
    fn entries(&self) -> usize;

    /// Fragments that resolve merged into others.
    fn merged(&self) -> u32;
}

macro_rules! holds {
    ($($type:ty: $variant:ident, $kind:ident, $entries:expr, $merged:expr;)*) => {$(
        impl Holds for $type {
            const KIND: HeldKind = HeldKind::$kind;

            #[inline]
            fn of(held: &mut Held) -> &mut Self {
                if !matches!(held, Held::$variant(_)) {
                    *held = HeldKind::$kind.empty();
                }
                match held {
                    Held::$variant(own) => own,
                    _ => unreachable!("it was just made so"),
                }
            }

            fn into_held(self) -> Held {
                Held::$variant(self)
            }

            #[inline]
            fn entries(&self) -> usize {
                let entries: fn(&Self) -> usize = $entries;
                entries(self)
            }

            #[inline]
            fn merged(&self) -> u32 {
                let merged: fn(&Self) -> u32 = $merged;
                merged(self)
            }
        }
    )*};
}

holds! {
    Keys: Keys, Fragments, Vec::len, |_| 0;
    Records: Records, Records, Records::len, |records| records.merged;
    Light: Light, Color, |_| 0, |_| 0;
    Depth: Depth, Depth, |_| 0, |_| 0;
}

impl Held {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> HeldKind {
        match self {
            Self::Keys(_) => HeldKind::Fragments,
            Self::Records(_) => HeldKind::Records,
            Self::Light(_) => HeldKind::Color,
            Self::Depth(_) => HeldKind::Depth,
        }
    }

    /// Forget what it holds, and keep its capacity.
    #[inline]
    pub fn clear(&mut self) {
        match self {
            Self::Keys(keys) => keys.clear(),
            Self::Records(records) => records.clear(),
            Self::Light(light) => *light = Light::default(),
            Self::Depth(depth) => *depth = Depth::default(),
        }
    }

    /// Add what another resolve of the same pixel gave, in a program of several rounds. A colour or a depth is the last
    /// one.
    pub fn append(&mut self, other: Self) {
        match (self, other) {
            (Self::Keys(keys), Self::Keys(mut more)) if keys.is_empty() => {
                std::mem::swap(keys, &mut more);
            }
            (Self::Keys(keys), Self::Keys(mut more)) => keys.append(&mut more),
            (Self::Records(records), Self::Records(more)) => records.append(&more),
            (own, other) => *own = other,
        }
    }

    /// Whether it changes nothing that it is appended to: an empty list.
    #[must_use]
    pub fn adds_nothing(&self) -> bool {
        match self {
            Self::Keys(keys) => keys.is_empty(),
            Self::Records(records) => records.is_empty() && records.merged == 0,
            Self::Light(_) | Self::Depth(_) => false,
        }
    }

    /// Put it into canonical order.
    pub fn sort(&mut self) {
        match self {
            Self::Keys(keys) => keys.sort_unstable(),
            Self::Records(records) => records.sort(),
            Self::Light(_) | Self::Depth(_) => {}
        }
    }

    /// Fragments and records that it holds one by one.
    #[inline]
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Keys(keys) => keys.len(),
            Self::Records(records) => records.len(),
            Self::Light(light) => light.kept as usize,
            Self::Depth(_) => 0,
        }
    }

    /// It holds nothing one by one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Fragments that resolve merged into others.
    #[inline]
    #[must_use]
    pub fn merged(&self) -> u32 {
        match self {
            Self::Records(records) => records.merged,
            Self::Keys(_) | Self::Light(_) | Self::Depth(_) => 0,
        }
    }

    /// Its fragments, if it is a list of them.
    #[must_use]
    pub fn keys(&self) -> Option<&[u64]> {
        match self {
            Self::Keys(keys) => Some(keys),
            Self::Records(_) | Self::Light(_) | Self::Depth(_) => None,
        }
    }
}

impl std::fmt::Display for Held {
    /// Entries as depth/data, hexadecimal; of records, the thickness and weight besides.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let entries: Vec<String> = match self {
            Self::Keys(keys) => {
                keys.iter().map(|&key| format!("{:x}/{:x}", key >> 32, key as u32)).collect()
            }
            Self::Records(records) => {
                let entry = |r: &Record| {
                    format!(
                        "{:x}/{:x} thick {} weight {}",
                        r.depth,
                        r.color(),
                        r.thickness,
                        r.weight
                    )
                };
                records.spelt_out().map(|record| entry(&record)).collect()
            }
            Self::Light(Light { color: [r, g, b], transmittance, .. }) => {
                return write!(f, "colour {r} {g} {b}, transmittance {transmittance}");
            }
            Self::Depth(Depth(u32::MAX)) => return f.write_str("no depth"),
            Self::Depth(Depth(depth)) => return write!(f, "depth {depth:x}"),
        };
        write!(f, "[{}]", entries.join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fragment::key;

    #[test]
    fn a_value_of_another_kind_is_replaced() {
        let mut held = HeldKind::Color.empty();
        Keys::of(&mut held).push(key(3, 4));
        assert_eq!(held, Held::Keys(vec![key(3, 4)]));
        assert_eq!((held.kind(), held.len()), (HeldKind::Fragments, 1));
        held.clear();
        assert!(held.is_empty());
    }

    #[test]
    fn equality_is_of_bits() {
        let light = |color| Light { color: [color; 3], ..Light::default() };
        assert_ne!(light(0.0), light(-0.0));
        assert_eq!(light(f64::NAN), light(f64::NAN));
    }

    #[test]
    fn rounds_add_up() {
        let mut held = HeldKind::Records.empty();
        let one = || Records::of(vec![Record::default()], 2);
        held.append(one().into_held());
        held.append(one().into_held());
        assert_eq!((held.len(), held.merged()), (2, 4));
        assert_eq!(held.to_string(), "[0/0 thick 0 weight 0 0/0 thick 0 weight 0]");
    }
}
