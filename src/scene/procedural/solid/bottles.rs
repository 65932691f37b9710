//! Glass bottles, row behind row and one on top of the other: surfaces of revolution with an outer and an inner wall,
//! so that a line of sight meets each bottle four times.

use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::super::super::{Material, Model};
use super::super::shape::revolve;
use super::super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
    name: "bottles",
    about: "stacked glass bottles with an outer and an inner wall, each 1 high",
    in_pixels: false,
    keys: &[
        Key { name: "columns", default: "5", range: Range::Count(1, 64), about: "side by side" },
        Key { name: "rows", default: "3", range: Range::Count(1, 64), about: "front to back" },
        Key { name: "levels", default: "2", range: Range::Count(1, 64), about: "stacked" },
        Key { name: "sides", default: "32", range: Range::Count(3, 512), about: "of a bottle" },
        Key::alpha("0.25"),
        Key::SEED,
    ],
    generate,
};

/// The wall as (radius, height), from the middle of the bottom outside to that inside.
const WALL: [[f64; 2]; 18] = [
    [0.0, 0.02],
    [0.12, 0.0],
    [0.165, 0.0],
    [0.18, 0.02],
    [0.18, 0.52],
    [0.165, 0.6],
    [0.1, 0.7],
    [0.065, 0.78],
    [0.06, 0.93],
    [0.075, 0.94],
    [0.075, 1.0],
    [0.055, 1.0],
    [0.048, 0.78],
    [0.085, 0.69],
    [0.15, 0.59],
    [0.164, 0.52],
    [0.164, 0.04],
    [0.0, 0.05],
];

const GLASS: [(&str, [f32; 3]); 5] = [
    ("green glass", [0.05, 0.4, 0.12]),
    ("brown glass", [0.4, 0.16, 0.03]),
    ("blue glass", [0.06, 0.2, 0.6]),
    ("clear glass", [0.6, 0.75, 0.75]),
    ("amber glass", [0.8, 0.45, 0.05]),
];

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let (columns, rows) = (keys.count("columns")?, keys.count("rows")?);
    let levels = keys.count("levels")?;
    let alpha = keys.alpha()?;
    let bottle = Arc::new(revolve(&WALL, keys.count("sides")?, true));
    let bottles = u64::from(columns) * u64::from(rows * levels);
    if bottles * bottle.triangles.len() as u64 > 1 << 24 {
        return Err(keys.wrong("columns", "columns x rows x levels makes more than 2^24 triangles"));
    }
    let mut model = Model::default();
    for (name, color) in GLASS {
        model.add_material(Material::new(name, color, alpha));
    }
    let mut random = Random::new(keys.seed()?, 1);
    for (column, row, level) in grid(columns, rows, levels) {
        let spread = |i: u32, n: u32| (f64::from(i) - f64::from(n - 1) * 0.5) * 0.42;
        let at = DVec3::new(spread(column, columns), f64::from(level), spread(row, rows));
        let glass = random.below(GLASS.len() as u64) as usize;
        model.add_placed(Arc::clone(&bottle), DMat4::from_translation(at), glass);
    }
    Ok(model)
}

/// All positions, levels outermost.
fn grid(columns: u32, rows: u32, levels: u32) -> impl Iterator<Item = (u32, u32, u32)> {
    let count = columns * rows * levels;
    (0..count).map(move |i| (i % columns, i / columns % rows, i / (columns * rows)))
}
