//! What a pixel holds after resolve: a list of fragments, a list of merged records, or a colour or a depth and no list.

use std::cmp::Ordering;

use crate::fragment::{data_of, depth_of};
use crate::num::ray::Ray;

/// Fragments as keys (depth in the upper half, data in the lower), in any order.
pub type Keys = Vec<u64>;

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

/// A record of one fragment of any thickness, in few bytes. Two are equal if their bits are.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    key: u64,
    thickness: f64,
}

/// A record of one fragment, in few bytes: its key with the colour word, and its thickness if it may have one. In their
/// own order, these are in the canonical order of their records.
pub trait Single: Copy + Ord {
    /// It may have a thickness.
    const THICK: bool;

    /// Its depth and colour word.
    fn key(self) -> u64;

    /// As of [`Record`].
    fn thickness(self) -> f64;

    /// Spelt out.
    #[inline]
    fn record(self) -> Record {
        Record { thickness: self.thickness(), ..Record::of_key(self.key()) }
    }
}

/// A pixel's merged records.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Records {
    /// In any order.
    pub list: Vec<Record>,
    /// More of them, in any order: surfaces of one fragment each, as keys with colour words. They are cheaper to sort,
    /// to composite and to keep.
    pub surfaces: Keys,
    /// More of them, in any order: what is one fragment and no surface.
    pub wholes: Vec<Whole>,
    /// Fragments that went into another record during resolve: those that no store invocation has reported as
    /// [`Outcome::Merged`](super::Outcome).
    pub merged: u32,
}

impl Records {
    /// Records of a list alone.
    #[must_use]
    pub fn of(list: Vec<Record>, merged: u32) -> Self {
        Self { list, merged, ..Self::default() }
    }

    /// Let all that are one fragment be of one kind.
    pub fn unite(&mut self) {
        self.wholes.extend(self.surfaces.drain(..).map(|key| Whole::new(key, 0.0)));
    }

    /// Put all of them into the list, in canonical order.
    pub fn sort(&mut self) {
        self.list.extend(self.surfaces.drain(..).map(Single::record));
        self.list.extend(self.wholes.drain(..).map(Single::record));
        self.list.sort_unstable();
    }
}

impl Whole {
    /// One fragment: a key with a colour word, and its thickness.
    #[inline]
    #[must_use]
    pub fn new(key: u64, thickness: f64) -> Self {
        // What cannot be seen has no colour, so that keys compare as records do.
        let color = if data_of(key) >> 24 == 0 { 0 } else { u64::from(u32::MAX) };
        Self { key: key & (u64::from(u32::MAX) << 32 | color), thickness }
    }

    fn bits(&self) -> [u64; 2] {
        [self.key, self.thickness.to_bits()]
    }

    #[inline]
    fn order(&self, other: &Self) -> Ordering {
        self.key.cmp(&other.key).then_with(|| self.bits().cmp(&other.bits()))
    }
}

impl Single for Whole {
    const THICK: bool = true;

    #[inline]
    fn key(self) -> u64 {
        self.key
    }

    #[inline]
    fn thickness(self) -> f64 {
        self.thickness
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
    fn thickness(self) -> f64 {
        0.0
    }
}

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

compared_by_bits! { Record Whole Light }

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
}

macro_rules! holds {
    ($($type:ty: $variant:ident, $kind:ident;)*) => {$(
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
        }
    )*};
}

holds! {
    Keys: Keys, Fragments;
    Records: Records, Records;
    Light: Light, Color;
    Depth: Depth, Depth;
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
            Self::Records(records) => {
                records.list.clear();
                records.surfaces.clear();
                records.wholes.clear();
                records.merged = 0;
            }
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
            (Self::Records(records), Self::Records(mut more)) => {
                records.list.append(&mut more.list);
                records.surfaces.append(&mut more.surfaces);
                records.wholes.append(&mut more.wholes);
                records.merged += more.merged;
            }
            (own, other) => *own = other,
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
            Self::Records(records) => {
                records.list.len() + records.surfaces.len() + records.wholes.len()
            }
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
                let Records { list, surfaces, wholes, .. } = records;
                let surfaces = surfaces.iter().map(|key| entry(&key.record()));
                let wholes = wholes.iter().map(|whole| entry(&whole.record()));
                list.iter().map(entry).chain(surfaces).chain(wholes).collect()
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
    fn a_colour_word_comes_back_from_a_surface() {
        for word in [0xFF01_80FF, 0x8000_FF01, 0x01FF_FFFF, 0x0000_0000, 0xFFFF_FFFF] {
            assert_eq!(Record::surface(7, word).color(), word, "{word:x}");
        }
    }

    #[test]
    fn surfaces_are_records_of_the_list_once_sorted() {
        let (near, far) = (key(3, 0x8000_FF01), key(5, 0xFF01_80FF));
        let list = vec![Record { weight: 2.0, ..Record::surface(4, 0x8000_FF01) }];
        let records = Records { surfaces: vec![far, near], ..Records::of(list.clone(), 1) };
        let mut held = records.into_held();
        assert_eq!(held.len(), 3);
        held.sort();
        let sorted = vec![Record::of_key(near), list[0], Record::of_key(far)];
        assert_eq!(held, Records::of(sorted, 1).into_held());
    }

    /// What has the same key, and what cannot be seen, included.
    #[test]
    fn single_fragments_have_the_order_of_their_records() {
        let words = [0x8000_FF01, 0xFF01_80FF, 0x00FF_0000, 0x0000_00FF, 0];
        let all = [3, 4].into_iter().flat_map(|depth| words.map(|word| key(depth, word)));
        let wholes = all.flat_map(|key| [0.5, 0.0, 0.25].map(|t| Whole::new(key, t)));
        let mut records =
            Records { wholes: wholes.collect(), surfaces: vec![key(3, 255)], ..Records::default() };
        let mut spelt_out = records.clone();
        spelt_out.sort();
        records.unite();
        records.wholes.sort_unstable();
        let found: Vec<Record> = records.wholes.iter().map(|whole| whole.record()).collect();
        assert_eq!((found, spelt_out.wholes.len()), (spelt_out.list, 0));
    }

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
