//! The raster path: triangles through the device's own rasterizer, into the same store pass.
//!
//! Corners are on the device's sub-pixel grid, and the viewport contains every triangle that is drawn, so that no
//! driver has anything to clip; a scissor cuts the band out. Triangles that do not fit into the viewport, and polygons
//! whose fan turns back on itself (their coverage is a sum of signs), take the compute path, and are counted.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;

use wgpu::BufferUsages;

use super::band::Band;
use super::code::Code;
use super::program::{Bound, Group, Program, WRITABLE, group};
use super::shape::FRAGMENT;
use super::source::Path;
use crate::fragment::Fragment;
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::spirv::write::Entry;
use crate::raster::clip::{Polygon, Snapped, UNITS, doubled_area};
use crate::raster::{Record, primitive::Rect};
use crate::scheme::contract::Contract;

/// Edge of the viewport, in pixels: a power of two, so that the mapping to clip space and back is exact.
const VIEWPORT: i32 = 8_192;

/// Fragments of one submission, about.
const CHUNK: u64 = 1 << 22;

/// The same where invocations wait for each other: so few that all of them may give up before a watchdog ends the
/// submission, and the device with it.
const WAITING_CHUNK: u64 = 1 << 16;

/// One instance, as `pass/raster.wgsl` has it.
type Instance = [u32; 15];

/// A band's triangles, for the device's rasterizer.
#[derive(Debug)]
pub struct Triangles {
    instances: Vec<Instance>,
    /// Which of them go into one submission.
    chunks: Vec<Range<u32>>,
    /// The most fragments of a submission.
    most: u64,
    /// Fragments of those primitives that take the compute path.
    pub rest: Vec<Fragment>,
}

/// Middle of a band's viewport, in 1/256 pixel of the picture.
fn center(band: &Band<'_>) -> [i32; 2] {
    let window = band.window();
    let middle = |from: u32, to: u32| (from + to) as i32 / 2 * UNITS;
    [middle(window.x0, window.x1), middle(window.y0, window.y1)]
}

fn fits(polygon: &Polygon, center: [i32; 2]) -> bool {
    let half = VIEWPORT / 2 * UNITS;
    let near = |v: &Snapped| (v.x - center[0]).abs() <= half && (v.y - center[1]).abs() <= half;
    polygon.vertices().iter().all(near)
}

/// Whether all triangles of the fan turn the same way, so that no pixel is hit twice.
fn is_simple(polygon: &Polygon) -> bool {
    let turns = |part| doubled_area(part).signum();
    let whole = polygon.doubled_area().signum();
    polygon.fan().all(|part| turns(part) == 0 || turns(part) == whole)
}

impl Triangles {
    /// The triangles of a band, in small submissions if invocations wait for each other, and may wait for ever.
    #[must_use]
    pub fn new(band: &Band<'_>, record: Record, waits: bool) -> Self {
        let chunk = if waits { WAITING_CHUNK } else { CHUNK };
        let front = &band.picture.front;
        let (window, center) = (band.window(), center(band));
        let (mut instances, mut chunks, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        let (mut first, mut pixels, mut most) = (0u32, 0u64, 0u64);
        for index in front.indices() {
            let primitive = front.primitive(index);
            let Some(outline) = front.outline(index) else { continue };
            let area: Rect = primitive.bounds.intersect(window);
            if area.is_empty() {
                continue;
            }
            // A device does not know which pixels a mask leaves out.
            let masked = front.surface(index).is_masked();
            if masked || !fits(outline, center) || !is_simple(outline) {
                rest.push(index);
                continue;
            }
            let [a0, a1, b0, b1, c0, c1, near, far] = primitive.plane.words();
            for part in outline.fan().filter(|&part| doubled_area(part) != 0) {
                let [a, b, c] = part.map(|v| [v.x as u32, v.y as u32]);
                let corners = [a[0], a[1], b[0], b[1], c[0], c[1]];
                let plane = [a0, a1, b0, b1, c0, c1, near, far, primitive.triangle];
                let mut words = [0; 15];
                words[..6].copy_from_slice(&corners);
                words[6..].copy_from_slice(&plane);
                instances.push(words);
            }
            pixels += area.pixels();
            most = most.max(pixels);
            if pixels >= chunk {
                let end = instances.len() as u32;
                chunks.push(first..end);
                (first, pixels) = (end, 0);
            }
        }
        let end = instances.len() as u32;
        if first < end {
            chunks.push(first..end);
        }
        Self { instances, chunks, most, rest: band.stream_of(record, false, rest) }
    }
}

/// What the raster path needs in addition to the program.
#[derive(Debug)]
pub struct Raster<'a, 'd> {
    program: &'a Program<'d>,
    band: &'a Band<'d>,
    triangles: &'a Triangles,
    code: Code,
    /// Instances of one submission each, and how many.
    buffers: Vec<(wgpu::Buffer, u32)>,
    target: wgpu::TextureView,
    /// Invocations that gave up waiting: how many, then as many of their fragments as there is room for.
    given_up: wgpu::Buffer,
    given_up_group: Group,
    /// The compiled pipelines, by function.
    pipelines: RefCell<BTreeMap<String, wgpu::RenderPipeline>>,
}

impl<'a, 'd> Raster<'a, 'd> {
    /// Upload a band's triangles.
    ///
    /// # Errors
    /// The band is too wide for the device, or the device refuses.
    pub fn new(
        program: &'a Program<'d>,
        band: &'a Band<'d>,
        triangles: &'a Triangles,
    ) -> Result<Self> {
        let device = program.device;
        let [x, y] = center(band);
        let constants = program
            .constants
            .clone()
            .with_signed("CENTER_X", x.into())
            .with_signed("CENTER_Y", y.into())
            .with_power("PER_HALF_VIEWPORT", -(VIEWPORT / 2 * UNITS).ilog2().cast_signed())
            .with("BAND_TOP", band.top().into());
        let text = program.twin.module(&constants, Path::Raster)?;
        let code = Code::new(device, program.twin, &text)?;
        let most = (device.largest() / size_of::<Instance>() as u64).max(1);
        let mut buffers = Vec::new();
        for chunk in &triangles.chunks {
            let instances = &triangles.instances[chunk.start as usize..chunk.end as usize];
            for part in instances.chunks(most.min(u32::MAX.into()) as usize) {
                let bytes = bytemuck::cast_slice(part);
                let buffer = device.filled("triangles", bytes, BufferUsages::VERTEX)?;
                buffers.push((buffer, part.len() as u32));
            }
        }
        let target = target(device, band.grid.width, band.grid.height)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let room = if program.twin.waits() { triangles.most.max(1) } else { 1 };
        let given_up = 4 + FRAGMENT * room;
        let given_up = device.buffer("given up", given_up.min(device.largest()), usage)?;
        let bound = Bound {
            binding: 0,
            buffer: &given_up,
            part: None,
            kind: WRITABLE,
            stages: wgpu::ShaderStages::FRAGMENT,
        };
        let given_up_group = group(device, &[bound])?;
        let pipelines = RefCell::default();
        Ok(Self {
            program,
            band,
            triangles,
            code,
            buffers,
            target,
            given_up,
            given_up_group,
            pipelines,
        })
    }

    /// A geometry pass: the triangles, then what takes the compute path.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn draw(&self, function: &str) -> Result<()> {
        let pipeline = self.pipeline(&format!("{function}_raster"))?;
        for (buffer, instances) in &self.buffers {
            let mut encoder = self.program.device.encoder();
            self.record(&mut encoder, &pipeline, buffer, *instances);
            self.program.device.submit(encoder)?;
            if self.program.twin.waits() && function == "store" {
                self.repeat()?;
            }
        }
        self.program.compute(function, &self.triangles.rest)
    }

    /// Rerun the invocations that gave up waiting in a submission.
    fn repeat(&self) -> Result<()> {
        let device = self.program.device;
        let count = device.read(&self.given_up, 4)?;
        let count = u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
        if count == 0 {
            return Ok(());
        }
        let bytes = 4 + FRAGMENT * count;
        if bytes > self.given_up.size() {
            return Err(Failure::Stuck(count));
        }
        let found = device.read(&self.given_up, bytes)?;
        device.queue.write_buffer(&self.given_up, 0, &[0; 4]);
        self.program.repeat(bytemuck::pod_collect_to_vec(&found[4..]))
    }

    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        buffer: &wgpu::Buffer,
        instances: u32,
    ) {
        let attachment = wgpu::RenderPassColorAttachment {
            view: &self.target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Discard,
            },
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..wgpu::RenderPassDescriptor::default()
        });
        let [x, y] = center(self.band);
        let corner = |center: i32| (center / UNITS - VIEWPORT / 2) as f32;
        let top = corner(y) - self.band.top() as f32;
        pass.set_viewport(corner(x), top, VIEWPORT as f32, VIEWPORT as f32, 0.0, 1.0);
        pass.set_scissor_rect(0, 0, self.band.grid.width, self.band.grid.height);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.program.words_group.group, &[]);
        pass.set_bind_group(1, &self.given_up_group.group, &[]);
        pass.set_vertex_buffer(0, buffer.slice(..));
        pass.draw(0..3, 0..instances);
    }

    fn pipeline(&self, entry: &str) -> Result<wgpu::RenderPipeline> {
        if let Some(pipeline) = self.pipelines.borrow().get(entry) {
            return Ok(pipeline.clone());
        }
        let device = self.program.device;
        let groups = [&self.program.words_group, &self.given_up_group];
        let bindings = groups.map(|group| group.bindings.as_slice());
        let module =
            |name| self.code.module(device, &Entry { name, overrides: &[], bindings: &bindings });
        let (vertex, fragment) = (module("raster_corner")?, module(entry)?);
        let layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &groups.map(|group| Some(&group.layout)),
            immediate_size: 0,
        });
        let attributes = wgpu::vertex_attr_array![
            0 => Sint32x2, 1 => Sint32x2, 2 => Sint32x2, 3 => Uint32x4, 4 => Uint32x4, 5 => Uint32
        ];
        let instances = wgpu::VertexBufferLayout {
            array_stride: size_of::<Instance>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &attributes,
        };
        let nothing = wgpu::ColorTargetState {
            format: TARGET,
            blend: None,
            write_mask: wgpu::ColorWrites::empty(),
        };
        let pipeline = device.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &vertex,
                entry_point: Some("raster_corner"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(instances)],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &fragment,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(nothing)],
            }),
            multiview_mask: None,
            cache: None,
        });
        device.check()?;
        self.pipelines.borrow_mut().insert(entry.to_owned(), pipeline.clone());
        Ok(pipeline)
    }
}

/// A format that every device can draw to; nothing is drawn.
const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Something to draw to: without it there is no render pass.
fn target(device: &Device, width: u32, height: u32) -> Result<wgpu::TextureView> {
    let most = device.limits.max_texture_dimension_2d;
    if width > most || height > most {
        let problem = format!("draws at most {most} pixels across, not {width}x{height}");
        return Err(Failure::Unsupported(problem));
    }
    let texture = device.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TARGET,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    device.check()?;
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// Whether a device's rasterizer knows all of a fragment that a method asks for.
///
/// # Errors
/// It does not.
pub fn knows_fragments_of(contract: &Contract) -> Result<()> {
    if contract.has_slabs() {
        let problem = "only on the compute path: its fragments are slabs, whose near ends the device does not compute";
        return Err(Failure::Unsupported(problem.to_owned()));
    }
    if contract.keeps.is_approximate() {
        let problem =
            "only on the compute path: its fragments have colours, which the device does not shade";
        return Err(Failure::Unsupported(problem.to_owned()));
    }
    Ok(())
}

/// Sub-pixel bits of a device, measured: left edges at 1/2 + 3/4 of a step beyond a pixel's centre leave the pixel out
/// as long as the device has such a step.
///
/// # Errors
/// Any error of the device.
pub fn sub_pixel_bits(device: &Device) -> Result<u32> {
    const MOST: u32 = 12;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let hits = device.buffer("hits", 4 * u64::from(MOST), usage)?;
    let bound = Bound {
        binding: 0,
        buffer: &hits,
        part: None,
        kind: WRITABLE,
        stages: wgpu::ShaderStages::FRAGMENT,
    };
    let group = group(device, &[bound])?;
    let module = device.module("probe", include_str!("../wgsl/probe.wgsl"))?;
    let layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("probe"),
        bind_group_layouts: &[Some(&group.layout)],
        immediate_size: 0,
    });
    let nothing = wgpu::ColorTargetState {
        format: TARGET,
        blend: None,
        write_mask: wgpu::ColorWrites::empty(),
    };
    let pipeline = device.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("probe"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("probe_corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("probe_pixel"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(nothing)],
        }),
        multiview_mask: None,
        cache: None,
    });
    let view = target(device, 2, MOST)?;
    let mut encoder = device.encoder();
    {
        let attachment = wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Discard,
            },
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_viewport(0.0, 0.0, 16.0, 16.0, 0.0, 1.0);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group.group, &[]);
        pass.draw(0..3, 0..MOST);
    }
    device.submit(encoder)?;
    let words = device.read(&hits, 4 * u64::from(MOST))?;
    let words: &[u32] = bytemuck::cast_slice(&words);
    Ok(words.iter().take_while(|&&hit| hit == 0).count() as u32)
}
