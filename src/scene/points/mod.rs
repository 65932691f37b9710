//! Point sets: every point becomes a disc.
//!
//! A file gives a table with a row per point (`table`). What a row lacks is estimated from its neighbours
//! (`estimate`); a row of a Gaussian splat has all it needs (`splat`).

mod eigen;
mod estimate;
mod lzf;
pub mod pcd;
mod splat;
pub(super) mod table;

use std::sync::Arc;

use glam::{DMat4, DVec3};

use self::estimate::Estimate;
use self::table::Table;
use super::model::{GREY, Unplaced};
use super::{Disc, Material, Mesh, Model, Shading, check};
use crate::error::{Error, Result};

/// What the user says about the radii of points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointSize {
    /// Of every point, in units of its file.
    pub radius: Option<f32>,
    /// Multiplies the radii that points have or get by estimation.
    pub scale: Option<f32>,
}

impl PointSize {
    /// Each must be finite and above 0, and at most one given. `names` are what the user calls them; an error is one of
    /// them, and what would be right.
    pub(super) fn check<'n>(
        &self,
        names: [&'n str; 2],
    ) -> std::result::Result<(), (&'n str, String)> {
        for (name, value) in names.into_iter().zip([self.radius, self.scale]) {
            if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                return Err((name, format!("{value} must be finite and above 0")));
            }
        }
        match (self.radius, self.scale) {
            (Some(_), Some(_)) => {
                Err((names[0], format!("must not be given together with {}", names[1])))
            }
            _ => Ok(()),
        }
    }

    /// This one, or where nothing is given, another.
    #[must_use]
    pub(super) fn or(self, other: Self) -> Self {
        if self == Self::default() { other } else { self }
    }
}

/// The model of a point set. `place` names the file in messages.
pub(super) fn model(table: &Table, size: PointSize, place: &str) -> Result<Model> {
    let wrong = |problem: String| Error::new(place, problem);
    let whole = table.whole();
    if whole.is_empty() {
        return Err(wrong("points: needs at least one with finite x, y and z".to_owned()));
    }
    let splats = table.is_splats().map_err(wrong)?;
    let discs = match splats {
        true => splat::discs(table, &whole, size),
        false => discs(table, &whole, size),
    };
    let mesh = Mesh { discs: discs.map_err(wrong)?, ..Mesh::default() };
    check::mesh(place, &mesh)?;
    let mut model = Model::default();
    let left_out = table.rows() - whole.len();
    if left_out > 0 {
        model.warnings.push(format!(
            "{place}: {left_out} of {} points have no finite position and are left out",
            table.rows()
        ));
    }
    // Splats hold the light that they give; nothing shines on them.
    let material = match splats {
        true => Material { shading: Shading::Flat, ..Material::new("default", [1.0; 3], 1.0) },
        false if table.has_color() => Material::new("default", [1.0; 3], 1.0),
        false => Material::new("default", GREY, 1.0),
    };
    let material = model.add_material(material);
    model.add_placed(Arc::new(mesh), DMat4::IDENTITY, material);
    Ok(model)
}

/// Round discs of the rows `whole`.
fn discs(table: &Table, whole: &[usize], size: PointSize) -> Unplaced<Vec<Disc>> {
    let radii = match size.radius {
        Some(radius) => Some(vec![f64::from(radius); whole.len()]),
        None => table.radii(whole)?,
    };
    let normals = table.normals(whole);
    let radii_missing = radii.is_none();
    let estimate = (radii_missing || normals.iter().any(Option::is_none)).then(|| {
        let positions: Vec<[f64; 3]> = whole.iter().map(|&row| table.position(row)).collect();
        Estimate::new(&positions)
    });
    let radii = match (radii, &estimate) {
        (Some(radii), _) => radii,
        (None, Some(estimate)) => estimate.radii().ok_or_else(|| {
            format!(
                "point {}: radius: has no neighbour to estimate it from; the point set needs a radius",
                whole[0]
            )
        })?,
        (None, None) => Vec::new(),
    };
    let scale = f64::from(size.scale.unwrap_or(1.0));
    let normal = |i: usize| {
        let estimated = || estimate.as_ref().map(|estimate| estimate.normal(i));
        normals[i].or_else(estimated).unwrap_or(DVec3::Z)
    };
    let disc = |(i, &row): (usize, &usize)| Disc {
        center: table.position(row),
        axes: axes(normal(i)).map(|axis| (axis * (radii[i] * scale)).as_vec3().to_array()),
        color: table.color(row),
        alpha: table.alpha(row),
        sigmas: 0.0,
    };
    Ok(whole.iter().enumerate().map(disc).collect())
}

/// Two unit vectors at right angles to a unit normal and to each other, which turn anticlockwise around it.
fn axes(normal: DVec3) -> [DVec3; 2] {
    let size = normal.abs();
    let least = if size.x <= size.y && size.x <= size.z {
        DVec3::X
    } else if size.y <= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let a = unit(least.cross(normal)).unwrap_or(DVec3::X);
    [a, normal.cross(a)]
}

/// The unit vector along `v`, if it has a direction.
fn unit(v: DVec3) -> Option<DVec3> {
    // Scaled first, so that no square leaves the range.
    let largest = v.abs().max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v * (1.0 / largest);
    let v = if v.is_finite() { v } else { return None };
    Some(v * (1.0 / ((v.x * v.x + v.y * v.y) + v.z * v.z).sqrt()))
}
