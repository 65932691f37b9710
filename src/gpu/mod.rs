//! The same schemes on devices, through wgpu: whether a GPU or a driver computes what the simulator computes.
//!
//! Every method that WGSL can express has a *twin*: one file of WGSL with the same words in the same places, and the same
//! operations on them. [`source`] makes modules of twins, [`program`] runs their passes, [`raster`] feeds them from the
//! device's own rasterizer, [`band`] cuts scenes to what a device has room for, [`compare`] looks at what came back, and
//! [`crosscheck`] does all of it. [`device`] is the only place that waits for a driver, and never does so for ever.
//!
//! What decides a compared bit is computed in integers on both sides. Floats carry vertices to the device's rasterizer,
//! by a way that is exact.

pub mod check;
pub mod driver;
pub mod twin;
