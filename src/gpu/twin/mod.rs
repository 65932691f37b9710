//! Twins: the WGSL text of a method, the program of its passes, its fragments from the device's rasterizer, and its
//! lists, resolved.

pub mod program;
pub mod raster;
pub mod resolve;
pub mod source;
