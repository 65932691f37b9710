//! The node hierarchy, flattened: which meshes stand where.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::scene::Node;
use gltf::json::{Index, Root};

use crate::error::{Error, Result};

/// Index of each mesh to draw and its place in the world, in the order of a walk that visits parents first.
pub(super) fn placed_meshes(root: &Root, place: &str) -> Result<Vec<(usize, DMat4)>> {
    let wrong = |node: usize, problem: &str| Error::new(place, format!("node {node}: {problem}"));
    let mut seen = vec![false; root.nodes.len()];
    let mut todo: Vec<(usize, DMat4)> =
        roots(root, place)?.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    let mut meshes = Vec::new();
    while let Some((index, parent)) = todo.pop() {
        let node = root.nodes.get(index).ok_or_else(|| wrong(index, "there is no such node"))?;
        // Each node has at most one parent, so a second visit is a cycle or a shared child.
        if std::mem::replace(&mut seen[index], true) {
            return Err(wrong(index, "children: each node must have one parent and no cycle"));
        }
        let transform = parent * local(node);
        if !transform.is_finite() {
            return Err(wrong(index, "matrix, rotation, scale, translation: must be finite"));
        }
        meshes.extend(node.mesh.map(|mesh| (mesh.value(), transform)));
        let children = node.children.iter().flatten().rev();
        todo.extend(children.map(|child| (child.value(), transform)));
    }
    Ok(meshes)
}

/// The roots of the default scene, else of the first, else all nodes without a parent.
fn roots(root: &Root, place: &str) -> Result<Vec<usize>> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.iter().map(Index::value).collect()),
        None if root.scene.is_some() => {
            Err(Error::new(place, format!("scene: {scene} is not among the {}", root.scenes.len())))
        }
        None => {
            let mut is_root = vec![true; root.nodes.len()];
            for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
                if let Some(slot) = is_root.get_mut(child.value()) {
                    *slot = false;
                }
            }
            Ok((0..root.nodes.len()).filter(|&node| is_root[node]).collect())
        }
    }
}

/// The node's matrix, or its scale, then rotation, then translation.
fn local(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector =
        |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from(v.map(f64::from)));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| {
        let quaternion = DQuat::from_array(q.0.map(f64::from));
        if quaternion.length_squared() > 0.0 { quaternion.normalize() } else { DQuat::IDENTITY }
    });
    let scale = DMat3::from_diagonal(vector(node.scale, DVec3::ONE));
    let linear = DMat3::from_quat(rotation) * scale;
    DMat4::from_mat3_translation(linear, vector(node.translation, DVec3::ZERO))
}
