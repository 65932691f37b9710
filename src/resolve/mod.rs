//! From a pixel's kept fragments to a list and a colour: shared by all schemes.

pub mod compact;
pub mod composite;
pub mod digest;
pub mod lists;
mod network;
pub mod sort;

pub use lists::{Kept, Lists};
