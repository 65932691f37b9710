//! `EXT_mesh_gpu_instancing`: a node's mesh, many times.

use glam::{DMat4, DVec3};
use serde_json::Value;

use super::accessor::Data;
use super::json;
use super::nodes::placed;
use crate::error::Result;

/// The most instances of one node.
const MOST: usize = 1 << 20;

impl Data<'_> {
    /// Where the instances of a node are, relative to it; `None` if it has none.
    pub(super) fn instances(&self, node: &Value, name: &str) -> Result<Option<Vec<DMat4>>> {
        let keys = ["extensions", "EXT_mesh_gpu_instancing", "attributes"];
        let Some(attributes) = json::deep(node, &keys) else { return Ok(None) };
        let user = |key: &str| format!("{name}: EXT_mesh_gpu_instancing: {key}");
        let mut count = None;
        let mut numbers = |key: &str, width: usize| {
            let index = json::index(attributes, key).map_err(|p| self.wrong(&user(key), &p))?;
            let Some(index) = index else { return Ok(None) };
            let found = self.numbers(index, &[width], &user(key))?;
            let length = found.len();
            if *count.get_or_insert(length) != length || length > MOST {
                let problem = format!("{length} of them are too many, or differ from the others");
                return Err(self.wrong(&user(key), &problem));
            }
            Ok(Some(found))
        };
        let (translation, rotation) = (numbers("TRANSLATION", 3)?, numbers("ROTATION", 4)?);
        let scale = numbers("SCALE", 3)?;
        let three = |numbers: &Option<super::accessor::Numbers>, i: usize, default: f64| {
            let at = |n: &super::accessor::Numbers| DVec3::from_slice(&n.values[3 * i..]);
            numbers.as_ref().map_or(DVec3::splat(default), at)
        };
        let place = |i: usize| {
            let turned = rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |numbers| {
                std::array::from_fn(|axis| numbers.values[4 * i + axis])
            });
            placed(three(&translation, i, 0.0), turned, three(&scale, i, 1.0))
        };
        let places: Vec<_> = (0..count.unwrap_or_default()).map(place).collect();
        if places.iter().all(glam::DMat4::is_finite) {
            return Ok(Some(places));
        }
        Err(self.wrong(&user("TRANSLATION, ROTATION, SCALE"), "must be finite"))
    }
}
