//! Twins: the WGSL text of a method, its shape on a device, the program of its passes, scenes cut to fit a device, what
//! their pixels must hold, fragments from the device's rasterizer, and lists, resolved.

pub mod band;
pub mod bounds;
mod code;
pub mod expected;
pub mod light;
pub mod merged;
pub mod picture;
pub mod program;
pub mod raster;
pub mod resolve;
pub mod shape;
pub mod source;
