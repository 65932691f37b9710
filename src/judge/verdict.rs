//! What is said of a picture.

use serde::Serialize;

use super::class::Class;
use crate::image::Image;
use crate::image::foreign::Opacity;
use crate::image::metrics::Metrics;

/// Of one picture.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Its file.
    pub picture: String,
    /// Every pixel is the exact one, or within the tolerance.
    pub right: bool,
    /// Its errors against the exact picture.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// How its opacity was read; `Ignored` where it has none.
    pub opacity: Opacity,
    /// Classes that pixels have, in the order of [`Class::ALL`].
    pub classes: Vec<Counted>,
    /// The hypothesis about the whole picture that holds, if one does.
    pub hypothesis: Option<Held>,
    /// Other hypotheses that were tested on all pixels, the best first, with those that explain something.
    pub tested: Vec<Held>,
    /// Which fragments are concerned, those at most pixels first.
    pub culprits: Vec<Culprit>,
    /// What was tolerated, one sentence each.
    pub warnings: Vec<String>,
    /// By pixel, row by row.
    #[serde(skip)]
    pub map: Vec<Class>,
    /// By pixel, row by row: the largest difference of a channel from the exact picture, sRGB steps.
    #[serde(skip)]
    pub apart: Vec<u8>,
    /// The picture as it is seen, without opacity.
    #[serde(skip)]
    pub seen: Image,
}

/// How many pixels have a class.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Counted {
    /// The class.
    pub class: Class,
    /// What it means.
    pub meaning: &'static str,
    /// Pixels.
    pub pixels: u64,
    /// The largest difference of a channel among them, sRGB steps.
    pub max_difference: u8,
    /// Column and row of the first of them.
    pub first: [u32; 2],
}

/// A hypothesis, and how far it holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Held {
    /// The class of what it explains.
    pub class: Class,
    /// In words, after "as if".
    pub as_if: String,
    /// Pixels beyond the tolerance that it explains.
    pub explains: u64,
    /// Of how many.
    pub of: u64,
    /// Pixels that are right, and would not be if it held.
    pub contradicts: u64,
    /// Others that give the picture at the same pixels: they cannot be told from it.
    pub or_as_if: Vec<String>,
}

/// A fragment that is concerned at many pixels, or a number of fragments.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Culprit {
    /// What is the matter.
    pub class: Class,
    /// The same in words.
    pub what: String,
    /// The global triangle index.
    pub triangle: Option<u32>,
    /// Its object.
    pub object: Option<String>,
    /// Pixels at which this is the matter.
    pub pixels: u64,
    /// Pixels at which that triangle has a fragment.
    pub of: Option<u64>,
    /// Column and row of the first of them.
    pub first: [u32; 2],
    /// The depth word there.
    pub depth: Option<u32>,
    /// Its distance from the eye there, world units.
    pub distance: Option<f64>,
    /// Its place in the list there, counted from 0 at the front.
    pub index: Option<u32>,
}

/// Classes with their pixels; `apart` is by how much each pixel differs.
pub(super) fn counted(map: &[Class], apart: &[u8], width: u32) -> Vec<Counted> {
    let mut counts: Vec<Option<Counted>> = vec![None; Class::ALL.len()];
    for (pixel, (&class, &apart)) in map.iter().zip(apart).enumerate() {
        let first = [pixel as u32 % width, pixel as u32 / width];
        let meaning = class.meaning();
        let place = counts[class as usize].get_or_insert(Counted {
            class,
            meaning,
            pixels: 0,
            max_difference: 0,
            first,
        });
        place.pixels += 1;
        place.max_difference = place.max_difference.max(apart);
    }
    counts.into_iter().flatten().collect()
}
