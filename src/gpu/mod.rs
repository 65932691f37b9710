//! The same schemes on devices, through wgpu: whether a GPU or a driver computes what the simulator computes.
//!
//! Every method that WGSL can express has a *twin*: one file of WGSL with the same words in the same places, and the
//! same operations on them. [`twin`] makes modules of twins and runs their passes, on fragments that are given or that
//! come from the device's own rasterizer; for those that need acquire and release, which WGSL has not, [`spirv`] can put
//! them in. [`check`] compares the results. [`driver`] is the only place that waits for a
//! driver, and it never waits without end.
//!
//! A module uses only modules that come before it in this order:
//!
//! `driver` → `spirv` → `twin` → `check`
//!
//! What decides a compared bit is computed in integers on both sides. Floats carry vertices to the device's rasterizer,
//! exactly. Two twins that approximate add up floats besides: their sums are compared within bounds ([`twin::bounds`]),
//! and decide nothing.

pub mod check;
pub mod driver;
pub mod spirv;
pub mod twin;
