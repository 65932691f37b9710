//! SPIR-V that goes to a driver as it is. wgpu calls that unsafe, so it is in a file of its own.

use wgpu::{Backend, Features, PassthroughShaderEntryPoint, ShaderModuleDescriptorPassthrough};

use super::device::Device;
use super::failure::Result;

/// Whether an adapter takes SPIR-V. Others take other languages without wgpu's checks.
pub(super) fn takes_spirv(adapter: &wgpu::Adapter) -> bool {
    adapter.features().contains(Features::PASSTHROUGH_SHADERS)
        && adapter.get_info().backend == Backend::Vulkan
}

impl Device {
    /// A shader module of SPIR-V with one entry point. It is not validated: it must come from [`crate::gpu::spirv`].
    ///
    /// # Errors
    /// The device refuses it, or is one that takes none: see [`Device::spirv`].
    pub(in crate::gpu) fn spirv_module(
        &self,
        label: &str,
        entry: &str,
        words: &[u32],
    ) -> Result<wgpu::ShaderModule> {
        let entry = PassthroughShaderEntryPoint { name: entry.into(), workgroup_size: (0, 0, 0) };
        let descriptor = ShaderModuleDescriptorPassthrough {
            label: Some(label),
            entry_points: vec![entry].into(),
            spirv: Some(words.into()),
            ..ShaderModuleDescriptorPassthrough::default()
        };
        #[expect(
            unsafe_code,
            reason = "wgpu checks no SPIR-V. naga wrote this from a module that it had validated, with every index kept \
                      inside of its buffer and every loop bounded; only orders of atomic operations were changed since"
        )]
        // SAFETY: see the reason; and the layout of the pipeline has the bindings that the words were written for.
        let module = unsafe { self.device.create_shader_module_passthrough(descriptor) };
        self.check().map(|()| module)
    }
}
