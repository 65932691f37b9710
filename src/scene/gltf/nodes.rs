//! The node hierarchy, flattened: which nodes stand where.

use glam::{DMat3, DMat4, DQuat, DVec3};
use serde_json::Value;

use super::super::model::Unplaced;
use super::json;

/// The nodes that are seen, and where all nodes are.
pub(super) struct Placed {
    /// In the order of a walk that visits parents first.
    pub(super) seen: Vec<usize>,
    /// By node, its place in the world, if it is in the scene.
    pub(super) places: Vec<Option<DMat4>>,
    /// Nodes that are not to be seen.
    pub(super) hidden: usize,
}

/// Walks the default scene, else the first, else all nodes without a parent.
pub(super) fn walk(root: &Value) -> Unplaced<Placed> {
    let nodes = json::list(root, "nodes")?;
    let wrong = |node: usize, problem: &str| format!("node {node}: {problem}");
    let (mut seen, mut hidden) = (Vec::new(), 0);
    let mut places = vec![None; nodes.len()];
    let roots = roots(root, nodes)?.into_iter().rev();
    let mut todo: Vec<(usize, DMat4, bool)> =
        roots.map(|node| (node, DMat4::IDENTITY, true)).collect();
    while let Some((index, parent, visible)) = todo.pop() {
        let node = nodes.get(index).ok_or_else(|| wrong(index, "there is no such node"))?;
        // Each node has at most one parent, so a second visit is a cycle or a shared child.
        if places[index].is_some() {
            return Err(wrong(index, "children: each node must have one parent and no cycle"));
        }
        let transform = parent * local(node).map_err(|problem| wrong(index, &problem))?;
        if !transform.is_finite() {
            return Err(wrong(index, "matrix, rotation, scale, translation: must be finite"));
        }
        places[index] = Some(transform);
        let shown = json::deep(node, &["extensions", "KHR_node_visibility", "visible"]);
        let visible = visible && shown != Some(&Value::Bool(false));
        if visible {
            seen.push(index);
        } else {
            hidden += 1;
        }
        let children = json::indices(node, "children").map_err(|p| wrong(index, &p))?;
        todo.extend(children.into_iter().rev().map(|child| (child, transform, visible)));
    }
    Ok(Placed { seen, places, hidden })
}

fn roots(root: &Value, nodes: &[Value]) -> Unplaced<Vec<usize>> {
    let (own, scenes) = (json::index(root, "scene")?, json::list(root, "scenes")?);
    let scene = own.unwrap_or_default();
    match scenes.get(scene) {
        Some(scene) => {
            json::indices(scene, "nodes").map_err(|problem| format!("scenes: {problem}"))
        }
        None if own.is_some() => Err(format!("scene: {scene} is not among the {}", scenes.len())),
        None => {
            let mut is_root = vec![true; nodes.len()];
            for (i, node) in nodes.iter().enumerate() {
                let children = json::indices(node, "children");
                for child in children.map_err(|problem| format!("node {i}: {problem}"))? {
                    if let Some(slot) = is_root.get_mut(child) {
                        *slot = false;
                    }
                }
            }
            Ok((0..nodes.len()).filter(|&node| is_root[node]).collect())
        }
    }
}

/// The node's matrix, or its scale, then rotation, then translation.
fn local(node: &Value) -> Unplaced<DMat4> {
    if let Some(matrix) = json::numbers::<16>(node, "matrix")? {
        return Ok(DMat4::from_cols_array(&matrix));
    }
    let vector = |key, default: f64| {
        json::numbers::<3>(node, key).map(|v| DVec3::from(v.unwrap_or([default; 3])))
    };
    let rotation = json::numbers::<4>(node, "rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    Ok(placed(vector("translation", 0.0)?, rotation, vector("scale", 1.0)?))
}

/// Scale, then rotation by a quaternion, then translation.
pub(super) fn placed(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> DMat4 {
    let quaternion = DQuat::from_array(rotation);
    let square = quaternion.length_squared();
    let quaternion =
        if square > 0.0 && square.is_finite() { quaternion.normalize() } else { DQuat::IDENTITY };
    let linear = DMat3::from_quat(quaternion) * DMat3::from_diagonal(scale);
    DMat4::from_mat3_translation(linear, translation)
}
