//! Cutting away what a mask leaves out. The opacity of a triangle is linear between its corners, so what remains of it is
//! a polygon.

use super::super::Mesh;

/// What is at least `cutoff` opaque, where the mesh's opacities are multiplied by `alpha`. The rest is opaque.
pub(super) fn cut(mut mesh: Mesh, alpha: f32, cutoff: f32) -> Mesh {
    let opacities = std::mem::take(&mut mesh.alphas);
    if opacities.is_empty() {
        if alpha < cutoff {
            mesh.triangles.clear();
        }
        return mesh;
    }
    let opacities: Vec<f32> = opacities.into_iter().map(|own| own * alpha).collect();
    for triangle in std::mem::take(&mut mesh.triangles) {
        let inside = triangle.map(|i| opacities[i as usize] >= cutoff);
        if inside == [true; 3] {
            mesh.triangles.push(triangle);
            continue;
        }
        let mut outline = Vec::new();
        for i in 0..3 {
            let next = (i + 1) % 3;
            if inside[i] {
                outline.push(triangle[i]);
            }
            if inside[i] != inside[next] {
                // From the inside, so that both triangles beside an edge get the same point.
                let (from, to) = if inside[i] { (i, next) } else { (next, i) };
                let ends = [triangle[from], triangle[to]];
                let [a, b] = ends.map(|i| f64::from(opacities[i as usize]));
                let share = (a - f64::from(cutoff)) / (a - b);
                outline.push(between(&mut mesh, ends, share));
            }
        }
        if let [first, rest @ ..] = &outline[..] {
            mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        }
    }
    mesh
}

/// Adds a vertex between two others.
fn between(mesh: &mut Mesh, ends: [u32; 2], share: f64) -> u32 {
    let [a, b] = ends.map(|i| i as usize);
    let mixed = |a: f32, b: f32| (f64::from(a) + (f64::from(b) - f64::from(a)) * share) as f32;
    let (p, q) = (mesh.positions[a], mesh.positions[b]);
    mesh.positions.push([0, 1, 2].map(|i| p[i] + (q[i] - p[i]) * share));
    for values in [&mut mesh.normals, &mut mesh.colors] {
        if !values.is_empty() {
            let (p, q) = (values[a], values[b]);
            values.push([0, 1, 2].map(|i| mixed(p[i], q[i])));
        }
    }
    mesh.positions.len() as u32 - 1
}
