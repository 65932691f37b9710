//! Rows of binary files, many at once: where all rows have the same length, each is where it is known to be.

use rayon::prelude::*;

use super::super::parts::Tally;
use super::super::points::table::{self, NORMAL, Table};
use super::faces::{self, Faces};
use super::header::{Element, Encoding, Kind, Scalar};
use super::payload::{Payload, number};

/// Rows that a thread reads at once.
const BLOCK: usize = 1 << 12;

/// A number of each row.
struct Field<'a> {
    /// Bytes before it.
    at: usize,
    scalar: Scalar,
    column: usize,
    /// Where it is kept among a row's values.
    slot: usize,
    name: &'a str,
}

/// Reads all vertices into a table that is filled already; whether it did, which it does not where there are lists, or
/// where the file ends too early.
pub(super) fn vertices(
    payload: &mut Payload<'_>,
    element: &Element,
    table: &mut Table,
    tally: &mut Tally,
) -> bool {
    let mut fields = Vec::new();
    let mut stride = 0;
    for property in &element.properties {
        let Kind::Scalar(scalar) = property.kind else { return false };
        if let Some(column) = table::column(&property.name) {
            let slot = if column < NORMAL { column } else { table.slot(column) };
            fields.push(Field { at: stride, scalar, column, slot, name: &property.name });
        }
        stride += scalar.size();
    }
    let size = stride.saturating_mul(element.count);
    let Some((bytes, rest)) = payload.left.split_at_checked(size) else { return false };
    if payload.encoding == Encoding::Text || stride == 0 || payload.piece == 0 {
        return false;
    }
    let width = table.width();
    let mut values = table.values.chunks_mut((BLOCK * width).max(1));
    let places = table.places.chunks_mut(BLOCK);
    let parts: Vec<_> = places
        .zip(bytes.chunks(BLOCK * stride))
        .enumerate()
        .map(|(i, (places, bytes))| (i * BLOCK, places, values.next().unwrap_or_default(), bytes))
        .collect();
    let encoding = payload.encoding;
    let read = |(first, places, values, bytes): (usize, &mut [[f64; 3]], &mut [f32], &[u8])| {
        let mut tally = Tally::default();
        for (i, (place, row)) in places.iter_mut().zip(bytes.chunks_exact(stride)).enumerate() {
            let values = &mut values[i * width..(i + 1) * width];
            for field in &fields {
                let value = &row[field.at..field.at + field.scalar.size()];
                let value = number(value, field.scalar, encoding);
                if field.column < NORMAL {
                    place[field.slot] = value;
                } else if table::is_share(field.column) {
                    let context = || format!("vertex {}: {}", first + i, field.name);
                    values[field.slot] = tally.clamped(value / field.scalar.largest(), context);
                } else {
                    values[field.slot] = value as f32;
                }
            }
        }
        tally
    };
    let said: Vec<Tally> = parts.into_par_iter().map(read).collect();
    said.into_iter().for_each(|said| tally.append(said));
    payload.left = rest;
    true
}

/// Reads faces or strips whose only list is that of their corners; how many, which is fewer than all where there are
/// other lists, or something is wrong with one.
pub(super) fn faces(
    payload: &mut Payload<'_>,
    element: &Element,
    faces: &mut Faces,
    strip: bool,
) -> usize {
    let (mut before, mut list, mut after) = (0, None, 0);
    for (i, property) in element.properties.iter().enumerate() {
        match property.kind {
            Kind::List(length, item) if faces::indices(element) == Some(i) => {
                list = Some((length, item));
            }
            Kind::List(..) => return 0,
            Kind::Scalar(scalar) if list.is_none() => before += scalar.size(),
            Kind::Scalar(scalar) => after += scalar.size(),
        }
    }
    let Some((length, item)) =
        list.filter(|_| payload.encoding != Encoding::Text && payload.piece > 0)
    else {
        return 0;
    };
    let (first, encoding) = (before + length.size(), payload.encoding);
    let mut done = 0;
    while done < element.count {
        let Some(word) = payload.left.get(before..first) else { break };
        let size = number(word, length, encoding);
        if !(size >= 0.0 && size.fract() == 0.0 && size <= payload.left.len() as f64) {
            break;
        }
        let size = size as usize;
        let stride = first + size * item.size() + after;
        let rows = payload.left.chunks_exact(stride).take(element.count - done);
        let count = rows.take_while(|row| row[before..first] == *word).count();
        if count == 0 {
            break;
        }
        let (rows, left) = payload.left.split_at(count * stride);
        let end = first + size * item.size();
        faces.extend([done, count, size], strip, |corners| {
            corners_of(rows, stride, first..end, corners, |bytes| number(bytes, item, encoding))
        });
        (payload.left, done) = (left, done + count);
    }
    done
}

/// Reads the corners of rows of one length; gives the odd ones.
fn corners_of(
    rows: &[u8],
    stride: usize,
    list: std::ops::Range<usize>,
    corners: &mut [u32],
    number: impl Fn(&[u8]) -> f64 + Sync,
) -> Vec<(usize, f64)> {
    let size = corners.len() / (rows.len() / stride);
    if size == 0 {
        return Vec::new();
    }
    let item = list.len() / size;
    let read = |(i, (corners, rows)): (usize, (&mut [u32], &[u8]))| {
        let items = rows.chunks_exact(stride).flat_map(|row| row[list.clone()].chunks_exact(item));
        let mut odd = Vec::new();
        for (at, (corner, bytes)) in corners.iter_mut().zip(items).enumerate() {
            let value = number(bytes);
            *corner = faces::kept(value);
            if faces::is_odd(*corner) {
                odd.push((i * BLOCK * size + at, value));
            }
        }
        odd
    };
    if rows.len() < BLOCK * stride {
        return read((0, (corners, rows)));
    }
    let blocks = corners.par_chunks_mut(BLOCK * size).zip(rows.par_chunks(BLOCK * stride));
    blocks.enumerate().map(read).collect::<Vec<_>>().concat()
}
