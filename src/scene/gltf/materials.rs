//! Materials: the base colour with its picture, and what the opacity means.

use serde_json::Value;

use super::super::model::Unplaced;
use super::super::parts::Tally;
use super::super::texture::Opacity;
use super::super::{Material, Shading};
use super::json;
use super::textures::{Lying, Pictures};

/// What a material's opacity means, and how its picture lies on a mesh, if it has one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) opacity: Opacity,
    pub(super) lying: Option<Lying>,
}

impl Look {
    /// Opaque, and without a picture.
    pub(super) const PLAIN: Self = Self { opacity: Opacity::Opaque, lying: None };
}

/// A material, with its picture from `pictures`.
pub(super) fn read(
    index: usize,
    value: &Value,
    pictures: &mut Pictures<'_>,
    tally: &mut Tally,
) -> Unplaced<(Material, Look)> {
    let name = json::text(value, "name").map_or_else(|| format!("material {index}"), str::to_owned);
    let wrong = |problem: String| format!("material {name:?}: {problem}");
    let pbr = json::get(value, "pbrMetallicRoughness");
    let older = json::deep(value, &["extensions", "KHR_materials_pbrSpecularGlossiness"]);
    let own = [(pbr, "baseColorFactor"), (older, "diffuseFactor")];
    let mut factor = [1.0; 4];
    for (table, key) in own {
        let found = table.map_or(Ok(None), |table| json::numbers::<4>(table, key));
        if let Some(found) = found.map_err(wrong)? {
            factor =
                found.map(|v| f64::from(tally.clamped(v, || format!("material {name:?}: {key}"))));
        }
    }
    let cutoff = json::number(value, "alphaCutoff").map_err(wrong)?.unwrap_or(0.5) as f32;
    let [r, g, b, alpha] = factor.map(|v| v as f32);
    let opacity = match json::text(value, "alphaMode") {
        None | Some("OPAQUE") => Opacity::Opaque,
        Some("MASK") => Opacity::Mask { alpha, cutoff },
        Some("BLEND") => Opacity::Blend,
        Some(other) => {
            let other: String = other.chars().take(40).collect();
            tally.add("must be OPAQUE, MASK or BLEND, and is taken for OPAQUE", || {
                format!("material {name:?}: alphaMode: {other:?}")
            });
            Opacity::Opaque
        }
    };
    let unlit = json::deep(value, &["extensions", "KHR_materials_unlit"]).is_some();
    let shading = if unlit { Shading::Flat } else { Shading::Lambert };
    let alpha = if opacity == Opacity::Blend { alpha } else { 1.0 };
    let mut found = None;
    for (table, key) in [(pbr, "baseColorTexture"), (older, "diffuseTexture")] {
        if let Some(info) = table.and_then(|table| json::get(table, key)) {
            found = match pictures.texture(info, opacity, &name, tally) {
                Ok(texture) => texture,
                Err(problem) => {
                    tally.add("the texture is left out", || wrong(format!("{key}: {problem}")));
                    None
                }
            };
        }
    }
    let (texture, lying) = found.unzip();
    let material = Material { shading, texture, ..Material::new(name, [r, g, b], alpha) };
    Ok((material, Look { opacity, lying }))
}
