//! `.nrrd` and `.nhdr` files: three axes, x the fastest, in the encodings raw, gzip and ascii, in the same file or in
//! one detached file. Fields that do not matter here are left out, like units, labels and the place in space.

use std::io::Read;

use super::Element;
use crate::error::{Error, Result};
use crate::scene::model::Unplaced;
use crate::scene::volume::Grid;
use crate::scene::volume::grid::voxels;

/// How the data are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Raw,
    Gzip,
    Ascii,
}

/// What a header says.
#[derive(Debug, Default)]
struct Header {
    element: Option<Element>,
    sizes: Option<[u64; 3]>,
    encoding: Option<Encoding>,
    big: Option<bool>,
    spacing: Option<[f64; 3]>,
    detached: Option<String>,
}

/// Reads a file, with what `read` gives for the name of a detached one. `place` names it in messages.
///
/// # Errors
/// Names the field of the header, or the voxel; `read`'s errors.
pub fn parse(
    bytes: &[u8],
    place: &str,
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
) -> Result<Grid> {
    let wrong = |problem: String| Error::new(place, problem);
    let (header, rest) = header(bytes).map_err(wrong)?;
    match &header.detached {
        Some(name) => header.grid(&read(name)?).map_err(wrong),
        None => header.grid(rest).map_err(wrong),
    }
}

/// The header, and what follows the empty line after it.
fn header(bytes: &[u8]) -> Unplaced<(Header, &[u8])> {
    let mut lines = Lines { rest: bytes };
    if !lines.next_line()?.is_some_and(|line| line.starts_with("NRRD000")) {
        return Err("header: is not that of a .nrrd file".to_owned());
    }
    let mut header = Header::default();
    while let Some(line) = lines.next_line()?.filter(|line| !line.is_empty()) {
        if line.starts_with('#') || line.contains(":=") {
            continue;
        }
        let (name, value) =
            line.split_once(':').ok_or_else(|| format!("header: {line:.40?} is no field"))?;
        header.take(name.trim(), value.trim())?;
    }
    Ok((header, lines.rest))
}

/// Lines that end with a line feed, or a carriage return and one.
struct Lines<'a> {
    rest: &'a [u8],
}

impl<'a> Lines<'a> {
    fn next_line(&mut self) -> Unplaced<Option<&'a str>> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let end = self.rest.iter().position(|&byte| byte == b'\n').unwrap_or(self.rest.len());
        let line = &self.rest[..end];
        self.rest = self.rest.get(end + 1..).unwrap_or_default();
        let text = std::str::from_utf8(line).map_err(|_| "header: is not text")?;
        Ok(Some(text.trim_end_matches('\r')))
    }
}

impl Header {
    fn take(&mut self, name: &str, value: &str) -> Unplaced<()> {
        match name {
            "type" => self.element = Some(element(value)?),
            "dimension" if value != "3" => return Err(format!("dimension: {value} must be 3")),
            "sizes" => {
                let words = value.split_whitespace().map(|word| word.parse().ok());
                let sizes = words.collect::<Option<Vec<u64>>>();
                let sizes = sizes.and_then(|sizes| <[u64; 3]>::try_from(sizes).ok());
                self.sizes = Some(sizes.ok_or("sizes: must be three whole numbers")?);
            }
            "encoding" => self.encoding = Some(encoding(value)?),
            "endian" => {
                self.big = Some(match value {
                    "little" => false,
                    "big" => true,
                    _ => return Err(format!("endian: {value:?} must be little or big")),
                });
            }
            "spacings" => {
                let parts = value.split_whitespace().map(|word| word.parse().ok());
                self.spacing = Some(spacing(parts.collect(), "spacings")?);
            }
            "space directions" => {
                self.spacing = Some(spacing(directions(value), "space directions")?);
            }
            "data file" | "datafile" => {
                if value.split_whitespace().count() != 1 || value == "LIST" {
                    return Err(format!("data file: {value:?} must be the name of one file"));
                }
                self.detached = Some(value.to_owned());
            }
            "byte skip" | "byteskip" | "line skip" | "lineskip" if value != "0" => {
                return Err(format!("{name}: {value} must be 0"));
            }
            _ => {}
        }
        Ok(())
    }

    fn grid(&self, data: &[u8]) -> Unplaced<Grid> {
        let element = self.element.ok_or("type: is missing")?;
        let sizes = self.sizes.ok_or("sizes: is missing")?;
        let encoding = self.encoding.ok_or("encoding: is missing")?;
        let count = voxels(sizes)?;
        let big = match self.big {
            None if element.bytes() > 1 && encoding != Encoding::Ascii => {
                return Err("endian: is missing".to_owned());
            }
            big => big.unwrap_or(false),
        };
        let values = match encoding {
            Encoding::Raw => element.decode(data, sizes, big)?,
            Encoding::Gzip => {
                let needed = count as u64 * element.bytes() as u64;
                element.decode(&unpacked(data, needed)?, sizes, big)?
            }
            Encoding::Ascii => numbers(data, count)?,
        };
        let grid = Grid::new(sizes.map(|n| n as usize), values)?;
        match self.spacing {
            Some(spacing) => grid.spaced(spacing),
            None => Ok(grid),
        }
    }
}

/// What is packed, up to one byte more than needed.
fn unpacked(data: &[u8], needed: u64) -> Unplaced<Vec<u8>> {
    let mut found = Vec::new();
    let mut reader = flate2::read::MultiGzDecoder::new(data).take(needed + 1);
    reader.read_to_end(&mut found).map_err(|error| format!("data: cannot be unpacked: {error}"))?;
    Ok(found)
}

/// Numbers as text; one more than needed is enough to see that there are too many.
fn numbers(data: &[u8], count: usize) -> Unplaced<Vec<f32>> {
    let text = std::str::from_utf8(data).map_err(|_| "data: is not text")?;
    let words = text.split_ascii_whitespace().take(count + 1);
    let number = |word: &str| word.parse().map_err(|_| format!("data: {word:.40?} is no number"));
    words.map(number).collect()
}

fn element(name: &str) -> Unplaced<Element> {
    match name {
        "signed char" | "int8" | "int8_t" => Ok(Element::I8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Ok(Element::U8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Ok(Element::I16)
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => {
            Ok(Element::U16)
        }
        "int" | "signed int" | "int32" | "int32_t" => Ok(Element::I32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Ok(Element::U32),
        "float" => Ok(Element::F32),
        "double" => Ok(Element::F64),
        _ => Err(format!("type: {name:?} must be an integer of at most 4 bytes, float or double")),
    }
}

fn encoding(name: &str) -> Unplaced<Encoding> {
    match name {
        "raw" => Ok(Encoding::Raw),
        "gzip" | "gz" => Ok(Encoding::Gzip),
        "ascii" | "text" | "txt" => Ok(Encoding::Ascii),
        _ => Err(format!("encoding: {name:?} must be raw, gzip or ascii")),
    }
}

/// The length of each of three vectors like `(1,0,0)`.
fn directions(text: &str) -> Option<Vec<f64>> {
    let vectors = text.split(')').map(str::trim).filter(|part| !part.is_empty());
    let length = |part: &str| {
        let inner = part.strip_prefix('(')?;
        let squares = inner.split(',').map(|word| word.trim().parse::<f64>().ok().map(|x| x * x));
        Some(squares.collect::<Option<Vec<f64>>>()?.iter().fold(0.0, |sum, x| sum + x).sqrt())
    };
    vectors.map(length).collect()
}

fn spacing(parts: Option<Vec<f64>>, name: &str) -> Unplaced<[f64; 3]> {
    let three = parts.and_then(|parts| <[f64; 3]>::try_from(parts).ok());
    three.ok_or_else(|| format!("{name}: must be given for three axes"))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    const HEAD: &str = "NRRD0004\n# a comment\ntype: uchar\ndimension: 3\nsizes: 3 2 1\nkey:=value\nunits: a b c\n";

    fn grid(text: &str, data: &[u8]) -> Result<Grid> {
        parse(&[text.as_bytes(), data].concat(), "it", &mut |name| {
            assert_eq!(name, "beside.raw");
            Ok(vec![1, 2, 3, 4, 5, 6])
        })
    }

    #[test]
    fn every_encoding_is_the_same_grid() {
        let data = [1, 2, 3, 4, 5, 6];
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(&data).unwrap();
        let packed = packer.finish().unwrap();
        let cases = [
            ("encoding: raw\n\n", &data[..]),
            ("encoding: raw\r\n\r\n", &data),
            ("encoding: gzip\n\n", &packed),
            ("encoding: ascii\n\n", b"1 2 3\n4 5 6\n"),
            ("encoding: raw\ndata file: beside.raw\n", b""),
            ("encoding: raw\nspacings: 1 1 1\n\n", &data),
        ];
        for (rest, data) in cases {
            let grid = grid(&format!("{HEAD}{rest}"), data).unwrap();
            assert_eq!(grid.size(), [3, 2, 1], "{rest}");
            assert_eq!(grid.values(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{rest}");
        }
        let spaced = "encoding: raw\nspace directions: (0,3,4) (0.5,0,0) (0,0,-2)\n\n";
        assert_eq!(grid(&format!("{HEAD}{spaced}"), &data).unwrap().extent(), [15.0, 1.0, 2.0]);
    }

    #[test]
    fn what_is_wrong_is_told() {
        let error =
            |rest: &str, data: &[u8]| grid(&format!("{HEAD}{rest}"), data).unwrap_err().to_string();
        let short = error("encoding: raw\n\n", &[0; 5]);
        assert!(short.contains("5 bytes") && short.contains("need 6"), "{short}");
        assert!(error("encoding: ascii\n\n", b"1 2 3 4 5 6 7").contains("7 values for 3 x 2 x 1"));
        assert!(error("encoding: ascii\n\n", b"1 2 3 4 5 x").contains("\"x\" is no number"));
        assert!(error("encoding: ascii\n\n", b"1 2 3 4 5 nan").contains("is not finite"));
        assert!(error("encoding: bzip2\n\n", b"").contains("encoding"));
        assert!(error("encoding: gzip\n\n", b"abc").contains("cannot be unpacked"));
        assert!(error("type: short\nencoding: raw\n\n", &[0; 12]).contains("endian: is missing"));
        assert!(error("type: block\n\n", b"").contains("type"));
        assert!(error("dimension: 4\n\n", b"").contains("dimension"));
        assert!(error("sizes: 3 2\n\n", b"").contains("sizes"));
        assert!(error("sizes: 99999999 99999999 9\nencoding: gzip\n\n", b"").contains("size"));
        assert!(error("encoding: raw\nspacings: 1 0 1\n\n", &[0; 6]).contains("above 0"));
        assert!(error("data file: LIST\n\n", b"").contains("one file"));
        assert!(grid("", b"").unwrap_err().to_string().contains("header"));
    }

    /// A small file that unpacks to much more than its header says is read no farther than one byte beyond.
    #[test]
    fn what_is_packed_is_read_no_farther_than_needed() {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(&vec![0; 1 << 20]).unwrap();
        let error = grid(&format!("{HEAD}encoding: gzip\n\n"), &packer.finish().unwrap());
        assert!(error.unwrap_err().to_string().contains("7 bytes"));
    }
}
