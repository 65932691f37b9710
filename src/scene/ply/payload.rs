//! The numbers after the header, one after the other.

use super::super::model::Unplaced;
use super::header::{Encoding, Header, Kind, Scalar};

/// What is left to read.
pub(super) struct Payload<'a> {
    left: &'a [u8],
    encoding: Encoding,
    /// Of text: the number of the line.
    line: usize,
    /// Of text: there are as many lines as elements, so that each has its own.
    by_lines: bool,
    /// The first line with more on it than its element has.
    beyond: Option<usize>,
}

impl<'a> Payload<'a> {
    pub(super) fn new(bytes: &'a [u8], header: &Header) -> Self {
        let left = bytes.get(header.end..).unwrap_or_default();
        let lines = || left.split(|b| matches!(b, b'\n' | b'\r'));
        let filled = || lines().filter(|line| !line.trim_ascii().is_empty()).count();
        let elements = header.elements.iter().fold(0, |sum: usize, e| sum.saturating_add(e.count));
        let by_lines = header.encoding == Encoding::Text && filled() >= elements;
        let (encoding, line) = (header.encoding, header.lines + 1);
        Self { left, encoding, line, by_lines, beyond: None }
    }

    /// After an element: what else is on its line is left out, if each has a line of its own.
    pub(super) fn end_row(&mut self) {
        if !self.by_lines {
            return;
        }
        let end = self.left.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let (rest, left) = self.left.split_at(end.unwrap_or(self.left.len()));
        if !rest.trim_ascii().is_empty() {
            self.beyond.get_or_insert(self.line);
        }
        self.left = left;
    }

    /// The first line of which something was left out.
    pub(super) fn beyond(&self) -> Option<usize> {
        self.beyond
    }

    /// The next number. All but the largest integers of 8 bytes fit into an f64.
    pub(super) fn scalar(&mut self, scalar: Scalar) -> Unplaced<f64> {
        if self.encoding == Encoding::Text {
            return self.word(scalar == Scalar::F32);
        }
        let size = scalar.size();
        let (bytes, left) = self.left.split_at_checked(size).ok_or("the file ends before it")?;
        self.left = left;
        let mut word = [0; 8];
        word[..size].copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            word[..size].reverse();
        }
        let word = u64::from_le_bytes(word);
        Ok(match scalar {
            Scalar::I8 => f64::from(word as i8),
            Scalar::I16 => f64::from(word as i16),
            Scalar::I32 => f64::from(word as i32),
            Scalar::I64 => word as i64 as f64,
            Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => word as f64,
            Scalar::F32 => f64::from(f32::from_bits(word as u32)),
            Scalar::F64 => f64::from_bits(word),
        })
    }

    /// The length of the next list.
    pub(super) fn length(&mut self, scalar: Scalar) -> Unplaced<usize> {
        let length = self.scalar(scalar)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= self.left.len() as f64 {
            return Ok(length as usize);
        }
        Err(format!("{}a list of {length} items does not fit into the file", self.place()))
    }

    pub(super) fn skip(&mut self, kind: Kind) -> Unplaced<()> {
        match kind {
            Kind::Scalar(scalar) => self.scalar(scalar).map(drop),
            Kind::List(length, item) => {
                let length = self.length(length)?;
                (0..length).try_for_each(|_| self.scalar(item).map(drop))
            }
        }
    }

    /// The next number of a text; one that is `single` is rounded once, to its own type, as in a binary file.
    fn word(&mut self, single: bool) -> Unplaced<f64> {
        let space = |byte: &u8| byte.is_ascii_whitespace();
        let start = self.left.iter().position(|b| !space(b)).unwrap_or(self.left.len());
        let (blank, left) = self.left.split_at(start);
        for (i, &byte) in blank.iter().enumerate() {
            let second = byte == b'\n' && i > 0 && blank[i - 1] == b'\r';
            self.line += usize::from(matches!(byte, b'\n' | b'\r') && !second);
        }
        let end = left.iter().position(space).unwrap_or(left.len());
        let (word, left) = left.split_at(end);
        self.left = left;
        if word.is_empty() {
            return Err(format!("{}the file ends before it", self.place()));
        }
        let text = std::str::from_utf8(word).unwrap_or_default();
        let value = if single { text.parse().map(|v: f32| v.into()) } else { text.parse::<f64>() };
        if let Ok(value) = value {
            return Ok(value);
        }
        // Printed by C: -nan(ind), 1.#QNAN, -1.#IND and the like.
        let lower = text.to_ascii_lowercase();
        if lower.contains("nan") || lower.contains("#i") || lower.contains("#q") {
            return Ok(f64::NAN);
        }
        let word: String = String::from_utf8_lossy(word).chars().take(40).collect();
        Err(format!("{}{word:?} is not a number", self.place()))
    }

    /// Where in a text this is.
    fn place(&self) -> String {
        match self.encoding {
            Encoding::Text => format!("line {}: ", self.line),
            Encoding::Little | Encoding::Big => String::new(),
        }
    }
}
