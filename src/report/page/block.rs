//! The fragments of a block of pixels and what became of them, as bytes that compress well. `blocks.js` reads them.
//!
//! A block is a number of streams: their count and lengths as little-endian u32, then their bytes. Pixels come row by row.
//! The first five streams are of the pixels and their fragments, and each method adds seven:
//!
//! | stream | |
//! |---|---|
//! | counts | fragments of a pixel |
//! | triangles | differences from the fragment at the same place in the pixel before (left, or at the edge above), if there is one, otherwise from the fragment before |
//! | depths | differences from where the triangle's last two depths lead, if it was in an earlier pixel, otherwise from the fragment before |
//! | colours | RGBA8, exclusive or with the triangle's last colour: all R, then all G, B and A |
//! | exact | the picture: RGBA8, exclusive or with the pixel before, R, G, B and A apart |
//! | words | JSON: the block's distinct fates, each with its reason or null |
//! | fates | index into the words, for each fragment |
//! | parts | 1 + the record that a fragment is in, or 0; left out if there are none |
//! | picture | the method's, RGBA8, exclusive or with the exact one, R, G, B and A apart |
//! | records | for each pixel their count, then depth (u32), thickness, R, G, B, opacity and weight (f64) of each; left out if there are none |
//! | extra | for each pixel their count, then what (1 is torn), depth, data and colour (u32) of each; left out if there are none |
//! | absorbed | an f64 for each pixel; only of a method that gives colours |
//!
//! Numbers are LEB128 where nothing else is said; differences are of u32, wrapped, and zigzag.

use std::collections::BTreeMap;

use crate::image::Image;
use crate::inspect::frame::{Drawn, Frame};
use crate::inspect::{Became, Generated, Look};
use crate::render::{Kept, Options};

/// Pixels of a block's edge.
pub(super) const EDGE: u32 = 64;

/// Streams of bytes.
pub(super) type Streams = Vec<Vec<u8>>;

/// The pixels of a block, row by row.
pub(super) fn pixels(
    [width, height]: [u32; 2],
    block: u32,
) -> impl Iterator<Item = [u32; 2]> + Clone {
    let columns = width.div_ceil(EDGE);
    let (x0, y0) = (block % columns * EDGE, block / columns * EDGE);
    let (x1, y1) = ((x0 + EDGE).min(width), (y0 + EDGE).min(height));
    (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y]))
}

/// Blocks of a picture.
pub(super) fn count([width, height]: [u32; 2]) -> u32 {
    width.div_ceil(EDGE) * height.div_ceil(EDGE)
}

/// Join streams: one block.
pub(super) fn join(streams: &[&[Vec<u8>]]) -> Vec<u8> {
    let all = || streams.iter().flat_map(|some| some.iter());
    let mut bytes = (all().count() as u32).to_le_bytes().to_vec();
    all().for_each(|stream| bytes.extend((stream.len() as u32).to_le_bytes()));
    all().for_each(|stream| bytes.extend(stream));
    bytes
}

/// The streams of a block's fragments, and of the exact picture.
pub(super) fn fragments(frame: &Frame<'_>, block: u32) -> Streams {
    let places = pixels(frame.size(), block);
    let [mut counts, mut triangles, mut depths] = <[Vec<u8>; 3]>::default();
    let mut colors: Vec<u32> = Vec::new();
    let mut seen: BTreeMap<u32, Seen> = BTreeMap::new();
    let (mut before, mut row): (&[Generated], &[Generated]) = (&[], &[]);
    for (number, place) in (0..).zip(places.clone()) {
        let own = frame.pixel(place);
        let at_edge = place[0].is_multiple_of(EDGE);
        let neighbour = if at_edge { row } else { before };
        put(&mut counts, own.len() as u32);
        for (i, g) in own.iter().enumerate() {
            let last = i.checked_sub(1).map(|i| &own[i]);
            let guess = neighbour.get(i).or(last).map_or(0, |other| other.triangle);
            put(&mut triangles, apart(g.triangle, guess));
            let known = seen.get(&g.triangle).filter(|seen| seen.number < number);
            let guess = match known {
                Some(seen) => seen.depth.wrapping_add(seen.slope),
                None => last.map_or(0, |last| last.depth),
            };
            put(&mut depths, apart(g.depth, guess));
            colors.push(g.color ^ known.map_or(0, |seen| seen.color));
            let slope = known.map_or(0, |seen| g.depth.wrapping_sub(seen.depth));
            // A triangle that is at a pixel twice is told apart by the first.
            if seen.get(&g.triangle).is_none_or(|seen| seen.number < number) {
                let Generated { triangle, depth, color } = *g;
                seen.insert(triangle, Seen { number, depth, slope, color });
            }
        }
        before = own;
        row = if at_edge { own } else { row };
    }
    let mut last = 0;
    let exact = places.map(|place| {
        let color = color_at(&frame.exact, place);
        color ^ std::mem::replace(&mut last, color)
    });
    vec![counts, triangles, depths, planes(&colors), planes(&exact.collect::<Vec<_>>())]
}

/// What is known of a triangle in earlier pixels.
struct Seen {
    number: u32,
    depth: u32,
    slope: u32,
    color: u32,
}

/// The streams of what a method made of a block.
pub(super) fn method(
    frame: &Frame<'_>,
    options: &Options,
    drawn: &Drawn<'_>,
    block: u32,
) -> Streams {
    let places = pixels(frame.size(), block);
    let mut words: Vec<(Became, Option<String>)> = Vec::new();
    let [mut fates, mut parts, mut records, mut extra, mut absorbed] = <[Vec<u8>; 5]>::default();
    let [mut any_part, mut any_record, mut any_extra] = [false; 3];
    let mut colors = Vec::new();
    for place in places {
        let look = drawn.look(place);
        any_record |= !look.records.is_empty();
        any_extra |= !look.extra.is_empty();
        put_records(&mut records, &look);
        put_extra(&mut extra, frame, options, place, &look);
        if matches!(drawn.rendering.kept, Kept::Color(_)) {
            absorbed.extend(look.absorbed.to_le_bytes());
        }
        for fate in look.fates {
            let part = fate.record.map_or(0, |record| record as u32 + 1);
            any_part |= part > 0;
            put(&mut parts, part);
            let known = words.iter().position(|(word, reason)| {
                (*word, reason.as_deref()) == (fate.fate, fate.reason.as_deref())
            });
            put(&mut fates, known.unwrap_or(words.len()) as u32);
            if known.is_none() {
                words.push((fate.fate, fate.reason));
            }
        }
        let image = &drawn.rendering.image;
        colors.push(color_at(image, place) ^ color_at(&frame.exact, place));
    }
    let some = |any: bool, stream: Vec<u8>| if any { stream } else { Vec::new() };
    let told: Vec<_> = words.iter().map(|(word, reason)| (word.name(), reason)).collect();
    vec![
        serde_json::json!(told).to_string().into_bytes(),
        fates,
        some(any_part, parts),
        planes(&colors),
        some(any_record, records),
        some(any_extra, extra),
        absorbed,
    ]
}

fn put_records(records: &mut Vec<u8>, look: &Look) {
    put(records, look.records.len() as u32);
    for record in &look.records {
        records.extend(record.depth.to_le_bytes());
        let [r, g, b, a] = record.rgba;
        let reals = [record.thickness, r, g, b, a, record.weight];
        records.extend(reals.iter().flat_map(|real| real.to_le_bytes()));
    }
}

fn put_extra(
    extra: &mut Vec<u8>,
    frame: &Frame<'_>,
    options: &Options,
    place: [u32; 2],
    look: &Look,
) {
    put(extra, look.extra.len() as u32);
    for entry in &look.extra {
        let torn = u32::from(entry.what == "torn");
        let words = [torn, entry.depth, entry.data, frame.color_of(options, place, entry)];
        extra.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    }
}

fn color_at(image: &Image, [x, y]: [u32; 2]) -> u32 {
    u32::from_le_bytes(image.pixel(x, y))
}

/// The bytes of words, the lowest of all first.
fn planes(words: &[u32]) -> Vec<u8> {
    (0..4).flat_map(|plane| words.iter().map(move |word| word.to_le_bytes()[plane])).collect()
}

/// A difference of words: 0, -1, 1, -2, ... are 0, 1, 2, 3, ...
fn apart(word: u32, guess: u32) -> u32 {
    let difference = word.wrapping_sub(guess) as i32;
    ((difference << 1) ^ (difference >> 31)) as u32
}

/// LEB128.
fn put(bytes: &mut Vec<u8>, mut word: u32) {
    while word >= 0x80 {
        bytes.push(word as u8 | 0x80);
        word >>= 7;
    }
    bytes.push(word as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_the_picture_once() {
        for size in [[1, 1], [64, 64], [65, 130], [7, 200]] {
            let mut all: Vec<[u32; 2]> = (0..count(size)).flat_map(|b| pixels(size, b)).collect();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len() as u32, size[0] * size[1]);
            assert!(all.iter().all(|[x, y]| *x < size[0] && *y < size[1]));
        }
    }

    #[test]
    fn small_differences_are_small_numbers() {
        let differences = [(5, 5, 0), (4, 5, 1), (6, 5, 2), (0, u32::MAX, 2), (u32::MAX, 0, 1)];
        assert!(differences.iter().all(|&(word, guess, told)| apart(word, guess) == told));
        let mut bytes = Vec::new();
        [0, 127, 128, u32::MAX].iter().for_each(|&word| put(&mut bytes, word));
        assert_eq!(bytes, [0, 127, 0x80, 1, 0xFF, 0xFF, 0xFF, 0xFF, 15]);
        assert_eq!(planes(&[0x0403_0201, 0x1413_1211]), [1, 0x11, 2, 0x12, 3, 0x13, 4, 0x14]);
    }
}
