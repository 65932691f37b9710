//! What a pixel's difference is put down to.

use serde::{Serialize, Serializer};

/// Why a pixel is as it is. A pixel has one class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Class {
    /// It is the exact picture's, byte by byte.
    Equal,
    /// It differs by at most the tolerance.
    Rounding,
    /// The whole picture lies elsewhere: flipped, mirrored, moved by a pixel or by half of one.
    Placement,
    /// The opacity of the picture is read in another way than its format says.
    Opacity,
    /// The whole picture is encoded or blended in the wrong colour space.
    ColorSpace,
    /// Colours are multiplied by their opacity once too often, or not at all.
    Premultiplication,
    /// Fragments are blended by another formula.
    Blending,
    /// What is behind all fragments differs.
    Background,
    /// Red and blue are exchanged.
    Channels,
    /// Colours are rounded to 8 bits after each fragment.
    Precision,
    /// Faces that should be left out are there, or others are not.
    Culling,
    /// Fragments on the near or the far plane are not there.
    Clipping,
    /// The depth buffer is written, or its test is inverted.
    DepthTest,
    /// Coverage at edges is decided by another rule, or with other sub-pixel bits.
    Edge,
    /// Fragments of equal or nearly equal depth come in another order.
    Tie,
    /// A fragment, or all of an object's at that pixel, is missing.
    Missing,
    /// A fragment is there that should not be: of dumps only.
    Extra,
    /// A fragment is there twice.
    Duplicated,
    /// A fragment has another depth: of dumps only.
    Depth,
    /// A fragment has another colour, or is of another triangle: of dumps only.
    Data,
    /// Two fragments have changed places.
    Swapped,
    /// Only some of the nearest fragments are there.
    BeyondK,
    /// Fragments come in another order, or those that came first were kept.
    Order,
    /// An edge passes through the pixel, and it lies between covered and not covered.
    Partial,
    /// It differs by so little that its cause cannot be told.
    Faint,
    /// Nothing that is tried explains it.
    Unexplained,
}

impl Class {
    /// All, in the order in which they are decided.
    pub const ALL: [Self; 26] = [
        Self::Equal,
        Self::Rounding,
        Self::Placement,
        Self::Opacity,
        Self::ColorSpace,
        Self::Premultiplication,
        Self::Blending,
        Self::Background,
        Self::Channels,
        Self::Precision,
        Self::Culling,
        Self::Clipping,
        Self::DepthTest,
        Self::Edge,
        Self::Tie,
        Self::Missing,
        Self::Extra,
        Self::Duplicated,
        Self::Depth,
        Self::Data,
        Self::Swapped,
        Self::BeyondK,
        Self::Order,
        Self::Partial,
        Self::Faint,
        Self::Unexplained,
    ];

    /// The name on the command line and in documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Rounding => "rounding",
            Self::Placement => "placement",
            Self::Opacity => "opacity",
            Self::ColorSpace => "color-space",
            Self::Premultiplication => "premultiplication",
            Self::Blending => "blending",
            Self::Background => "background",
            Self::Channels => "channels",
            Self::Precision => "precision",
            Self::Culling => "culling",
            Self::Clipping => "clipping",
            Self::DepthTest => "depth-test",
            Self::Edge => "edge",
            Self::Tie => "tie",
            Self::Missing => "missing",
            Self::Extra => "extra",
            Self::Duplicated => "duplicated",
            Self::Depth => "depth",
            Self::Data => "data",
            Self::Swapped => "swapped",
            Self::BeyondK => "beyond-k",
            Self::Order => "order",
            Self::Partial => "partial",
            Self::Faint => "faint",
            Self::Unexplained => "unexplained",
        }
    }

    /// What it means, in a few words.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Equal => "the same bytes",
            Self::Rounding => "within the tolerance",
            Self::Placement => "the picture lies elsewhere",
            Self::Opacity => "opacity is to be read in another way",
            Self::ColorSpace => "encoded or blended in the wrong colour space",
            Self::Premultiplication => "multiplied by opacity twice, or not at all",
            Self::Blending => "another formula",
            Self::Background => "another background",
            Self::Channels => "red and blue exchanged",
            Self::Precision => "8 bits after each fragment",
            Self::Culling => "the wrong faces left out",
            Self::Clipping => "nothing on the near or far plane",
            Self::DepthTest => "depth buffer written, or test inverted",
            Self::Edge => "another rule or rounding at an edge",
            Self::Tie => "another order of nearly equal depths",
            Self::Missing => "a fragment is not there",
            Self::Extra => "a fragment that should not be there",
            Self::Duplicated => "a fragment is there twice",
            Self::Depth => "a fragment has another depth",
            Self::Data => "a fragment has another colour or triangle",
            Self::Swapped => "two fragments have changed places",
            Self::BeyondK => "only some of the nearest fragments",
            Self::Order => "another order, or those that came first",
            Self::Partial => "an edge passes, between both sides of it",
            Self::Faint => "too little to tell",
            Self::Unexplained => "nothing that is tried explains it",
        }
    }

    /// Its colour on a map.
    #[must_use]
    pub const fn color(self) -> [u8; 3] {
        match self {
            Self::Equal => [14, 14, 18],
            Self::Rounding => [52, 54, 66],
            Self::Placement => [0, 158, 115],
            Self::Opacity => [120, 94, 240],
            Self::ColorSpace => [86, 180, 233],
            Self::Premultiplication => [0, 114, 178],
            Self::Blending => [204, 121, 167],
            Self::Background => [148, 103, 189],
            Self::Channels => [23, 190, 207],
            Self::Precision => [127, 148, 150],
            Self::Culling => [188, 189, 34],
            Self::Clipping => [140, 86, 75],
            Self::DepthTest => [160, 110, 30],
            Self::Edge => [240, 228, 66],
            Self::Tie => [255, 176, 0],
            Self::Missing => [214, 39, 40],
            Self::Extra => [255, 90, 60],
            Self::Duplicated => [255, 120, 200],
            Self::Depth => [90, 90, 255],
            Self::Data => [0, 200, 200],
            Self::Swapped => [230, 159, 0],
            Self::BeyondK => [44, 160, 44],
            Self::Order => [213, 94, 0],
            Self::Partial => [196, 190, 130],
            Self::Faint => [110, 112, 130],
            Self::Unexplained => [255, 255, 255],
        }
    }

    /// By its name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }

    /// Whether a pixel of this class is right.
    #[must_use]
    pub const fn is_right(self) -> bool {
        matches!(self, Self::Equal | Self::Rounding)
    }
}

impl Serialize for Class {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_names_and_colours_of_their_own() {
        for (i, class) in Class::ALL.into_iter().enumerate() {
            assert_eq!(class as usize, i);
            assert_eq!(Class::named(class.name()), Some(class));
            assert!(Class::ALL[..i].iter().all(|other| other.color() != class.color()));
        }
        assert_eq!(Class::named("edges"), None);
    }
}
