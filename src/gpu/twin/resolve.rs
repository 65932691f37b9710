//! Resolve on the device: gather, sort, composite; and the results.

use wgpu::{BufferUsages, ShaderStages};

use super::program::{Bound, Dispatch, Group, Program, READABLE, WRITABLE, group};
use crate::gpu::driver::failure::Result;

/// A device's results: as many records of every pixel as were expected, and how many there were.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Downloaded {
    /// Records that the device has of each pixel.
    pub counts: Vec<u32>,
    /// The records, in places of the same size as those expected.
    pub keys: Vec<u64>,
    /// Colours, sRGB RGBA8.
    pub colors: Vec<u32>,
    /// Where each pixel's places begin, and how many it has.
    pub rooms: Vec<(u32, u32)>,
}

impl Downloaded {
    /// A pixel's records, as many as it has places for.
    #[must_use]
    pub fn pixel(&self, pixel: usize) -> &[u64] {
        let (start, room) = self.rooms[pixel];
        let count = self.counts[pixel].min(room);
        &self.keys[start as usize..(start + count) as usize]
    }
}

/// A resolve pass with room for its results.
#[derive(Debug)]
pub struct Resolve<'a, 'd> {
    program: &'a Program<'d>,
    rays: wgpu::Buffer,
    lists: wgpu::Buffer,
    group: Group,
    pass: Dispatch,
    /// Where each pixel's places begin, and how many it has.
    rooms: Vec<(u32, u32)>,
    /// The bytes of all lists.
    bytes: u64,
}

impl<'a, 'd> Resolve<'a, 'd> {
    /// Make room. `starts`: where each pixel's places begin, and the end; `palette` as `shared/composite.wgsl` has it.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn new(program: &'a Program<'d>, palette: &[u32], starts: &[u32]) -> Result<Self> {
        let device = program.device;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
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
        let bound =
            [seen(1, &rays, WRITABLE), seen(2, &lists, WRITABLE), seen(3, &palette, READABLE)];
        let group = group(device, &bound)?;
        let pass = program.pass("resolve_pass", Some(&group), &[])?;
        Ok(Self { program, rays, lists, group, pass, rooms, bytes })
    }

    /// Run it.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn run(&self) -> Result<()> {
        let mut encoder = self.program.device.encoder();
        let pixels = self.program.shape.config.pixels.into();
        self.program.dispatch(&mut encoder, &self.pass, Some(&self.group.group), pixels);
        self.program.device.submit(encoder)
    }

    /// Fetch the results.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn fetch(self) -> Result<Downloaded> {
        let device = self.program.device;
        let pixels = u64::from(self.program.shape.config.pixels);
        let rays = device.read(&self.rays, 16 * pixels)?;
        let rays: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&rays);
        let keys = device.read(&self.lists, self.bytes)?;
        Ok(Downloaded {
            counts: rays.iter().map(|ray| ray[2]).collect(),
            keys: bytemuck::pod_collect_to_vec(&keys),
            colors: rays.iter().map(|ray| ray[3]).collect(),
            rooms: self.rooms,
        })
    }
}

/// Resolve, sort and composite on the device, and fetch the results.
///
/// # Errors
/// Any error of the device.
pub fn resolve(program: &Program<'_>, palette: &[u32], starts: &[u32]) -> Result<Downloaded> {
    let resolve = Resolve::new(program, palette, starts)?;
    resolve.run()?;
    resolve.fetch()
}
