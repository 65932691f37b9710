//! The schemes' twins in WGSL: without a driver, that they are valid and have their words where the simulator has them;
//! with drivers, that these compute what the simulator computes.
//!
//! Tests that need a driver say so where there is none. With `FRAGLOOM_ADAPTERS=2` in the environment, as CI has it,
//! fewer than two adapters fail.

#![cfg(feature = "gpu")]

mod approximate;
mod drivers;
mod inputs;
mod merging;
mod mutants;
mod outcomes;
mod race;
mod text;
mod vulkan;

#[path = "../support/mod.rs"]
mod support;
