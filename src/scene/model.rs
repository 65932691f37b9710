//! What a file or a generator contributes to a scene, before there is a camera.

use std::sync::Arc;

use glam::DMat4;

use super::volume::{self, Volume};
use super::{Bounds, Material, Mesh, NamedCamera, Object, ScreenTriangle, Shading};

/// A result whose error says what is wrong, but not yet where.
pub(super) type Unplaced<T> = std::result::Result<T, String>;

/// The most triangles (and discs) a scene may have.
pub const MAX_TRIANGLES: usize = 1 << 26;

/// The largest file that is read, in bytes.
pub const MAX_FILE: u64 = 1 << 30;

/// The colour of a surface whose file gives none.
pub const GREY: [f32; 3] = [0.8; 3];

/// Materials, placed meshes and screen triangles; objects name materials of the same model.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Objects name them by index.
    pub materials: Vec<Material>,
    /// Placed meshes, in drawing order.
    pub objects: Vec<Object>,
    /// Triangles in pixels.
    pub screen: Vec<ScreenTriangle>,
    /// Placed volumes.
    pub volumes: Vec<Volume>,
    /// Cameras of its file.
    pub cameras: Vec<NamedCamera>,
    /// Other files that its file names, relative to it, read or not: pictures.
    pub named: Vec<String>,
    /// What was tolerated, one sentence each.
    pub warnings: Vec<String>,
}

impl Model {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a mesh where it is. A mesh without triangles and discs is left out.
    pub fn add_mesh(&mut self, mesh: Mesh, material: usize) {
        self.add_placed(Arc::new(mesh), DMat4::IDENTITY, material);
    }

    /// Adds a shared mesh at a place. A mesh without triangles and discs is left out.
    pub fn add_placed(&mut self, mesh: Arc<Mesh>, transform: DMat4, material: usize) {
        if mesh.primitives() > 0 {
            let name = String::new();
            self.objects.push(Object { name, mesh, transform, material, thickness: None });
        }
    }

    /// Adds another model, moved by `transform`, all in `material` if one is given.
    pub fn append(&mut self, other: Self, transform: DMat4, material: Option<usize>) {
        let offset = self.materials.len();
        self.materials.extend(other.materials);
        self.objects.extend(other.objects.into_iter().map(|object| Object {
            name: object.name,
            transform: transform * object.transform,
            material: material.unwrap_or(offset + object.material),
            mesh: object.mesh,
            thickness: object.thickness,
        }));
        self.screen.extend(other.screen);
        self.volumes.extend(other.volumes);
        self.named.extend(other.named);
        self.cameras.extend(
            other
                .cameras
                .into_iter()
                .map(|camera| NamedCamera { transform: transform * camera.transform, ..camera }),
        );
        self.warnings.extend(other.warnings);
    }

    /// Names every mesh that has no name yet `name`, so that all of them are one object.
    pub(super) fn call(&mut self, name: &str) {
        let nameless = self.objects.iter_mut().filter(|object| object.name.is_empty());
        nameless.for_each(|object| name.clone_into(&mut object.name));
    }

    /// Around all placed meshes and volumes.
    pub(super) fn bounds(&self) -> Bounds {
        volume::grown(Bounds::of(&self.objects), &self.volumes)
    }

    /// How many triangles and discs there are, placed ones and screen triangles together.
    #[must_use]
    pub fn triangles(&self) -> usize {
        let placed = self.objects.iter().map(|object| object.mesh.primitives());
        placed.fold(self.screen.len(), usize::saturating_add)
    }
}

impl Material {
    /// Lit (Lambert) surface of a linear colour and an opacity, each 0..1.
    #[must_use]
    pub fn new(name: impl Into<String>, color: [f32; 3], alpha: f32) -> Self {
        Self { name: name.into(), color, alpha, shading: Shading::Lambert, texture: None }
    }
}
