//! The SPIR-V of an entry point, as naga writes it.

use naga::back::spv::{BindingInfo, BindingMap, Options, PipelineOptions, WriterFlags, write_vec};
use naga::back::{PipelineConstants, pipeline_constants::process_overrides};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, MemoryDecorations, Module, ResourceBinding, ShaderStage, StorageAccess};

use crate::gpu::driver::failure::{Failure, Result};

/// A valid module, whose writable buffers are coherent.
#[derive(Debug)]
pub struct Source {
    module: Module,
    info: ModuleInfo,
}

/// An entry point of a pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// Its name.
    pub name: &'a str,
    /// Values of the module's overrides; the others keep their defaults.
    pub overrides: &'a [(&'a str, f64)],
    /// By group of the pipeline's layout, the numbers of all its bindings, ascending.
    pub bindings: &'a [&'a [u32]],
}

impl Source {
    /// Parse and validate a module.
    ///
    /// # Errors
    /// It is not valid.
    pub fn new(text: &str) -> Result<Self> {
        let mut module = naga::front::wgsl::parse_str(text)
            .map_err(|error| Failure::Invalid(error.emit_to_string(text)))?;
        for (_, variable) in module.global_variables.iter_mut() {
            if let AddressSpace::Storage { access } = variable.space
                && access.contains(StorageAccess::STORE)
            {
                variable.memory_decorations |= MemoryDecorations::COHERENT;
            }
        }
        let needs = Capabilities::MEMORY_DECORATION_COHERENT;
        let info = Validator::new(ValidationFlags::all(), needs)
            .validate(&module)
            .map_err(|error| Failure::Invalid(error.emit_to_string(text)))?;
        Ok(Self { module, info })
    }

    /// The names of its functions.
    pub fn functions(&self) -> impl Iterator<Item = &str> {
        self.module.functions.iter().filter_map(|(_, function)| function.name.as_deref())
    }

    /// An entry point and all that it reaches, with the names of functions.
    ///
    /// # Errors
    /// There is no such entry point, or it needs an override or a binding that is not there.
    pub fn words(&self, entry: &Entry<'_>) -> Result<Vec<u32>> {
        let stage = self.stage(entry.name)?;
        let values = entry.overrides.iter().map(|&(name, value)| (name.to_owned(), value));
        let values: PipelineConstants = values.collect();
        let (module, info) =
            process_overrides(&self.module, &self.info, Some((stage, entry.name)), &values)
                .map_err(|error| Failure::Invalid(error.to_string()))?;
        let pipeline = PipelineOptions { shader_stage: stage, entry_point: entry.name.to_owned() };
        write_vec(&module, &info, &options(entry), Some(&pipeline))
            .map_err(|error| Failure::Invalid(format!("{}: {error}", entry.name)))
    }

    fn stage(&self, entry: &str) -> Result<ShaderStage> {
        let found = self.module.entry_points.iter().find(|known| known.name == entry);
        let problem = || Failure::Invalid(format!("there is no entry point {entry}"));
        found.map(|known| known.stage).ok_or_else(problem)
    }
}

/// What wgpu-hal asks of naga for Vulkan, where it matters to these modules. An index is always kept inside of its
/// buffer, also where wgpu would leave that to the device.
fn options(entry: &Entry<'_>) -> Options<'static> {
    Options {
        lang_version: (1, 0),
        flags: WriterFlags::DEBUG | WriterFlags::LABEL_VARYINGS,
        fake_missing_bindings: false,
        binding_map: bindings(entry.bindings),
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Restrict,
            image_load: BoundsCheckPolicy::Restrict,
            binding_array: BoundsCheckPolicy::Unchecked,
        },
        force_loop_bounding: true,
        emit_int_div_checks: true,
        ..Options::default()
    }
}

/// wgpu-hal numbers the bindings of a group anew, in ascending order and without gaps.
fn bindings(groups: &[&[u32]]) -> BindingMap {
    let mut map = BindingMap::default();
    for (group, numbers) in (0..).zip(groups) {
        for (place, &binding) in (0..).zip(*numbers) {
            let info =
                BindingInfo { descriptor_set: group, binding: place, binding_array_size: None };
            map.insert(ResourceBinding { group, binding }, info);
        }
    }
    map
}
