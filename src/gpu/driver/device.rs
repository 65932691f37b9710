//! A device: buffers, pipelines, and work that is waited for, but not forever.
//!
//! Nothing here panics on what a driver does. wgpu reports errors to a callback; the first one is kept, and the next
//! call that can fail returns it. A caller that cuts work into submissions keeps each of them small, so that a hanging
//! device is noticed. Such a device is left alone and never dropped, since dropping would wait for it again.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serde::Serialize;
use wgpu::{BufferUsages, Features, PollType};

use super::failure::{Failure, Result};
use super::passthrough::takes_spirv;

/// How long a submission may take by default, in seconds.
pub const PATIENCE: u64 = 120;

/// How an adapter describes itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdapterName {
    /// Its name.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// Vulkan, Metal, ...
    pub backend: String,
    /// A software rasterizer, a discrete GPU, ...
    pub kind: String,
}

/// All available adapters, including software ones.
#[must_use]
pub fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.flags |= wgpu::InstanceFlags::ALLOW_UNDERLYING_NONCOMPLIANT_ADAPTER;
    let instance = wgpu::Instance::new(descriptor);
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

/// How an adapter describes itself.
#[must_use]
pub fn name(adapter: &wgpu::Adapter) -> AdapterName {
    let info = adapter.get_info();
    let driver = [info.driver.as_str(), info.driver_info.as_str()].join(" ").trim().to_owned();
    AdapterName {
        name: info.name,
        driver: if driver.is_empty() { "unnamed".to_owned() } else { driver },
        backend: info.backend.to_string(),
        kind: format!("{:?}", info.device_type),
    }
}

/// An open device.
#[derive(Debug)]
pub struct Device {
    /// Its name.
    pub name: AdapterName,
    /// Atomic operations on 64 bits.
    pub atomics64: bool,
    /// It takes SPIR-V as it is.
    pub spirv: bool,
    /// Its limits.
    pub limits: wgpu::Limits,
    /// How long a submission may take, in seconds.
    pub patience: u64,
    /// Submissions that have come back: a sign of life.
    pub submissions: Arc<Mutex<u64>>,
    pub(in crate::gpu) device: wgpu::Device,
    pub(in crate::gpu) queue: wgpu::Queue,
    failure: Arc<Mutex<Option<Failure>>>,
}

impl Drop for Device {
    /// A device that hangs is leaked.
    fn drop(&mut self) {
        if self.is_lost() {
            std::mem::forget((self.device.clone(), self.queue.clone()));
        }
    }
}

fn note(slot: &Mutex<Option<Failure>>, failure: Failure) {
    let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
    if slot.is_none() {
        *slot = Some(failure);
    }
}

fn failure_of(error: wgpu::Error) -> Failure {
    let line = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
    match error {
        wgpu::Error::OutOfMemory { source } => Failure::OutOfMemory(line(source.to_string())),
        wgpu::Error::Validation { description, .. } => Failure::Invalid(line(description)),
        wgpu::Error::Internal { description, .. } => Failure::Invalid(line(description)),
    }
}

impl Device {
    /// Open an adapter with every feature that methods can use.
    ///
    /// # Errors
    /// The adapter refuses.
    pub fn open(adapter: &wgpu::Adapter) -> Result<Self> {
        let all64 = Features::SHADER_INT64 | Features::SHADER_INT64_ATOMIC_ALL_OPS;
        let small64 = Features::SHADER_INT64_ATOMIC_MIN_MAX;
        let atomics64 = adapter.features().contains(all64);
        let features = adapter.features() & (all64 | small64);
        let mut required_features = if atomics64 { features } else { Features::empty() };
        let spirv = takes_spirv(adapter);
        required_features.set(Features::PASSTHROUGH_SHADERS, spirv);
        let limits = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("fragloom"),
            required_features,
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| {
                Failure::Unsupported(format!("the device cannot be opened: {error}"))
            })?;
        let failure = Arc::new(Mutex::new(None));
        let (uncaptured, lost) = (Arc::clone(&failure), Arc::clone(&failure));
        device.on_uncaptured_error(Arc::new(move |error| note(&uncaptured, failure_of(error))));
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(&lost, Failure::Lost(message));
            }
        });
        let (name, patience) = (name(adapter), PATIENCE);
        let submissions = Arc::default();
        Ok(Self { name, atomics64, spirv, limits, patience, submissions, device, queue, failure })
    }

    fn failure(&self) -> Option<Failure> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Whether the device can no longer be used.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.failure().is_some_and(|failure| failure.is_fatal())
    }

    /// What went wrong since the last call, if anything did. Only a fatal error stays.
    ///
    /// # Errors
    /// That error.
    pub fn check(&self) -> Result<()> {
        let mut slot = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        match slot.take() {
            None => Ok(()),
            Some(failure) => {
                if failure.is_fatal() {
                    *slot = Some(failure.clone());
                }
                Err(failure)
            }
        }
    }

    /// The largest buffer that a shader can see, in bytes.
    #[must_use]
    pub fn largest(&self) -> u64 {
        self.limits.max_buffer_size.min(self.limits.max_storage_buffer_binding_size)
    }

    /// A zeroed buffer.
    ///
    /// # Errors
    /// It is larger than the device allows, or there is no memory.
    pub fn buffer(&self, label: &str, bytes: u64, usage: BufferUsages) -> Result<wgpu::Buffer> {
        let size = bytes.max(16).next_multiple_of(16);
        if size > self.largest() {
            let most = self.largest();
            return Err(Failure::TooLarge(format!("{label}: {size} bytes, at most {most}")));
        }
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        });
        self.check().map(|()| buffer)
    }

    /// A buffer with these contents.
    ///
    /// # Errors
    /// As [`Self::buffer`].
    pub fn filled(&self, label: &str, bytes: &[u8], usage: BufferUsages) -> Result<wgpu::Buffer> {
        let buffer = self.buffer(label, bytes.len() as u64, usage | BufferUsages::COPY_DST)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    /// A shader module; naga has validated it when this returns.
    ///
    /// # Errors
    /// The module is refused.
    pub fn module(&self, label: &str, text: &str) -> Result<wgpu::ShaderModule> {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        self.check().map(|()| module)
    }

    /// A recorder for commands.
    #[must_use]
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Run commands, and wait for them.
    ///
    /// # Errors
    /// Any error of the device, or no answer within [`Self::patience`] seconds.
    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> Result<()> {
        let index = self.queue.submit([encoder.finish()]);
        self.wait(Some(index))
    }

    fn wait(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<()> {
        let timeout = Some(Duration::from_secs(self.patience));
        match self.device.poll(PollType::Wait { submission_index, timeout }) {
            Ok(_) => {
                *self.submissions.lock().unwrap_or_else(PoisonError::into_inner) += 1;
            }
            Err(wgpu::PollError::Timeout) => note(&self.failure, Failure::TimedOut(self.patience)),
            Err(error) => note(&self.failure, Failure::Invalid(error.to_string())),
        }
        self.check()
    }

    /// A buffer's first bytes.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn read(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>> {
        if bytes == 0 {
            return Ok(Vec::new());
        }
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let staging = self.buffer("read back", bytes, usage)?;
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes.next_multiple_of(4));
        self.submit(encoder)?;
        let failure = Arc::clone(&self.failure);
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            if let Err(error) = result {
                note(&failure, Failure::Lost(error.to_string()));
            }
        });
        self.wait(None)?;
        let view = staging.get_mapped_range(..).map_err(|e| Failure::Lost(e.to_string()))?;
        Ok(view[..bytes as usize].to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// wgpu's out-of-memory error becomes one of our failures, after which the device goes on; the first one counts.
    #[test]
    fn out_of_memory_is_a_failure_that_passes() {
        let slot = Mutex::new(None);
        let source = || Box::new(std::io::Error::other("no room")) as Box<_>;
        note(&slot, failure_of(wgpu::Error::OutOfMemory { source: source() }));
        let (source, description) = (source(), "worse".to_owned());
        note(&slot, failure_of(wgpu::Error::Internal { source, description }));
        let found = slot.into_inner().unwrap_or_default();
        assert_eq!(found, Some(Failure::OutOfMemory("no room".to_owned())));
        assert!(found.is_some_and(|failure| !failure.is_fatal()));
    }
}
