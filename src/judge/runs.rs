//! Several pictures of one renderer: where they differ from each other, and why.

use serde::Serialize;

use super::answer::Answer;
use super::class::Class;
use super::verdict::{Counted, Verdict, counted};
use super::{Settings, near_edge};

/// What differs between runs.
#[derive(Clone, Debug, Serialize)]
pub struct Runs {
    /// How many there are.
    pub runs: usize,
    /// Pixels that are not the same bytes in all of them.
    pub pixels_different: u64,
    /// Pixels that differ by more than the tolerance.
    pub pixels_beyond: u64,
    /// The largest difference of a channel between two runs, sRGB steps.
    pub max_difference: u8,
    /// Classes of the pixels, in the order of [`Class::ALL`]; `equal` are those that are the same in all runs.
    pub classes: Vec<Counted>,
    /// Where the pixels lie that differ by more than the tolerance.
    pub places: Places,
    /// By pixel, row by row: its class.
    #[serde(skip)]
    pub map: Vec<Class>,
    /// By pixel, row by row: the largest difference of a channel.
    #[serde(skip)]
    pub apart: Vec<u8>,
}

/// Of the pixels that differ between runs by more than the tolerance, how many are of a kind; a pixel may be of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Places {
    /// They have more fragments than k; none, if there is no k.
    pub deeper_than_k: Option<u64>,
    /// Two of their fragments are nearly at the same depth, and of different colours.
    pub tied: u64,
    /// An edge is near to their centre.
    pub near_edge: u64,
    /// Nothing of this.
    pub elsewhere: u64,
}

/// Compare runs that were judged against the same answer. The order of the runs does not matter.
///
/// A pixel that differs between runs by more than the tolerance has the class that it has in the run that is explained
/// last in the order of [`Class::ALL`].
#[must_use]
pub fn compare(answer: &Answer<'_>, verdicts: &[Verdict], settings: &Settings) -> Runs {
    let width = answer.scene.size[0];
    let pixels = answer.picture.pixels.len();
    let apart: Vec<u8> = (0..pixels)
        .map(|pixel| {
            let spread = |c: usize| {
                let values = || verdicts.iter().map(|verdict| verdict.seen.pixels[pixel][c]);
                values().max().unwrap_or(0) - values().min().unwrap_or(0)
            };
            (0..3).map(spread).max().unwrap_or(0)
        })
        .collect();
    let class = |pixel: usize| match apart[pixel] {
        0 => Class::Equal,
        apart if apart <= settings.tolerance => Class::Rounding,
        _ => verdicts.iter().map(|verdict| verdict.map[pixel]).max().unwrap_or(Class::Equal),
    };
    let map: Vec<Class> = (0..pixels).map(class).collect();
    Runs {
        runs: verdicts.len(),
        pixels_different: apart.iter().filter(|&&apart| apart > 0).count() as u64,
        pixels_beyond: apart.iter().filter(|&&apart| apart > settings.tolerance).count() as u64,
        max_difference: apart.iter().copied().max().unwrap_or(0),
        classes: counted(&map, &apart, width),
        places: places(answer, &apart, settings),
        map,
        apart,
    }
}

fn places(answer: &Answer<'_>, apart: &[u8], settings: &Settings) -> Places {
    let format = answer.options.record().depth;
    let near = near_edge(answer, settings.edge_distance);
    let mut places = Places { deeper_than_k: answer.options.k.map(|_| 0), ..Places::default() };
    for pixel in (0..apart.len()).filter(|&pixel| apart[pixel] > settings.tolerance) {
        let list = answer.list(pixel);
        let deeper = answer.options.k.is_some_and(|k| list.len() > k as usize);
        let tied = list.windows(2).any(|pair| {
            let [a, b] = [&pair[0], &pair[1]];
            format.decode(b.depth) - format.decode(a.depth) <= settings.depth_distance
                && a.color != b.color
        });
        if let Some(count) = &mut places.deeper_than_k {
            *count += u64::from(deeper);
        }
        places.tied += u64::from(tied);
        places.near_edge += u64::from(near[pixel]);
        places.elsewhere += u64::from(!deeper && !tied && !near[pixel]);
    }
    places
}
