//! `.npy` files of NumPy, versions 1 to 3: three axes, named z, y and x, of 1 to 4 byte integers, f4 or f8.

use super::Element;
use crate::error::{Error, Result};
use crate::scene::model::Unplaced;
use crate::scene::volume::Grid;

/// What a header says.
#[derive(Debug)]
struct Header {
    element: Element,
    big: bool,
    /// The first axis is the fastest.
    fortran: bool,
    /// z, y and x.
    shape: [u64; 3],
}

/// Reads a file. `place` names it in messages.
///
/// # Errors
/// Names the field of the header, or the voxel.
pub fn parse(bytes: &[u8], place: &str) -> Result<Grid> {
    read(bytes).map_err(|problem| Error::new(place, problem))
}

fn read(bytes: &[u8]) -> Unplaced<Grid> {
    let (text, data) = split(bytes)?;
    let Header { element, big, fortran, shape: [z, y, x] } = header(text)?;
    let values = element.decode(data, [x, y, z], big)?;
    let size = [x as usize, y as usize, z as usize];
    Grid::new(size, if fortran { turned(&values, size) } else { values })
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

fn header(text: &str) -> Unplaced<Header> {
    let descr = field(text, "descr")?;
    let descr = descr.strip_prefix('\'').and_then(|rest| Some(rest.split_once('\'')?.0));
    let (element, big) = element(descr.ok_or("descr: must be one type, like '<f4'")?)?;
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
    let shape = axes.and_then(|axes| <[u64; 3]>::try_from(axes).ok());
    let shape = shape.ok_or("shape: must be three whole numbers, (z, y, x)")?;
    Ok(Header { element, big, fortran, shape })
}

/// What follows a name.
fn field<'a>(text: &'a str, name: &str) -> Unplaced<&'a str> {
    let rest = text.split_once(&format!("'{name}'")).map(|(_, rest)| rest.trim_start());
    let rest = rest.and_then(|rest| rest.strip_prefix(':'));
    rest.map(str::trim_start).ok_or_else(|| format!("header: {name} is missing"))
}

fn element(descr: &str) -> Unplaced<(Element, bool)> {
    let (big, name) = match descr.split_at_checked(1) {
        Some(("<" | "|" | "=", name)) => (false, name),
        Some((">", name)) => (true, name),
        _ => (false, descr),
    };
    let element = match name {
        "u1" => Element::U8,
        "i1" => Element::I8,
        "u2" => Element::U16,
        "i2" => Element::I16,
        "u4" => Element::U32,
        "i4" => Element::I32,
        "f4" => Element::F32,
        "f8" => Element::F64,
        _ => {
            let right = "must be one of u1, i1, u2, i2, u4, i4, f4, f8";
            return Err(format!("descr: {descr:?} {right}"));
        }
    };
    Ok((element, big))
}

/// From z fastest to x fastest.
fn turned(values: &[f32], [x, y, z]: [usize; 3]) -> Vec<f32> {
    let places = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| (i, j, k))));
    places.map(|(i, j, k)| values[k + z * (j + y * i)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, text: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((text.len() as u16).to_le_bytes()),
            _ => bytes.extend((text.len() as u32).to_le_bytes()),
        }
        [&bytes, text.as_bytes(), data].concat()
    }

    fn dict(descr: &str, fortran: &str, shape: &str) -> String {
        format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}   \n")
    }

    /// Value 100 z + 10 y + x at each voxel of a grid of 3 x 2 x 2 (x, y, z), in each order and type.
    #[test]
    fn every_order_and_type_is_the_same_grid() {
        let value = |x: u8, y: u8, z: u8| 100 * z + 10 * y + x;
        let c: Vec<u8> = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .iter()
            .flat_map(|&(y, z)| [0, 1, 2].map(|x| value(x, y, z)))
            .collect();
        let f: Vec<u8> = [0, 1, 2]
            .iter()
            .flat_map(|&x| [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(y, z)| value(x, y, z)))
            .collect();
        let expected: Vec<f32> = c.iter().copied().map(f32::from).collect();
        let wide = |of: &dyn Fn(u8) -> Vec<u8>| c.iter().flat_map(|&v| of(v)).collect::<Vec<u8>>();
        let le = wide(&|v| f32::from(v).to_le_bytes().to_vec());
        let be = wide(&|v| f64::from(v).to_be_bytes().to_vec());
        let i2 = wide(&|v| i16::from(v).to_be_bytes().to_vec());
        for (descr, fortran, data) in [
            ("|u1", "False", &c),
            ("|u1", "True", &f),
            ("<f4", "False", &le),
            (">f8", "False", &be),
            (">i2", "False", &i2),
        ] {
            for version in [1, 2] {
                let grid = read(&file(version, &dict(descr, fortran, "(2, 2, 3)"), data)).unwrap();
                assert_eq!(grid.size(), [3, 2, 2]);
                assert_eq!(grid.values(), expected, "{descr} {fortran} {version}");
            }
        }
    }

    #[test]
    fn what_is_wrong_is_told() {
        let error = |text: &str, data: &[u8]| read(&file(1, text, data)).unwrap_err();
        let short = error(&dict("|u1", "False", "(2, 2, 2)"), &[0; 7]);
        assert!(short.contains("7 bytes") && short.contains("need 8"), "{short}");
        assert!(error(&dict("|u1", "False", "(2, 4)"), &[0; 8]).starts_with("shape"));
        assert!(error(&dict("|u1", "False", "(2, -2, 2)"), &[0; 8]).starts_with("shape"));
        assert!(error(&dict("<c8", "False", "(1, 1, 1)"), &[0; 8]).starts_with("descr"));
        assert!(error(&dict("<f4", "no", "(1, 1, 1)"), &[0; 4]).starts_with("fortran_order"));
        assert!(error("{}", &[]).contains("descr is missing"));
        let huge = "(9223372036854775807, 9223372036854775807, 4)";
        assert!(error(&dict("<f8", "False", huge), &[0; 8]).starts_with("size"));
        let nan = error(&dict("<f4", "False", "(1, 1, 1)"), &f32::NAN.to_le_bytes());
        assert!(nan.contains("is not finite"), "{nan}");
        let large = error(&dict("<f8", "False", "(1, 1, 1)"), &1e300_f64.to_le_bytes());
        assert!(large.contains("is not finite"), "{large}");
        for bytes in
            [&b""[..], b"\x93NUMPY", b"\x93NUMPY\x01\x00\xff", b"\x93NUMPY\x09\x00\x00\x00"]
        {
            assert!(read(bytes).unwrap_err().starts_with("header"));
        }
    }
}
