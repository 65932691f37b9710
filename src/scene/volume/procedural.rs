//! Volumes that are made by rule, without a file: the same bytes on every machine. All of them have values of 0 to 1.

use std::collections::BTreeMap;

use super::Grid;
use super::grid::voxels;
use crate::error::{Error, Result};
use crate::num::random;
use crate::scene::procedural::{Key, Keys, Range};

/// A rule.
#[derive(Clone, Copy, Debug)]
pub struct Generator {
    /// The name that `procedural` uses.
    pub name: &'static str,
    /// One line about it.
    pub about: &'static str,
    /// Its settings.
    pub keys: &'static [Key],
    /// The value at a point of the box -1..1.
    value: fn(keys: &Keys<'_>, point: [f64; 3]) -> Result<f64>,
}

/// Voxels along each edge.
const N: Key =
    Key { name: "n", default: "64", range: Range::Count(1, 512), about: "voxels along each edge" };

const GENERATORS: [Generator; 4] = [
    Generator {
        name: "constant",
        about: "the same value everywhere",
        keys: &[
            Key { default: "1", ..N },
            Key { name: "value", default: "1", range: Range::Real(0.0, 1.0), about: "it" },
        ],
        value: |keys, _| keys.real("value"),
    },
    Generator {
        name: "sphere",
        about: "1 in the middle, 0 at the faces' middles, and linear in the distance between",
        keys: &[N],
        value: |_, point| Ok((1.0 - length(point)).max(0.0)),
    },
    Generator {
        name: "ellipsoid",
        about: "1 inside of the ellipsoid that touches the faces, 0 outside, with an edge of some width",
        keys: &[
            N,
            Key {
                name: "edge",
                default: "0.05",
                range: Range::Real(1e-6, 1.0),
                about: "its width, of the radius",
            },
        ],
        value: |keys, point| Ok(((1.0 - length(point)) / keys.real("edge")?).clamp(0.0, 1.0)),
    },
    Generator {
        name: "cloud",
        about: "noise of four octaves that fades towards the faces",
        keys: &[
            N,
            Key { name: "cells", default: "4", range: Range::Count(1, 64), about: "of the noise" },
            Key::SEED,
        ],
        value: |keys, point| {
            let (cells, seed) = (f64::from(keys.count("cells")?), keys.seed()?);
            let fade = (1.5 - 1.5 * length(point)).clamp(0.0, 1.0);
            Ok((noise(point, cells, seed) * 2.2 - 0.6).clamp(0.0, 1.0) * fade)
        },
    },
];

/// All rules.
#[must_use]
pub fn generators() -> &'static [Generator] {
    &GENERATORS
}

/// The one of a name.
pub(super) fn find(name: &str) -> Result<&'static Generator> {
    GENERATORS.iter().find(|generator| generator.name == name).ok_or_else(|| {
        let names = GENERATORS.map(|generator| generator.name).join(", ");
        Error::new(name, format!("is none of the volumes made by rule: {names}"))
    })
}

/// The grid of a rule, with a range of 0 to 1.
pub(super) fn generate(name: &str, given: &BTreeMap<String, toml::Value>) -> Result<Grid> {
    let generator = find(name)?;
    let keys = Keys::new(generator.name, generator.keys, given)?;
    let wrong = |problem: String| Error::new(generator.name, problem);
    let n = keys.count("n")? as usize;
    let count = voxels([n as u64; 3]).map_err(wrong)?;
    let middle = |i: usize| (i as f64 + 0.5) * 2.0 / n as f64 - 1.0;
    let point = |i: usize| [middle(i % n), middle(i / n % n), middle(i / (n * n))];
    let value = |i: usize| Ok((generator.value)(&keys, point(i))? as f32);
    let values = (0..count).map(value).collect::<Result<Vec<f32>>>()?;
    Grid::new([n; 3], values).and_then(|grid| grid.ranged([0.0, 1.0])).map_err(wrong)
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Value noise of four octaves, 0 to 1, at a point of -1..1.
fn noise(point: [f64; 3], cells: f64, seed: u64) -> f64 {
    let (mut sum, mut weight, mut scale) = (0.0, 0.5, cells);
    for octave in 0..4 {
        sum += weight * lattice(point.map(|x| (x + 1.0) * 0.5 * scale), seed, octave);
        weight *= 0.5;
        scale *= 2.0;
    }
    sum / 0.9375
}

/// Random values at whole numbers, with smooth steps between.
fn lattice(point: [f64; 3], seed: u64, octave: u64) -> f64 {
    let cell = point.map(f64::floor);
    let [fx, fy, fz] = [0, 1, 2].map(|i| {
        let t = point[i] - cell[i];
        t * t * (3.0 - 2.0 * t)
    });
    let value = |corner: [f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|i| (cell[i] + corner[i]) as u64);
        let bits = random::bits(seed, octave, (z << 40) | (y << 20) | x);
        (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    };
    let between = |a: f64, b: f64, share: f64| a + (b - a) * share;
    let row = |y, z| between(value([0.0, y, z]), value([1.0, y, z]), fx);
    let plane = |z| between(row(0.0, z), row(1.0, z), fy);
    between(plane(0.0), plane(1.0), fz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_valid() {
        for generator in generators() {
            let grid = generate(generator.name, &BTreeMap::new()).unwrap();
            assert!(grid.values().iter().all(|v| (0.0..=1.0).contains(v)), "{}", generator.name);
            assert!(grid.values().iter().any(|v| *v > 0.2), "{}", generator.name);
        }
    }

    #[test]
    fn names_and_keys_are_told() {
        let given = |key: &str| BTreeMap::from([(key.to_owned(), toml::Value::Integer(0))]);
        assert!(generate("spere", &BTreeMap::new()).unwrap_err().to_string().contains("sphere"));
        let error = generate("sphere", &given("m")).unwrap_err().to_string();
        assert!(error.starts_with("sphere: m: is not a key"), "{error}");
        assert!(generate("sphere", &given("n")).unwrap_err().to_string().contains("not within 1"));
    }
}
