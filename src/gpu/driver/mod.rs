//! The layer between wgpu and the rest: adapters, waiting for them, and their failures.

pub mod device;
pub mod failure;
mod passthrough;
