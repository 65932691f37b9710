//! glTF 2.0 and GLB, walked as plain JSON: each index, offset and count is checked where it is used, and what nobody
//! draws is not looked at.
//!
//! Drawn are the meshes of the default scene (else the first, else all root nodes), each node's transform applied after
//! its children's: with morph targets and skins at rest, instances, and base colours with their pictures (PNG and JPEG,
//! by their samplers, but never smaller copies of them). Not drawn: other textures, points and lines (a warning), cameras
//! and lights.

mod accessor;
mod buffers;
mod cameras;
mod extensions;
mod instances;
mod json;
mod mask;
mod materials;
mod nodes;
mod primitive;
mod skin;
mod textures;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DMat4;
use serde_json::Value;

use self::accessor::Data;
use self::materials::Look;
use self::primitive::Found;
use self::textures::Pictures;
use super::model::{GREY, MAX_TRIANGLES, Unplaced};
use super::parts::Tally;
use super::texture::Opacity;
use super::{Material, Mesh, Model, Object, check};
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
    let wrong = |problem: String| Error::new(place, problem);
    let (json, bin) = buffers::split(bytes).map_err(wrong)?;
    let root = json::parse(json).map_err(wrong)?;
    check_version(&root).map_err(wrong)?;
    let mut tally = Tally::default();
    extensions::check(&root, &mut tally).map_err(wrong)?;
    let buffers = buffers::load(&root, bin, place, read).map_err(wrong)?;
    let data = Data { root: &root, buffers, place };
    let mut loader = Loader {
        data: &data,
        model: Model { named: textures::names(&root), ..Model::default() },
        looks: Vec::new(),
        white: None,
        plain: BTreeMap::new(),
        known: BTreeMap::new(),
        tally,
        read: 0,
        gone: false,
    };
    loader.materials(read).map_err(wrong)?;
    loader.nodes()?;
    loader.finish()
}

/// `asset.minVersion`, else the major number of `asset.version`, must be 2.
fn check_version(root: &Value) -> Unplaced<()> {
    let asset = json::get(root, "asset").unwrap_or(&Value::Null);
    if let Some(least) = json::text(asset, "minVersion").filter(|least| *least != "2.0")
        && !least.starts_with("1.")
    {
        let least: String = least.chars().take(20).collect();
        return Err(format!(
            "asset.minVersion: the file needs a reader of glTF {least}; this one reads 2.0, so export it as that"
        ));
    }
    let version = json::get(asset, "version");
    let text = version.and_then(Value::as_str).map(str::to_owned);
    // A number is wrong, but says the same.
    let text = text.or_else(|| version.and_then(Value::as_f64).map(|v| v.to_string()));
    let by_name = ["meshes", "nodes", "accessors"];
    match text.as_deref().map(|text| text.split('.').next().unwrap_or_default()) {
        Some("2") => Ok(()),
        Some("0" | "1") => Err(format!("asset.version: {}", buffers::CONVERT)),
        None if by_name.iter().any(|key| root.get(key).is_some_and(Value::is_object)) => {
            Err(format!("asset.version: is missing; the file {}", buffers::CONVERT))
        }
        Some(_) => {
            let text: String = text.unwrap_or_default().chars().take(20).collect();
            Err(format!("asset.version: {text:?} is not known; export the file as glTF 2.0"))
        }
        None => Err("asset.version: is missing; it must be \"2.0\"".to_owned()),
    }
}

/// The most objects.
const MOST: usize = 1 << 22;

struct Loader<'a> {
    data: &'a Data<'a>,
    model: Model,
    /// What else is known of each material.
    looks: Vec<Look>,
    /// The default material in white.
    white: Option<usize>,
    /// Materials without their pictures, by the number of the one with it.
    plain: BTreeMap<usize, usize>,
    /// Meshes by number and weights.
    known: BTreeMap<(usize, Vec<u64>), Vec<Part>>,
    tally: Tally,
    /// How many corners, vertices, joints and instances were read so far.
    read: usize,
    /// Whether something is there that is not to be seen.
    gone: bool,
}

/// A mesh with the index of its material.
type Part = (Arc<Mesh>, usize);

impl<'a> Loader<'a> {
    fn materials(&mut self, read: &mut dyn FnMut(&str) -> Result<Vec<u8>>) -> Unplaced<()> {
        let mut pictures = Pictures::new(self.data, read);
        for (i, value) in json::list(self.data.root, "materials")?.iter().enumerate() {
            let (material, look) = materials::read(i, value, &mut pictures, &mut self.tally)?;
            self.material(material, look);
        }
        // Of primitives without one: grey, or white for the colours of vertices to show.
        self.material(Material::new("default", GREY, 1.0), Look::PLAIN);
        Ok(())
    }

    fn material(&mut self, material: Material, look: Look) -> usize {
        self.looks.push(look);
        self.model.add_material(material)
    }

    fn nodes(&mut self) -> Result<()> {
        let root = self.data.root;
        let placed = nodes::walk(root).map_err(|problem| Error::new(self.data.place, problem))?;
        self.gone |= placed.hidden > 0;
        let nodes = json::list(root, "nodes").unwrap_or_default();
        for index in placed.seen {
            let (node, place) = (&nodes[index], placed.places[index].unwrap_or_default());
            let own = json::text(node, "name").map_or_else(String::new, |own| format!(" {own:?}"));
            let name = format!("node {index}{own}");
            let camera = cameras::of_node(root, node, place, &name, &mut self.tally);
            self.model.cameras.extend(camera);
            let field = |key| json::index(node, key).map_err(|p| self.data.wrong(&name, &p));
            let (Some(mesh), skin) = (field("mesh")?, field("skin")?) else { continue };
            let instances = self.data.instances(node, &name)?;
            self.spend(instances.as_ref().map_or(0, Vec::len), &name)?;
            let weights = self.weights(node, mesh, &name)?;
            let joints = match skin {
                Some(skin) => Some((skin, self.data.joints(skin, &placed.places)?)),
                None => None,
            };
            if let Some((skin, joints)) = joints {
                let joints = joints.and_then(|joints| match instances {
                    None => Ok(joints),
                    Some(_) => Err("it has instances, too"),
                });
                let said = match joints {
                    Ok(joints) => {
                        self.spend(joints.len(), &name)?;
                        self.skinned(mesh, &weights, &joints)?
                    }
                    Err(problem) => Err(problem),
                };
                match said {
                    Ok(parts) => {
                        self.place(&parts, DMat4::IDENTITY);
                        continue;
                    }
                    Err(problem) => {
                        self.tally.add("the skin is left out", || {
                            format!("{name}: skin {skin}: {problem}")
                        });
                    }
                }
            }
            let parts = self.parts(mesh, &weights)?;
            match instances {
                None => self.place(&parts, place),
                Some(instances) => {
                    for instance in instances {
                        self.place(&parts, place * instance);
                    }
                }
            }
            self.check_count()?;
        }
        Ok(())
    }

    fn place(&mut self, parts: &[Part], place: DMat4) {
        for (mesh, material) in parts {
            self.model.add_placed(Arc::clone(mesh), place, *material);
        }
    }

    /// The weights of morph targets: the node's, else the mesh's.
    fn weights(&self, node: &Value, mesh: usize, name: &str) -> Result<Vec<f64>> {
        let meshes = json::list(self.data.root, "meshes");
        let meshes = meshes.map_err(|problem| Error::new(self.data.place, problem))?;
        let Some(mesh) = meshes.get(mesh) else {
            let problem = format!("nodes: mesh {mesh} is not among the {}", meshes.len());
            return Err(Error::new(self.data.place, problem));
        };
        let own = if json::get(node, "weights").is_some() { node } else { mesh };
        let weights = json::list(own, "weights").map_err(|p| self.data.wrong(name, &p))?;
        Ok(weights.iter().map(|weight| weight.as_f64().unwrap_or_default()).collect())
    }

    /// A mesh as it is drawn, read once for each set of weights.
    fn parts(&mut self, mesh: usize, weights: &[f64]) -> Result<Vec<Part>> {
        let key = (mesh, weights.iter().map(|weight| weight.to_bits()).collect());
        if let Some(parts) = self.known.get(&key) {
            return Ok(parts.clone());
        }
        let mut parts = Vec::new();
        for (i, primitive) in self.primitives(mesh)?.iter().enumerate() {
            let name = format!("mesh {mesh} primitive {i}");
            if let Some(found) = self.primitive(primitive, &name, weights)? {
                parts.push(self.finished(found, primitive, &name)?);
            }
        }
        self.known.insert(key, parts.clone());
        Ok(parts)
    }

    /// A mesh moved by joints; a text if it cannot be.
    fn skinned(
        &mut self,
        mesh: usize,
        weights: &[f64],
        joints: &[DMat4],
    ) -> Result<std::result::Result<Vec<Part>, &'static str>> {
        let mut parts = Vec::new();
        for (i, primitive) in self.primitives(mesh)?.iter().enumerate() {
            let name = format!("mesh {mesh} primitive {i}");
            let Some(mut found) = self.primitive(primitive, &name, weights)? else { continue };
            if let Err(problem) = self.data.skinned(&mut found, primitive, joints, &name)? {
                return Ok(Err(problem));
            }
            parts.push(self.finished(found, primitive, &name)?);
        }
        Ok(Ok(parts))
    }

    fn primitives(&self, mesh: usize) -> Result<&'a [Value]> {
        let meshes = json::list(self.data.root, "meshes").unwrap_or_default();
        let found = meshes.get(mesh).map_or(Ok(&[][..]), |mesh| json::list(mesh, "primitives"));
        found.map_err(|problem| self.data.wrong(&format!("mesh {mesh}"), &problem))
    }

    fn primitive(&mut self, value: &Value, name: &str, weights: &[f64]) -> Result<Option<Mesh>> {
        self.spend(1, name)?;
        match self.data.primitive(value, name, weights, &mut self.tally)? {
            Found::LeftOut(why) => {
                self.tally.add(why, || name.to_owned());
                Ok(None)
            }
            Found::Mesh(mesh) => {
                self.spend(mesh.positions.len().saturating_add(3 * mesh.triangles.len()), name)?;
                Ok(Some(*mesh))
            }
        }
    }

    /// Counts what is read, since a small file may ask for the same things again and again.
    fn spend(&mut self, count: usize, name: &str) -> Result<()> {
        self.read = self.read.saturating_add(count);
        if self.read <= 4 * MAX_TRIANGLES {
            return Ok(());
        }
        let problem =
            format!("more than {} corners, joints or instances so far", 4 * MAX_TRIANGLES);
        Err(self.data.wrong(name, &problem))
    }

    /// Brings the material to a mesh.
    fn finished(&mut self, mut mesh: Mesh, primitive: &Value, name: &str) -> Result<Part> {
        let count = json::list(self.data.root, "materials").map_or(0, <[_]>::len);
        let wrong = |problem: String| self.data.wrong(name, &problem);
        let mut material = match json::index(primitive, "material").map_err(wrong)? {
            Some(index) if index < count => index,
            Some(index) => {
                return Err(wrong(format!("material: {index} is not among the {count}")));
            }
            None if mesh.colors.is_empty() => count,
            None => self.white(),
        };
        if let Some(lying) = self.looks[material].lying {
            let vertices = mesh.positions.len();
            match self.data.places(primitive, lying, vertices, name, &mut self.tally)? {
                Some(places) => mesh.places = places,
                None => material = self.plain(material),
            }
        }
        match self.looks[material].opacity {
            Opacity::Blend => {}
            // A picture's mask is looked at pixel by pixel.
            Opacity::Mask { .. } if !mesh.places.is_empty() => {}
            Opacity::Mask { alpha, cutoff } => {
                mesh = mask::cut(mesh, alpha, cutoff);
                self.gone |= mesh.triangles.is_empty();
            }
            Opacity::Opaque => mesh.alphas.clear(),
        }
        check::mesh(self.data.place, &mesh).map_err(|e| self.data.wrong(name, e.problem()))?;
        Ok((Arc::new(mesh), material))
    }

    fn white(&mut self) -> usize {
        if let Some(white) = self.white {
            return white;
        }
        let white = self.material(Material::new("default", [1.0; 3], 1.0), Look::PLAIN);
        *self.white.insert(white)
    }

    /// A material without its picture.
    fn plain(&mut self, material: usize) -> usize {
        if let Some(&plain) = self.plain.get(&material) {
            return plain;
        }
        let own = Material { texture: None, ..self.model.materials[material].clone() };
        let look = Look { lying: None, ..self.looks[material] };
        let plain = self.material(own, look);
        self.plain.insert(material, plain);
        plain
    }

    fn check_count(&self) -> Result<()> {
        let triangles = self.model.triangles();
        if triangles > MAX_TRIANGLES {
            let problem = format!("meshes: {triangles} triangles are more than {MAX_TRIANGLES}");
            return Err(Error::new(self.data.place, problem));
        }
        if self.model.objects.len() > MOST {
            let problem = format!("nodes: more than {MOST} instances of primitives");
            return Err(Error::new(self.data.place, problem));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Model> {
        let place = self.data.place;
        if self.model.triangles() == 0 {
            if !self.gone {
                let problem = "meshes: the scene has no triangle; it needs at least one";
                let meshes = json::list(self.data.root, "meshes").map_or(0, <[_]>::len);
                let reasons = match self.read == 0 && meshes > 0 {
                    true => format!(" ({meshes} in the file, but on no node of the scene)"),
                    false => self.tally.reasons(primitive::is_left_out),
                };
                return Err(Error::new(place, problem.to_owned() + &reasons));
            }
            // Nothing is what is to be seen.
            let mesh = Arc::new(Mesh::default());
            let (name, transform) = (String::new(), DMat4::IDENTITY);
            self.model.objects.push(Object { name, mesh, transform, material: 0, thickness: None });
            self.tally.add("nothing is left to draw", || {
                "meshes: all are hidden, or masked out by alphaCutoff".to_owned()
            });
        }
        self.model.warnings = self.tally.warnings(place);
        Ok(self.model)
    }
}
