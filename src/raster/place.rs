//! An object in place: its vertices in clip space and its normals in world space, in scalar f64, by sums of products in
//! a fixed order, so that they are the same everywhere.

use glam::{DMat4, DVec3, DVec4};
use rayon::prelude::*;

use super::clip::{Snapped, Viewport};
use super::disc::Lying;
use super::primitive::Rect;
use super::shade::{Attributes, Lighting, Seen, Surface};
use crate::scene::{Disc, Material, Mesh, Object, Scene};

/// An object with its vertices transformed.
pub(super) struct Placed<'a> {
    mesh: &'a Mesh,
    material: &'a Material,
    light: Lighting,
    transform: DMat4,
    view_projection: DMat4,
    vertices: Vec<Vertex>,
    normals: Vec<[f32; 3]>,
    mirrored: bool,
    /// What lies on all triangles, if they are all the same in any light.
    flat: Option<Surface>,
}

/// A vertex in place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    world: DVec3,
    /// On the screen, if it is finite and inside of all planes: found once for all triangles that share it.
    screen: Option<Snapped>,
}

/// The corners of a triangle in place, and the normal of its face, not of unit length.
pub(super) struct Corners {
    vertices: [Vertex; 3],
    normal: DVec3,
}

impl<'a> Placed<'a> {
    /// Transform an object's vertices, in parallel, in the room of `vertices`.
    #[must_use]
    pub(super) fn new(
        object: &'a Object,
        scene: &'a Scene,
        view_projection: DMat4,
        viewport: &Viewport,
        mut vertices: Vec<Vertex>,
    ) -> Self {
        let vertex = |&p: &[f64; 3]| {
            let world = transform(&object.transform, DVec3::from(p)).truncate();
            let clip = transform(&view_projection, world);
            let screen = clip.is_finite().then(|| viewport.place(clip)).flatten();
            Vertex { world, screen }
        };
        let mesh = &*object.mesh;
        mesh.positions.par_iter().map(vertex).collect_into_vec(&mut vertices);
        let cofactors = cofactors(&object.transform);
        let normals = mesh.normals.par_iter().map(|&n| turn(&cofactors, n)).collect();
        let material = &scene.materials[object.material];
        let plain = mesh.colors.is_empty() && mesh.alphas.is_empty() && material.texture.is_none();
        Self {
            mesh,
            material,
            light: Lighting::from(scene.light),
            transform: object.transform,
            view_projection,
            vertices,
            normals,
            mirrored: is_mirrored(&object.transform),
            flat: plain.then(|| Surface::flat(material)).flatten(),
        }
    }

    /// The room of its vertices.
    pub(super) fn leave(self) -> Vec<Vertex> {
        self.vertices
    }

    /// What it is made of.
    pub(super) fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// Whether front faces are seen clockwise here, since the object is mirrored.
    #[must_use]
    pub(super) fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// The corners of a triangle; `None` if it has no area in the world.
    #[inline]
    #[must_use]
    pub(super) fn corners(&self, triangle: [u32; 3]) -> Option<Corners> {
        let [a, b, c] = triangle;
        let vertices = [a, b, c].map(|i| self.vertices[i as usize]);
        let [a, b, c] = vertices.each_ref().map(|v| v.world);
        let normal = (b - a).cross(c - a);
        (normal != DVec3::ZERO).then_some(Corners { vertices, normal })
    }

    /// A triangle on the screen, if all of it is inside of all planes.
    #[inline]
    pub(super) fn screen(&self, corners: &Corners) -> Option<[Snapped; 3]> {
        let [a, b, c] = corners.vertices;
        Some([a.screen?, b.screen?, c.screen?])
    }

    /// A triangle in clip space; `None` if it is not finite there.
    #[must_use]
    pub(super) fn clip(&self, corners: &Corners) -> Option<[DVec4; 3]> {
        let clip = corners.vertices.map(|v| transform(&self.view_projection, v.world));
        clip.iter().all(|v| v.is_finite()).then_some(clip)
    }

    /// The surface of a triangle, as it is seen.
    #[inline]
    pub(super) fn surface(
        &self,
        triangle: [u32; 3],
        corners: &Corners,
        seen: Seen,
        viewport: &Viewport,
        bounds: Rect,
    ) -> Surface {
        match &self.flat {
            Some(surface) if !seen.normals => surface.clone(),
            _ => self.shaded(triangle, corners, seen, viewport, bounds),
        }
    }

    fn shaded(
        &self,
        triangle: [u32; 3],
        corners: &Corners,
        seen: Seen,
        viewport: &Viewport,
        bounds: Rect,
    ) -> Surface {
        let at = triangle.map(|i| i as usize);
        let clip = corners.vertices.map(|v| transform(&self.view_projection, v.world));
        let normals = (!self.normals.is_empty()).then(|| at.map(|i| self.normals[i]));
        let colors = (!self.mesh.colors.is_empty()).then(|| at.map(|i| self.mesh.colors[i]));
        let alphas = (!self.mesh.alphas.is_empty()).then(|| at.map(|i| self.mesh.alphas[i]));
        let textured = self.material.texture.is_some() && !self.mesh.places.is_empty();
        let places = textured.then(|| at.map(|i| self.mesh.places[i]));
        let face_normal = corners.normal;
        let corners = Attributes { clip, face_normal, normals, colors, alphas, places };
        Surface::new(&corners, self.material, self.light, seen, viewport, bounds)
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
#[inline]
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
