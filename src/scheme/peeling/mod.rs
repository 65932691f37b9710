//! Depth peeling: one layer, two layers or one layer per bucket of depth in each pass over the geometry.

pub mod depth_peel;
pub mod depth_peel_bucket;
pub mod depth_peel_dual;
