//! A piece of a file, read without what stands before it. Lines that are as they should be become numbers; of all others,
//! only where they are is kept, for [`Reader`](super::reader::Reader) to read them when all before them is known.

use super::statement::statement;

/// A corner of a face as it is written: vertex, texture coordinates, normal; 0 where there is none.
pub(super) type Written = [i32; 3];

/// What was read, in its order.
#[derive(Debug, Default)]
pub(super) struct Piece<'a> {
    pub(super) text: &'a str,
    pub(super) lines: usize,
    pub(super) runs: Vec<Run>,
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) places: Vec<[f32; 2]>,
    pub(super) corners: Vec<Written>,
}

/// Lines of one kind, one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) kind: Kind,
    pub(super) count: usize,
    /// How many lines of the piece stand before the first.
    pub(super) line: usize,
    /// Where the first one begins, in bytes.
    pub(super) at: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `v x y z`.
    Vertices,
    /// `v x y z r g b`, the colour within 0 to 1.
    Colored,
    Normals,
    Places,
    /// Faces of as many corners; their indices are numbers, and none is 0.
    Faces(usize),
    /// A statement of any kind, perhaps of several lines.
    Other,
}

impl<'a> Piece<'a> {
    /// Reads whole lines, the last of which does not go on.
    pub(super) fn read(text: &'a str) -> Self {
        let mut piece = Self { text, ..Self::default() };
        let mut at = 0;
        while at < text.len() {
            let mut line = Line { text, at };
            if let Some(kind) = piece.usual(&mut line) {
                piece.push(kind, at);
                piece.lines += 1;
                at = line.at;
                continue;
            }
            let (whole, lines, rest) = statement(&text[at..]);
            if !matches!(whole.trim_start().as_bytes(), [] | [b'#', ..]) {
                piece.push(Kind::Other, at);
            }
            piece.lines += lines;
            at = text.len() - rest.map_or(0, str::len);
        }
        piece
    }

    /// Adds a line, to the last run if it can.
    fn push(&mut self, kind: Kind, at: usize) {
        let line = self.lines;
        // Faces are found again by counting lines.
        let goes_on = |run: &Run| match kind {
            Kind::Other => false,
            Kind::Faces(_) => run.kind == kind && run.line + run.count == line,
            _ => run.kind == kind,
        };
        match self.runs.last_mut().filter(|run| goes_on(run)) {
            Some(run) => run.count += 1,
            None => self.runs.push(Run { kind, count: 1, line, at }),
        }
    }

    /// Keeps the numbers of a line that is as it should be; otherwise nothing, and `None`.
    fn usual(&mut self, line: &mut Line<'a>) -> Option<Kind> {
        match line.keyword()? {
            b"v" => {
                let position = line.numbers()?;
                if line.ends() {
                    self.positions.push(position);
                    return Some(Kind::Vertices);
                }
                let color: [f64; 3] = line.numbers()?;
                let inside = color.iter().all(|channel| (0.0..=1.0).contains(channel));
                (inside && line.ends()).then_some(())?;
                self.positions.push(position);
                self.colors.push(color.map(|channel| channel as f32));
                Some(Kind::Colored)
            }
            b"vn" => {
                let normal = line.numbers()?.map(|c: f64| c as f32);
                (line.ends() && normal.iter().all(|c| c.is_finite())).then_some(())?;
                self.normals.push(normal);
                Some(Kind::Normals)
            }
            b"vt" => {
                let [u, v] = line.numbers()?;
                // A third number is not used.
                (line.ends() || (line.number().is_some() && line.ends())).then_some(())?;
                self.places.push([u as f32, (1.0 - v) as f32]);
                Some(Kind::Places)
            }
            b"f" => {
                let start = self.corners.len();
                let whole = self.face(line);
                if whole.is_none() {
                    self.corners.truncate(start);
                }
                whole
            }
            _ => None,
        }
    }

    fn face(&mut self, line: &mut Line<'_>) -> Option<Kind> {
        let mut count = 0;
        while !line.ends() {
            let vertex = line.index()?;
            let (mut place, mut normal) = (0, 0);
            if line.skips(b'/') {
                place = if line.is_index() { line.index()? } else { 0 };
                if line.skips(b'/') {
                    normal = if line.is_index() { line.index()? } else { 0 };
                }
            }
            line.is_between().then_some(())?;
            self.corners.push([vertex, place, normal]);
            count += 1;
        }
        (count >= 3).then_some(Kind::Faces(count))
    }
}

/// Where one is in a line.
struct Line<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Line<'a> {
    fn byte(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// Whether one is at the end of a word.
    fn is_between(&self) -> bool {
        matches!(self.byte(), None | Some(b' ' | b'\t' | b'\r' | b'\n'))
    }

    /// Passes blanks.
    fn blanks(&mut self) {
        while let Some(b' ' | b'\t') = self.byte() {
            self.at += 1;
        }
    }

    /// Passes a byte, if it is the next one.
    fn skips(&mut self, byte: u8) -> bool {
        let is = self.byte() == Some(byte);
        self.at += usize::from(is);
        is
    }

    /// Passes the end of the line, if only blanks are before it.
    fn ends(&mut self) -> bool {
        self.blanks();
        match self.byte() {
            None => true,
            Some(b'\n') => self.skips(b'\n'),
            Some(b'\r') => {
                self.at += 1;
                self.skips(b'\n');
                true
            }
            Some(_) => false,
        }
    }

    /// The next word of the line; empty at its end.
    fn word(&mut self) -> Option<&'a str> {
        self.blanks();
        let start = self.at;
        while !self.is_between() {
            self.at += 1;
        }
        self.text.get(start..self.at)
    }

    fn keyword(&mut self) -> Option<&'a [u8]> {
        self.word().map(str::as_bytes)
    }

    /// A finite number.
    fn number(&mut self) -> Option<f64> {
        self.word()?.parse().ok().filter(|number: &f64| number.is_finite())
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    fn is_index(&self) -> bool {
        matches!(self.byte(), Some(b'-' | b'0'..=b'9'))
    }

    /// A whole number of at most nine digits that is not 0.
    fn index(&mut self) -> Option<i32> {
        let negative = self.skips(b'-');
        let start = self.at;
        let mut number = 0;
        while let Some(digit @ b'0'..=b'9') = self.byte() {
            (self.at - start < 9).then_some(())?;
            number = number * 10 + i32::from(digit - b'0');
            self.at += 1;
        }
        let number = if negative { -number } else { number };
        (number != 0).then_some(number)
    }
}
