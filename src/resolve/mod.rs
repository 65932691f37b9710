//! From a pixel's kept fragments to a list and a colour: shared by all schemes.

pub mod composite;
pub mod digest;
pub mod lists;

pub use lists::{Kept, Lists};
