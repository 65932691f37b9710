//! Pictures of drivers: ordinary blending of whole triangles, sorted from back to front, with nothing of this program but
//! the scene.

use std::collections::BTreeMap;

use fragloom::gpu::driver::device::adapters;
use fragloom::image::foreign::Foreign;
use fragloom::image::{Image, png};
use fragloom::judge::{Answer, Class, Settings, Verdict, judge};
use fragloom::scene::{Overrides, Scene, Shading};
use wgpu::TextureFormat;

use super::confusion::{exact, main_class};

const SHADER: &str = "
struct Corner { @builtin(position) place: vec4f, @location(0) color: vec4f }
@vertex fn corner(@location(0) place: vec4f, @location(1) color: vec4f) -> Corner {
    return Corner(place, color);
}
@fragment fn shade(corner: Corner) -> @location(0) vec4f {
    return corner.color;
}
";

/// Nine scenes, and whether sorting whole triangles is right for them.
const SCENES: [(&str, bool); 9] = [
    ("layers:count=6", true),
    ("stairs", true),
    ("shuffled", true),
    ("alpha-steps", true),
    ("concave", true),
    ("perspective-colours", true),
    ("interpenetrating", false),
    ("cycle", false),
    ("cubes", false),
];

fn load(name: &str) -> Scene {
    let path = format!("{}/suite/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let is_file = std::path::Path::new(&path).is_file();
    let size = (!is_file).then_some([64, 48]);
    let overrides = Overrides { size, shading: Some(Shading::Flat), ..Overrides::default() };
    fragloom::scene::load(if is_file { &path } else { name }, &overrides).expect("a scene")
}

/// A corner: its place in clip space, and its colour.
type Corner = [f32; 8];

/// The triangles, the farthest middle first; of equally far ones, those submitted first come first.
fn triangles(scene: &Scene) -> Vec<[Corner; 3]> {
    let mut found: Vec<(f64, [Corner; 3])> = Vec::new();
    let quantised = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5).floor() / 255.0;
    let view_projection = scene.camera.view_projection(scene.size);
    let view = scene.camera.view();
    for object in &scene.objects {
        let (mesh, material) = (&object.mesh, &scene.materials[object.material]);
        for triangle in &mesh.triangles {
            let corner = |vertex: u32| {
                let vertex = vertex as usize;
                let place =
                    object.transform * glam::DVec3::from(mesh.positions[vertex]).extend(1.0);
                let clip = (view_projection * place).as_vec4();
                let tint = mesh.colors.get(vertex).copied().unwrap_or([1.0; 3]);
                let rgb: [f32; 3] = std::array::from_fn(|i| material.color[i] * tint[i]);
                let alpha = material.alpha * mesh.alphas.get(vertex).copied().unwrap_or(1.0);
                let [r, g, b, a] = match mesh.colors.is_empty() && mesh.alphas.is_empty() {
                    true => [rgb[0], rgb[1], rgb[2], alpha].map(quantised),
                    false => [rgb[0], rgb[1], rgb[2], alpha],
                };
                (-(view * place).z, [clip.x, clip.y, clip.z, clip.w, r, g, b, a])
            };
            let corners = triangle.map(corner);
            let middle = corners.iter().map(|(depth, _)| depth).sum::<f64>() / 3.0;
            found.push((middle, corners.map(|(_, corner)| corner)));
        }
    }
    let [width, height] = scene.size.map(f64::from);
    for triangle in &scene.screen {
        let [r, g, b, a] = triangle.color.map(quantised);
        let corner = |[x, y, z]: [f64; 3]| {
            let [x, y] = [x / width * 2.0 - 1.0, 1.0 - y / height * 2.0];
            [x as f32, y as f32, z as f32, 1.0, r, g, b, a]
        };
        let middle = triangle.points.iter().map(|p| p[2]).sum::<f64>() / 3.0;
        found.push((middle, triangle.points.map(corner)));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, corners)| corners).collect()
}

/// A device, and whether it blends 32-bit floating point.
struct Gpu {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    blends32: bool,
}

fn open(adapter: &wgpu::Adapter) -> Option<Gpu> {
    let wanted = adapter.features() & wgpu::Features::FLOAT32_BLENDABLE;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: wanted,
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).ok()?;
    Some(Gpu { name: adapter.get_info().name, device, queue, blends32: !wanted.is_empty() })
}

impl Gpu {
    /// The target's bytes after drawing, row by row.
    fn draw(&self, scene: &Scene, format: TextureFormat) -> Vec<u8> {
        let corners: Vec<Corner> = triangles(scene).into_iter().flatten().collect();
        let bytes: &[u8] = bytemuck::cast_slice(&corners);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        let [width, height] = scene.size;
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let pipeline = self.pipeline(format);
        let each = format.block_copy_size(None).expect("a size");
        let row = (width * each).next_multiple_of(256);
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let [r, g, b] = scene.background.map(f64::from);
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let attachment = wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&pipeline);
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(0..corners.len() as u32, 0..1);
        }
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |result| result.expect("a mapped buffer"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("an answer");
        let mapped = staging.get_mapped_range(..).expect("what was drawn");
        let rows = mapped.chunks(row as usize);
        rows.flat_map(|line| line[..(width * each) as usize].to_vec()).collect()
    }

    fn pipeline(&self, format: TextureFormat) -> wgpu::RenderPipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let attributes = wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4];
        let corners = wgpu::VertexBufferLayout {
            array_stride: 32,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(corners)],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shade"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format,
                    blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::COLOR,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// What a file of the picture would hold.
    fn file(&self, scene: &Scene, format: TextureFormat) -> Vec<u8> {
        let bytes = self.draw(scene, format);
        let [width, height] = scene.size;
        let element = match format {
            TextureFormat::Rgba16Float => "<f2",
            TextureFormat::Rgba32Float => "<f4",
            _ => {
                let (pixels, _) = bytes.as_chunks();
                let pixels = pixels.iter().map(|&[r, g, b, _]| [r, g, b, 255]).collect();
                return png::encode(&Image { width, height, pixels }).expect("a PNG file");
            }
        };
        let text = format!(
            "{{'descr': '{element}', 'fortran_order': False, 'shape': ({height}, {width}, 4), }}\n"
        );
        let head = [b"\x93NUMPY\x01\x00".to_vec(), (text.len() as u16).to_le_bytes().to_vec()];
        [head.concat(), text.into_bytes(), bytes].concat()
    }
}

fn summary(verdict: &Verdict) -> String {
    let counts: Vec<String> = verdict
        .classes
        .iter()
        .filter(|count| count.class != Class::Equal)
        .map(|count| {
            let (name, by) = (count.class.name(), count.max_difference);
            format!("{name} {} (by {by})", count.pixels)
        })
        .collect();
    let as_if = verdict.hypothesis.as_ref().map(|held| format!(", as if {}", held.as_if));
    let counts = if counts.is_empty() { "equal".to_owned() } else { counts.join(", ") };
    format!("{counts}{}", as_if.unwrap_or_default())
}

/// Where sorting whole triangles is right, only rounding is found, or what a target of 8 bits does, or edges; where it is
/// wrong, the order is.
#[test]
fn pictures_of_drivers_are_judged() {
    let demanded = std::env::var("FRAGLOOM_ADAPTERS").map_or(0, |n| n.parse().expect("a number"));
    let gpus: Vec<Gpu> = adapters().iter().filter_map(open).collect();
    assert!(gpus.len() >= demanded, "{} adapters instead of {demanded}", gpus.len());
    if gpus.is_empty() {
        println!("skipped: judging pictures of drivers needs a Vulkan driver");
    }
    let mut problems = Vec::new();
    for gpu in &gpus {
        println!("{}", gpu.name);
        let mut calls: BTreeMap<Class, u32> = BTreeMap::new();
        for (name, is_right) in SCENES {
            let scene = load(name);
            let answer = Answer::new(&scene, &exact()).expect("an answer");
            let floats = [TextureFormat::Rgba16Float, TextureFormat::Rgba32Float];
            let formats = [TextureFormat::Rgba8UnormSrgb, floats[0], floats[1]];
            for format in formats.into_iter().filter(|f| *f != floats[1] || gpu.blends32) {
                let file = gpu.file(&scene, format);
                let picture = Foreign::parse(&file, 16_384).expect("a picture");
                // What opacity a target holds is nobody's business.
                let picture =
                    Foreign { opacity: fragloom::image::foreign::Opacity::Ignored, ..picture };
                let settings = Settings::default();
                let found = judge(&answer, &picture, "theirs", &settings).expect("a verdict");
                println!("| {name} | {format:?} | {} |", summary(&found));
                let class = main_class(&found);
                *calls.entry(class).or_default() += 1;
                let rightly: &[Class] = match (is_right, format) {
                    (true, TextureFormat::Rgba8UnormSrgb) => &[
                        Class::Equal,
                        Class::Rounding,
                        Class::Precision,
                        Class::Faint,
                        Class::Edge,
                    ],
                    // Where colours vary, the exact answer has them in 8 bits of linear light: dark ones are coarse.
                    (true, _) if name == "perspective-colours" => &[Class::Faint],
                    (true, _) => &[Class::Equal, Class::Rounding, Class::Edge],
                    (false, _) => &[Class::Order, Class::Swapped],
                };
                if !rightly.contains(&class) {
                    problems.push(format!("{}: {name} {format:?}: {}", gpu.name, summary(&found)));
                }
            }
        }
        println!("{calls:?}");
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}
