//! One primitive of a mesh: vertices with their attributes, moved by morph targets, and triangles.

use serde_json::Value;

use super::super::Mesh;
use super::super::check;
use super::super::parts::Tally;
use super::accessor::{Data, Numbers};
use super::json;
use crate::error::Result;

/// What becomes of a primitive.
pub(super) enum Found {
    Mesh(Box<Mesh>),
    /// Why it is not drawn.
    LeftOut(&'static str),
}

/// Why primitives are not drawn.
const NO_TRIANGLES: &str = "points and lines are not drawn";
const NO_POSITION: &str = "has no POSITION, and is left out";
const PACKED: &str =
    "KHR_draco_mesh_compression is not supported, and there is no plain mesh beside it";

/// Whether a warning of that kind says why a primitive is not drawn.
pub(super) fn is_left_out(kind: &str) -> bool {
    [NO_TRIANGLES, NO_POSITION, PACKED].contains(&kind)
}

impl Data<'_> {
    /// A primitive as a mesh. `name` names it, and `weights` are those of its morph targets.
    pub(super) fn primitive(
        &self,
        value: &Value,
        name: &str,
        weights: &[f64],
        tally: &mut Tally,
    ) -> Result<Found> {
        let wrong = |problem: String| self.wrong(name, &problem);
        let mode = json::index(value, "mode").map_err(wrong)?.unwrap_or(4);
        match mode {
            0..=3 => return Ok(Found::LeftOut(NO_TRIANGLES)),
            4..=6 => {}
            _ => return Err(wrong("mode: must be 0 to 6".to_owned())),
        }
        let attributes = json::get(value, "attributes").unwrap_or(&Value::Null);
        let attribute = |key: &str| json::index(attributes, key).map_err(wrong);
        let Some(positions) = attribute("POSITION")? else {
            return Ok(Found::LeftOut(NO_POSITION));
        };
        if json::deep(value, &["extensions", "KHR_draco_mesh_compression"]).is_some()
            && !self.has_data(positions)
        {
            return Ok(Found::LeftOut(PACKED));
        }
        let mut positions = self.numbers(positions, &[3], &format!("{name}: POSITION"))?;
        let mut optional = |key: &str, widths: &[usize]| {
            let found = attribute(key)?;
            let found = found.map(|i| self.numbers(i, widths, &format!("{name}: {key}")));
            Ok(self.sound(found, positions.len(), &format!("{name}: {key}"), tally))
        };
        let mut normals = optional("NORMAL", &[3])?;
        let mut colors = optional("COLOR_0", &[3, 4])?;
        let targets = json::list(value, "targets").map_err(wrong)?;
        let moved = |key: &str, values: &mut Numbers| {
            for (i, (target, weight)) in targets.iter().zip(weights).enumerate() {
                let user = format!("{name}: targets {i}: {key}");
                let index = json::index(target, key).map_err(|p| self.wrong(&user, &p))?;
                let Some(index) = index.filter(|_| *weight != 0.0) else { continue };
                let by = self.numbers(index, &[values.width], &user)?;
                if by.len() != values.len() {
                    let (have, need) = (by.len(), values.len());
                    return Err(self.wrong(&user, &format!("{have} of them for {need} vertices")));
                }
                values.values.iter_mut().zip(&by.values).for_each(|(v, by)| *v += by * weight);
            }
            Ok(())
        };
        moved("POSITION", &mut positions)?;
        normals.as_mut().map_or(Ok(()), |normals| moved("NORMAL", normals))?;
        colors.as_mut().map_or(Ok(()), |colors| moved("COLOR_0", colors))?;
        let order = match json::index(value, "indices").map_err(wrong)? {
            Some(index) => self.indices(index, &format!("{name}: indices"))?,
            None => (0..positions.len() as u32).collect(),
        };
        let mut channel = |v: &f64| tally.clamped(*v, || format!("{name}: COLOR_0"));
        let colors = colors.map(|colors| {
            let values: Vec<f32> = colors.values.iter().map(&mut channel).collect();
            (colors.width, values)
        });
        let mut mesh = Mesh {
            positions: positions.into_threes(),
            triangles: triangles(mode, order),
            ..Mesh::default()
        };
        if let Some(normals) = normals {
            mesh.normals = normals.threes().map(|n| n.map(|c| c as f32)).collect();
        }
        if let Some((width, values)) = colors {
            let each = || values.chunks_exact(width);
            mesh.colors = each().map(|v| [v[0], v[1], v[2]]).collect();
            mesh.alphas = each().filter_map(|v| v.get(3).copied()).collect();
        }
        unused(&mut mesh, name, tally);
        check::mesh(self.place, &mesh).map_err(|error| wrong(error.problem().to_owned()))?;
        Ok(Found::Mesh(Box::new(mesh)))
    }

    /// An attribute that can be done without, if nothing is wrong with it.
    pub(super) fn sound(
        &self,
        found: Option<Result<Numbers>>,
        count: usize,
        user: &str,
        tally: &mut Tally,
    ) -> Option<Numbers> {
        let problem = match found? {
            Ok(numbers) if numbers.len() != count => {
                format!("{user}: {} of them for {count} vertices", numbers.len())
            }
            Ok(numbers) if numbers.values.iter().all(|v| (*v as f32).is_finite()) => {
                return Some(numbers);
            }
            Ok(_) => format!("{user}: not all numbers are finite"),
            Err(error) => error.problem().to_owned(),
        };
        tally.add("the attribute is left out", || problem);
        None
    }
}

/// Vertices that no triangle uses need not be finite.
fn unused(mesh: &mut Mesh, name: &str, tally: &mut Tally) {
    let broken = |position: &[f64; 3]| !position.iter().all(|c| c.is_finite());
    if !mesh.positions.iter().any(broken) {
        return;
    }
    let mut used = vec![false; mesh.positions.len()];
    for &corner in mesh.triangles.iter().flatten() {
        if let Some(used) = used.get_mut(corner as usize) {
            *used = true;
        }
    }
    for (i, position) in mesh.positions.iter_mut().enumerate() {
        if broken(position) && !used[i] {
            let what = *position;
            tally.add("is not finite; no triangle uses it, and it is left out", || {
                format!("{name}: POSITION: vertex {i}: {what:?}")
            });
            *position = [0.0; 3];
        }
    }
}

/// The triangles that the vertices make in order; strips turn every other triangle around. Vertices left over at the
/// end form no triangle.
fn triangles(mode: usize, mut order: Vec<u32>) -> Vec<[u32; 3]> {
    match mode {
        5 => {
            let window = |(i, w): (usize, &[u32])| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[0], w[2], w[1]],
            };
            order.windows(3).enumerate().map(window).collect()
        }
        6 => match &order[..] {
            [hub, rim @ ..] => rim.windows(2).map(|w| [w[0], w[1], *hub]).collect(),
            [] => Vec::new(),
        },
        _ => {
            order.truncate(order.len() / 3 * 3);
            // The same memory, if it can be.
            let cast = bytemuck::allocation::try_cast_slice_box(order.into());
            cast.map_or_else(|(_, order)| order.as_chunks().0.to_vec(), <[_]>::into_vec)
        }
    }
}
