//! From what a user names to a checked scene.

mod archive;
mod files;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use self::archive::Archive;
pub use self::files::STDIN;
use self::files::{Files, beside, is_stdin, place};
use super::draft::{Draft, Overrides, image_size};
use super::file::{self, Source};
use super::model::Model;
use super::parts::FileFormat;
use super::procedural::{self, Builtin};
use super::texture::{Opacity, Texture};
use super::{Material, Object, PointSize, Scene, gltf, names, obj, pcd, ply, stl};
use crate::error::{Error, Result};

/// The opacity given to surfaces of a mesh file that would be opaque.
pub const MESH_ALPHA: f32 = 0.5;

/// Loads a scene: a mesh or point set (`.obj`, `.gltf`, `.glb`, `.ply`, `.stl`, `.pcd`,
/// each also compressed, as in `.obj.gz`, or alone in a `.zip` with what it names), a scene file (`.toml`), or a
/// built-in scene's name, optionally with keys as in `layers:count=64,alpha=0.25`. `-` is stdin, in the format that
/// [`Overrides::format`] says.
///
/// A mesh file alone is framed by a default camera, and its materials that would be opaque (opacity 1, or none given)
/// become half transparent ([`MESH_ALPHA`]), since this program is not about opaque surfaces; an opacity below 1 is
/// kept, be it the material's, its picture's, or that of any point or vertex. In a scene file, a mesh file's own materials
/// are kept unchanged.
///
/// # Errors
/// Names the file, option or scene, the field, and what would be right.
pub fn load(source: &str, overrides: &Overrides) -> Result<Scene> {
    let (path, files) = (Path::new(source), Files::default());
    let scene = match overrides.format.or_else(|| FileFormat::of(path)) {
        Some(FileFormat::Toml) => scene_file(path, overrides, &files),
        Some(format) => {
            let mut model = mesh_file(path, format, overrides.point_size()?, &files)?;
            if model.objects.iter().all(|object| is_opaque(object, &model.materials)) {
                let opaque = model.materials.iter_mut().filter(|material| material.alpha >= 1.0);
                opaque.for_each(|material| material.alpha = MESH_ALPHA);
            }
            model.call(&names::letters(0));
            Draft::new(file_name(path), model).finish(overrides)
        }
        None if is_stdin(path) => {
            let problem = "must say what comes in on stdin, as SCENE -: obj, gltf, ply, stl, pcd, zip or toml";
            Err(Error::new("--format", problem))
        }
        None => built_in(source, overrides),
    };
    Ok(Scene { files: files.read.into_inner(), ..scene? })
}

/// Whether no point, vertex or picture of an object says that it lets light through.
fn is_opaque(object: &Object, materials: &[Material]) -> bool {
    let mesh = &object.mesh;
    let texture = materials.get(object.material).and_then(|material| material.texture.as_ref());
    let texture = texture.filter(|_| !mesh.places.is_empty());
    // Opacities of vertices under a mask only say where the surface is.
    let masked = |texture: &Texture| matches!(texture.opacity, Opacity::Mask { .. });
    mesh.discs.iter().all(|disc| disc.alpha >= 1.0)
        && (texture.is_some_and(masked) || mesh.alphas.iter().all(|alpha| *alpha >= 1.0))
        && !texture.is_some_and(Texture::is_translucent)
}

/// The catalogue of procedural scenes.
#[must_use]
pub fn builtin() -> &'static [Builtin] {
    procedural::builtin()
}

fn built_in(source: &str, overrides: &Overrides) -> Result<Scene> {
    let (name, keys) = source.split_once(':').unwrap_or((source, ""));
    if procedural::find(name).is_err() && Path::new(source).exists() {
        let problem = "extension: must be .obj, .gltf, .glb, .ply, .stl, .pcd, .zip or .toml, or --format must say what it is";
        return Err(Error::new(source, problem));
    }
    let size = image_size(name, None, overrides)?;
    let mut model = procedural::generate(name, &procedural::parse_keys(name, keys)?, size)?;
    for (i, object) in model.objects.iter_mut().enumerate() {
        object.name = names::letters(i);
    }
    Draft::new(name.to_owned(), model).finish(overrides)
}

fn scene_file(path: &Path, overrides: &Overrides, files: &Files) -> Result<Scene> {
    let description = file::parse(&files.read(path)?, &place(path))?;
    let size = overrides.point_size()?;
    let mut meshes: BTreeMap<(PathBuf, [Option<u32>; 2]), Model> = BTreeMap::new();
    let mut read_mesh = |name: &str, own: PointSize| {
        let (path, size) = (beside(path, name), size.or(own));
        let key = (path.clone(), [size.radius, size.scale].map(|v| v.map(f32::to_bits)));
        if let Some(model) = meshes.get(&key) {
            return Ok(Model { warnings: Vec::new(), ..model.clone() });
        }
        let format = FileFormat::of(&path).filter(|format| format.is_model());
        let format = format.ok_or_else(|| {
            let problem = "file: must end in .obj, .gltf, .glb, .ply, .stl, .pcd or .zip";
            Error::new(path.display().to_string(), problem)
        })?;
        let model = mesh_file(&path, format, size, files)?;
        meshes.insert(key, model.clone());
        Ok(model)
    };
    let mut model = |source: Source<'_>| match source {
        Source::Procedural { name, keys, size } => procedural::generate(name, keys, size),
        Source::File(name) => read_mesh(name, PointSize::default()),
        Source::Points { file, size } => read_mesh(file, size),
    };
    let mut read = |name: &str| files.read(&beside(path, name));
    let mut scene = description.build(overrides, &mut model, &mut read)?;
    scene.name = file_name(path);
    Ok(scene)
}

/// Reads a mesh file or point set of any kind, with its materials as they are.
fn mesh_file(path: &Path, format: FileFormat, size: PointSize, files: &Files) -> Result<Model> {
    let (bytes, place) = (files.read(path)?, place(path));
    if format == FileFormat::Zip {
        return zipped(&bytes, &place, size);
    }
    let model = parse(&bytes, format, &place, size, &mut |name| files.read(&beside(path, name)))?;
    model.named.iter().for_each(|name| files.note(&beside(path, name)));
    Ok(model)
}

/// The one model in a zip archive, in memory. `place` names it in messages.
///
/// # Errors
/// Names the archive, or the file in it and what is wrong with that.
pub fn zipped(bytes: &[u8], place: &str, size: PointSize) -> Result<Model> {
    let archive = Archive::new(bytes, place)?;
    let (model, format) = archive.model()?;
    let place = format!("{place}: {}", model.display());
    parse(&archive.file(&model)?, format, &place, size, &mut |name| archive.read(&model, name))
}

/// Reads a model from memory; `read` gives the files that it names.
fn parse(
    bytes: &[u8],
    format: FileFormat,
    place: &str,
    size: PointSize,
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
) -> Result<Model> {
    match format {
        FileFormat::Obj => obj::parse(bytes, place, &mut |name| read(name).ok()),
        FileFormat::Ply => ply::parse_sized(bytes, place, size),
        FileFormat::Stl => stl::parse(bytes, place),
        FileFormat::Pcd => pcd::parse_sized(bytes, place, size),
        FileFormat::Gltf => gltf::parse(bytes, place, read),
        FileFormat::Toml | FileFormat::Zip => Err(Error::new(place, "is no model")),
    }
}

fn file_name(path: &Path) -> String {
    let name = || path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    if is_stdin(path) { place(path) } else { name() }
}
