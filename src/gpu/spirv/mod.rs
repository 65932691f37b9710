//! SPIR-V in which atomic operations acquire and release, from WGSL, whose atomics are relaxed.
//!
//! [`mod@write`] has naga write the SPIR-V of one entry point, with the checks that wgpu would ask for. [`orders`] puts the
//! orders in: which operations get one follows from the names of the functions that they are in.
//!
//! wgpu does not enable Vulkan's memory model, which would let every access say what it makes available and visible. So
//! the module has the older model, in which a method's buffers are declared coherent.

pub mod orders;
pub mod write;
