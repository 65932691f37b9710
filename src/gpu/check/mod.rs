//! Whether a device agrees: twins against the simulator on scenes, on random fragments, and under stress.

pub mod backend;
pub mod compare;
pub mod conform;
pub mod crosscheck;
pub mod double;
pub mod open;
pub mod outcomes;
pub mod pressure;
pub mod race;
mod seen;
mod split;
pub mod stress;
