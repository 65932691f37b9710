//! Hypotheses about a whole picture: how it would have been made, if one thing, or two, were not as they should be.
//!
//! A hypothesis is a function from the exact list of a pixel to the bytes of the picture there. It is wrong along one of
//! six axes: where pixels lie, what covers them, which fragments are blended and in which order, by which formula, over
//! which background, and how light is encoded.

pub(super) mod light;
pub(super) mod order;
pub(super) mod place;

use super::answer::{Answer, Entry};
use super::class::Class;
use super::variant::Variant;
use light::{Background, Blending, Encoding};
use order::{Fragments, Scope};
use place::Placement;

/// The most fragments that "the nearest n" and "the first n" are tried with.
const MOST_KEPT: u32 = 128;

/// How a picture may have been made. The default is the right way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Rule {
    /// Where pixels lie.
    pub(super) placement: Placement,
    /// What covers them; none is right.
    pub(super) coverage: Option<Variant>,
    /// Which fragments, in which order.
    pub(super) fragments: Fragments,
    /// By which formula.
    pub(super) blending: Blending,
    /// Over what.
    pub(super) background: Background,
    /// Into which numbers.
    pub(super) encoding: Encoding,
}

impl Rule {
    /// Those that are wrong in one way and need no other coverage, the simplest first.
    pub(super) fn singles(answer: &Answer<'_>) -> Vec<Self> {
        let right = Self::default();
        let placements = Placement::wrong().into_iter();
        let mut rules: Vec<Self> =
            placements.map(|placement| Self { placement, ..right }).collect();
        use {Background as B, Blending as L, Encoding as E, Fragments as F};
        let bytes = [L::Bytes { encoded: true }, L::Bytes { encoded: false }];
        rules.extend(bytes.map(|blending| Self { blending, ..right }));
        let encodings = [E::None, E::Twice, E::Swapped, E::Power];
        rules.extend(encodings.map(|encoding| Self { encoding, ..right }));
        let blendings = [
            L::Encoded,
            L::Unmultiplied { cut: true },
            L::Unmultiplied { cut: false },
            L::Twice,
            L::Off,
            L::Added,
            L::Average,
            L::AverageCovered,
        ];
        rules.extend(blendings.map(|blending| Self { blending, ..right }));
        let backgrounds = [B::Black, B::White, B::Encoded, B::Decoded];
        rules.extend(backgrounds.map(|background| Self { background, ..right }));
        if answer.options.k.is_some() {
            rules.push(Self { fragments: F::All, ..right });
        }
        let orders = [
            F::TiesFirst,
            F::TiesLast,
            F::Triangles,
            F::Objects,
            F::NoBacks,
            F::NoFronts,
            F::NoNear,
            F::NoFar,
            F::Submitted,
            F::SubmittedUnder,
            F::Reversed,
            F::DepthWritten { or_equal: false },
            F::DepthWritten { or_equal: true },
            F::Farthest,
        ];
        rules.extend(orders.map(|fragments| Self { fragments, ..right }));
        let deepest = answer.lists.offsets.windows(2).map(|ends| ends[1] - ends[0]).max();
        let most = (deepest.unwrap_or(0) as u32).min(MOST_KEPT);
        rules.extend((1..most).map(|n| Self { fragments: F::Nearest(n), ..right }));
        rules.extend((1..most).map(|n| Self { fragments: F::First(n), ..right }));
        rules
    }

    /// Those that are wrong in two ways, each in one of `singles`, along two axes.
    pub(super) fn pairs(singles: &[Self]) -> Vec<Self> {
        let few = |rule: &&Self| {
            !matches!(rule.fragments, Fragments::First(_))
                && !matches!(rule.placement, Placement::Moved(_))
                && !matches!(rule.fragments, Fragments::Nearest(n) if n > 16)
        };
        let few: Vec<&Self> = singles.iter().filter(few).collect();
        let mut pairs = Vec::new();
        for (i, first) in few.iter().enumerate() {
            pairs.extend(few[i + 1..].iter().filter_map(|second| first.and(second)));
        }
        pairs
    }

    /// Wrong in both ways, if they are along different axes.
    fn and(&self, other: &Self) -> Option<Self> {
        let own = self.axes();
        if own.iter().zip(other.axes()).any(|(&a, b)| a && b) {
            return None;
        }
        let pick = |mine: bool| if mine { self } else { other };
        Some(Self {
            placement: pick(own[0]).placement,
            coverage: pick(own[1]).coverage,
            fragments: pick(own[2]).fragments,
            blending: pick(own[3]).blending,
            background: pick(own[4]).background,
            encoding: pick(own[5]).encoding,
        })
    }

    /// Along which axes it is wrong.
    fn axes(&self) -> [bool; 6] {
        let right = Self::default();
        [
            self.placement != right.placement,
            self.coverage != right.coverage,
            self.fragments != right.fragments,
            self.blending != right.blending,
            self.background != right.background,
            self.encoding != right.encoding,
        ]
    }

    /// The class of pixels that it explains.
    pub(super) fn class(&self) -> Class {
        use {Blending as L, Fragments as F};
        if self.placement != Placement::Right {
            return Class::Placement;
        }
        match self.coverage {
            Some(Variant::Moved(_)) => return Class::Placement,
            Some(Variant::BothFaces) => return Class::Culling,
            Some(Variant::BottomRight | Variant::Bits(_)) => return Class::Edge,
            None => {}
        }
        match self.encoding {
            Encoding::Right => {}
            Encoding::Swapped => return Class::Channels,
            Encoding::None | Encoding::Twice | Encoding::Power => return Class::ColorSpace,
        }
        match self.blending {
            L::Right => {}
            L::Encoded => return Class::ColorSpace,
            L::Unmultiplied { .. } | L::Twice => return Class::Premultiplication,
            L::Added | L::Average | L::AverageCovered | L::Off => return Class::Blending,
            L::Bytes { .. } => return Class::Precision,
        }
        match self.fragments {
            F::Right => Class::Background,
            F::All | F::Nearest(_) => Class::BeyondK,
            F::First(_) | F::Reversed | F::Submitted | F::SubmittedUnder => Class::Order,
            F::Triangles | F::Objects => Class::Order,
            F::DepthWritten { .. } | F::Farthest => Class::DepthTest,
            F::TiesFirst | F::TiesLast => Class::Tie,
            F::NoBacks | F::NoFronts => Class::Culling,
            F::NoNear | F::NoFar => Class::Clipping,
        }
    }

    /// In words, after "as if".
    pub(super) fn name(&self) -> String {
        let parts = [
            self.placement.name(),
            self.coverage.map(Variant::name).unwrap_or_default(),
            self.fragments.name(),
            self.blending.name().to_owned(),
            self.background.name().to_owned(),
            self.encoding.name().to_owned(),
        ];
        let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join("; and ")
    }
}

/// A rule, ready for a scene.
#[derive(Clone, Copy)]
pub(super) struct Maker<'a> {
    pub(super) rule: Rule,
    pub(super) scope: Scope<'a>,
    pub(super) background: [f64; 3],
}

impl<'a> Maker<'a> {
    pub(super) fn new(rule: Rule, answer: &'a Answer<'_>) -> Self {
        let format = answer.options.record().depth;
        let scope = Scope { k: answer.options.k, facts: &answer.facts, format };
        Self { rule, scope, background: rule.background.of(answer.scene.background) }
    }

    /// The picture's bytes, of a sorted list of fragments. `scratch` may hold anything.
    pub(super) fn color(&self, list: &[Entry], scratch: &mut Vec<Entry>) -> [u8; 3] {
        scratch.clear();
        scratch.extend_from_slice(list);
        self.rule.fragments.arrange(self.scope, scratch);
        self.arranged(scratch)
    }

    /// The same, of fragments in the order in which they are blended.
    pub(super) fn arranged(&self, list: &[Entry]) -> [u8; 3] {
        self.words(list.iter().map(|entry| entry.color))
    }

    /// The same, of their colour words.
    pub(super) fn words(&self, words: impl DoubleEndedIterator<Item = u32> + Clone) -> [u8; 3] {
        let Rule { blending, encoding, .. } = self.rule;
        encoding.bytes(blending.blend(words, self.background), blending.is_encoded())
    }
}
