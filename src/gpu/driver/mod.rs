//! What stands between wgpu and the rest: adapters, waiting for them, and what can go wrong.

pub mod device;
pub mod failure;
