//! What is found at a pixel.

use serde::Serialize;

use crate::fragment::{Data, key};
use crate::num::depth::Format;

/// A pixel's fragments before and after each method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Column and row from the top left.
    pub pixel: [u32; 2],
    /// The scene's name.
    pub scene: String,
    /// Pixels of the picture across.
    pub width: u32,
    /// Pixels of the picture down.
    pub height: u32,
    /// Linear RGB, 0 to 1.
    pub background: [f32; 3],
    /// What a depth word is.
    pub depth_format: Format,
    /// All fragments in canonical order.
    pub fragments: Vec<PixelFragment>,
    /// What they give, one over the other.
    pub exact: Exact,
    /// In the order in which they were given.
    pub methods: Vec<Inspected>,
}

/// A fragment as it was generated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelFragment {
    /// Its place in canonical order, from 0.
    pub index: usize,
    /// The object's name; none for triangles given in pixels.
    pub object: Option<String>,
    /// The global triangle index.
    pub triangle: u32,
    /// The stored depth word.
    pub depth: u32,
    /// From the eye's plane along the line of sight, in world units.
    pub distance: f64,
    /// Linear colour and opacity, each 0 to 255.
    pub rgba: [u8; 4],
}

/// The exact answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Exact {
    /// sRGB.
    pub color: [u8; 4],
    /// The share of the background's light that is absorbed.
    pub absorbed: f64,
    /// As [`Inspected::absorbance`].
    pub absorbance: Vec<[f64; 2]>,
}

/// What one method makes of the pixel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspected {
    /// Its name.
    pub method: String,
    /// The executor.
    pub exec: String,
    /// Fragments kept per pixel; none is all, or another number for each pixel.
    pub k: Option<u32>,
    /// sRGB.
    pub color: [u8; 4],
    /// The largest difference of a channel from the exact colour.
    pub difference: u8,
    /// The share of the background's light that is absorbed.
    pub absorbed: f64,
    /// Merged records, front to back; none where the method keeps fragments or a colour.
    pub records: Vec<PixelRecord>,
    /// What became of each fragment.
    pub fates: Vec<Fate>,
    /// What the pixel's list holds besides.
    pub extra: Vec<Extra>,
    /// Corners of the absorbance as a function of the distance, front to back: 1 minus the transmittance, which a
    /// fragment raises at once and a merged record along its thickness. None where the pixel holds a colour alone.
    pub absorbance: Vec<[f64; 2]>,
    /// What was tolerated in the whole frame.
    pub warnings: Vec<String>,
    /// What the method promised and did not keep in the whole frame.
    pub violations: Vec<String>,
}

/// A merged record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelRecord {
    /// The stored depth word of its far end.
    pub depth: u32,
    /// Of its far end, in world units.
    pub distance: f64,
    /// How far it reaches from there towards the eye, in world units.
    pub thickness: f64,
    /// Linear, multiplied by the opacity, and the opacity: all 0 to 1.
    pub rgba: [f64; 4],
    /// How many fragments it stands for.
    pub weight: f64,
}

/// What became of a fragment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fate {
    /// In a word.
    pub fate: Became,
    /// What is known besides.
    pub reason: Option<String>,
    /// The record that it is, or is part of, from 0.
    pub record: Option<usize>,
}

/// The fate of a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Became {
    /// It is in the pixel's list.
    Kept,
    /// It is part of a record, or of the pixel's colour.
    Merged,
    /// Rejected before it was stored.
    Culled,
    /// Stored, and pushed out later.
    Evicted,
    /// There was no room for it, for the reason that is given.
    Dropped,
    /// The method promises to keep it, and it is gone.
    Lost,
    /// It is gone, as the method allows; how is not known.
    NotKept,
}

impl Became {
    /// The name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Merged => "merged",
            Self::Culled => "culled",
            Self::Evicted => "evicted",
            Self::Dropped => "dropped",
            Self::Lost => "lost",
            Self::NotKept => "not-kept",
        }
    }
}

/// A method's name, and k where it has one.
pub(super) fn title(method: &str, k: Option<u32>) -> String {
    k.map_or_else(|| method.to_owned(), |k| format!("{method}, k = {k}"))
}

/// An entry of a pixel's list that is not one of its fragments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Extra {
    /// `duplicated`: it is there more often than it was generated; `torn`: it was never generated.
    pub what: &'static str,
    /// The stored depth word.
    pub depth: u32,
    /// In world units.
    pub distance: f64,
    /// The stored data word.
    pub data: u32,
}

/// A fragment as all methods get it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Generated {
    /// The global triangle index.
    pub triangle: u32,
    /// The stored depth word.
    pub depth: u32,
    /// RGBA8, R in the low byte.
    pub color: u32,
}

impl Generated {
    /// What a method stores that stores this data word.
    pub(super) fn key(&self, data: Data) -> u64 {
        let word = match data {
            Data::Color => self.color,
            Data::Primitive => self.triangle,
            Data::Nothing => 0,
        };
        key(self.depth, word)
    }
}
