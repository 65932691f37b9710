//! Files of fragments: NumPy's `.npz` and CSV.

use crate::num::depth::{Format, code};
use crate::num::npy::Array;

/// Fragments as a renderer dumped them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dump {
    /// Pixels across and down, if the file says.
    pub size: Option<[u32; 2]>,
    /// Column, row, depth and data word of each, those of a pixel in their order. Depths are words of the format that the
    /// file was read for.
    pub fragments: Vec<([u32; 2], u32, u32)>,
    /// Depths were real numbers, and not words.
    pub is_real: bool,
}

impl Dump {
    /// Whether a file of `.npz` holds fragments, and not a picture.
    #[must_use]
    pub fn is_npz(members: &[(String, Vec<u8>)]) -> bool {
        members.iter().any(|(name, _)| name == "offsets")
    }

    /// From the arrays `offsets`, `depth` and `data`, and `width` and `height` (scalars), as `fragloom render --fragments`
    /// writes them. `depth` may be floating point: depths from 0 to 1.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn of_npz(members: &[(String, Vec<u8>)], format: Format) -> Result<Self, String> {
        let array = |name: &str| {
            let found = members.iter().find(|(own, _)| own == name);
            let (_, bytes) = found.ok_or_else(|| format!("{name}: is missing"))?;
            Array::of(bytes).map_err(|problem| format!("{name}: {problem}"))
        };
        let wholes = |name: &str| {
            let values = array(name)?.wholes();
            values.map_err(|problem| format!("{name}: {problem}"))
        };
        let edge = |name: &str| match wholes(name)?[..] {
            [edge @ 1..=16_384] => Ok(edge as u32),
            _ => Err(format!("{name}: must be one number, 1 to 16384")),
        };
        let size = [edge("width")?, edge("height")?];
        let offsets = wholes("offsets")?;
        let data = words("data", &wholes("data")?)?;
        let depths = array("depth")?;
        let is_real = depths.element.starts_with('f');
        let depths = match is_real {
            true => {
                let values = depths.reals().map_err(|problem| format!("depth: {problem}"))?;
                values.into_iter().map(|z| real(z, format)).collect::<Result<_, _>>()?
            }
            false => words("depth", &wholes("depth")?)?,
        };
        if depths.len() != data.len() {
            let lengths = (depths.len(), data.len());
            return Err(format!("depth and data: {lengths:?} fragments, but must be as many"));
        }
        let pixels = size[0] as usize * size[1] as usize;
        let whole = offsets.len() == pixels + 1
            && offsets.first() == Some(&0)
            && offsets.last() == Some(&(data.len() as u64))
            && offsets.is_sorted();
        if !whole {
            return Err(format!(
                "offsets: must be {} numbers that rise from 0 to {}",
                pixels + 1,
                data.len()
            ));
        }
        let mut fragments = Vec::with_capacity(data.len());
        for (pixel, ends) in offsets.windows(2).enumerate() {
            let place = [pixel as u32 % size[0], pixel as u32 / size[0]];
            let own = ends[0] as usize..ends[1] as usize;
            fragments.extend(own.map(|i| (place, depths[i], data[i])));
        }
        Ok(Self { size: Some(size), fragments, is_real })
    }

    /// From lines of values between commas. The first line names the columns, in any order: `x`, `y`; `depth` (words) or
    /// `z` (0 to 1); `data` (words) or `r`, `g`, `b`, `a` (0 to 255, linear, straight). Others are skipped.
    ///
    /// # Errors
    /// The line and column that is wrong.
    pub fn of_csv(text: &str, format: Format) -> Result<Self, String> {
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
        let names: Vec<&str> = match lines.next() {
            Some((_, line)) => {
                line.trim_start_matches('\u{feff}').split(',').map(str::trim).collect()
            }
            None => return Err("must begin with a line of names: x,y,depth,data".to_owned()),
        };
        let place = |name: &str| names.iter().position(|own| own.eq_ignore_ascii_case(name));
        let needed =
            |name: &str| place(name).ok_or_else(|| format!("line 1: the column {name} is missing"));
        let (x, y) = (needed("x")?, needed("y")?);
        let z = place("z");
        let depth = if z.is_some() { 0 } else { needed("depth")? };
        let colors = match place("data") {
            Some(data) => vec![data],
            None if place("r").is_some() => {
                ["r", "g", "b", "a"].into_iter().map(needed).collect::<Result<_, _>>()?
            }
            None => vec![needed("data")?],
        };
        let mut fragments = Vec::new();
        for (number, line) in lines {
            let values: Vec<&str> = line.split(',').map(str::trim).collect();
            let wrong = |column: usize, right: &str| {
                let (name, value) = (names[column], values.get(column).unwrap_or(&""));
                format!("line {number}: {name}: {value:?} must be {right}")
            };
            let whole = |column: usize, most: u32| {
                let value = values.get(column).and_then(|value| value.parse::<u32>().ok());
                let right = format!("a whole number up to {most}");
                value.filter(|&value| value <= most).ok_or_else(|| wrong(column, &right))
            };
            let at = [whole(x, 16_383)?, whole(y, 16_383)?];
            let depth = match z {
                Some(z) => {
                    let value = values.get(z).and_then(|value| value.parse().ok());
                    let value = value.ok_or_else(|| wrong(z, "a number from 0 to 1"))?;
                    real(value, format).map_err(|_| wrong(z, "a number from 0 to 1"))?
                }
                None => whole(depth, u32::MAX - 1)?,
            };
            let data = match colors[..] {
                [data] => whole(data, u32::MAX)?,
                _ => {
                    let mut bytes = [0; 4];
                    for (byte, &column) in bytes.iter_mut().zip(&colors) {
                        *byte = whole(column, 255)? as u8;
                    }
                    u32::from_le_bytes(bytes)
                }
            };
            fragments.push((at, depth, data));
        }
        Ok(Self { size: None, fragments, is_real: z.is_some() })
    }
}

fn words(name: &str, values: &[u64]) -> Result<Vec<u32>, String> {
    let word = |&value: &u64| {
        u32::try_from(value).map_err(|_| format!("{name}: {value} must be a word of 32 bits"))
    };
    values.iter().map(word).collect()
}

/// The word of a depth from 0 to 1.
fn real(z: f64, format: Format) -> Result<u32, String> {
    match (0.0..=1.0).contains(&z) {
        true => Ok(format.encode(code(z))),
        false => Err(format!("depth: {z} must be a number from 0 to 1")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_text_are_fragments() {
        let text = "y, x,depth,R,g,b,a,more\n1,2,77,1,2,3,4,x\n\n0,0,5,0,0,0,255,\n";
        let dump = Dump::of_csv(text, Format::D32).unwrap();
        let expected = vec![([2, 1], 77, 0x0403_0201), ([0, 0], 5, 0xFF00_0000)];
        assert_eq!((dump.size, dump.fragments, dump.is_real), (None, expected, false));
        let dump = Dump::of_csv("x,y,z,data\n0,0,0.5,7\n", Format::D32).unwrap();
        assert_eq!((dump.fragments, dump.is_real), (vec![([0, 0], code(0.5), 7)], true));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, words) in [
            ("", &["x,y,depth,data"][..]),
            ("x,y,data\n", &["line 1", "depth"]),
            ("x,y,depth\n", &["line 1", "data"]),
            ("x,y,depth,r,g,b\n", &["line 1", "column a"]),
            ("x,y,depth,data\n1,2,3\n", &["line 2", "data"]),
            ("x,y,depth,data\n1,2,3,4\n1,-2,3,4\n", &["line 3", "y", "\"-2\""]),
            ("x,y,z,data\n1,2,1.5,4\n", &["line 2", "z", "0 to 1"]),
            ("x,y,z,data\n1,2,nan,4\n", &["line 2", "z", "0 to 1"]),
            ("x,y,depth,r,g,b,a\n1,2,3,4,5,6,256\n", &["line 2", "a", "255"]),
            ("x,y,depth,data\n1,2,4294967295,4\n", &["line 2", "depth"]),
        ] {
            let problem = Dump::of_csv(text, Format::D32).unwrap_err();
            assert!(words.iter().all(|word| problem.contains(word)), "{text:?}: {problem}");
        }
    }
}
