//! Rows of text, many at once: where each row has a line of its own, what stands before it need not be read for it.

use super::super::parts::{ends_line, in_order, pieces};
use super::super::points::table::{self, NORMAL, Table};
use super::faces::{self, Faces};
use super::header::{Element, Kind, Scalar};
use super::payload::{Payload, value};

/// The rows at the beginning of a piece.
struct Rows<T> {
    found: T,
    count: usize,
    /// Bytes and ends of lines before the next row.
    bytes: usize,
    lines: usize,
    /// Whether the piece has nothing else.
    whole: bool,
}

/// Reads the rows at the beginning of a text, at most `most`, up to the first that is not as it should be: of that one
/// `read` keeps nothing, and gives `None`.
fn rows<T: Default>(
    text: &[u8],
    most: usize,
    read: impl Fn(usize, &[u8], &mut T) -> Option<()>,
) -> Rows<T> {
    let mut rows = Rows { found: T::default(), count: 0, bytes: 0, lines: 0, whole: false };
    while rows.bytes < text.len() {
        let left = &text[rows.bytes..];
        let length = left.iter().position(|&byte| ends_line(byte)).unwrap_or(left.len());
        let (line, end) = left.split_at(length);
        if !line.trim_ascii().is_empty() {
            if rows.count == most || read(rows.count, line, &mut rows.found).is_none() {
                return rows;
            }
            rows.count += 1;
        }
        rows.lines += usize::from(!end.is_empty());
        rows.bytes += length + if end.starts_with(b"\r\n") { 2 } else { end.len().min(1) };
    }
    rows.whole = true;
    rows
}

/// Reads the rows of an element, of which there are `count`, up to the first that is not as it should be; how many.
fn all<T: Default + Send>(
    payload: &mut Payload<'_>,
    count: usize,
    read: impl Fn(usize, &[u8], &mut T) -> Option<()> + Sync,
    mut keep: impl FnMut(usize, T) + Send,
) -> usize {
    if !payload.by_lines || payload.piece == 0 {
        return 0;
    }
    let text = payload.left;
    let (mut done, mut bytes, mut lines) = (0, 0, 0);
    let pieces = pieces(text, payload.piece, |_| true);
    // Where it ends, and whether early, is in what is counted.
    let _ = in_order(
        &pieces,
        |piece| (piece.clone(), rows(&text[piece.clone()], count, &read)),
        |(piece, found)| {
            // The piece may have rows of the next element.
            let left = count - done;
            let found = match found.count > left {
                true => rows(&text[piece], left, &read),
                false => found,
            };
            keep(done, found.found);
            done += found.count;
            bytes += found.bytes;
            lines += found.lines;
            if found.whole && done < count { Ok(()) } else { Err(()) }
        },
    );
    payload.left = &text[bytes..];
    payload.line += lines;
    done
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Reads vertices into a table that is filled already; how many. Those whose colours must be clamped are not as they
/// should be.
pub(super) fn vertices(payload: &mut Payload<'_>, element: &Element, table: &mut Table) -> usize {
    let mut fields = Vec::new();
    for property in &element.properties {
        let Kind::Scalar(scalar) = property.kind else { return 0 };
        let column = table::column(&property.name);
        let slot = |column| if column < NORMAL { column } else { table.slot(column) };
        fields.push((scalar, column.map(|column| (column, slot(column)))));
    }
    let width = table.width();
    let read = |_: usize, line: &[u8], rows: &mut (Vec<[f64; 3]>, Vec<f32>)| {
        let (mut place, start, mut words) = ([0.0; 3], rows.1.len(), words(line));
        rows.1.resize(start + width, 0.0);
        let mut field = |(scalar, column): &(Scalar, Option<(usize, usize)>)| {
            let value = value(words.next()?, *scalar == Scalar::F32)?;
            match *column {
                Some((column, slot)) if column < NORMAL => place[slot] = value,
                Some((column, slot)) => {
                    let share = table::is_share(column);
                    let value = if share { value / scalar.largest() } else { value };
                    (!share || (0.0..=1.0).contains(&value)).then_some(())?;
                    rows.1[start + slot] = value as f32;
                }
                None => {}
            }
            Some(())
        };
        let read = fields.iter().try_for_each(&mut field);
        let read = read.filter(|()| words.next().is_none());
        match read {
            Some(()) => rows.0.push(place),
            None => rows.1.truncate(start),
        }
        read
    };
    all(payload, element.count, read, |first, (places, values)| {
        table.places[first..first + places.len()].copy_from_slice(&places);
        table.values[first * width..first * width + values.len()].copy_from_slice(&values);
    })
}

/// Reads faces or strips; how many.
pub(super) fn faces(
    payload: &mut Payload<'_>,
    element: &Element,
    faces: &mut Faces,
    strip: bool,
) -> usize {
    let wanted = faces::indices(element);
    let read = |number: usize, line: &[u8], found: &mut Faces| {
        let start = found.len();
        let whole = corners(element, wanted, line, found);
        match whole {
            Some(()) => found.end(number, start, strip),
            None => found.truncate(start),
        }
        whole
    };
    all(payload, element.count, read, |first, found| faces.append(first, found))
}

/// Adds the corners of one line.
fn corners(element: &Element, wanted: Option<usize>, line: &[u8], found: &mut Faces) -> Option<()> {
    let mut words = words(line);
    let mut next = |scalar: Scalar| {
        let word = words.next()?;
        let single = scalar == Scalar::F32;
        whole(word).filter(|_| !single).or_else(|| value(word, single))
    };
    for (i, property) in element.properties.iter().enumerate() {
        match property.kind {
            Kind::Scalar(scalar) => drop(next(scalar)?),
            Kind::List(length, item) => {
                let length = next(length)?;
                (length >= 0.0 && length.fract() == 0.0).then_some(())?;
                let mut left = length;
                while left > 0.0 {
                    let value = next(item)?;
                    if wanted == Some(i) {
                        found.push(value);
                    }
                    left -= 1.0;
                }
            }
        }
    }
    words.next().is_none().then_some(())
}

/// A whole number of a few digits, which needs no rounding.
fn whole(word: &[u8]) -> Option<f64> {
    let digit = |byte: &u8| byte.is_ascii_digit();
    let number = |number: u32, byte: &u8| number * 10 + u32::from(byte - b'0');
    (word.len() <= 9 && word.iter().all(digit)).then(|| word.iter().fold(0, number).into())
}
