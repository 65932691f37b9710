//! What the file's extensions are about: a file that requires one that changes the geometry is refused unless it is
//! supported; those about looks are named in a warning, and those about neither are left out.

use std::collections::BTreeSet;

use serde_json::Value;

use super::super::model::Unplaced;
use super::super::parts::Tally;
use super::json;

/// Drawn as they should be.
const DRAWN: [&str; 6] = [
    "EXT_mesh_gpu_instancing",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// The beginnings of names of extensions about looks.
const LOOKS: [&str; 15] = [
    "ADOBE_materials_",
    "CESIUM_primitive_outline",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_texture_",
    "FB_materials_",
    "GOOGLE_texture_",
    "KHR_environment_",
    "KHR_lights_",
    "KHR_materials_",
    // Drafts called it KHR_technique_webgl.
    "KHR_technique",
    "KHR_texture_",
    "MSFT_texture_",
    "NV_materials_",
    "VRMC_materials_",
];

/// The beginnings of names of extensions that change nothing about a picture at rest.
const SILENT: [&str; 24] = [
    "AGI_",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "FB_ngon_encoding",
    "GODOT_single_root",
    "GRIFFEL_bim_data",
    "KHR_animation_",
    "KHR_audio",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_",
    "KHR_xmp",
    "MSFT_audio_",
    "MSFT_lod",
    "MSFT_packing_",
    "OMI_",
    "VRM",
    "VRMC_node_constraint",
    "VRMC_vrm",
];

/// Packed meshes, which may have plain ones beside them.
const PACKED: [&str; 3] =
    ["EXT_meshopt_compression", "KHR_draco_mesh_compression", "KHR_meshopt_compression"];

/// Refuses the file, or names what is not drawn.
pub(super) fn check(root: &Value, tally: &mut Tally) -> Unplaced<()> {
    let begins = |name: &str, list: &[&str]| list.iter().any(|prefix| name.starts_with(prefix));
    let names = |key| {
        let names = json::list(root, key);
        names.map(|names| names.iter().filter_map(Value::as_str).collect::<Vec<_>>())
    };
    let required = names("extensionsRequired")?;
    for name in &required {
        if !DRAWN.contains(name) && !begins(name, &LOOKS) && !begins(name, &SILENT) {
            let advice = match PACKED.contains(name) {
                true => "; export the file without mesh compression",
                false => "",
            };
            return Err(format!("extensionsRequired: {name:?} is not supported{advice}"));
        }
    }
    let mut said = BTreeSet::new();
    for name in names("extensionsUsed")?.into_iter().chain(required) {
        let quiet = DRAWN.contains(&name) || begins(name, &SILENT) || PACKED.contains(&name);
        if !quiet {
            said.insert(name);
        }
    }
    let (looks, unknown): (Vec<_>, Vec<_>) =
        said.into_iter().partition(|name| begins(name, &LOOKS));
    for (names, kind) in [(looks, "is not drawn"), (unknown, "is not known, and is left out")] {
        if !names.is_empty() {
            tally.add(kind, || format!("extensionsUsed: {}", names.join(", ")));
        }
    }
    Ok(())
}
