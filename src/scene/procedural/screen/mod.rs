//! Made of triangles in pixels: layers whose number and order are known.

pub(super) mod layers;
pub(super) mod stack;
pub(super) mod synthetic;
