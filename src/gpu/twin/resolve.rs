//! Resolve on the device: gather, sort, composite; and the results. In a program that repeats, each round adds to them.

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
    /// The pass; or, where rounds are repeated, that of the first and that of all others.
    passes: Vec<Dispatch>,
    /// Where rounds are repeated: a word that is not 0 if a pixel needs another one.
    more: Option<wgpu::Buffer>,
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
        let repeats = program.twin.defines("again");
        let more = repeats.then(|| device.filled("more", &[0; 4], usage | BufferUsages::COPY_DST));
        let more = more.transpose()?;
        let mut bound =
            vec![seen(1, &rays, WRITABLE), seen(2, &lists, WRITABLE), seen(3, &palette, READABLE)];
        bound.extend(more.as_ref().map(|more| seen(4, more, WRITABLE)));
        let group = group(device, &bound)?;
        let round = |number| program.pass("round_pass", Some(&group), &[("ROUND", number)]);
        let passes = if repeats {
            vec![round(0.0)?, round(1.0)?]
        } else {
            vec![program.pass("resolve_pass", Some(&group), &[])?]
        };
        Ok(Self { program, rays, lists, group, passes, more, rooms, bytes })
    }

    /// Run it, for a single round.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn run(&self) -> Result<()> {
        self.round(0).map(drop)
    }

    /// Run it in a round, with so many before, and say whether a pixel needs another one.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn round(&self, before: u32) -> Result<bool> {
        let device = self.program.device;
        let mut encoder = device.encoder();
        self.encode(&mut encoder, before);
        device.submit(encoder)?;
        let Some(more) = &self.more else { return Ok(false) };
        let again = device.read(more, 4)?.iter().any(|&byte| byte != 0);
        device.queue.write_buffer(more, 0, &[0; 4]);
        Ok(again)
    }

    pub(in crate::gpu) fn encode(&self, encoder: &mut wgpu::CommandEncoder, before: u32) {
        let pixels = self.program.shape.config.pixels.into();
        let pass = self.passes.get(before as usize).or(self.passes.last());
        if let Some(pass) = pass {
            self.program.dispatch(encoder, pass, Some(&self.group.group), pixels);
        }
    }

    /// Run a whole frame: the method's course with all its rounds. `geometry` runs the passes over fragments, by the
    /// function of the twin.
    ///
    /// # Errors
    /// Any error of the device; or rounds without end.
    pub fn frame(&self, geometry: impl FnMut(&str) -> Result<()>) -> Result<u32> {
        self.program.frame(geometry, |before| self.round(before))
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

/// Run a whole frame, and fetch the results.
///
/// # Errors
/// Any error of the device; or rounds without end.
pub fn draw(
    program: &Program<'_>,
    palette: &[u32],
    starts: &[u32],
    geometry: impl FnMut(&str) -> Result<()>,
) -> Result<Downloaded> {
    let resolve = Resolve::new(program, palette, starts)?;
    resolve.frame(geometry)?;
    resolve.fetch()
}

/// Resolve, sort and composite on the device, and fetch the results, after a single round.
///
/// # Errors
/// Any error of the device.
pub fn resolve(program: &Program<'_>, palette: &[u32], starts: &[u32]) -> Result<Downloaded> {
    let resolve = Resolve::new(program, palette, starts)?;
    resolve.run()?;
    resolve.fetch()
}
