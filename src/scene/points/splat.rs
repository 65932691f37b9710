//! Gaussian splats (Kerbl, Kopanas, Leimkühler, Drettakis, "3D Gaussian splatting for real-time radiance field
//! rendering", 2023), drawn flat: a disc in the plane of the two longest axes, with its rim at [`SIGMAS`] standard
//! deviations.
//!
//! The colour is 1/2 + [`Y0`] `f_dc`, of all directions alike (higher harmonics are left out); it is trained on images,
//! so it is taken for sRGB and made linear. The opacity is the logistic function of `opacity`, a standard deviation the
//! exponential of `scale`, and the rotation the quaternion `rot`: w, x, y, z.

use glam::DVec3;

use super::PointSize;
use super::table::{COLUMNS, SPLAT, Table};
use crate::num::color::linear;
use crate::scene::Disc;
use crate::scene::model::Unplaced;

/// The spherical harmonic of degree 0: 1 / (2 sqrt(pi)).
const Y0: f64 = 0.282_094_791_773_878_14;

/// Standard deviations from the centre to the rim: there, 1.1 % of the opacity are left.
const SIGMAS: f32 = 3.0;

/// The discs of the rows `whole`.
pub(super) fn discs(table: &Table, whole: &[usize], size: PointSize) -> Unplaced<Vec<Disc>> {
    if size.radius.is_some() {
        return Err("radius: Gaussian splats have their own; scale those".to_owned());
    }
    let scale = f64::from(size.scale.unwrap_or(1.0));
    whole.iter().map(|&row| disc(table, row, scale)).collect()
}

fn disc(table: &Table, row: usize, scale: f64) -> Unplaced<Disc> {
    let wrong = |column: usize, problem: &str| {
        Err(format!("point {row}: {}: {problem}", Table::name(column)))
    };
    let values: [f64; COLUMNS - SPLAT] = std::array::from_fn(|i| table.get(row, SPLAT + i).into());
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        return wrong(SPLAT + i, "must be finite");
    }
    let [r, g, b, opacity, scales @ .., w, x, y, z] = values;
    let deviations: [f64; 3] = scales.map(libm::exp);
    let reach = |i: usize| deviations[i] * f64::from(SIGMAS) * scale;
    if let Some(i) = (0..3).find(|&i| reach(i) > f64::from(f32::MAX)) {
        return wrong(SPLAT + 4 + i, "its exponential is too large");
    }
    let Some(turned) = columns([w, x, y, z]) else {
        return wrong(SPLAT + 7, "rot_0 to rot_3 must not all be 0");
    };
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| deviations[j].total_cmp(&deviations[i]));
    let axis = |i: usize| (turned[i] * reach(i)).as_vec3().to_array();
    Ok(Disc {
        center: table.position(row),
        axes: [axis(order[0]), axis(order[1])],
        color: [r, g, b].map(|f_dc| linear((0.5 + Y0 * f_dc).clamp(0.0, 1.0)) as f32),
        alpha: (1.0 / (1.0 + libm::exp(-opacity))) as f32,
        sigmas: SIGMAS,
    })
}

/// What a rotation makes of the three axes.
fn columns(quaternion: [f64; 4]) -> Option<[DVec3; 3]> {
    let [w, x, y, z] = quaternion;
    let square = ((w * w + x * x) + y * y) + z * z;
    if square == 0.0 {
        return None;
    }
    let [w, x, y, z] = quaternion.map(|c| c / square.sqrt());
    Some([
        DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        DVec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        DVec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    ])
}
