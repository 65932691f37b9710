//! Objects: meshes where they are, each once, however often it is placed.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DMat4;
use serde_json::{Value, json};

use super::super::texture::Opacity;
use super::super::{Material, Mesh, Scene, Shading};
use super::Document;
use super::binary::Use;
use crate::error::Result;

impl Document {
    /// All objects, in their order.
    pub(super) fn objects(&mut self, scene: &Scene) -> Result<()> {
        let mut materials: BTreeMap<usize, usize> = BTreeMap::new();
        // By place in memory, which is only compared.
        let mut meshes: BTreeMap<(*const Mesh, usize), usize> = BTreeMap::new();
        for object in scene.objects.iter().filter(|object| !object.mesh.triangles.is_empty()) {
            let own = &scene.materials[object.material];
            let key = (Arc::as_ptr(&object.mesh), object.material);
            let mesh = match meshes.get(&key) {
                Some(&mesh) => mesh,
                None => {
                    let material = match materials.get(&object.material) {
                        Some(&material) => material,
                        None => {
                            let material = self.material(own)?;
                            materials.insert(object.material, material);
                            material
                        }
                    };
                    let primitive = self.primitive(&object.mesh, own, material);
                    self.meshes.push(json!({ "name": object.name, "primitives": [primitive] }));
                    meshes.insert(key, self.meshes.len() - 1);
                    self.meshes.len() - 1
                }
            };
            let mut node = json!({ "name": object.name, "mesh": mesh });
            if object.transform != DMat4::IDENTITY {
                node["matrix"] = json!(object.transform.to_cols_array());
            }
            if object.thickness.is_some() {
                self.warn("thickness: glTF has no such thing, and it is left out");
            }
            self.nodes.push(node);
        }
        Ok(())
    }

    fn primitive(&mut self, mesh: &Mesh, material: &Material, number: usize) -> Value {
        let mut attributes = json!({ "POSITION": self.positions(&mesh.positions) });
        if !mesh.normals.is_empty() && material.shading != Shading::Flat {
            let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|n| self.unit(*n)).collect();
            attributes["NORMAL"] = self.vertices(normals.as_flattened(), 3, None).into();
        }
        // Where a picture's opacity means nothing, or a mask, that of vertices does not, either.
        let textured = material.texture.as_ref().filter(|_| !mesh.places.is_empty());
        let opaque = textured.is_some_and(|texture| texture.opacity == Opacity::Opaque);
        let alphas = (!opaque && !mesh.alphas.is_empty()).then_some(&mesh.alphas);
        let color = |i: usize| mesh.colors.get(i).copied().unwrap_or([1.0; 3]);
        match alphas {
            Some(alphas) => {
                let rgba = alphas.iter().enumerate().flat_map(|(i, &alpha)| {
                    let [r, g, b] = color(i);
                    [r, g, b, alpha]
                });
                let rgba: Vec<f32> = rgba.collect();
                attributes["COLOR_0"] = self.vertices(&rgba, 4, None).into();
            }
            None if !mesh.colors.is_empty() => {
                attributes["COLOR_0"] = self.vertices(mesh.colors.as_flattened(), 3, None).into();
            }
            None => {}
        }
        if textured.is_some() {
            attributes["TEXCOORD_0"] = self.vertices(mesh.places.as_flattened(), 2, None).into();
        }
        let indices: Vec<u8> =
            mesh.triangles.as_flattened().iter().flat_map(|index| index.to_le_bytes()).collect();
        let view = self.binary.view(&indices, Use::Indices);
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": 5_125,
            "count": 3 * mesh.triangles.len(),
            "type": "SCALAR",
        }));
        let indices = self.accessors.len() - 1;
        json!({ "attributes": attributes, "indices": indices, "material": number, "mode": 4 })
    }

    /// A normal as glTF wants it: of unit length.
    fn unit(&mut self, normal: [f32; 3]) -> [f32; 3] {
        let square: f64 = normal.iter().map(|&c| f64::from(c) * f64::from(c)).sum();
        if (square - 1.0).abs() < 1e-5 || square == 0.0 {
            return normal;
        }
        let length = square.sqrt();
        normal.map(|c| self.narrow(f64::from(c) / length))
    }

    /// Positions, with the box around them that glTF asks for; gives the accessor.
    pub(super) fn positions(&mut self, positions: &[[f64; 3]]) -> usize {
        let narrow: Vec<[f32; 3]> =
            positions.iter().map(|position| position.map(|c| self.narrow(c))).collect();
        let ends = |pick: fn(f32, f32) -> f32, from: f32| {
            let join = |ends: [f32; 3], p: &[f32; 3]| std::array::from_fn(|i| pick(ends[i], p[i]));
            narrow.iter().fold([from; 3], join)
        };
        let bounds = [ends(f32::min, f32::INFINITY), ends(f32::max, f32::NEG_INFINITY)];
        self.vertices(narrow.as_flattened(), 3, Some(bounds))
    }

    /// Numbers of vertices, `width` of each; gives the accessor.
    fn vertices(&mut self, numbers: &[f32], width: usize, bounds: Option<[[f32; 3]; 2]>) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let view = self.binary.view(&bytes, Use::Vertices);
        let mut accessor = json!({
            "bufferView": view,
            "componentType": 5_126,
            "count": numbers.len() / width,
            "type": format!("VEC{width}"),
        });
        if let Some([min, max]) = bounds {
            accessor["min"] = json!(min);
            accessor["max"] = json!(max);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
