//! The accounting of a frame, by the names that `--json` uses.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Budget, CullingReport, ImportanceReport, TableReport};

/// The accounting of a frame from the light.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ShadowReport {
    /// The map's edge in pixels.
    pub size: u32,
    /// World units.
    pub bias: f64,
    /// Fragments of one geometry pass.
    pub generated: u64,
    /// Entries of the map's lists.
    pub kept: u64,
    /// SHA-256 of its resolved lists.
    pub fragments_hash: Option<String>,
}

/// The accounting of a frame: the fields of `render --json`, by those names.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// The method's name in the catalogue.
    pub method: String,
    /// The scene's name.
    pub scene: String,
    /// `tile`, `threads`, `sim`, or `sequential` for the oracle.
    pub exec: String,
    /// Worker threads.
    pub threads: usize,
    /// Fragments kept per pixel; `None` is all.
    pub k: Option<u32>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Triangles in the scene.
    pub triangles: u64,
    /// Triangles of zero area, before or after snapping.
    pub degenerate: u64,
    /// Fragments of one geometry pass.
    pub generated: u64,
    /// List entries beyond the number of times they were generated.
    pub duplicated: u64,
    /// List entries that were never generated.
    pub torn: u64,
    /// List entries.
    pub kept: u64,
    /// Fragments merged into others.
    pub merged: u64,
    /// Fragments rejected before they were stored.
    pub culled: u64,
    /// Fragments stored and pushed out later.
    pub evicted: u64,
    /// Fragments dropped, by reason.
    pub dropped: BTreeMap<String, u64>,
    /// The names of the fields that no schedule can change.
    pub deterministic: Vec<String>,
    /// The largest number of fragments at a pixel.
    pub max_depth_complexity: u32,
    /// Bytes of the method's storage for this image, by its own declaration.
    pub bytes: u64,
    /// The result of a memory budget, if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Budget>,
    /// How records were divided, if the method divides them by importance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub importance: Option<ImportanceReport>,
    /// What the culling passes did, if there were any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub culling: Option<CullingReport>,
    /// The hash table, if the method has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<TableReport>,
    /// Steps after which memory was checked, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checked: Option<u64>,
    /// What was made from the lists: `oit`, `media`, `csg`, `ldi`, `ao`, `dof` or `ao+dof`.
    pub effect: String,
    /// At how many pixels an object's faces do not pair, by its name: odd parity (`csg`; `ldi` of the whole `scene`),
    /// or more front than back faces or fewer (`media`). Objects that are closed are left out.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub open_pixels: BTreeMap<String, u64>,
    /// Voxels that are inside, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid_voxels: Option<u64>,
    /// The frame from the light, if there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadows: Option<ShadowReport>,
    /// Geometry passes of a round.
    pub passes: u32,
    /// Rounds: how often passes and resolve were repeated. A schedule may change it if rounds repair what races lost.
    pub rounds: u32,
    /// SHA-256 of the picture.
    pub image_hash: String,
    /// SHA-256 of the resolved lists; `None` where the method gives none.
    pub fragments_hash: Option<String>,
    /// Pixels whose colour is no number, if the method gives colours; they are drawn black.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nan_pixels: Option<u64>,
    /// Memory operations by kind.
    pub counters: BTreeMap<String, u64>,
    /// Seconds by phase.
    pub seconds: BTreeMap<String, f64>,
    /// What was tolerated.
    pub warnings: Vec<String>,
    /// What the method promised and did not keep.
    pub violations: Vec<String>,
}

impl Report {
    /// What identifies the result: the hash of the resolved lists, or of the picture where the method gives no lists.
    #[must_use]
    pub fn result_hash(&self) -> &str {
        self.fragments_hash.as_deref().unwrap_or(&self.image_hash)
    }
}
