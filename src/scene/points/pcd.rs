//! Point Cloud Library PCD of any version: a header of lines, then the points as text, as bytes, or as bytes
//! compressed with LZF, then one field after another.
//!
//! Fields that are read: `x y z`, `normal_x normal_y normal_z`, `rgb` or `rgba` (four bytes: blue, green, red and, of
//! `rgba`, opacity; also where the type is a float), `intensity` (where there is no colour: a grey that spans its range)
//! and `radius`. The viewpoint is not looked at.

use super::table::{self, ALPHA, COLOR, Table};
use super::{PointSize, lzf, model};
use crate::error::{Error, Result};
use crate::scene::Model;
use crate::scene::model::{MAX_TRIANGLES, Unplaced};

/// The most bytes of a point, and the most values.
const MAX_POINT: usize = 1 << 16;

/// The points of a PCD file. `place` names the file in messages.
///
/// # Errors
/// Names the line of the header, or the point, and the field.
pub fn parse(bytes: &[u8], place: &str) -> Result<Model> {
    parse_sized(bytes, place, PointSize::default())
}

/// As [`parse`], with radii.
///
/// # Errors
/// As [`parse`].
pub fn parse_sized(bytes: &[u8], place: &str, size: PointSize) -> Result<Model> {
    let table = Header::read(bytes).and_then(|(header, data)| header.table(data));
    model(&table.map_err(|problem| Error::new(place, problem))?, size, place)
}

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Signed,
    Unsigned,
    Float,
}

/// What a field means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// A column of the table.
    Column(usize),
    /// Packed bytes; with an opacity or not.
    Packed { alpha: bool },
    /// A grey, if there is no colour.
    Intensity,
    /// Nothing that is drawn.
    Skipped,
}

#[derive(Clone, Copy, Debug)]
struct Field {
    meaning: Meaning,
    kind: Kind,
    /// Bytes of a value: 1, 2, 4 or 8.
    size: usize,
    /// Values; only the first is read.
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Binary,
    Compressed,
}

struct Header {
    fields: Vec<Field>,
    points: usize,
    encoding: Encoding,
}

impl Header {
    /// The header, and what follows it.
    fn read(bytes: &[u8]) -> Unplaced<(Self, &[u8])> {
        let mut lines = Lines { left: bytes };
        let (mut fields, mut sizes, mut types) = (Vec::new(), Vec::new(), Vec::new());
        let (mut counts, mut width, mut height, mut points) = (Vec::new(), None, None, None);
        loop {
            let line = lines.next().ok_or("DATA: is missing; it ends the header")?;
            let mut words = line.split_whitespace();
            let Some(key) = words.next().filter(|key| !key.starts_with('#')) else { continue };
            let words: Vec<&str> = words.collect();
            let number = |word: &str| {
                let wrong = |_| format!("{key}: {:?} must be a whole number", clipped(word));
                word.parse::<usize>().map_err(wrong)
            };
            let numbers = || words.iter().map(|word| number(word)).collect::<Unplaced<Vec<_>>>();
            let one = || match numbers()?[..] {
                [only] => Ok(Some(only)),
                _ => Err(format!("{key}: needs one number")),
            };
            match key {
                // The library does not look at the version, either.
                "VERSION" | "VIEWPOINT" => {}
                "FIELDS" | "COLUMNS" => {
                    fields = words.iter().map(|&word| word.to_owned()).collect();
                }
                "SIZE" => sizes = numbers()?,
                "TYPE" => types = words.iter().map(kind).collect::<Unplaced<_>>()?,
                "COUNT" => counts = numbers()?,
                "WIDTH" => width = one()?,
                "HEIGHT" => height = one()?,
                "POINTS" => points = one()?,
                "DATA" => {
                    let encoding = encoding(&words)?;
                    let points = count(width, height, points)?;
                    if points > MAX_TRIANGLES {
                        return Err(format!("POINTS: {points} are more than {MAX_TRIANGLES}"));
                    }
                    let fields = layout(&fields, &sizes, &types, &counts)?;
                    return Ok((Self { fields, points, encoding }, lines.left));
                }
                other => return Err(format!("header: {:?} is not known", clipped(other))),
            }
        }
    }

    fn bytes_per_point(&self) -> usize {
        self.fields.iter().map(|field| field.size * field.count).sum()
    }

    fn table(&self, data: &[u8]) -> Unplaced<Table> {
        let whole = self.points.saturating_mul(self.bytes_per_point());
        let too_few = |needed: usize| {
            let (points, found) = (self.points, data.len());
            format!("POINTS: {points} need {needed} bytes after the header, which has {found}")
        };
        let mut fill = Fill::new(self);
        match self.encoding {
            Encoding::Ascii => self.read_text(data, &mut fill)?,
            Encoding::Binary if data.len() < whole => return Err(too_few(whole)),
            Encoding::Binary => {
                let stride = self.bytes_per_point();
                self.read_bytes(data, &mut fill, |_, offset| (offset, stride));
            }
            Encoding::Compressed => {
                let (lengths, data) = data.split_at_checked(8).ok_or_else(|| too_few(8))?;
                let length = |at: usize| {
                    u32::from_le_bytes(std::array::from_fn(|i| lengths[at + i])) as usize
                };
                let (packed, unpacked) = (length(0), length(4));
                if unpacked != whole {
                    return Err(format!(
                        "DATA: holds {unpacked} bytes, but {} points are {whole}",
                        self.points
                    ));
                }
                let packed = data.get(..packed).ok_or_else(|| too_few(packed + 8))?;
                let data = lzf::unpack(packed, unpacked).map_err(|p| format!("DATA: {p}"))?;
                let points = self.points;
                self.read_bytes(&data, &mut fill, |field, offset| {
                    (offset * points, field.size * field.count)
                });
            }
        }
        Ok(fill.finish())
    }

    /// `place` gives, of a field and its place in a point, where the first one lies and how far the next is from it.
    fn read_bytes(
        &self,
        data: &[u8],
        fill: &mut Fill,
        place: impl Fn(&Field, usize) -> (usize, usize),
    ) {
        fill.table.fill(self.points);
        let mut offset = 0;
        for field in &self.fields {
            let (first, step) = place(field, offset);
            offset += field.size * field.count;
            if field.meaning == Meaning::Skipped {
                continue;
            }
            for row in 0..self.points {
                let at = first + row * step;
                fill.set(row, field.meaning, number(&data[at..at + field.size], field.kind));
            }
        }
    }

    fn read_text(&self, data: &[u8], fill: &mut Fill) -> Unplaced<()> {
        // A value takes at least a digit and what separates it from the next.
        let values: usize = self.fields.iter().map(|field| field.count).sum();
        if self.points.saturating_mul(2 * values) > data.len().saturating_add(1) {
            let (points, bytes) = (self.points, data.len());
            return Err(format!("POINTS: {points} do not fit into {bytes} bytes"));
        }
        fill.table.fill(self.points);
        let mut lines = Lines { left: data };
        for row in 0..self.points {
            let line = loop {
                match lines.next() {
                    Some(line) if line.trim().is_empty() => {}
                    Some(line) => break line,
                    None => return Err(format!("point {row}: is missing")),
                }
            };
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.len() != values {
                // The library leaves such a point out: it has no place.
                fill.table.set(row, 0, f64::NAN);
                continue;
            }
            let mut words = words.into_iter();
            for field in &self.fields {
                for i in 0..field.count {
                    let word = words.next().unwrap_or_default();
                    if i == 0 && field.meaning != Meaning::Skipped {
                        let value = text_number(word, field).ok_or_else(|| {
                            format!("point {row}: {:?} is not a number of its type", clipped(word))
                        })?;
                        fill.set(row, field.meaning, value);
                    }
                }
            }
        }
        Ok(())
    }
}

/// A table that is being filled.
struct Fill {
    table: Table,
    /// Whether the colour is an intensity so far.
    grey: bool,
}

impl Fill {
    fn new(header: &Header) -> Self {
        let has = |wanted: fn(&Meaning) -> bool| header.fields.iter().any(|f| wanted(&f.meaning));
        let mut table = Table::default();
        for field in &header.fields {
            if let Meaning::Column(column) = field.meaning {
                table.has[column] = true;
            }
        }
        let packed = has(|meaning| matches!(meaning, Meaning::Packed { .. }));
        let grey = !packed && has(|meaning| *meaning == Meaning::Intensity);
        if packed || grey {
            table.has[COLOR..COLOR + 3].fill(true);
        }
        table.has[ALPHA] |= has(|meaning| *meaning == Meaning::Packed { alpha: true });
        Self { table, grey }
    }

    fn set(&mut self, row: usize, meaning: Meaning, value: Number) {
        if let Meaning::Column(column) = meaning {
            return self.table.set(row, column, value.real);
        }
        let table = &mut self.table;
        match meaning {
            Meaning::Packed { alpha } => {
                let [b, g, r, a] = value.bits.to_le_bytes();
                let mut share = |column, byte: u8| table.set(row, column, f64::from(byte) / 255.0);
                [r, g, b].into_iter().enumerate().for_each(|(i, byte)| share(COLOR + i, byte));
                if alpha {
                    share(ALPHA, a);
                }
            }
            Meaning::Intensity if self.grey => table.set(row, COLOR, value.real),
            Meaning::Intensity | Meaning::Skipped | Meaning::Column(_) => {}
        }
    }

    /// Intensities become greys: 0 at the smallest, 1 at the largest and where it is not finite.
    fn finish(mut self) -> Table {
        if self.grey {
            let rows = 0..self.table.rows();
            let all = rows.clone().map(|row| self.table.get(row, COLOR));
            let (min, max) = all
                .filter(|v| v.is_finite())
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)));
            let range = f64::from(max) - f64::from(min);
            for row in rows {
                let grey = (f64::from(self.table.get(row, COLOR)) - f64::from(min)) / range;
                let grey = if (0.0..=1.0).contains(&(grey as f32)) { grey } else { 1.0 };
                (COLOR..COLOR + 3).for_each(|column| self.table.set(row, column, grey));
            }
        }
        self.table
    }
}

/// A number, and the lower four bytes that it is stored in.
#[derive(Clone, Copy)]
struct Number {
    real: f64,
    bits: u32,
}

/// A little-endian number of 1, 2, 4 or 8 bytes.
fn number(bytes: &[u8], kind: Kind) -> Number {
    let mut word = [0; 8];
    word[..bytes.len()].copy_from_slice(bytes);
    let word = u64::from_le_bytes(word);
    let shift = 64 - 8 * bytes.len() as u32;
    let real = match (kind, bytes.len()) {
        (Kind::Float, 4) => f32::from_bits(word as u32).into(),
        (Kind::Float, _) => f64::from_bits(word),
        (Kind::Unsigned, _) => word as f64,
        (Kind::Signed, _) => ((word << shift) as i64 >> shift) as f64,
    };
    Number { real, bits: word as u32 }
}

/// A number as text, of a field's type.
fn text_number(word: &str, field: &Field) -> Option<Number> {
    match field.kind {
        // As the library reads it: a float is rounded once, to its own type.
        Kind::Float if field.size == 4 => {
            let value: f32 = word.parse().ok()?;
            Some(Number { real: value.into(), bits: value.to_bits() })
        }
        Kind::Float => Some(Number { real: word.parse().ok()?, bits: 0 }),
        Kind::Signed | Kind::Unsigned => {
            let value: i64 = word.parse().ok()?;
            Some(Number { real: value as f64, bits: value as u32 })
        }
    }
}

fn kind(word: &&str) -> Unplaced<Kind> {
    match *word {
        "I" => Ok(Kind::Signed),
        "U" => Ok(Kind::Unsigned),
        "F" => Ok(Kind::Float),
        other => Err(format!("TYPE: {:?} must be I, U or F", clipped(other))),
    }
}

fn encoding(words: &[&str]) -> Unplaced<Encoding> {
    match words {
        ["ascii"] => Ok(Encoding::Ascii),
        ["binary"] => Ok(Encoding::Binary),
        ["binary_compressed"] => Ok(Encoding::Compressed),
        _ => Err("DATA: must be ascii, binary or binary_compressed".to_owned()),
    }
}

/// How many points there are.
fn count(width: Option<usize>, height: Option<usize>, points: Option<usize>) -> Unplaced<usize> {
    let area = width.map(|width| width.saturating_mul(height.unwrap_or(1)));
    match (area, points) {
        (Some(area), Some(points)) if area != points => {
            Err(format!("POINTS: {points} are not WIDTH times HEIGHT, {area}"))
        }
        (_, Some(points)) => Ok(points),
        (Some(area), None) => Ok(area),
        (None, None) => Err("POINTS: is missing".to_owned()),
    }
}

/// The fields in the order of the file.
fn layout(
    names: &[String],
    sizes: &[usize],
    types: &[Kind],
    counts: &[usize],
) -> Unplaced<Vec<Field>> {
    for (key, found) in [("SIZE", sizes.len()), ("TYPE", types.len())] {
        if found != names.len() && found > 0 {
            return Err(format!("{key}: has {found} values for {} FIELDS", names.len()));
        }
    }
    if !(counts.is_empty() || counts.len() == names.len()) {
        return Err(format!("COUNT: has {} values for {} FIELDS", counts.len(), names.len()));
    }
    let field = |(i, name): (usize, &String)| {
        // Without these lines, all are floats of 4 bytes.
        let kind = types.get(i).copied().unwrap_or(Kind::Float);
        let size = sizes.get(i).copied().unwrap_or(4);
        let field = clipped(name);
        if !matches!(
            (kind, size),
            (Kind::Float, 4 | 8) | (Kind::Signed | Kind::Unsigned, 1 | 2 | 4 | 8)
        ) {
            return Err(format!("SIZE: a {kind:?} of {size} bytes, field {field:?}, is not known"));
        }
        let count = counts.get(i).copied().unwrap_or(1);
        let meaning = if count == 0 { Meaning::Skipped } else { meaning(name) };
        if matches!(meaning, Meaning::Packed { .. }) && size != 4 {
            return Err(format!("SIZE: field {field:?} needs 4 bytes, not {size}"));
        }
        Ok(Field { meaning, kind, size, count })
    };
    let fields = names.iter().enumerate().map(field).collect::<Unplaced<Vec<_>>>()?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if !fields.iter().any(|field| field.meaning == Meaning::Column(axis)) {
            return Err(format!("FIELDS: {name} is missing"));
        }
    }
    let bytes =
        fields.iter().fold(0usize, |sum, f| sum.saturating_add(f.size.saturating_mul(f.count)));
    if bytes > MAX_POINT {
        return Err(format!("COUNT: a point of {bytes} bytes is larger than {MAX_POINT}"));
    }
    Ok(fields)
}

fn meaning(name: &str) -> Meaning {
    match name {
        "rgb" => Meaning::Packed { alpha: false },
        "rgba" => Meaning::Packed { alpha: true },
        "intensity" => Meaning::Intensity,
        "x" | "y" | "z" | "normal_x" | "normal_y" | "normal_z" | "radius" => {
            table::column(name).map_or(Meaning::Skipped, Meaning::Column)
        }
        _ => Meaning::Skipped,
    }
}

/// Text for a message.
fn clipped(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Lines of bytes that may not be text.
struct Lines<'a> {
    left: &'a [u8],
}

impl<'a> Lines<'a> {
    /// The next line; empty where it is not UTF-8.
    fn next(&mut self) -> Option<&'a str> {
        if self.left.is_empty() {
            return None;
        }
        let end = self.left.iter().position(|&byte| byte == b'\n');
        let (line, left) = self.left.split_at(end.unwrap_or(self.left.len()));
        self.left = left.get(1..).unwrap_or_default();
        Some(std::str::from_utf8(line).unwrap_or_default())
    }
}
