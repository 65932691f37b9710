//! From a scene to fragments, exactly.
//!
//! `place` transforms, `disc` makes a polygon of a disc, `clip` clips and snaps, `edge` decides coverage, `plane` gives
//! depth, `shade` gives colour, `primitive` joins them for one triangle, `grid` numbers tiles and pixels, `front` sets up
//! and bins a whole scene, `slab` gives surfaces a thickness, `emit` turns packets into a `batch` of fragments. `naive`
//! is the reference that all of it is tested against.

pub mod batch;
pub mod clip;
pub mod disc;
pub mod edge;
pub mod emit;
pub mod front;
pub mod grid;
pub mod naive;
mod place;
pub mod plane;
pub mod primitive;
pub mod shade;
pub mod slab;

pub use batch::Batch;
pub use emit::Record;
pub use front::{CullFace, FrontEnd, Room};
pub use grid::Grid;
pub use shade::Attenuation;
