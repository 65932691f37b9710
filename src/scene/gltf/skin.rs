//! Skins at rest: every vertex goes where its joints stand in the file; the node of the mesh does not matter.

use glam::{DMat3, DMat4, DVec3};
use serde_json::Value;

use super::super::Mesh;
use super::accessor::Data;
use super::json;
use crate::error::Result;

impl Data<'_> {
    /// What each joint of a skin does to a vertex in the world; a text if it cannot be said.
    pub(super) fn joints(
        &self,
        skin: usize,
        places: &[Option<DMat4>],
    ) -> Result<std::result::Result<Vec<DMat4>, &'static str>> {
        let name = format!("skin {skin}");
        let wrong = |problem: String| self.wrong(&name, &problem);
        let skins = json::list(self.root, "skins").map_err(wrong)?;
        let Some(value) = skins.get(skin) else { return Ok(Err("there is no such skin")) };
        let joints = json::indices(value, "joints").map_err(wrong)?;
        let inverse = match json::index(value, "inverseBindMatrices").map_err(wrong)? {
            Some(index) => {
                Some(self.numbers(index, &[16], &format!("{name}: inverseBindMatrices"))?.values)
            }
            None => None,
        };
        let mut found = Vec::new();
        for (i, joint) in joints.into_iter().enumerate() {
            let Some(place) = places.get(joint).copied().flatten() else {
                return Ok(Err("a joint is not in the scene"));
            };
            let inverse = match &inverse {
                None => DMat4::IDENTITY,
                Some(values) => match values.get(16 * i..16 * i + 16) {
                    Some(values) => DMat4::from_cols_slice(values),
                    None => return Ok(Err("there are too few inverseBindMatrices")),
                },
            };
            found.push(place * inverse);
        }
        Ok(Ok(found))
    }

    /// Moves a mesh by its joints; a text if it cannot be.
    pub(super) fn skinned(
        &self,
        mesh: &mut Mesh,
        primitive: &Value,
        joints: &[DMat4],
        name: &str,
    ) -> Result<std::result::Result<(), &'static str>> {
        let attributes = json::get(primitive, "attributes").unwrap_or(&Value::Null);
        let mut sums = vec![(DMat4::ZERO, 0.0); mesh.positions.len()];
        for set in 0.. {
            let [at, how_much] = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
            let index = |key| json::index(attributes, key).map_err(|p| self.wrong(name, &p));
            let (Some(at), Some(how_much)) = (index(&at)?, index(&how_much)?) else {
                if set == 0 {
                    return Ok(Err("the mesh has no JOINTS_0 and WEIGHTS_0"));
                }
                break;
            };
            let at = self.numbers(at, &[4], &format!("{name}: JOINTS_{set}"))?;
            let how_much = self.numbers(how_much, &[4], &format!("{name}: WEIGHTS_{set}"))?;
            if at.len() != sums.len() || how_much.len() != sums.len() {
                return Ok(Err("there are not as many joints and weights as vertices"));
            }
            for (i, (joint, weight)) in at.values.iter().zip(&how_much.values).enumerate() {
                if *weight == 0.0 {
                    continue;
                }
                let Some(moves) = joints.get(*joint as usize) else {
                    return Ok(Err("a vertex has a joint that is not there"));
                };
                let (sum, whole) = &mut sums[i / 4];
                *sum += *moves * *weight;
                *whole += weight;
            }
        }
        for (i, (sum, whole)) in sums.into_iter().enumerate() {
            let moves = sum * (1.0 / whole);
            if !moves.is_finite() {
                return Ok(Err("a vertex has no weight"));
            }
            let position = DVec3::from(mesh.positions[i]);
            mesh.positions[i] = moves.transform_point3(position).to_array();
            if let Some(normal) = mesh.normals.get_mut(i) {
                let [x, y, z] =
                    [moves.x_axis, moves.y_axis, moves.z_axis].map(glam::DVec4::truncate);
                let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
                let turned = cofactors * DVec3::from(normal.map(f64::from));
                *normal = turned.normalize_or_zero().to_array().map(|c| c as f32);
            }
        }
        Ok(Ok(()))
    }
}
