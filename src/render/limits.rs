//! Memory limits, checked before memory is allocated.

use super::options::{Exec, Options, Wanted};
use crate::effect::Effect;
use crate::error::{Error, Result};
use crate::exec::Job;
use crate::memory::Layout;
use crate::raster::Grid;
use crate::resolve::Kept;
use crate::scheme::bound::Bound;
use crate::scheme::merging::slab::Slab;
use crate::scheme::{Depth, HeldKind, Light, Record};

/// What executors keep per pixel in addition to the method's own storage, in bytes: colours, counts and offsets.
const HOST_BYTES: u64 = 32;

/// A pixel's bytes in 16 bits of linear light.
const LINEAR_BYTES: u64 = 8;

/// The bytes of a kept fragment, or of a record of one: by tile, and then row by row if lists are wanted.
fn kept_bytes(wanted: Wanted, holds: HeldKind) -> u64 {
    let [by_tile, joined] = match holds {
        HeldKind::Fragments => [size_of::<u64>(); 2],
        HeldKind::Records => [size_of::<u64>() + size_of::<u32>(), size_of::<Record>()],
        HeldKind::Color | HeldKind::Depth => [0; 2],
    };
    (match wanted {
        Wanted::Lists => by_tile + joined,
        Wanted::Hash => by_tile,
        Wanted::Picture => 0,
    }) as u64
}

/// The bytes of a pixel's one value, by tile and row by row, where pixels hold no lists.
fn value_bytes(holds: HeldKind) -> u64 {
    (match holds {
        HeldKind::Fragments | HeldKind::Records => 0,
        HeldKind::Color => 2 * size_of::<Light>(),
        HeldKind::Depth => 2 * size_of::<Depth>(),
    }) as u64
}

/// Refuse storage that would not fit.
pub(super) fn storage(options: &Options, job: &Job<'_>, layout: &Layout) -> Result<()> {
    let grid = &job.front.grid;
    if grid.storage_pixels() > job.contract.max_pixels as usize {
        let (name, most) = (job.contract.name, job.contract.max_pixels);
        let found = grid.storage_pixels();
        let problem = format!(
            "the image has {found} pixels in whole tiles, but {name} can address at most {most}"
        );
        return Err(Error::new("--size", problem));
    }
    let pixels = match options.exec {
        Exec::Tile if job.contract.program.is_local() => job.threads * grid.pixels_per_tile(),
        // If pixels wait for each other, every tile keeps its memory from pass to pass.
        _ => grid.storage_pixels(),
    };
    let linear = if options.needs_light() { LINEAR_BYTES } else { 0 };
    let each = HOST_BYTES + linear + value_bytes(job.holds);
    let own = each * grid.storage_pixels() as u64;
    let bytes = layout.bytes(pixels as u64).saturating_add(own);
    refuse_above(options, bytes, &format!("storage on '{}'", options.exec.name()))
}

/// Refuse lists that would not fit: at most k fragments per pixel, and no more than are generated. Fragments are
/// counted only if the primitives' bounding boxes do not already show that there is room.
pub(super) fn kept(options: &Options, job: &Job<'_>, wanted: Wanted) -> Result<()> {
    let each = kept_bytes(wanted, job.holds);
    let grid = &job.front.grid;
    let pixels = u64::from(grid.width) * u64::from(grid.height);
    let by_k = match job.nearest {
        Bound::Same(k) => pixels.saturating_mul(u64::from(k)),
        Bound::All | Bound::PerPixel(_) => u64::MAX,
    };
    let boxes = job.front.primitives().map(|p| p.bounds.pixels());
    let fits = |fragments: u64| fragments.saturating_mul(each) <= options.max_memory;
    if fits(by_k.min(boxes.sum())) {
        return Ok(());
    }
    let generated: u64 = job.front.count_fragments().iter().sum();
    let bytes = by_k.min(generated).saturating_mul(each);
    refuse_above(options, bytes, "kept fragments")
}

/// Refuse layers in screen space that would not fit: a record, its slab and its ends for each entry.
pub(super) fn layers(options: &Options, kept: &Kept) -> Result<()> {
    let Effect::Screen(_) = options.effect else { return Ok(()) };
    let entries = match kept {
        Kept::Fragments(lists) => lists.entries.len(),
        Kept::Records(lists) => lists.entries.len(),
        Kept::Color(_) | Kept::Depths(_) | Kept::Gone(_) => 0,
    };
    let each = 2 * size_of::<Record>() + size_of::<Slab>() + size_of::<[f64; 2]>();
    refuse_above(options, (entries * each) as u64, "layers in screen space")
}

/// Refuse a grid of voxels that would not fit: a byte each.
pub(super) fn voxels(options: &Options, grid: &Grid) -> Result<()> {
    let Effect::Ldi { voxels: Some(slices) } = options.effect else { return Ok(()) };
    let bytes = u64::from(grid.width) * u64::from(grid.height) * u64::from(slices);
    refuse_above(options, bytes, "voxels")
}

fn refuse_above(options: &Options, bytes: u64, what: &str) -> Result<()> {
    let (method, limit) = (&options.method, options.max_memory);
    if bytes <= limit {
        return Ok(());
    }
    let problem = format!("{method} needs {bytes} bytes for {what}, above the limit of {limit}");
    Err(Error::new("--max-memory", problem))
}
