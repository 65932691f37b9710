//! Command-line flags exactly as given: nothing is checked or completed here except the syntax of numbers.

use clap::{Args, ValueEnum};

use super::{approximation, importance, scene};

/// Options of every command that draws.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct Drawing {
    /// Fragments kept per pixel, at least 1 [default: the method's own; 8 for k-buffers, all for exact and A-buffers]
    #[arg(short, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) k: Option<u32>,

    /// Image size in pixels, each edge 1 to 16384 [default: the scene's, else 1024x1024]
    #[arg(long, value_name = "WxH")]
    pub(in crate::cli) size: Option<String>,

    /// Opacity of every material, 0 to 1 [default: the scene's, else 0.5]
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub(in crate::cli) alpha: Option<f32>,

    /// Shading of every material [default: the scene's, else lambert]
    #[arg(long, value_enum, value_name = "SHADING")]
    pub(in crate::cli) shading: Option<Shading>,

    #[command(flatten)]
    pub(in crate::cli) scene: scene::Typed,

    /// Radius of every point of point sets, in units of their file [default: the points' own, else estimated]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub(in crate::cli) point_radius: Option<f32>,

    /// Multiplies the radii that points have or get by estimation [default: 1]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(in crate::cli) point_scale: Option<f32>,

    /// How invocations are executed: parallel tiles, contending threads, or a simulated device
    #[arg(long, value_enum, value_name = "EXECUTOR", default_value = "tile")]
    pub(in crate::cli) exec: Exec,

    /// Worker threads; 0 is one per core
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub(in crate::cli) threads: usize,

    /// Seed of `--schedule random` and `pct:D`, 64 bits [default: 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) seed: Option<u64>,

    /// With `--exec sim`, which invocation goes next: order, reverse, round-robin, random, pct:D (D - 1 random changes
    /// of priority), warp:N (lanes) or recorded:FILE (written by `render --record`) [default: random]
    #[arg(long, value_name = "POLICY")]
    pub(in crate::cli) schedule: Option<String>,

    /// With `--exec sim`, invocations in flight, at least 1 [default: 4096]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(in crate::cli) resident: Option<usize>,

    /// Sub-pixel bits that vertices are snapped to, 8 or 4
    #[arg(long, value_name = "BITS", default_value_t = 8, allow_negative_numbers = true)]
    pub(in crate::cli) sub_pixel_bits: u32,

    /// Tile edge in pixels, 16, 32 or 64
    #[arg(long, value_name = "PIXELS", default_value_t = 64, allow_negative_numbers = true)]
    pub(in crate::cli) tile: u32,

    /// What is stored for a depth [default: the method's own; d32 unless its paper fixes another]
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(in crate::cli) depth_format: Option<DepthFormat>,

    /// The 32-bit word stored with a depth: RGBA8, the global triangle index, or none, 0 [default: color; primitive if
    /// the effect must know a fragment's object; the method's own if it has room for no other]
    #[arg(long, value_enum, value_name = "WORD")]
    pub(in crate::cli) data: Option<Data>,

    /// Which faces are left out; front is counter-clockwise
    #[arg(long, value_enum, value_name = "FACES", default_value = "none")]
    pub(in crate::cli) cull_face: CullFace,

    /// Let the method's storage take at most this many bytes (K, M, G and T as below): the largest k that fits, from
    /// the depth-complexity histogram; or the largest pool, if storage does not depend on k [default: no budget]
    #[arg(long, value_name = "BYTES", allow_negative_numbers = true)]
    pub(in crate::cli) memory_budget: Option<String>,

    /// Cull fragments before a method that keeps the nearest ones sees them: occupancy:D, by a mask of D words of 32
    /// depth intervals a pixel, D from 1 to 256; two more geometry passes. occupancy is D = 32 [default: no culling]
    #[arg(long, value_name = "occupancy[:D]")]
    pub(in crate::cli) cull: Option<String>,

    #[command(flatten)]
    pub(in crate::cli) importance: importance::Typed,

    /// For methods that merge, how thick surfaces are that do not say so themselves: Nx, times the depth precision P(z),
    /// or world units [default: 2x]
    #[arg(long, value_name = "Nx|UNITS", allow_hyphen_values = true)]
    pub(in crate::cli) thickness: Option<String>,

    /// For dfb+sfm, how slabs are cut: from 0, strictly optical, to 1, smooth
    #[arg(long, value_name = "B", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(in crate::cli) beta: f64,

    #[command(flatten)]
    pub(in crate::cli) approximation: approximation::Typed,

    /// Size of a hash table: the share of its cells to be filled by fragments, 1 to 100 per cent. It is never smaller
    /// than the image on either axis [default: 50]
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    pub(in crate::cli) load: Option<u32>,

    /// Size of a hash table in cells, instead; at least the image's size on each axis [default: from --load]
    #[arg(long, value_name = "WxH")]
    pub(in crate::cli) table: Option<String>,

    /// Which cells a hash table's ages lead to: independent random offsets, or each the farthest from all before
    #[arg(long, value_enum, value_name = "OFFSETS", default_value = "random")]
    pub(in crate::cli) offsets: Offsets,

    /// Seed of the offsets, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub(in crate::cli) offset_seed: u64,

    /// Largest age of a record in a hash table, 1 to 255
    #[arg(long, value_name = "N", default_value_t = 255, allow_negative_numbers = true)]
    pub(in crate::cli) age_limit: u32,

    /// Early culling: opacity above which nothing behind is stored, 0 to 1
    #[arg(long, value_name = "OPACITY", default_value_t = 0.99, allow_negative_numbers = true)]
    pub(in crate::cli) cull_threshold: f64,

    /// With `--exec sim`, check memory after every step of the store pass: words that may only grow, and the method's
    /// invariants
    #[arg(long)]
    pub(in crate::cli) check_steps: bool,

    /// How a pixel's fragments are sorted; published is insertion sort up to 16 and shell sort above
    #[arg(long, value_enum, value_name = "SORT", default_value = "fastest")]
    pub(in crate::cli) sort: Sort,

    /// Refuse a run that needs more memory, in bytes; K, M, G and T are powers of 1024
    #[arg(long, value_name = "BYTES", default_value = "8G", allow_negative_numbers = true)]
    pub(in crate::cli) max_memory: String,
}

/// Options of every command that prints.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct Output {
    /// Print one JSON document instead of the table
    #[arg(long)]
    pub(in crate::cli) json: bool,

    /// Show no progress
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,
}

/// `--exec`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Exec {
    Tile,
    Threads,
    Sim,
}

/// `--shading`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Shading {
    Flat,
    Lambert,
    Gooch,
}

/// `--depth-format`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum DepthFormat {
    D32,
    D24,
    F32,
}

/// `--data`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Data {
    Color,
    Primitive,
    None,
}

/// `--offsets`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Offsets {
    Random,
    FarthestPoint,
}

/// `--sort`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Sort {
    Fastest,
    Published,
}

/// `--cull-face`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum CullFace {
    None,
    Front,
    Back,
}
