//! NumPy's arrays in files: `.npy` of versions 1 to 3, and the members of `.npz`.

use std::io::{Cursor, Read};

use zip::ZipArchive;

/// A result whose error says what is wrong, but not yet where.
type Unplaced<T> = Result<T, String>;

/// An array as it lies in a file.
#[derive(Debug)]
pub struct Array<'a> {
    /// The type of its numbers without the byte order, as in `f4`.
    pub element: &'a str,
    /// Bytes of a number come with the highest first.
    pub big: bool,
    /// The first axis is the fastest.
    pub fortran: bool,
    /// Its axes.
    pub shape: Vec<u64>,
    /// Its numbers.
    pub data: &'a [u8],
}

impl<'a> Array<'a> {
    /// The array in the bytes of a `.npy` file.
    ///
    /// # Errors
    /// The field of the header that is wrong. Whether the data are as long as the shape says is not looked at.
    pub fn of(bytes: &'a [u8]) -> Unplaced<Self> {
        let (text, data) = split(bytes)?;
        let descr = field(text, "descr")?;
        let descr = descr.strip_prefix('\'').and_then(|rest| Some(rest.split_once('\'')?.0));
        let descr = descr.ok_or("descr: must be one type, like '<f4'")?;
        let (big, element) = match descr.split_at_checked(1) {
            Some(("<" | "|" | "=", name)) => (false, name),
            Some((">", name)) => (true, name),
            _ => (false, descr),
        };
        let fortran = match field(text, "fortran_order")? {
            rest if rest.starts_with("True") => true,
            rest if rest.starts_with("False") => false,
            _ => return Err("fortran_order: must be True or False".to_owned()),
        };
        let shape =
            field(text, "shape")?.strip_prefix('(').and_then(|rest| Some(rest.split_once(')')?.0));
        let parts = shape.into_iter().flat_map(|inner| inner.split(','));
        let parts = parts.map(str::trim).filter(|part| !part.is_empty());
        let axes: Option<Vec<u64>> = parts.map(|part| part.parse().ok()).collect();
        let shape = axes.ok_or("shape: must be whole numbers, as in (2, 3)")?;
        Ok(Self { element, big, fortran, shape, data })
    }

    /// Its numbers in the order in which they lie there; whole numbers of up to 53 bits are exact.
    ///
    /// # Errors
    /// A type that is no number, or more or fewer bytes than the shape needs.
    pub fn reals(&self) -> Unplaced<Vec<f64>> {
        let one: fn(u64) -> f64 = match self.element {
            "b1" | "u1" | "u2" | "u4" | "u8" => |bits| bits as f64,
            "i1" => |bits| f64::from(bits as i8),
            "i2" => |bits| f64::from(bits as i16),
            "i4" => |bits| f64::from(bits as i32),
            "i8" => |bits| bits as i64 as f64,
            "f2" => |bits| half(bits as u16),
            "f4" => |bits| f64::from(f32::from_bits(bits as u32)),
            "f8" => f64::from_bits,
            _ => return Err(self.no_number()),
        };
        Ok(self.words()?.into_iter().map(one).collect())
    }

    /// Its numbers in the order in which they lie there, which must be whole and not negative.
    ///
    /// # Errors
    /// Another type, or more or fewer bytes than the shape needs.
    pub fn wholes(&self) -> Unplaced<Vec<u64>> {
        match self.element {
            "u1" | "u2" | "u4" | "u8" => self.words(),
            "i1" | "i2" | "i4" | "i8" => {
                let spare = 64 - 8 * self.width()? as u32;
                let words = self.words()?;
                match words.iter().all(|word| (word << spare) as i64 >= 0) {
                    true => Ok(words),
                    false => Err("data: must not be negative".to_owned()),
                }
            }
            _ => Err(format!("descr: {:?} must be whole numbers, as u4", self.element)),
        }
    }

    fn no_number(&self) -> String {
        let right = "must be one of u1, i1, u2, i2, u4, i4, u8, i8, f2, f4, f8";
        format!("descr: {:?} {right}", self.element)
    }

    /// Bytes of a number.
    fn width(&self) -> Unplaced<usize> {
        let width = self.element.get(1..).and_then(|digits| digits.parse().ok());
        width.filter(|width| [1, 2, 4, 8].contains(width)).ok_or_else(|| self.no_number())
    }

    /// Every number's bits, filled up with zeroes.
    fn words(&self) -> Unplaced<Vec<u64>> {
        let width = self.width()?;
        let count = self.shape.iter().try_fold(1_u64, |all, &axis| all.checked_mul(axis));
        let needed = count.and_then(|count| count.checked_mul(width as u64));
        if needed != Some(self.data.len() as u64) {
            let found = self.data.len();
            let needed = needed.map_or("far more".to_owned(), |needed| needed.to_string());
            return Err(format!("data: {found} bytes, but the shape needs {needed}"));
        }
        let one = |chunk: &[u8]| {
            let mut word = [0; 8];
            word[..width].copy_from_slice(chunk);
            if self.big {
                word[..width].reverse();
            }
            u64::from_le_bytes(word)
        };
        Ok(self.data.chunks_exact(width).map(one).collect())
    }
}

/// The arrays of a `.npz` file by name, without their endings, as the bytes of `.npy` files.
///
/// # Errors
/// It is no zip archive, is broken, or unpacks to more than `most` bytes.
pub fn members(bytes: &[u8], most: u64) -> Unplaced<Vec<(String, Vec<u8>)>> {
    let broken = |error: &dyn std::fmt::Display| format!("must be a whole .npz file ({error})");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| broken(&error))?;
    let (mut members, mut left) = (Vec::new(), most);
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|error| broken(&error))?;
        let name = file.name().map_err(|error| broken(&error))?;
        let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else { continue };
        let mut data = Vec::new();
        file.take(left + 1).read_to_end(&mut data).map_err(|error| broken(&error))?;
        left = left
            .checked_sub(data.len() as u64)
            .ok_or_else(|| format!("unpacks to more than {most} bytes"))?;
        members.push((name, data));
    }
    Ok(members)
}

/// The header's text and the data.
fn split(bytes: &[u8]) -> Unplaced<(&str, &[u8])> {
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or("header: is not that of a .npy file")?;
    let short = "header: is cut off";
    let &[major, _minor, ref rest @ ..] = rest else { return Err(short.to_owned()) };
    let (length, rest) = match (major, rest) {
        (1, &[a, b, ref rest @ ..]) => (u32::from(u16::from_le_bytes([a, b])), rest),
        (2 | 3, &[a, b, c, d, ref rest @ ..]) => (u32::from_le_bytes([a, b, c, d]), rest),
        (1..=3, _) => return Err(short.to_owned()),
        _ => return Err(format!("header: version {major} is not 1, 2 or 3")),
    };
    let (text, data) = rest.split_at_checked(length as usize).ok_or(short)?;
    let text = std::str::from_utf8(text).map_err(|_| "header: is not text")?;
    Ok((text, data))
}

/// What follows a name.
fn field<'a>(text: &'a str, name: &str) -> Unplaced<&'a str> {
    let rest = text.split_once(&format!("'{name}'")).map(|(_, rest)| rest.trim_start());
    let rest = rest.and_then(|rest| rest.strip_prefix(':'));
    rest.map(str::trim_start).ok_or_else(|| format!("header: {name} is missing"))
}

/// The number that 16 bits of floating point are.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1_023));
    let size = match exponent {
        0 => fraction / 16_777_216.0,
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction / 1_024.0) * libm::ldexp(1.0, exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        [&bytes, text.as_bytes(), data].concat()
    }

    #[test]
    fn numbers_of_every_type_are_read() {
        let read = |descr: &str, data: &[u8]| {
            Array::of(&file(descr, "(1,)", data)).unwrap().reals().map(|values| values[0])
        };
        assert_eq!(read("|u1", &[200]), Ok(200.0));
        assert_eq!(read("|i1", &[200]), Ok(-56.0));
        assert_eq!(read(">u2", &[1, 2]), Ok(258.0));
        assert_eq!(read("<i8", &(-5_i64).to_le_bytes()), Ok(-5.0));
        assert_eq!(read("<f2", &0x3800_u16.to_le_bytes()), Ok(0.5));
        assert_eq!(read("<f2", &0xC100_u16.to_le_bytes()), Ok(-2.5));
        assert_eq!(read("<f2", &1_u16.to_le_bytes()), Ok(1.0 / 16_777_216.0));
        assert_eq!(read("<f2", &0x7C00_u16.to_le_bytes()), Ok(f64::INFINITY));
        assert!(read("<f2", &0x7C01_u16.to_le_bytes()).unwrap().is_nan());
        assert_eq!(read(">f4", &0.25_f32.to_be_bytes()), Ok(0.25));
        assert_eq!(read("<f8", &(-0.1_f64).to_le_bytes()), Ok(-0.1));
        assert!(read("<c8", &[0; 8]).unwrap_err().starts_with("descr"));
        assert!(read("<é", &[0; 8]).unwrap_err().starts_with("descr"));
        assert!(read("<f4", &[0; 3]).unwrap_err().contains("needs 4"));
    }

    #[test]
    fn wholes_are_not_negative() {
        let read = |descr: &str, data: &[u8]| {
            Array::of(&file(descr, "(1,)", data)).unwrap().wholes().map(|values| values[0])
        };
        assert_eq!(read("<u4", &[255; 4]), Ok(0xFFFF_FFFF));
        assert_eq!(read("<u8", &u64::MAX.to_le_bytes()), Ok(u64::MAX));
        assert_eq!(read("<i4", &[1, 0, 0, 0]), Ok(1));
        assert!(read("<i4", &[255; 4]).unwrap_err().contains("negative"));
        assert!(read("<f4", &[0; 4]).unwrap_err().contains("whole"));
        let huge = "(9223372036854775807, 9223372036854775807)";
        assert!(Array::of(&file("<f8", huge, &[0; 8])).unwrap().reals().is_err());
    }
}
