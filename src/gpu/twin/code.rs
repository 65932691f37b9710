//! A twin's text as shader modules, in the form that it has.

use super::source::{Form, Twin};
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::spirv::orders::{Order, ordered};
use crate::gpu::spirv::write::{Entry, Source};

/// A module of a twin.
#[derive(Debug)]
pub(super) struct Code {
    name: String,
    wgsl: wgpu::ShaderModule,
    /// What the SPIR-V of the Vulkan form is written from.
    source: Option<Source>,
}

impl Code {
    /// Compile a module's text.
    ///
    /// # Errors
    /// The text is not valid, says nothing about orders but has to, or the device takes no such form.
    pub(super) fn new(device: &Device, twin: Twin, text: &str) -> Result<Self> {
        let name = twin.name();
        if twin.form == Form::Vulkan && !device.spirv {
            let problem = format!("{} takes no SPIR-V as it is", device.name.backend);
            return Err(Failure::Unsupported(problem));
        }
        let wgsl = device.module(&name, text)?;
        let source = (twin.form == Form::Vulkan).then(|| source(&name, text)).transpose()?;
        Ok(Self { name, wgsl, source })
    }

    /// The module with an entry point. Only what reaches an operation with an order differs from the WGSL.
    ///
    /// # Errors
    /// An order cannot be put in, or the device refuses.
    pub(super) fn module(&self, device: &Device, entry: &Entry<'_>) -> Result<wgpu::ShaderModule> {
        let words = self.source.as_ref().map(|source| source.words(entry)).transpose()?;
        let words = words.map(|words| ordered(&words)).transpose()?.flatten();
        words.map_or_else(
            || Ok(self.wgsl.clone()),
            |words| device.spirv_module(&self.name, entry.name, &words),
        )
    }
}

/// A module that names both orders.
fn source(name: &str, text: &str) -> Result<Source> {
    let source = Source::new(text)?;
    for order in Order::ALL {
        if !source.functions().any(|function| Order::of(function) == Some(order)) {
            let problem = format!("{name} has no function {}...", order.prefix());
            return Err(Failure::Invalid(problem));
        }
    }
    Ok(source)
}
