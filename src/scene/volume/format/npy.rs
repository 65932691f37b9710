//! `.npy` files of NumPy, versions 1 to 3: three axes, named z, y and x, of 1 to 4 byte integers, f4 or f8.

use super::Element;
use crate::error::{Error, Result};
use crate::num::npy::Array;
use crate::scene::model::Unplaced;
use crate::scene::volume::Grid;

/// Reads a file. `place` names it in messages.
///
/// # Errors
/// Names the field of the header, or the voxel.
pub fn parse(bytes: &[u8], place: &str) -> Result<Grid> {
    read(bytes).map_err(|problem| Error::new(place, problem))
}

fn read(bytes: &[u8]) -> Unplaced<Grid> {
    let Array { element, big, fortran, shape, data } = Array::of(bytes)?;
    let element = named(element)?;
    let right = "shape: must be three whole numbers, (z, y, x)";
    let [z, y, x] = <[u64; 3]>::try_from(shape).map_err(|_| right)?;
    let values = element.decode(data, [x, y, z], big)?;
    let size = [x as usize, y as usize, z as usize];
    Grid::new(size, if fortran { turned(&values, size) } else { values })
}

fn named(name: &str) -> Unplaced<Element> {
    match name {
        "u1" => Ok(Element::U8),
        "i1" => Ok(Element::I8),
        "u2" => Ok(Element::U16),
        "i2" => Ok(Element::I16),
        "u4" => Ok(Element::U32),
        "i4" => Ok(Element::I32),
        "f4" => Ok(Element::F32),
        "f8" => Ok(Element::F64),
        _ => {
            let right = "must be one of u1, i1, u2, i2, u4, i4, f4, f8";
            Err(format!("descr: {name:?} {right}"))
        }
    }
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
