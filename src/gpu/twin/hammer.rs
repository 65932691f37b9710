//! Invocations beside those of a pass, which do nothing but load the memory system.

use wgpu::{BufferUsages, ShaderStages};

use super::program::{Bound, Group, WRITABLE, group};
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::Result;

/// Bytes that are hammered: more than a first-level cache has.
const SCRATCH: u64 = 1 << 20;

/// A dispatch of these invocations.
#[derive(Debug)]
pub struct Hammer {
    workgroups: u32,
    group: Group,
    pipeline: wgpu::ComputePipeline,
}

impl Hammer {
    /// One with so many workgroups.
    ///
    /// # Errors
    /// Any error of the device.
    pub fn new(device: &Device, workgroups: u32) -> Result<Self> {
        let scratch = device.buffer("scratch", SCRATCH, BufferUsages::STORAGE)?;
        let (binding, part, kind, stages) = (0, None, WRITABLE, ShaderStages::COMPUTE);
        let group = group(device, &[Bound { binding, buffer: &scratch, part, kind, stages }])?;
        let module = device.module("hammer", include_str!("../wgsl/pass/hammer.wgsl"))?;
        let device = (device, &device.device);
        let layout = device.1.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("hammer"),
            bind_group_layouts: &[Some(&group.layout)],
            immediate_size: 0,
        });
        let pipeline = device.1.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("hammer"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("hammer"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        device.0.check()?;
        Ok(Self { workgroups, group, pipeline })
    }

    /// Put them before what comes next. They share no buffer with it, so nothing waits for them.
    pub(super) fn dispatch(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut compute = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        compute.set_pipeline(&self.pipeline);
        compute.set_bind_group(0, &self.group.group, &[]);
        compute.dispatch_workgroups(self.workgroups, 1, 1);
    }
}
