//! What is in a scene, and how many fragments it gives.

pub mod description;
mod seams;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::raster::{CullFace, FrontEnd, Grid};
use crate::scene::{Bounds, Material, Object, Projection, STDIN, Scene, Shading, Volume};
use seams::Seams;

/// What is in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contents {
    /// The scene's name.
    pub scene: String,
    /// What kind of scene it is, with the file's ending.
    pub kind: String,
    /// The files that it was read from.
    pub files: Vec<String>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Triangles of all objects.
    pub triangles: u64,
    /// Discs of all objects: points.
    pub discs: u64,
    /// Triangles given in pixels.
    pub screen_triangles: u64,
    /// Around objects and volumes; `None` where there are none.
    pub bounds: Option<Extent>,
    /// In drawing order; meshes of one name are one object.
    pub objects: Vec<Solid>,
    /// In their order in the scene.
    pub materials: Vec<Look>,
    /// In their order in the scene.
    pub volumes: Vec<Body>,
    /// Where it is seen from.
    pub camera: View,
    /// Names of the cameras that its files have: of each its own and its node's, where there are any.
    pub cameras: Vec<[String; 2]>,
    /// Where light comes from.
    pub light: Lighting,
    /// Linear red, green and blue.
    pub background: [f32; 3],
    /// How many fragments there are.
    pub depth_complexity: Complexity,
    /// What was tolerated while loading.
    pub warnings: Vec<String>,
}

/// A box in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extent {
    /// The smallest coordinates.
    pub min: [f64; 3],
    /// The largest coordinates.
    pub max: [f64; 3],
}

/// An object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Solid {
    /// Its name for effects.
    pub name: String,
    /// Meshes that it consists of.
    pub meshes: u64,
    /// Its triangles.
    pub triangles: u64,
    /// Its discs.
    pub discs: u64,
    /// Triangles without area.
    pub degenerate: u64,
    /// Whether it is closed; `None` if it has no triangles.
    pub closed: Option<bool>,
    /// Edges that do not belong to exactly two triangles, which pass them in opposite directions.
    pub open_edges: u64,
    /// The names of its materials, in order.
    pub materials: Vec<String>,
}

/// A material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Look {
    /// Its name.
    pub name: String,
    /// Linear red, green and blue.
    pub color: [f32; 3],
    /// Its opacity.
    pub alpha: f32,
    /// How light acts on it.
    pub shading: &'static str,
    /// Width and height of its picture, pixels.
    pub picture: Option<[u32; 2]>,
}

/// A volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Body {
    /// Voxels along x, y and z.
    pub voxels: [usize; 3],
    /// The values that become 0 and 1.
    pub range: [f64; 2],
    /// Around it.
    pub bounds: Extent,
    /// Multiplies its opacities.
    pub density: f64,
    /// World units between samples.
    pub step: f64,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct View {
    /// Its position.
    pub eye: [f64; 3],
    /// The point in the middle of the image.
    pub target: [f64; 3],
    /// Roughly up.
    pub up: [f64; 3],
    /// `perspective` or `orthographic`.
    pub projection: &'static str,
    /// The vertical field of view in degrees, of a perspective.
    pub fov_y: Option<f64>,
    /// The height of the visible box in world units, of an orthographic projection.
    pub ortho_height: Option<f64>,
    /// The distance of the near plane.
    pub near: f64,
    /// The distance of the far plane.
    pub far: f64,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lighting {
    /// The unit vector towards it.
    pub towards: [f64; 3],
    /// The share of light that comes from everywhere.
    pub ambient: f32,
}

/// Fragments by pixel, of one geometry pass with all faces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Complexity {
    /// The most at any pixel.
    pub max: u64,
    /// Their mean over pixels that have any; 0 where none has.
    pub mean: f64,
    /// Pixels that have any.
    pub covered_pixels: u64,
    /// All of them.
    pub fragments: u64,
    /// Triangles and discs without area at this size.
    pub degenerate: u64,
}

impl Contents {
    /// Look through a scene, and rasterize it without drawing.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let discs = scene.objects.iter().map(|object| object.mesh.discs.len() as u64).sum();
        let screen_triangles = scene.screen.len() as u64;
        let bounds = scene.bounds();
        let [width, height] = scene.size;
        Self {
            scene: scene.name.clone(),
            kind: kind(scene),
            files: scene.files.iter().map(|path| path.display().to_string()).collect(),
            width,
            height,
            triangles: scene.triangles() - discs - screen_triangles,
            discs,
            screen_triangles,
            bounds: (bounds.min.x <= bounds.max.x).then(|| bounds.into()),
            objects: solids(scene),
            materials: looks(scene),
            volumes: bodies(scene),
            camera: view(scene),
            cameras: scene.cameras.clone(),
            light: Lighting {
                towards: scene.light.towards.to_array(),
                ambient: scene.light.ambient,
            },
            background: scene.background,
            depth_complexity: Complexity::of(scene),
            warnings: scene.warnings.clone(),
        }
    }
}

impl From<Bounds> for Extent {
    fn from(bounds: Bounds) -> Self {
        Self { min: bounds.min.to_array(), max: bounds.max.to_array() }
    }
}

impl Complexity {
    fn of(scene: &Scene) -> Self {
        let grid = Grid { width: scene.size[0], height: scene.size[1], tile: 64 };
        let front = FrontEnd::new(scene, grid, 8, CullFace::None);
        let histogram = front.depth_complexity();
        let covered_pixels = histogram.iter().skip(1).sum();
        let fragments = (0..).zip(&histogram).map(|(fragments, pixels)| fragments * pixels).sum();
        Self {
            max: histogram.len() as u64 - 1,
            mean: if covered_pixels > 0 { fragments as f64 / covered_pixels as f64 } else { 0.0 },
            covered_pixels,
            fragments,
            degenerate: front.degenerate,
        }
    }
}

/// By where it comes from, and what it holds.
fn kind(scene: &Scene) -> String {
    if scene.name == STDIN {
        return "from stdin".to_owned();
    }
    let Some(file) = scene.files.first() else { return "built-in scene".to_owned() };
    let ending = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let ending = match ending(file).unwrap_or_default() {
        packed if packed == "gz" => {
            let own = ending(&file.with_extension("")).unwrap_or_default();
            format!("{own}.{packed}")
        }
        own => own,
    };
    let meshes = || scene.objects.iter().map(|object| &object.mesh);
    let (triangles, discs) =
        (meshes().any(|m| !m.triangles.is_empty()), meshes().any(|m| !m.discs.is_empty()));
    let name = match (triangles, discs) {
        _ if ending == "toml" => "scene file",
        (true, true) => "mesh and point set",
        (false, true) if meshes().flat_map(|m| &m.discs).any(|disc| disc.sigmas > 0.0) => {
            "Gaussian splats"
        }
        (false, true) => "point set",
        _ => "mesh",
    };
    format!("{name} (.{ending})")
}

fn solids(scene: &Scene) -> Vec<Solid> {
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    let mut groups: Vec<Vec<&Object>> = Vec::new();
    for object in &scene.objects {
        let place = *places.entry(&object.name).or_insert(groups.len());
        match groups.get_mut(place) {
            Some(group) => group.push(object),
            None => groups.push(vec![object]),
        }
    }
    groups.iter().map(|meshes| solid(scene, meshes)).collect()
}

fn solid(scene: &Scene, meshes: &[&Object]) -> Solid {
    let seams = Seams::of(meshes);
    let mut materials: Vec<usize> = meshes.iter().map(|object| object.material).collect();
    materials.sort_unstable();
    materials.dedup();
    Solid {
        name: meshes.first().map(|object| object.name.clone()).unwrap_or_default(),
        meshes: meshes.len() as u64,
        triangles: seams.triangles,
        discs: meshes.iter().map(|object| object.mesh.discs.len() as u64).sum(),
        degenerate: seams.degenerate,
        closed: seams.is_closed(),
        open_edges: seams.open_edges,
        materials: materials.into_iter().map(|i| scene.materials[i].name.clone()).collect(),
    }
}

fn looks(scene: &Scene) -> Vec<Look> {
    let shading = |shading| match shading {
        Shading::Flat => "flat",
        Shading::Lambert => "lambert",
        Shading::Gooch => "gooch",
    };
    let look = |material: &Material| Look {
        name: material.name.clone(),
        color: material.color,
        alpha: material.alpha,
        shading: shading(material.shading),
        picture: material.texture.as_ref().map(|texture| texture.picture.size()),
    };
    scene.materials.iter().map(look).collect()
}

fn bodies(scene: &Scene) -> Vec<Body> {
    let body = |volume: &Volume| Body {
        voxels: volume.grid.size(),
        range: volume.grid.range(),
        bounds: volume.bounds().into(),
        density: volume.density,
        step: volume.step,
    };
    scene.volumes.iter().map(body).collect()
}

fn view(scene: &Scene) -> View {
    let camera = &scene.camera;
    let (projection, fov_y, ortho_height) = match camera.projection {
        Projection::Perspective { fov_y } => ("perspective", Some(fov_y), None),
        Projection::Orthographic { height } => ("orthographic", None, Some(height)),
    };
    View {
        eye: camera.eye.to_array(),
        target: camera.target.to_array(),
        up: camera.up.to_array(),
        projection,
        fov_y,
        ortho_height,
        near: camera.near,
        far: camera.far,
    }
}
