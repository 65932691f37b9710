//! Which fragments are concerned, and how often.

use std::collections::BTreeMap;

use super::answer::Answer;
use super::pixel::cause::Cause;
use super::rule::Maker;
use super::rule::order::Fragments;
use super::verdict::Culprit;

/// So many are told.
const MOST: usize = 10;

/// The causes of pixels, gathered: those at most pixels first.
pub(super) fn of(
    answer: &Answer<'_>,
    maker: &Maker<'_>,
    causes: &[(usize, Cause)],
) -> Vec<Culprit> {
    let mut found: BTreeMap<Cause, (u64, usize)> = BTreeMap::new();
    for &(pixel, cause) in causes {
        found.entry(cause).or_insert((0, pixel)).0 += 1;
    }
    let mut found: Vec<(Cause, (u64, usize))> = found.into_iter().collect();
    found.sort_by_key(|&(cause, (pixels, _))| (std::cmp::Reverse(pixels), cause));
    found.truncate(MOST);
    let mut totals: BTreeMap<u32, u64> =
        found.iter().filter_map(|(cause, _)| Some((triangle(*cause)?, 0))).collect();
    if !totals.is_empty() {
        for entry in &answer.lists.entries {
            if let Some(total) = totals.get_mut(&entry.triangle) {
                *total += 1;
            }
        }
    }
    let size = answer.scene.size;
    let culprit = |(cause, (pixels, pixel)): (Cause, (u64, usize))| {
        let triangle = triangle(cause);
        let source = maker.rule.placement.source(pixel, size).unwrap_or(pixel);
        let list = answer.list(source);
        let index = list.iter().position(|entry| Some(entry.triangle) == triangle);
        let depth = index.map(|index| list[index].depth);
        let object = match cause {
            Cause::MissingObject(solid) => Some(answer.solids.names()[solid].clone()),
            _ => triangle.and_then(|triangle| answer.object(triangle)).map(str::to_owned),
        };
        Culprit {
            class: cause.class(),
            what: what(cause),
            triangle,
            object,
            pixels,
            of: triangle.map(|triangle| totals[&triangle]),
            first: [pixel as u32 % size[0], pixel as u32 / size[0]],
            depth,
            distance: depth.map(|depth| answer.lens.along(depth)),
            index: index.map(|index| index as u32),
        }
    };
    found.into_iter().map(culprit).collect()
}

/// The triangle that a cause is about.
fn triangle(cause: Cause) -> Option<u32> {
    match cause {
        Cause::Missing(triangle) | Cause::Duplicated(triangle) | Cause::Swapped(triangle, _) => {
            Some(triangle)
        }
        Cause::MissingObject(_) | Cause::Nearest(_) | Cause::First(_) | Cause::Order(_) => None,
    }
}

fn what(cause: Cause) -> String {
    match cause {
        Cause::Missing(triangle) => format!("triangle {triangle} is missing"),
        Cause::MissingObject(_) => "all fragments of an object are missing".to_owned(),
        Cause::Duplicated(triangle) => format!("triangle {triangle} is there twice"),
        Cause::Swapped(a, b) => format!("triangles {a} and {b} have changed places"),
        Cause::Nearest(1) => "the nearest fragment is there alone".to_owned(),
        Cause::Nearest(n) => format!("the {n} nearest are there alone"),
        Cause::First(1) => "the fragment submitted first is there alone".to_owned(),
        Cause::First(n) => format!("the {n} submitted first are there alone"),
        Cause::Order(Fragments::Submitted) => "they are in the order of submission".to_owned(),
        Cause::Order(Fragments::SubmittedUnder) => {
            "they are in the reverse order of submission".to_owned()
        }
        Cause::Order(_) => "they are from back to front".to_owned(),
    }
}
