//! Resolve on the device: gather, sort, composite; and what came back.

use wgpu::{BufferUsages, ShaderStages};

use super::compare::Downloaded;
use super::failure::Result;
use super::program::{Bound, Program, READABLE, WRITABLE, group};

/// Resolve, sort and composite on the device, and fetch what came of it. `starts`: where each pixel's places begin, and
/// the end; `palette` as `shared/composite.wgsl` has it.
///
/// # Errors
/// Whatever the device says.
pub fn resolve(program: &Program<'_>, palette: &[u32], starts: &[u32]) -> Result<Downloaded> {
    let device = program.device;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let pixels = program.shape.config.pixels as usize;
    let rooms: Vec<(u32, u32)> =
        starts.windows(2).map(|ends| (ends[0], ends[1] - ends[0])).collect();
    let bytes = 8 * starts.last().copied().map_or(0, u64::from);
    let rays: Vec<[u32; 4]> = rooms.iter().map(|&(start, room)| [start, room, 0, 0]).collect();
    let rays = device.filled("rays", bytemuck::cast_slice(&rays), usage)?;
    let lists = device.buffer("lists", bytes, usage)?;
    let palette = device.filled("palette", bytemuck::cast_slice(palette), usage)?;
    let seen = |binding, buffer, kind| Bound {
        binding,
        buffer,
        part: None,
        kind,
        stages: ShaderStages::COMPUTE,
    };
    let bound = [seen(1, &rays, WRITABLE), seen(2, &lists, WRITABLE), seen(3, &palette, READABLE)];
    let group = group(device, &bound)?;
    let pass = program.pass("resolve_pass", Some(&group.layout), &[])?;
    let mut encoder = device.encoder();
    program.dispatch(&mut encoder, &pass, Some(&group.group), pixels as u64);
    device.submit(encoder)?;
    let rays = device.read(&rays, 16 * pixels as u64)?;
    let rays: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&rays);
    let keys = device.read(&lists, bytes)?;
    Ok(Downloaded {
        counts: rays.iter().map(|ray| ray[2]).collect(),
        keys: bytemuck::pod_collect_to_vec(&keys),
        colors: rays.iter().map(|ray| ray[3]).collect(),
        rooms,
    })
}
