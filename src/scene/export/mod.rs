//! A scene as glTF 2.0 for other renderers, with a scene file beside it for this one: geometry in drawing order,
//! materials with opacity, colours of vertices, the camera.
//!
//! Triangles given in pixels are snapped, and seen by an orthographic camera whose world unit is a pixel: x to the right,
//! y up from the image's lower edge, z = -depth, so that each coordinate is exact in the 32 bits that glTF has if the
//! depth is. Objects keep their own vertices and transforms, and the scene's own camera.

mod binary;
mod camera;
mod material;
mod mesh;
mod scene_file;
mod screen;

use serde_json::{Value, json};

use self::binary::Binary;
use self::camera::Seen;
use super::{Camera, Scene, Shading};
use crate::error::{Error, Result};

/// A scene as files.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// The bytes of a `.glb` file.
    pub glb: Vec<u8>,
    /// A scene file that draws it: size, background, camera, light, and the `.glb` file by its name.
    pub scene: String,
    /// The camera that it is seen by.
    pub camera: Camera,
    /// How many numbers are not the scene's own, since 32 bits do not hold them.
    pub rounded: u64,
    /// What another renderer, or this one, will draw in another way.
    pub warnings: Vec<String>,
}

/// What is written so far.
#[derive(Default)]
struct Document {
    binary: Binary,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    textures: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    unlit: bool,
    rounded: u64,
    warnings: Vec<String>,
}

/// Export a scene. `name` is the name of the `.glb` file, by which the scene file names it; triangles in pixels are
/// snapped to `sub_pixel_bits`, 8 or 4.
///
/// # Errors
/// What glTF cannot hold: points, volumes, and objects together with triangles in pixels.
pub fn export(scene: &Scene, name: &str, sub_pixel_bits: u32) -> Result<Exported> {
    check(scene)?;
    let mut document = Document::default();
    let camera = if scene.objects.is_empty() {
        document.screen(scene, sub_pixel_bits)?;
        screen::camera(scene.size)
    } else {
        document.objects(scene)?;
        scene.camera
    };
    let seen = Seen { camera, size: scene.size };
    let text = scene_file::text(scene, &camera, name);
    document.finish(&seen, text)
}

fn check(scene: &Scene) -> Result<()> {
    let wrong = |problem: &str| Err(Error::new(&scene.name, format!("export: {problem}")));
    if scene.objects.iter().any(|object| !object.mesh.discs.is_empty()) {
        return wrong("glTF has no discs, so that point sets cannot be exported");
    }
    if !scene.volumes.is_empty() {
        return wrong("glTF has no volumes, so that they cannot be exported");
    }
    if !scene.objects.is_empty() && !scene.screen.is_empty() {
        return wrong(
            "no one camera shows both objects and triangles in pixels; export them apart",
        );
    }
    Ok(())
}

impl Document {
    fn finish(mut self, seen: &Seen, scene: String) -> Result<Exported> {
        self.nodes.push(seen.node());
        let mut root = json!({
            "asset": { "version": "2.0", "generator": concat!("fragloom ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "cameras": [seen.gltf()],
            "nodes": self.nodes,
        });
        for (key, list) in [
            ("accessors", self.accessors),
            ("bufferViews", std::mem::take(&mut self.binary.views)),
            ("images", self.images),
            ("materials", self.materials),
            ("meshes", self.meshes),
            ("samplers", self.samplers),
            ("textures", self.textures),
        ] {
            // glTF has no empty lists.
            if !list.is_empty() {
                root[key] = Value::Array(list);
            }
        }
        if self.unlit {
            root["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        }
        let glb = self.binary.glb(root)?;
        Ok(Exported {
            glb,
            scene,
            camera: seen.camera,
            rounded: self.rounded,
            warnings: self.warnings,
        })
    }

    /// A number in 32 bits.
    fn narrow(&mut self, number: f64) -> f32 {
        let narrow = number as f32;
        self.rounded += u64::from(f64::from(narrow) != number);
        narrow
    }

    fn warn(&mut self, text: &str) {
        if !self.warnings.iter().any(|known| known == text) {
            self.warnings.push(text.to_owned());
        }
    }

    /// How light acts, as far as glTF says it.
    fn shaded(&mut self, shading: Shading, material: &mut Value) {
        match shading {
            Shading::Flat => {
                self.unlit = true;
                material["extensions"] = json!({ "KHR_materials_unlit": {} });
            }
            Shading::Lambert => {
                self.warn("lit surfaces: other renderers light them in their own way; --shading flat is the same everywhere");
            }
            Shading::Gooch => {
                self.warn("shading gooch: glTF has no such thing, and it is exported as lambert");
            }
        }
    }
}
