//! fragloom: a bit-exact CPU rasterizer that runs multi-fragment shaders as real concurrent programs.
//!
//! Data flows one way through the modules, in this order, and a module uses only what stands before it
//! (`tests/layering.rs` checks that):
//!
//! `error` → `num` → `image` → `scene` → `fragment` → `raster` → `memory` → `scheme` → `resolve` → `exec` →
//! `catalogue` → `effect` → `render` → `explore` → `gpu` → `report` → `reproduce` → `cli`

pub mod catalogue;
pub mod cli;
pub mod effect;
pub mod error;
pub mod exec;
pub mod explore;
pub mod fragment;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
pub mod memory;
pub mod num;
pub mod raster;
pub mod render;
pub mod report;
pub mod reproduce;
pub mod resolve;
pub mod scene;
pub mod scheme;
