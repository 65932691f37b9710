//! Scenes: what is drawn, before any pixel exists.
//!
//! A [`Scene`] is plain data: meshes (triangles and discs) placed by transforms, materials, one directional light, a camera, a
//! background, volumes, and `screen` triangles given directly in pixels. It comes from a mesh file, a TOML scene file
//! or a procedural generator. The *global triangle index* counts the objects' triangles and discs in order, each object's
//! triangles before its discs, then the screen triangles. A disc counts as one triangle wherever triangles are counted.

mod bounds;
mod camera;
pub mod check;
mod draft;
pub mod export;
pub mod file;
pub mod gltf;
mod load;
mod model;
pub mod names;
pub mod obj;
mod parts;
mod placement;
pub mod ply;
pub mod points;
pub mod procedural;
pub mod stl;
pub mod texture;
mod thickness;
mod viewpoint;
pub mod volume;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat4, DVec3};
use serde::Deserialize;

pub use self::bounds::Bounds;
pub use self::camera::{AMBIENT, FOV_Y};
pub use self::draft::{DEFAULT_BACKGROUND, DEFAULT_SIZE, Overrides};
pub use self::load::{MESH_ALPHA, STDIN, builtin, load, zipped};
pub use self::model::{GREY, MAX_FILE, MAX_TRIANGLES, Model};
pub use self::parts::FileFormat;
pub use self::points::{PointSize, pcd};
pub use self::procedural::Builtin;
pub use self::texture::Texture;
pub use self::thickness::Thickness;
pub use self::viewpoint::{NamedCamera, Parallel, Side, Viewpoint};
pub use self::volume::Volume;

/// A whole scene, validated: every number is finite, every index is in range, and there is at least one
/// object, screen triangle or volume.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name in reports: the file's or the generator's name.
    pub name: String,
    /// Width and height of the image in pixels, each 1 to [`MAX_SIZE`].
    pub size: [u32; 2],
    /// Linear RGB, 0..1.
    pub background: [f32; 3],
    /// Where it is seen from.
    pub camera: Camera,
    /// Names of the cameras that its files have: of each its own and its node's, where there are any.
    pub cameras: Vec<[String; 2]>,
    /// The one light.
    pub light: Light,
    /// At least one; objects name them by index.
    pub materials: Vec<Material>,
    /// Placed meshes, in drawing order.
    pub objects: Vec<Object>,
    /// Triangles in pixels, drawn after the objects.
    pub screen: Vec<ScreenTriangle>,
    /// What light passes through, placed.
    pub volumes: Vec<Volume>,
    /// What was tolerated while loading, one sentence each.
    pub warnings: Vec<String>,
    /// The files that it was read from.
    pub files: Vec<PathBuf>,
}

/// The largest width and height of an image, in pixels.
pub const MAX_SIZE: u32 = 16_384;

/// A perspective or orthographic camera, right-handed, looking from `eye` to `target`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: DVec3,
    /// The point in the middle of the image.
    pub target: DVec3,
    /// Roughly up; not parallel to the line of sight.
    pub up: DVec3,
    /// The kind of projection and its field of view.
    pub projection: Projection,
    /// Distance of the near plane, > 0 for a perspective.
    pub near: f64,
    /// Distance of the far plane, > near.
    pub far: f64,
}

/// How a camera projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// The vertical field of view in degrees, above 0 and below 180.
    Perspective {
        /// Degrees.
        fov_y: f64,
    },
    /// The height of the visible box in world units.
    Orthographic {
        /// World units.
        height: f64,
    },
}

/// One directional light and an ambient term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector from the surface towards the light, in world space.
    pub towards: DVec3,
    /// The share of light that comes from everywhere, 0..1.
    pub ambient: f32,
}

/// What a surface looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Linear RGB, 0..1; multiplied with vertex colours where a mesh has them.
    pub color: [f32; 3],
    /// Opacity, 0..1.
    pub alpha: f32,
    /// How light acts on it.
    pub shading: Shading,
    /// A picture on it, where a mesh says how it lies ([`Mesh::places`]); colour and opacity are multiplied with it.
    pub texture: Option<Texture>,
}

/// How light acts on a surface. `raster::shade` states the order of operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shading {
    /// The colour as it is, unlit.
    Flat,
    /// Ambient plus diffuse by the cosine of the angle to the light.
    #[default]
    Lambert,
    /// From cool to warm with that cosine (Gooch et al., SIGGRAPH 1998).
    Gooch,
}

/// A mesh somewhere in the world. Meshes of one name are one solid to effects that distinguish inside from outside.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name for effects; see [`names`].
    pub name: String,
    /// Shared, since scenes repeat meshes.
    pub mesh: Arc<Mesh>,
    /// From mesh to world space.
    pub transform: DMat4,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// How thick its surfaces are, for methods that merge; `None` where the run says.
    pub thickness: Option<Thickness>,
}

/// Indexed triangles, and discs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Finite.
    pub positions: Vec<[f64; 3]>,
    /// Empty, or one per position; need not be unit length.
    pub normals: Vec<[f32; 3]>,
    /// Empty, or one linear RGB per position.
    pub colors: Vec<[f32; 3]>,
    /// Empty, or one opacity per position, 0..1; multiplied with the material's.
    pub alphas: Vec<f32>,
    /// Empty, or one place in the material's picture per position: (0, 0) is the upper left corner and (1, 1) the lower
    /// right one. Finite.
    pub places: Vec<[f32; 2]>,
    /// Each index is below `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
    /// Points of a point set; drawn after the triangles.
    pub discs: Vec<Disc>,
}

/// A flat elliptic disc: a point of a point set.
///
/// It is drawn as an octagon whose corners lie on its rim, one primitive with at most one fragment per pixel. Its front
/// is where its axes turn anticlockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Finite.
    pub center: [f64; 3],
    /// From the centre to the rim, at right angles to each other; finite. What is drawn is an ellipse also where they
    /// are not.
    pub axes: [[f32; 3]; 2],
    /// Linear RGB, 0..1; multiplied with the material's.
    pub color: [f32; 3],
    /// Opacity at the centre, 0..1; multiplied with the material's.
    pub alpha: f32,
    /// How many standard deviations of a Gaussian the rim is from the centre; 0 for the same opacity all over. Finite,
    /// not negative.
    pub sigmas: f32,
}

impl Mesh {
    /// Its triangles and discs together: as many as it takes of the global triangle index.
    #[must_use]
    pub fn primitives(&self) -> usize {
        self.triangles.len() + self.discs.len()
    }
}

/// A triangle in pixels: x right, y down, the centre of the first pixel at (0.5, 0.5), z in 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenTriangle {
    /// x, y, z of the corners; x and y within ±32,768 pixels.
    pub points: [[f64; 3]; 3],
    /// Linear RGB and opacity, 0..1.
    pub color: [f32; 4],
}

impl Scene {
    /// Around all objects and volumes.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        volume::grown(Bounds::of(&self.objects), &self.volumes)
    }

    /// Triangles and discs of all objects, and triangles of the screen.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        let objects = self.objects.iter().map(|o| o.mesh.primitives() as u64);
        objects.sum::<u64>() + self.screen.len() as u64
    }
}
