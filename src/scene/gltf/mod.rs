//! glTF 2.0 and GLB. The `gltf` crate reads the JSON and splits GLB files; its own validation and its accessor
//! readers panic on some hostile files (a POSITION out of range, an accessor of no elements), so this module
//! walks the plain JSON structures and checks each index, offset and count where it uses it.
//!
//! Drawn are the meshes of the default scene (else the first, else all root nodes), each node's transform
//! applied after its children's. Not drawn: textures (one warning), points and lines (one warning), skins,
//! morph targets, cameras and lights.

mod accessor;
mod buffers;
mod nodes;

use std::sync::Arc;

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use self::accessor::Data;
use super::model::{GREY, MAX_TRIANGLES, Unplaced};
use super::{Material, Mesh, Model, check};
use crate::error::{Error, Result};

/// The meshes of a glTF or GLB file: one object per node and primitive. `place` names the file in messages;
/// `read` gives the bytes of an external buffer by its relative path.
///
/// # Errors
/// Names the mesh, accessor or buffer and what is wrong with it; `read`'s errors are passed on.
pub fn parse(
    bytes: &[u8],
    place: &str,
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
) -> Result<Model> {
    let (json, bin) = buffers::split(bytes, place)?;
    let root =
        Root::from_slice(&json).map_err(|error| Error::new(place, format!("JSON: {error}")))?;
    check_extensions(&root, place)?;
    let buffers = buffers::load(&root, bin, place, read)?;
    let mut loader = Loader {
        data: Data { root: &root, buffers, place },
        model: Model::default(),
        skipped: 0,
        read: 0,
    };
    loader.materials()?;
    let meshes = (0..root.meshes.len()).map(|i| loader.mesh(i)).collect::<Result<Vec<_>>>()?;
    for (mesh, transform) in nodes::placed_meshes(&root, place)? {
        let parts = meshes.get(mesh).ok_or_else(|| {
            Error::new(place, format!("nodes: mesh {mesh} is not among the {}", meshes.len()))
        })?;
        for (part, material) in parts {
            loader.model.add_placed(Arc::clone(part), transform, *material);
        }
    }
    loader.finish()
}

/// Extensions that change how geometry is stored are refused; those that change how it looks are ignored.
fn check_extensions(root: &Root, place: &str) -> Result<()> {
    let harmless =
        ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_mesh_quant"];
    let strange = |name: &&String| !harmless.iter().any(|prefix| name.starts_with(prefix));
    match root.extensions_required.iter().find(strange) {
        Some(name) => {
            let problem = format!("extensionsRequired: {name:?} is not supported");
            Err(Error::new(place, problem))
        }
        None => Ok(()),
    }
}

struct Loader<'a> {
    data: Data<'a>,
    model: Model,
    /// How many primitives are points or lines.
    skipped: usize,
    /// How many corners and vertices were read so far.
    read: usize,
}

/// A mesh with the index of its material.
type Part = (Arc<Mesh>, usize);

impl Loader<'_> {
    fn materials(&mut self) -> Result<()> {
        for (i, material) in self.data.root.materials.iter().enumerate() {
            let name = material.name.clone().unwrap_or_else(|| format!("material {i}"));
            let [r, g, b, alpha] = material.pbr_metallic_roughness.base_color_factor.0;
            let field = format!("material {name:?}: baseColorFactor");
            check::color(self.data.place, &field, [r, g, b])?;
            check::fraction(self.data.place, &field, alpha)?;
            self.model.add_material(Material::new(name, [r, g, b], alpha));
        }
        self.model.add_material(Material::new("default", GREY, 1.0));
        Ok(())
    }

    fn mesh(&mut self, index: usize) -> Result<Vec<Part>> {
        let primitives = &self.data.root.meshes[index].primitives;
        let mut parts = Vec::new();
        for (i, primitive) in primitives.iter().enumerate() {
            let name = format!("mesh {index} primitive {i}");
            match primitive.mode {
                Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) => {
                    parts.push(self.primitive(primitive, &name)?);
                }
                Checked::Valid(_) => self.skipped += 1,
                Checked::Invalid => {
                    return Err(Error::new(
                        self.data.place,
                        format!("{name}: mode: must be 0 to 6"),
                    ));
                }
            }
        }
        Ok(parts)
    }

    fn primitive(&mut self, primitive: &Primitive, name: &str) -> Result<Part> {
        let wrong = |problem: String| Error::new(self.data.place, format!("{name}: {problem}"));
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
        let positions =
            attribute(Semantic::Positions).ok_or_else(|| wrong("has no POSITION".into()))?;
        let positions = self.data.vectors(positions.value(), "POSITION", name)?;
        let optional = |index: Option<&Index<_>>, semantic| match index {
            Some(index) => self.data.vectors(index.value(), semantic, name),
            None => Ok(Vec::new()),
        };
        let order = match primitive.indices {
            Some(index) => self.data.indices(index.value(), name)?,
            None => (0..positions.len() as u32).collect(),
        };
        self.read = self.read.saturating_add(positions.len()).saturating_add(order.len());
        if self.read > 4 * MAX_TRIANGLES {
            return Err(wrong(format!("more than {} corners so far", 4 * MAX_TRIANGLES)));
        }
        let mesh = Mesh {
            normals: optional(attribute(Semantic::Normals), "NORMAL")?,
            colors: optional(attribute(Semantic::Colors(0)), "COLOR_0")?,
            triangles: triangles(primitive.mode, &order),
            positions,
            discs: Vec::new(),
        };
        check::mesh(self.data.place, &mesh).map_err(|error| wrong(error.problem().to_owned()))?;
        Ok((Arc::new(mesh), self.material(primitive).map_err(wrong)?))
    }

    fn material(&self, primitive: &Primitive) -> Unplaced<usize> {
        let count = self.data.root.materials.len();
        match primitive.material {
            None => Ok(count),
            Some(index) if index.value() < count => Ok(index.value()),
            Some(index) => Err(format!("material: {} is not among the {count}", index.value())),
        }
    }

    fn finish(mut self) -> Result<Model> {
        let place = self.data.place;
        let triangles = self.model.triangles();
        if triangles == 0 {
            return Err(Error::new(
                place,
                "meshes: the scene has no triangle; it needs at least one",
            ));
        }
        if triangles > MAX_TRIANGLES {
            let problem = format!("meshes: {triangles} triangles are more than {MAX_TRIANGLES}");
            return Err(Error::new(place, problem));
        }
        if !self.data.root.textures.is_empty() || !self.data.root.images.is_empty() {
            self.model.warnings.push(format!("{place}: textures are not drawn; colours are plain"));
        }
        if self.skipped > 0 {
            let skipped = self.skipped;
            self.model
                .warnings
                .push(format!("{place}: {skipped} primitives of points or lines left out"));
        }
        Ok(self.model)
    }
}

/// The triangles that the vertices make in order; strips turn every other triangle around. Vertices left over at the
/// end form no triangle.
fn triangles(mode: Checked<Mode>, order: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Checked::Valid(Mode::TriangleStrip) => {
            let window = |(i, w): (usize, &[u32])| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[0], w[2], w[1]],
            };
            order.windows(3).enumerate().map(window).collect()
        }
        Checked::Valid(Mode::TriangleFan) => match order {
            [hub, rim @ ..] => rim.windows(2).map(|w| [w[0], w[1], *hub]).collect(),
            [] => Vec::new(),
        },
        _ => order.as_chunks().0.to_vec(),
    }
}
