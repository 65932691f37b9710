//! From what a user names to a checked scene.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::draft::{Draft, Overrides, image_size};
use super::file::{self, Source};
use super::model::{MAX_FILE, Model, read_file};
use super::procedural::{self, Builtin};
use super::{Mesh, PointSize, Scene, gltf, names, obj, pcd, ply, stl};
use crate::error::{Error, Result};

/// The opacity given to surfaces of a mesh file that would be opaque.
pub const MESH_ALPHA: f32 = 0.5;

/// Loads a scene: a mesh or point set (`.obj`, `.gltf`, `.glb`, `.ply`, `.stl`, `.pcd`,
/// each also compressed, as in `.obj.gz`), a scene file (`.toml`), or a built-in scene's
/// name, optionally with keys as in `layers:count=64,alpha=0.25`.
///
/// A mesh file alone is framed by a default camera, and its materials that would be opaque (opacity 1, or none given)
/// become half transparent ([`MESH_ALPHA`]), since this program is not about opaque surfaces; an opacity below 1 is
/// kept, be it the material's or that of any point or vertex. In a scene file, a mesh file's own materials are kept unchanged.
///
/// # Errors
/// Names the file, option or scene, the field, and what would be right.
pub fn load(source: &str, overrides: &Overrides) -> Result<Scene> {
    let (path, reader) = (Path::new(source), Reader::default());
    let scene = match extension(path).as_str() {
        "toml" => scene_file(path, overrides, &reader),
        _ if is_mesh(path) => {
            let mut model = mesh_file(path, overrides.point_size()?, &reader)?;
            let opaque = |mesh: &Mesh| {
                mesh.discs.iter().all(|disc| disc.alpha >= 1.0)
                    && mesh.alphas.iter().all(|alpha| *alpha >= 1.0)
            };
            if model.objects.iter().all(|object| opaque(&object.mesh)) {
                let opaque = model.materials.iter_mut().filter(|material| material.alpha >= 1.0);
                opaque.for_each(|material| material.alpha = MESH_ALPHA);
            }
            model.call(&names::letters(0));
            Draft::new(file_name(path), model).finish(overrides)
        }
        _ => built_in(source, overrides),
    };
    Ok(Scene { files: reader.files.into_inner(), ..scene? })
}

/// Reads files, and remembers which.
#[derive(Default)]
struct Reader {
    files: RefCell<Vec<PathBuf>>,
}

impl Reader {
    fn read(&self, path: &Path) -> Result<Vec<u8>> {
        self.files.borrow_mut().push(path.to_path_buf());
        read_file(path)
    }
}

/// The catalogue of procedural scenes.
#[must_use]
pub fn builtin() -> &'static [Builtin] {
    procedural::builtin()
}

fn built_in(source: &str, overrides: &Overrides) -> Result<Scene> {
    let (name, keys) = source.split_once(':').unwrap_or((source, ""));
    if procedural::find(name).is_err() && Path::new(source).exists() {
        let problem = "extension: must be .obj, .gltf, .glb, .ply, .stl, .pcd or .toml";
        return Err(Error::new(source, problem));
    }
    let size = image_size(name, None, overrides)?;
    let mut model = procedural::generate(name, &procedural::parse_keys(name, keys)?, size)?;
    for (i, object) in model.objects.iter_mut().enumerate() {
        object.name = names::letters(i);
    }
    Draft::new(name.to_owned(), model).finish(overrides)
}

fn scene_file(path: &Path, overrides: &Overrides, reader: &Reader) -> Result<Scene> {
    let place = path.display().to_string();
    let description = file::parse(&reader.read(path)?, &place)?;
    let size = overrides.point_size()?;
    let mut meshes: BTreeMap<(PathBuf, [Option<u32>; 2]), Model> = BTreeMap::new();
    let mut read_mesh = |name: &str, own: PointSize| {
        let (path, size) = (beside(path, name), size.or(own));
        let key = (path.clone(), [size.radius, size.scale].map(|v| v.map(f32::to_bits)));
        if let Some(model) = meshes.get(&key) {
            return Ok(Model { warnings: Vec::new(), ..model.clone() });
        }
        let model = mesh_file(&path, size, reader)?;
        meshes.insert(key, model.clone());
        Ok(model)
    };
    let mut model = |source: Source<'_>| match source {
        Source::Procedural { name, keys, size } => procedural::generate(name, keys, size),
        Source::File(name) => read_mesh(name, PointSize::default()),
        Source::Points { file, size } => read_mesh(file, size),
    };
    let mut read = |name: &str| reader.read(&beside(path, name));
    let mut scene = description.build(overrides, &mut model, &mut read)?;
    scene.name = file_name(path);
    Ok(scene)
}

/// Reads a mesh file or point set of any kind, with its materials as they are.
fn mesh_file(path: &Path, size: PointSize, reader: &Reader) -> Result<Model> {
    let place = path.display().to_string();
    if !is_mesh(path) {
        return Err(Error::new(place, "file: must end in .obj, .gltf, .glb, .ply, .stl or .pcd"));
    }
    let bytes = unpacked(reader.read(path)?, &place)?;
    match extension(path).as_str() {
        "obj" => obj::parse(&bytes, &place, &mut |name| reader.read(&beside(path, name)).ok()),
        "ply" => ply::parse_sized(&bytes, &place, size),
        "stl" => stl::parse(&bytes, &place),
        "pcd" => pcd::parse_sized(&bytes, &place, size),
        _ => gltf::parse(&bytes, &place, &mut |name| reader.read(&beside(path, name))),
    }
}

fn is_mesh(path: &Path) -> bool {
    matches!(extension(path).as_str(), "obj" | "gltf" | "glb" | "ply" | "stl" | "pcd")
}

/// What gzip packed, if it did.
fn unpacked(bytes: Vec<u8>, place: &str) -> Result<Vec<u8>> {
    if !bytes.starts_with(b"\x1F\x8B") {
        return Ok(bytes);
    }
    let wrong = |problem: String| Error::new(place, problem);
    let mut whole = Vec::new();
    let unpacking = flate2::read::MultiGzDecoder::new(&bytes[..]);
    unpacking
        .take(MAX_FILE + 1)
        .read_to_end(&mut whole)
        .map_err(|_| wrong("gzip: the compressed data are broken".to_owned()))?;
    if whole.len() as u64 > MAX_FILE {
        return Err(wrong(format!("size: must be at most {MAX_FILE} bytes, unpacked")));
    }
    Ok(whole)
}

/// In lower case; of a compressed file, the one before `.gz`.
fn extension(path: &Path) -> String {
    let of = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match of(path) {
        Some(packed) if packed == "gz" => of(&path.with_extension("")).unwrap_or(packed),
        own => own.unwrap_or_default(),
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The path of a file named in another file.
fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(name)
}
