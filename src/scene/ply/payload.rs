//! The numbers after the header, one after the other.

use std::ops::Range;

use rayon::prelude::*;

use super::super::model::Unplaced;
use super::super::parts::{ends_line, pieces};
use super::header::{Encoding, Header, Kind, Scalar};

/// What is left to read.
pub(super) struct Payload<'a> {
    pub(super) left: &'a [u8],
    pub(super) encoding: Encoding,
    /// Of text: the number of the line.
    pub(super) line: usize,
    /// Of text: there are as many lines as elements, so that each has its own.
    pub(super) by_lines: bool,
    /// The first line with more on it than its element has.
    beyond: Option<usize>,
    /// Of text: how many bytes are read at once; 0 where rows are read one after the other, also of binary files.
    pub(super) piece: usize,
}

impl<'a> Payload<'a> {
    /// What follows a header; text is read in pieces of about `piece` bytes. 0 is for rows one after the other.
    pub(super) fn new(bytes: &'a [u8], header: &Header, piece: usize) -> Self {
        let left = bytes.get(header.end..).unwrap_or_default();
        let filled = |own: &Range<usize>| {
            let lines = left[own.clone()].split(|&byte| ends_line(byte));
            lines.filter(|line| !line.trim_ascii().is_empty()).count()
        };
        let filled = || pieces(left, piece, |_| true).par_iter().map(filled).sum::<usize>();
        let elements = header.elements.iter().fold(0, |sum: usize, e| sum.saturating_add(e.count));
        let by_lines = header.encoding == Encoding::Text && filled() >= elements;
        let (encoding, line) = (header.encoding, header.lines + 1);
        Self { left, encoding, line, by_lines, beyond: None, piece }
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
        Ok(number(bytes, scalar, self.encoding))
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
        if let Some(value) = value(word, single) {
            return Ok(value);
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

/// The number that a word says; one that is `single` is rounded once.
pub(super) fn value(word: &[u8], single: bool) -> Option<f64> {
    let text = std::str::from_utf8(word).unwrap_or_default();
    let value = if single { text.parse().map(|v: f32| v.into()) } else { text.parse::<f64>() };
    value.ok().or_else(|| {
        // Printed by C: -nan(ind), 1.#QNAN, -1.#IND and the like.
        let lower = text.to_ascii_lowercase();
        let none = lower.contains("nan") || lower.contains("#i") || lower.contains("#q");
        none.then_some(f64::NAN)
    })
}

/// The number of a binary file that takes all of `bytes`. All but the largest integers of 8 bytes fit into an f64.
#[inline]
pub(super) fn number(bytes: &[u8], scalar: Scalar, encoding: Encoding) -> f64 {
    let big = encoding == Encoding::Big;
    match scalar {
        Scalar::I8 => f64::from(i8::from_le_bytes(word(bytes, big))),
        Scalar::U8 => f64::from(u8::from_le_bytes(word(bytes, big))),
        Scalar::I16 => f64::from(i16::from_le_bytes(word(bytes, big))),
        Scalar::U16 => f64::from(u16::from_le_bytes(word(bytes, big))),
        Scalar::I32 => f64::from(i32::from_le_bytes(word(bytes, big))),
        Scalar::U32 => f64::from(u32::from_le_bytes(word(bytes, big))),
        Scalar::I64 => i64::from_le_bytes(word(bytes, big)) as f64,
        Scalar::U64 => u64::from_le_bytes(word(bytes, big)) as f64,
        Scalar::F32 => f64::from(f32::from_le_bytes(word(bytes, big))),
        Scalar::F64 => f64::from_le_bytes(word(bytes, big)),
    }
}

/// The bytes of a number, the lowest first.
#[inline]
fn word<const N: usize>(bytes: &[u8], big: bool) -> [u8; N] {
    let mut word = bytes.try_into().unwrap_or([0; N]);
    if big {
        word.reverse();
    }
    word
}
