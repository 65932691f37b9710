//! What a file says of its points: a column for every property that is known, a row for every point.

use glam::DVec3;

use super::unit;
use crate::scene::model::Unplaced;

/// How many properties are known.
pub(in crate::scene) const COLUMNS: usize = 22;

/// Their columns' names, as messages call them.
const NAMES: [&str; COLUMNS] = [
    "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha", "radius", "f_dc_0", "f_dc_1",
    "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
];

/// The first column of the normal.
pub(in crate::scene) const NORMAL: usize = 3;
/// The first column of the colour.
pub(in crate::scene) const COLOR: usize = 6;
/// The column of the opacity.
pub(in crate::scene) const ALPHA: usize = 9;
/// The column of the radius.
pub(super) const RADIUS: usize = 10;
/// The first column of a Gaussian splat: colour, opacity, scales and rotation, as `splat` reads them.
pub(super) const SPLAT: usize = 11;
/// The column of a splat's opacity, whose name others use, too.
const OPACITY: usize = 14;

/// The column of a property by one of its names, if it is known. Asked for every property of every point.
pub(in crate::scene) fn column(name: &str) -> Option<usize> {
    Some(match name {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" | "normal_x" => NORMAL,
        "ny" | "normal_y" => NORMAL + 1,
        "nz" | "normal_z" => NORMAL + 2,
        "red" | "r" | "diffuse_red" => COLOR,
        "green" | "g" | "diffuse_green" => COLOR + 1,
        "blue" | "b" | "diffuse_blue" => COLOR + 2,
        "alpha" | "a" | "diffuse_alpha" => ALPHA,
        "radius" | "scalar_radius" => RADIUS,
        "f_dc_0" => SPLAT,
        "f_dc_1" => SPLAT + 1,
        "f_dc_2" => SPLAT + 2,
        "opacity" => OPACITY,
        "scale_0" => OPACITY + 1,
        "scale_1" => OPACITY + 2,
        "scale_2" => OPACITY + 3,
        "rot_0" => OPACITY + 4,
        "rot_1" => OPACITY + 5,
        "rot_2" => OPACITY + 6,
        "rot_3" => OPACITY + 7,
        _ => return None,
    })
}

/// Whether a column holds a share of 1, which integers count in the largest value of their type.
pub(in crate::scene) fn is_share(column: usize) -> bool {
    (COLOR..RADIUS).contains(&column)
}

/// A point set as its file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::scene) struct Table {
    /// Which columns the file has.
    pub(in crate::scene) has: [bool; COLUMNS],
    /// The positions of the rows, which need not fit into single precision.
    pub(in crate::scene) places: Vec<[f64; 3]>,
    /// The other columns that the file has, row by row.
    pub(in crate::scene) values: Vec<f32>,
}

impl Table {
    /// How many rows there are.
    pub(in crate::scene) fn rows(&self) -> usize {
        self.places.len()
    }

    /// The rows whose position is finite.
    pub(super) fn whole(&self) -> Vec<usize> {
        let finite = |&row: &usize| self.places[row].iter().all(|c| c.is_finite());
        (0..self.places.len()).filter(finite).collect()
    }

    /// How many values a row has.
    pub(in crate::scene) fn width(&self) -> usize {
        self.slot(COLUMNS)
    }

    /// Where a column stands in a row's values, if the file has it.
    pub(in crate::scene) fn slot(&self, column: usize) -> usize {
        self.has[NORMAL..column].iter().filter(|has| **has).count()
    }

    /// A row's value in a column behind the position; 0 where the file has none.
    pub(in crate::scene) fn get(&self, row: usize, column: usize) -> f32 {
        let value = || self.values[row * self.width() + self.slot(column)];
        if self.has[column] { value() } else { 0.0 }
    }

    /// Sets a row's value in a column that the file has.
    pub(in crate::scene) fn set(&mut self, row: usize, column: usize, value: f64) {
        match column {
            0..NORMAL => self.places[row][column] = value,
            _ if self.has[column] => {
                let at = row * self.width() + self.slot(column);
                self.values[at] = value as f32;
            }
            _ => {}
        }
    }

    /// As many empty rows, when it is known which columns there are.
    pub(in crate::scene) fn fill(&mut self, rows: usize) {
        self.places = vec![[0.0; 3]; rows];
        self.values = vec![0.0; rows * self.width()];
    }

    /// Whether the points are Gaussian splats; an error if the file has only some of their properties.
    pub(super) fn is_splats(&self) -> Unplaced<bool> {
        let wanted = SPLAT..COLUMNS;
        if !wanted.clone().any(|column| self.has[column] && column != OPACITY) {
            return Ok(false);
        }
        let missing: Vec<&str> =
            wanted.filter(|&column| !self.has[column]).map(|column| NAMES[column]).collect();
        if missing.is_empty() {
            return Ok(true);
        }
        Err(format!("a Gaussian splat needs {} as well", missing.join(", ")))
    }

    pub(super) fn position(&self, row: usize) -> [f64; 3] {
        self.places[row]
    }

    /// Three neighbouring columns.
    pub(super) fn three(&self, row: usize, from: usize) -> [f32; 3] {
        std::array::from_fn(|i| self.get(row, from + i))
    }

    /// White without one, for the material's to show.
    pub(super) fn color(&self, row: usize) -> [f32; 3] {
        if self.has_color() { self.three(row, COLOR) } else { [1.0; 3] }
    }

    /// Whether there are colours.
    pub(super) fn has_color(&self) -> bool {
        self.has[COLOR..COLOR + 3] == [true; 3]
    }

    pub(super) fn alpha(&self, row: usize) -> f32 {
        if self.has[ALPHA] { self.get(row, ALPHA) } else { 1.0 }
    }

    /// Unit normals of the rows that have one.
    pub(super) fn normals(&self, rows: &[usize]) -> Vec<Option<DVec3>> {
        let whole = self.has[NORMAL..NORMAL + 3] == [true; 3];
        let normal = |&row: &usize| {
            let normal = || unit(DVec3::from(self.three(row, NORMAL).map(f64::from)));
            if whole { normal() } else { None }
        };
        rows.iter().map(normal).collect()
    }

    /// The radii, if there are any: all must be finite and above 0.
    pub(super) fn radii(&self, rows: &[usize]) -> Unplaced<Option<Vec<f64>>> {
        if !self.has[RADIUS] {
            return Ok(None);
        }
        let radius = |&row: &usize| match self.get(row, RADIUS) {
            radius if radius > 0.0 && radius.is_finite() => Ok(f64::from(radius)),
            radius => Err(format!("point {row}: radius: {radius} must be finite and above 0")),
        };
        rows.iter().map(radius).collect::<Unplaced<_>>().map(Some)
    }

    /// A column's name, for messages.
    pub(super) fn name(column: usize) -> &'static str {
        NAMES[column]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_to_its_column() {
        for (i, name) in NAMES.iter().enumerate() {
            assert_eq!(column(name), Some(i), "{name}");
        }
        assert_eq!(column("normal_z"), Some(5));
        assert_eq!(column("curvature"), None);
    }
}
