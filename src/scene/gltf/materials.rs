//! Materials: the base colour, and what its opacity means.

use serde_json::Value;

use super::super::model::Unplaced;
use super::super::parts::Tally;
use super::super::{Material, Shading};
use super::json;

/// What a material's opacity means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    /// Nothing.
    Opaque,
    /// What is at least as opaque as this is opaque, the rest is not there. The material's own opacity is kept beside.
    Mask {
        /// The material's opacity.
        alpha: f32,
        /// The least that is drawn.
        cutoff: f32,
    },
    /// What it says.
    Blend,
}

/// A material and what its opacity means.
pub(super) fn read(index: usize, value: &Value, tally: &mut Tally) -> Unplaced<(Material, Mode)> {
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
    for (table, key) in [(pbr, "baseColorTexture"), (older, "diffuseTexture")] {
        if table.is_some_and(|table| json::get(table, key).is_some()) {
            tally.add("textures are not drawn, neither their colour nor their opacity", || {
                format!("material {name:?}: {key}")
            });
        }
    }
    let cutoff = json::number(value, "alphaCutoff").map_err(wrong)?.unwrap_or(0.5) as f32;
    let [r, g, b, alpha] = factor.map(|v| v as f32);
    let mode = match json::text(value, "alphaMode") {
        None | Some("OPAQUE") => Mode::Opaque,
        Some("MASK") => Mode::Mask { alpha, cutoff },
        Some("BLEND") => Mode::Blend,
        Some(other) => {
            let other: String = other.chars().take(40).collect();
            tally.add("must be OPAQUE, MASK or BLEND, and is taken for OPAQUE", || {
                format!("material {name:?}: alphaMode: {other:?}")
            });
            Mode::Opaque
        }
    };
    let unlit = json::deep(value, &["extensions", "KHR_materials_unlit"]).is_some();
    let shading = if unlit { Shading::Flat } else { Shading::Lambert };
    let alpha = if mode == Mode::Blend { alpha } else { 1.0 };
    Ok((Material { shading, ..Material::new(name, [r, g, b], alpha) }, mode))
}
