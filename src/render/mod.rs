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
    /// The method's name in the catalogue, with `@variant` if any.
    pub method: String,
    /// The scene's name.
    pub scene: String,
    /// Who ran the invocations, with the policy and seed of a simulated device.
    pub exec: String,
    /// Worker threads used, at least 1.
    pub threads: usize,
    /// Fragments kept per pixel; `None` where the method keeps all.
    pub k: Option<u32>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Triangles of the scene, before clipping and culling.
    pub triangles: u64,
    /// Triangles of zero area, before or after snapping; they generate nothing.
    pub degenerate: u64,
    /// Fragments that one geometry pass generates.
    pub generated: u64,
    /// Fragments that a race stored more than once, counted beyond the first.
    pub duplicated: u64,
    /// Fragments in the lists that were never generated: halves of different ones, put together by a race.
    pub torn: u64,
    /// Fragments in the resolved lists.
    pub kept: u64,
    /// Fragments that went into another one.
    pub merged: u64,
    /// Fragments rejected before they were stored.
    pub culled: u64,
    /// Fragments stored and pushed out again by nearer ones.
    pub evicted: u64,
    /// Fragments that should have been kept and were not: reason to count. `lost`: by a race.
    pub dropped: BTreeMap<String, u64>,
    /// The names of the fields that no schedule can change.
    pub deterministic: Vec<String>,
    /// The most fragments generated at one pixel.
    pub max_depth_complexity: u32,
    /// Bytes of the method's memory.
    pub bytes: u64,
    /// Geometry passes.
    pub passes: u32,
    /// [`Image::hash`] of the picture.
    pub image_hash: String,
    /// [`fragments_hash`](crate::resolve::hash::fragments_hash) of the resolved lists.
    pub fragments_hash: String,
    /// Memory operations by kind; empty unless asked for.
    pub counters: BTreeMap<String, u64>,
    /// Wall time by pass, in seconds: the only field that differs from run to run of one schedule.
    pub seconds: BTreeMap<String, f64>,
    /// What was tolerated, one sentence each.
    pub warnings: Vec<String>,
    /// What must not happen and did, one sentence each: accounts that do not balance, say.
    pub violations: Vec<String>,
}

/// Draw `scene`.
///
/// # Errors
/// An unknown method, an option out of range, or more memory than `options.max_memory`.
pub fn render(scene: &Scene, options: &Options) -> Result<Rendering> {
    let _ = (scene, options);
    Err(crate::error::Error::new("render", "not here yet"))
}
