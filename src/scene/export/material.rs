//! Materials and the pictures on them.

use serde_json::{Value, json};

use super::super::texture::{Opacity, Texture, Wrap};
use super::super::{Material, Shading};
use super::Document;
use super::binary::Use;
use crate::error::{Error, Result};
use crate::image::png;

impl Document {
    /// A material without a picture; gives its number. Every one of them is blended, also what is opaque, so that its
    /// opacity is what counts.
    pub(super) fn plain_material(
        &mut self,
        name: &str,
        [r, g, b]: [f32; 3],
        alpha: f32,
        shading: Shading,
    ) -> usize {
        let mut value = json!({
            "name": name,
            "alphaMode": "BLEND",
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, alpha],
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
        });
        self.shaded(shading, &mut value);
        self.materials.push(value);
        self.materials.len() - 1
    }

    /// A material; gives its number.
    pub(super) fn material(&mut self, material: &Material) -> Result<usize> {
        let Material { name, color, alpha, shading, texture } = material;
        let number = self.plain_material(name, *color, *alpha, *shading);
        let Some(texture) = texture else { return Ok(number) };
        let index = self.texture(name, texture)?;
        self.materials[number]["pbrMetallicRoughness"]["baseColorTexture"] =
            json!({ "index": index });
        if let Opacity::Mask { alpha: own, cutoff } = texture.opacity {
            self.materials[number]["alphaMode"] = "MASK".into();
            self.materials[number]["alphaCutoff"] = json!(cutoff);
            self.materials[number]["pbrMetallicRoughness"]["baseColorFactor"][3] = json!(own);
            if *alpha < 1.0 {
                self.warn("what a mask leaves is opaque in glTF, and here it is not");
            }
        }
        Ok(number)
    }

    fn texture(&mut self, name: &str, texture: &Texture) -> Result<usize> {
        let image = match texture.opacity {
            Opacity::Opaque => (*texture.picture).clone().opaque(),
            _ => (*texture.picture).clone(),
        };
        let bytes = png::encode(image.image());
        let bytes = bytes.map_err(|error| Error::new(name, error.to_string()))?;
        let view = self.binary.view(&bytes, Use::Picture);
        self.images.push(json!({ "bufferView": view, "mimeType": "image/png" }));
        let wrap = |wrap: Wrap| match wrap {
            Wrap::Repeat => 10_497,
            Wrap::Mirror => 33_648,
            Wrap::Clamp => 33_071,
        };
        let filter = if texture.nearest { 9_728 } else { 9_729 };
        let sampler: Value = json!({
            "wrapS": wrap(texture.wrap[0]),
            "wrapT": wrap(texture.wrap[1]),
            "magFilter": filter,
            "minFilter": filter,
        });
        let known = self.samplers.iter().position(|known| *known == sampler);
        let sampler = known.unwrap_or_else(|| {
            self.samplers.push(sampler);
            self.samplers.len() - 1
        });
        self.textures.push(json!({ "source": self.images.len() - 1, "sampler": sampler }));
        Ok(self.textures.len() - 1)
    }
}
