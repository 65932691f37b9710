//! What stands between wgpu and the rest: opening an adapter, waiting for it, and what can go wrong.

pub mod device;
pub mod failure;
pub mod open;
