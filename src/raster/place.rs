//! An object in place: its vertices in clip space and its normals in world space, in scalar f64, by sums of products in
//! a fixed order, so that they are the same everywhere.

use glam::{DMat4, DVec3, DVec4};
use rayon::prelude::*;

use super::clip::{Polygon, Snapped, Viewport};
use super::disc::Lying;
use super::primitive::Rect;
use super::shade::{Corners, Lighting, Seen, Surface};
use crate::scene::{Disc, Material, Mesh, Object, Scene};

/// An object with its vertices transformed.
pub(super) struct Placed<'a> {
    mesh: &'a Mesh,
    material: &'a Material,
    light: Lighting,
    transform: DMat4,
    view_projection: DMat4,
    world: Vec<DVec3>,
    clip: Vec<DVec4>,
    /// Where vertices lie on the screen: found once for all triangles that share one.
    screen: Vec<Option<Snapped>>,
    normals: Vec<[f32; 3]>,
    mirrored: bool,
}

impl<'a> Placed<'a> {
    /// Transform an object's vertices, in parallel.
    #[must_use]
    pub(super) fn new(
        object: &'a Object,
        scene: &'a Scene,
        view_projection: DMat4,
        viewport: &Viewport,
    ) -> Self {
        let to_world = |&p: &[f64; 3]| {
            let w = transform(&object.transform, DVec3::from(p));
            DVec3::new(w.x, w.y, w.z)
        };
        let mesh = &*object.mesh;
        let world: Vec<DVec3> = mesh.positions.par_iter().map(to_world).collect();
        let clip: Vec<DVec4> = world.par_iter().map(|&p| transform(&view_projection, p)).collect();
        let screen = clip.par_iter().map(|&v| viewport.place(v)).collect();
        let cofactors = cofactors(&object.transform);
        let normals = mesh.normals.par_iter().map(|&n| turn(&cofactors, n)).collect();
        Self {
            mesh,
            material: &scene.materials[object.material],
            light: Lighting::from(scene.light),
            transform: object.transform,
            view_projection,
            world,
            clip,
            screen,
            normals,
            mirrored: is_mirrored(&object.transform),
        }
    }

    /// Whether front faces are seen clockwise here, since the object is mirrored.
    #[must_use]
    pub(super) fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// The corners of a triangle; `None` if it has no area in the world, or is not finite in clip space.
    #[must_use]
    pub(super) fn corners(&self, triangle: [u32; 3]) -> Option<Corners> {
        let at = triangle.map(|i| i as usize);
        let clip = at.map(|i| self.clip[i]);
        let [a, b, c] = at.map(|i| self.world[i]);
        let face_normal = (b - a).cross(c - a);
        if face_normal == DVec3::ZERO || !clip.iter().all(|v| v.is_finite()) {
            return None;
        }
        let normals = (!self.normals.is_empty()).then(|| at.map(|i| self.normals[i]));
        let colors = (!self.mesh.colors.is_empty()).then(|| at.map(|i| self.mesh.colors[i]));
        let alphas = (!self.mesh.alphas.is_empty()).then(|| at.map(|i| self.mesh.alphas[i]));
        let textured = self.material.texture.is_some() && !self.mesh.places.is_empty();
        let places = textured.then(|| at.map(|i| self.mesh.places[i]));
        Some(Corners { clip, face_normal, normals, colors, alphas, places })
    }

    /// A triangle on the screen, clipped.
    #[must_use]
    pub(super) fn polygon(
        &self,
        triangle: [u32; 3],
        corners: &Corners,
        viewport: &Viewport,
    ) -> Polygon {
        let placed = triangle.map(|i| self.screen[i as usize]);
        Polygon::of_placed(placed).unwrap_or_else(|| viewport.clip(corners.clip))
    }

    /// The surface of a triangle, as it is seen.
    pub(super) fn surface(
        &self,
        corners: &Corners,
        seen: Seen,
        viewport: &Viewport,
        bounds: Rect,
    ) -> Surface {
        Surface::new(corners, self.material, self.light, seen, viewport, bounds)
    }

    /// A disc in place; `None` if it has no area in the world, or is not finite in clip space.
    #[must_use]
    pub(super) fn disc(&self, disc: &Disc) -> Option<Lying> {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let center = transform(&self.transform, DVec3::from(disc.center)).truncate();
        let axes = disc.axes.map(|axis| carry(&self.transform, wide(axis)).truncate());
        let normal = axes[0].cross(axes[1]);
        let lying = Lying {
            center: transform(&self.view_projection, center),
            axes: axes.map(|axis| carry(&self.view_projection, axis)),
            normal,
        };
        let finite = lying.octagon().iter().all(|v| v.is_finite());
        (normal != DVec3::ZERO && finite).then_some(lying)
    }

    /// The surface of a disc, as it is seen.
    pub(super) fn disc_surface(
        &self,
        disc: &Disc,
        lying: &Lying,
        seen: Seen,
        viewport: &Viewport,
        bounds: Rect,
    ) -> Surface {
        Surface::of_disc(disc, lying, self.material, self.light, seen, viewport, bounds)
    }
}

/// m * (v, 0), each row (x + y) + z.
fn carry(m: &DMat4, v: DVec3) -> DVec4 {
    let [x, y, z, _] = m.to_cols_array_2d();
    let row = |i: usize| (x[i] * v.x + y[i] * v.y) + z[i] * v.z;
    DVec4::new(row(0), row(1), row(2), row(3))
}

/// m * (p, 1), each row ((x + y) + z) + w.
fn transform(m: &DMat4, p: DVec3) -> DVec4 {
    let [x, y, z, w] = m.to_cols_array_2d();
    let row = |i: usize| ((x[i] * p.x + y[i] * p.y) + z[i] * p.z) + w[i];
    DVec4::new(row(0), row(1), row(2), row(3))
}

/// The cofactor matrix of the upper 3x3, as columns. It carries normals up to scale, exists for flat transforms too,
/// and under a mirroring one turns them over together with the winding, so that both still agree.
fn cofactors(m: &DMat4) -> [DVec3; 3] {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(DVec4::truncate);
    [y.cross(z), z.cross(x), x.cross(y)]
}

/// Whether a transform turns a right hand into a left one: its determinant is below 0. Columns are scaled first, so that
/// no product leaves the range.
fn is_mirrored(m: &DMat4) -> bool {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|column| {
        let column = column.truncate();
        let largest = column.abs().max_element();
        if largest > 0.0 { column / largest } else { column }
    });
    x.dot(y.cross(z)) < 0.0
}

/// A normal in world space, unit length where it has a direction.
fn turn(cofactors: &[DVec3; 3], n: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = n.map(f64::from);
    let v = (cofactors[0] * x + cofactors[1] * y) + cofactors[2] * z;
    let length = ((v.x * v.x + v.y * v.y) + v.z * v.z).sqrt();
    let unit = if length > 0.0 { v * (1.0 / length) } else { v };
    [unit.x, unit.y, unit.z].map(|c| c as f32)
}
