//! The header: what elements there are, and of what their properties are.

use super::super::model::Unplaced;
use super::super::parts::{Tally, decode};

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// What a property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    /// The types of its length and of its items.
    List(Scalar, Scalar),
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Where the payload begins, in bytes and lines.
    pub(super) end: usize,
    pub(super) lines: usize,
}

impl Scalar {
    fn parse(word: &str) -> Unplaced<Self> {
        Ok(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "long" | "int64" => Self::I64,
            "ulong" | "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return Err(format!("type {word:?} is none of PLY's")),
        })
    }

    /// Bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The value that stands for full colour.
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::I64 => i64::MAX as f64,
            Self::U64 => u64::MAX as f64,
            Self::F32 | Self::F64 => 1.0,
        }
    }
}

impl Property {
    pub(super) fn is_scalar(&self) -> bool {
        matches!(self.kind, Kind::Scalar(_))
    }
}

impl Element {
    /// The fewest bytes that one can take.
    pub(super) fn least_size(&self, text: bool) -> usize {
        let sizes = self.properties.iter().map(|property| match property.kind {
            // A digit and what separates it from the next one.
            _ if text => 2,
            Kind::Scalar(scalar) | Kind::List(scalar, _) => scalar.size(),
        });
        sizes.sum()
    }
}

impl Header {
    /// Reads lines that end in LF, CR or both, up to `end_header`.
    pub(super) fn read(bytes: &[u8], tally: &mut Tally) -> Unplaced<Self> {
        let (mut encoding, mut elements) = (None, Vec::new());
        let (mut end, mut line, mut bare_returns) = (0, 0, false);
        loop {
            let left = bytes.get(end..).unwrap_or_default();
            if left.is_empty() && line > 0 {
                return Err("header: end_header is missing".to_owned());
            }
            let length = left.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(left.len());
            let text = decode(&left[..length]);
            let words: Vec<&str> = text.split_whitespace().collect();
            line += 1;
            let pair = left[length..].starts_with(b"\r\n");
            if line == 1 {
                if words != ["ply"] {
                    return Err("line 1: must be \"ply\"".to_owned());
                }
                bare_returns = left[length..].starts_with(b"\r") && !pair;
            }
            // Where lines end in CR, a LF after the last one would be data.
            end += length + if pair && !bare_returns { 2 } else { 1 };
            if words == ["end_header"] {
                let encoding = encoding.ok_or("header: format is missing")?;
                return Ok(Self { encoding, elements, end, lines: line });
            }
            if let [word, ..] = words[..]
                && !KNOWN.contains(&word)
            {
                tally.add("is not a line of a PLY header, and is left out", || {
                    format!("line {line}: {:?}", word.chars().take(40).collect::<String>())
                });
                continue;
            }
            statement(&words, &mut encoding, &mut elements)
                .map_err(|problem| format!("line {line}: {problem}"))?;
        }
    }

    pub(super) fn is_text(&self) -> bool {
        self.encoding == Encoding::Text
    }

    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }
}

/// The words that lines of a header begin with.
const KNOWN: [&str; 6] = ["ply", "comment", "obj_info", "format", "element", "property"];

fn statement(
    words: &[&str],
    encoding: &mut Option<Encoding>,
    elements: &mut Vec<Element>,
) -> Unplaced<()> {
    match words {
        [] | ["ply"] | ["comment" | "obj_info", ..] => {}
        ["format", format, ..] => {
            *encoding = Some(match *format {
                "ascii" => Encoding::Text,
                "binary_little_endian" => Encoding::Little,
                "binary_big_endian" => Encoding::Big,
                _ => {
                    return Err(
                        "format: must be ascii, binary_little_endian or binary_big_endian".into()
                    );
                }
            });
        }
        ["element", name, count, ..] => {
            if elements.iter().any(|element| element.name == *name) {
                return Err(format!("element {name}: is there twice"));
            }
            let wrong = |_| format!("element {name}: count: {count:?} is not a whole number");
            let (name, count) = ((*name).to_owned(), count.parse().map_err(wrong)?);
            elements.push(Element { name, count, properties: Vec::new() });
        }
        ["property", kind @ .., name] => {
            let kind = match kind {
                ["list", length, item] => Kind::List(Scalar::parse(length)?, Scalar::parse(item)?),
                [scalar] => Kind::Scalar(Scalar::parse(scalar)?),
                _ => return Err("property: needs a type and a name".to_owned()),
            };
            let element = elements.last_mut().ok_or("property: needs an element before it")?;
            element.properties.push(Property { name: (*name).to_owned(), kind });
        }
        [word, ..] => {
            let word: String = word.chars().take(40).collect();
            return Err(format!("{word:?} is not a line of a PLY header"));
        }
    }
    Ok(())
}
