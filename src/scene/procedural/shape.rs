//! Shapes that several scenes are made of.

use std::f64::consts::TAU;

use glam::{DMat4, DVec3, DVec4};

use super::super::{Mesh, ScreenTriangle};
use super::{Key, Range};
use crate::num::random::Random;

/// In which order layers are drawn.
pub(super) const ORDER: Key = Key {
    name: "order",
    default: "random",
    range: Range::Choice(&["random", "front-to-back", "back-to-front"]),
    about: "in which layers are drawn",
};

/// Put layers, given front to back, in one of these orders.
pub(super) fn in_order<T>(order: &str, mut random: Random, mut layers: Vec<T>) -> Vec<T> {
    match order {
        "back-to-front" => layers.reverse(),
        "front-to-back" => {}
        _ => random.shuffle(&mut layers),
    }
    layers
}

/// The two triangles of a screen-aligned rectangle `[left, top, right, bottom]`, in pixels, at depth `z`.
pub(super) fn rectangle(edges: [f64; 4], z: f64, color: [f32; 4]) -> [ScreenTriangle; 2] {
    let [left, top, right, bottom] = edges;
    let corner = |x, y| [x, y, z];
    let (a, b) = (corner(left, top), corner(right, top));
    let (c, d) = (corner(right, bottom), corner(left, bottom));
    [[a, d, c], [a, c, b]].map(|points| ScreenTriangle { points, color })
}

/// The depth of layer `i` of `n`: the middle of its share of 0..1.
pub(super) fn layer_depth(i: u32, n: u32) -> f64 {
    (f64::from(i) + 0.5) / f64::from(n)
}

/// A linear colour that is neither black nor white.
pub(super) fn random_color(random: &mut Random) -> [f32; 3] {
    [(); 3].map(|()| random.range(0.05, 0.9) as f32)
}

/// Point `i` of `n` on the unit circle, as (cosine, sine).
pub(super) fn on_circle(i: u32, n: u32) -> (f64, f64) {
    turned(TAU * f64::from(i) / f64::from(n))
}

/// The unit vector at an angle in radians, as (cosine, sine).
pub(super) fn turned(angle: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(angle);
    (cosine, sine)
}

/// A rotation about z by an angle in radians, then a move.
pub(super) fn turn_and_move(angle: f64, to: DVec3) -> DMat4 {
    let (c, s) = turned(angle);
    let (x, y) = (DVec4::new(c, s, 0.0, 0.0), DVec4::new(-s, c, 0.0, 0.0));
    DMat4::from_cols(x, y, DVec4::Z, to.extend(1.0))
}

/// A mesh's own form of a direction.
pub(super) fn point(p: DVec3) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}

/// A mesh's own form of a place. Generators make single precision, as they always did.
pub(super) fn place(p: DVec3) -> [f64; 3] {
    point(p).map(f64::from)
}

/// The surface that a profile of (radius, height) makes around the y axis: outside is to the right of its
/// direction. `smooth` gives it normals; without them its faces are flat.
pub(super) fn revolve(profile: &[[f64; 2]], sides: u32, smooth: bool) -> Mesh {
    let mut mesh = Mesh::default();
    for (i, &[radius, height]) in profile.iter().enumerate() {
        let [out, up] = profile_normal(profile, i);
        for (c, s) in (0..sides).map(|side| on_circle(side, sides)) {
            mesh.positions.push(place(DVec3::new(radius * c, height, radius * s)));
            if smooth {
                mesh.normals.push(point(DVec3::new(out * c, up, out * s)));
            }
        }
    }
    for (i, pair) in (0..).zip(profile.windows(2)) {
        for side in 0..sides {
            let next = (side + 1) % sides;
            let [a, b] = [i * sides + side, i * sides + next];
            let [c, d] = [a + sides, b + sides];
            // A ring of no radius is a point, and makes no triangle of its own.
            mesh.triangles.extend((pair[1][0] > 0.0).then_some([a, c, d]));
            mesh.triangles.extend((pair[0][0] > 0.0).then_some([a, d, b]));
        }
    }
    mesh
}

/// The direction out of a profile at one of its points: the sum over the segments that meet there.
fn profile_normal(profile: &[[f64; 2]], i: usize) -> [f64; 2] {
    let from = &profile[i.saturating_sub(1)..profile.len().min(i + 2)];
    from.windows(2).fold([0.0, 0.0], |[out, up], pair| {
        let (run, rise) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
        let length = libm::sqrt(run * run + rise * rise);
        [out + rise / length, up - run / length]
    })
}

/// A ball around the origin: `sides` around, half as many from pole to pole.
pub(super) fn sphere(radius: f64, sides: u32) -> Mesh {
    let rings = sides / 2;
    let profile: Vec<_> = (0..=rings)
        .map(|ring| {
            let (c, s) = turned(TAU * 0.5 * f64::from(ring) / f64::from(rings));
            // The sine of pi is not quite 0, but a pole is a point.
            let r = if ring == 0 || ring == rings { 0.0 } else { radius * s };
            [r, -radius * c]
        })
        .collect();
    revolve(&profile, sides, true)
}

/// A box between two corners, flat-shaded.
pub(super) fn cuboid(min: DVec3, max: DVec3) -> Mesh {
    let [a, b, c, d] = [(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y)];
    prism([a, b, c, d], min.z, max.z)
}

/// A prism over four corners given anticlockwise in x, y, between two heights in z, flat-shaded.
pub(super) fn prism(corners: [(f64, f64); 4], bottom: f64, top: f64) -> Mesh {
    let at = |z: f64| corners.map(|(x, y)| place(DVec3::new(x, y, z)));
    let positions = [at(bottom), at(top)].concat();
    let sides = (0..4_u32).flat_map(|i| {
        let next = (i + 1) % 4;
        [[i, next, next + 4], [i, next + 4, i + 4]]
    });
    let triangles = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]].into_iter().chain(sides).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume that the triangles enclose: positive if they are anticlockwise from outside.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |&i: &u32| DVec3::from(mesh.positions[i as usize]);
        let parts =
            mesh.triangles.iter().map(|t| corner(&t[0]).cross(corner(&t[1])).dot(corner(&t[2])));
        parts.sum()
    }

    #[test]
    fn shapes_are_closed_and_face_outwards() {
        let cube = cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
        assert!((volume(&cube) - 48.0).abs() < 1e-12);
        let ball = sphere(1.0, 64);
        assert!((volume(&ball) / 8.0 - std::f64::consts::PI).abs() < 0.02, "{}", volume(&ball));
        for (vertex, normal) in ball.positions.iter().zip(&ball.normals) {
            assert!((0..3).map(|i| vertex[i] * f64::from(normal[i])).sum::<f64>() > 0.9);
        }
    }

    #[test]
    fn a_rectangle_is_two_triangles_on_one_diagonal() {
        let [first, second] = rectangle([1.0, 2.0, 5.0, 7.0], 0.25, [0.5; 4]);
        assert_eq!(first.points[0], second.points[0]);
        assert_eq!(first.points[2], second.points[1]);
        assert!(first.points.iter().chain(&second.points).all(|p| p[2] == 0.25));
    }
}
