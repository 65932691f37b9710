//! How the triangles of an object fit together: whether it is closed, and encloses something.

use glam::DVec3;
use rayon::prelude::*;

use crate::scene::Object;

/// How triangles meet at their edges. Corners at equal positions in the world are one corner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Seams {
    /// Triangles.
    pub(super) triangles: u64,
    /// Those without area.
    pub(super) degenerate: u64,
    /// Edges that do not belong to exactly two triangles, which pass them in opposite directions.
    pub(super) open_edges: u64,
}

impl Seams {
    /// Of several meshes that are one object.
    #[must_use]
    pub(super) fn of(meshes: &[&Object]) -> Self {
        let mut seams = Self::default();
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for object in meshes {
            let (mesh, first) = (&object.mesh, points.len());
            // Many objects may share many positions, and use few of them.
            let mut used = mesh.triangles.as_flattened().to_vec();
            used.par_sort_unstable();
            used.dedup();
            let place = |&i: &u32| DVec3::from(mesh.positions[i as usize]);
            points.par_extend(
                used.par_iter().map(place).map(|p| object.transform.transform_point3(p)),
            );
            let number = |i: u32| (first + used.partition_point(|&other| other < i)) as u32;
            triangles.par_extend(mesh.triangles.par_iter().map(|t| t.map(number)));
        }
        seams.triangles = triangles.len() as u64;
        let flat = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            (b - a).cross(c - a) == DVec3::ZERO
        };
        seams.degenerate = triangles.par_iter().filter(flat).count() as u64;
        let corners = welded(&points);
        // The two ends of every edge, the lower first, and whether a triangle passes it that way.
        let edges = triangles.par_iter().flat_map_iter(|t| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            // A triangle of two corners is a line that is passed to and fro.
            let ways = if a == b || b == c || c == a {
                [None; 3]
            } else {
                [(a, b), (b, c), (c, a)].map(Some)
            };
            ways.into_iter().flatten().map(|(from, to)| (from.min(to), from.max(to), from < to))
        });
        let mut edges: Vec<(u32, u32, bool)> = edges.collect();
        edges.par_sort_unstable();
        let is_open = |edge: &&[(u32, u32, bool)]| !matches!(edge, [(.., false), (.., true)]);
        let same = |a: &(u32, u32, bool), b: &(u32, u32, bool)| (a.0, a.1) == (b.0, b.1);
        seams.open_edges = edges.chunk_by(same).filter(is_open).count() as u64;
        seams
    }

    /// Whether the object is closed; `None` if it has no triangles.
    #[must_use]
    pub(super) fn is_closed(&self) -> Option<bool> {
        (self.triangles > 0).then_some(self.open_edges == 0 && self.degenerate < self.triangles)
    }
}

/// By point, a number that all points at its position share.
fn welded(points: &[DVec3]) -> Vec<u32> {
    // Zero has two signs, and one position.
    let bits = |&i: &u32| points[i as usize].to_array().map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.par_sort_unstable_by_key(bits);
    let mut numbers = vec![0; points.len()];
    for same in order.chunk_by(|a, b| bits(a) == bits(b)) {
        same.iter().for_each(|&i| numbers[i as usize] = same[0]);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DMat4;

    use super::*;
    use crate::scene::Mesh;

    const CORNERS: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn object(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Object {
        let (positions, triangles) = (positions.to_vec(), triangles.to_vec());
        let mesh = Arc::new(Mesh { positions, triangles, ..Mesh::default() });
        let (name, transform) = ("a".to_owned(), DMat4::IDENTITY);
        Object { name, mesh, transform, material: 0, thickness: None }
    }

    fn of(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Seams {
        Seams::of(&[&object(positions, triangles)])
    }

    #[test]
    fn a_tetrahedron_is_closed() {
        let seams = of(&CORNERS, &TETRAHEDRON);
        assert_eq!(seams, Seams { triangles: 4, degenerate: 0, open_edges: 0 });
        assert_eq!(seams.is_closed(), Some(true));
        let mirrored = TETRAHEDRON.map(|[a, b, c]| [a, c, b]);
        assert_eq!(of(&CORNERS, &mirrored).is_closed(), Some(true), "inside out");
        let more = [&[[9.0; 3]], &CORNERS[..]].concat();
        let after = TETRAHEDRON.map(|t| t.map(|i| i + 1));
        assert_eq!(of(&more, &after), of(&CORNERS, &TETRAHEDRON), "a corner that nothing uses");
    }

    #[test]
    fn corners_are_welded_also_of_several_meshes() {
        let soup: Vec<[f64; 3]> = TETRAHEDRON
            .as_flattened()
            .iter()
            .map(|&i| CORNERS[i as usize].map(|c| if c == 0.0 && i == 1 { -0.0 } else { c }))
            .collect();
        let triangles: Vec<[u32; 3]> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        assert_eq!(of(&soup, &triangles).open_edges, 0);
        let (one, other) =
            (object(&CORNERS, &TETRAHEDRON[..1]), object(&CORNERS, &TETRAHEDRON[1..]));
        assert_eq!(Seams::of(&[&one, &other]).is_closed(), Some(true));
        assert_eq!(Seams::of(&[&one]).open_edges, 3);
        let moved = Object { transform: DMat4::from_scale(DVec3::splat(2.0)), ..other };
        assert_eq!(Seams::of(&[&one, &moved]).is_closed(), Some(false), "apart in the world");
    }

    #[test]
    fn holes_turned_faces_and_fins_are_open() {
        assert_eq!(of(&CORNERS, &TETRAHEDRON[1..]).open_edges, 3, "a hole");
        let mut turned = TETRAHEDRON;
        turned[0] = [0, 1, 2];
        assert_eq!(of(&CORNERS, &turned).open_edges, 3, "a face the other way");
        let fin = [&TETRAHEDRON[..], &[[0, 1, 4]]].concat();
        let corners = [&CORNERS[..], &[[0.0, -1.0, 0.0]]].concat();
        assert_eq!(of(&corners, &fin).open_edges, 3, "a third face at an edge, and its own edges");
        let twice = [TETRAHEDRON, TETRAHEDRON].concat();
        assert_eq!(of(&CORNERS, &twice).open_edges, 6, "every face twice");
    }

    #[test]
    fn triangles_without_area_are_counted() {
        let corners = [&CORNERS[..], &[[0.5, 0.0, 0.0]]].concat();
        let more = [&TETRAHEDRON[..], &[[0, 0, 1]]].concat();
        let seams = of(&corners, &more);
        assert_eq!((seams.degenerate, seams.is_closed()), (1, Some(true)), "a line");
        assert_eq!(of(&corners, &[[0, 4, 1]]).degenerate, 1, "on a line");
        assert_eq!(of(&corners, &[[0, 0, 1]]).is_closed(), Some(false), "nothing is enclosed");
        assert_eq!(of(&CORNERS, &[]).is_closed(), None);
    }
}
