//! One frame from beginning to end: a scene and options in; an image, the kept fragments and a report out.

use std::collections::BTreeMap;

use crate::error::Result;
use crate::image::Image;
use crate::num::depth;
use crate::scene::Scene;

/// What to draw with, and how. The defaults are the command line's.
#[derive(Clone, Debug)]
pub struct Options {
    /// A method's name in the catalogue (`scheme::catalogue`), with `@variant` if any.
    pub method: String,
    /// Fragments kept per pixel; `None` is the method's own default (8 for k-buffers, all for `exact` and A-buffers).
    pub k: Option<u32>,
    /// Who runs the invocations.
    pub exec: Exec,
    /// Worker threads; 0 means one per core.
    pub threads: usize,
    /// Tile edge in pixels: 16, 32 or 64.
    pub tile: u32,
    /// Sub-pixel bits that vertices are snapped to: 8 or 4.
    pub sub_pixel_bits: u32,
    /// What is stored for a depth; `None` is the method's own.
    pub depth_format: Option<depth::Format>,
    /// What is stored beside a depth.
    pub data: Data,
    /// Which faces are not drawn.
    pub cull_face: CullFace,
    /// Count memory operations (costs a few per cent).
    pub counters: bool,
    /// Bytes of scheme memory and kept fragments above which a run is refused before anything is allocated.
    pub max_memory: u64,
}

/// Who runs the invocations of a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Exec {
    /// Tiles in parallel; each owns its pixels' memory.
    Tile,
    /// Rasterizer threads feed worker threads that contend on shared atomics.
    Threads,
    /// One thread steps resident invocations, one memory operation at a time.
    Sim(Sim),
}

/// How the simulated device schedules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sim {
    /// Who goes next.
    pub policy: Policy,
    /// Seed of `Policy::Random`.
    pub seed: u64,
    /// Invocations in flight, at least 1.
    pub resident: usize,
    /// Record the schedule and return it.
    pub record: bool,
}

/// Who goes next on the simulated device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Policy {
    /// The oldest invocation runs to its end: submission order.
    Order,
    /// The youngest resident invocation goes first.
    Reverse,
    /// Each in turn, one operation each.
    RoundRobin,
    /// A uniformly random resident invocation.
    Random,
    /// Warps of N consecutive invocations in lockstep, in turn.
    Warp(u32),
    /// A schedule recorded before, as `Rendering::schedule` returned it.
    Recorded(Vec<u8>),
}

/// The 32-bit word stored with a depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Data {
    /// Linear RGBA8.
    #[default]
    Color,
    /// The global triangle index; the colour is looked up at resolve.
    Primitive,
}

/// Which faces are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum CullFace {
    /// Draw both.
    #[default]
    None,
    /// Leave out counter-clockwise (front) faces.
    Front,
    /// Leave out clockwise (back) faces.
    Back,
}

/// The kept fragments of every pixel, front to back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lists {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row-major; pixel p's fragments are `keys[offsets[p]..offsets[p + 1]]`.
    pub offsets: Vec<u64>,
    /// Depth in the upper half, data word in the lower.
    pub keys: Vec<u64>,
}

/// Everything one frame gives.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The composited picture.
    pub image: Image,
    /// The kept fragments after resolve.
    pub lists: Lists,
    /// Accounting, counters, hashes, times.
    pub report: Report,
    /// The recorded schedule, if asked for.
    pub schedule: Option<Vec<u8>>,
}

/// The accounting of a frame: the fields of `render --json`, by those names.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Report {
    pub method: String,
    pub scene: String,
    pub exec: String,
    pub threads: usize,
    pub k: Option<u32>,
    pub width: u32,
    pub height: u32,
    pub triangles: u64,
    pub degenerate: u64,
    pub generated: u64,
    pub duplicated: u64,
    pub torn: u64,
    pub kept: u64,
    pub merged: u64,
    pub culled: u64,
    pub evicted: u64,
    pub dropped: BTreeMap<String, u64>,
    pub deterministic: Vec<String>,
    pub max_depth_complexity: u32,
    pub bytes: u64,
    pub passes: u32,
    pub image_hash: String,
    pub fragments_hash: String,
    pub counters: BTreeMap<String, u64>,
    pub seconds: BTreeMap<String, f64>,
    pub warnings: Vec<String>,
}

/// Draw `scene`.
///
/// # Errors
/// An unknown method, an option out of range, or more memory than `options.max_memory`.
pub fn render(scene: &Scene, options: &Options) -> Result<Rendering> {
    let _ = (scene, options);
    Err(crate::error::Error::new("render", "not here yet"))
}
