//! Commands that say what is available, what is in a scene, and what the command line is.

#[cfg(feature = "gpu")]
pub(super) mod adapters;
pub(super) mod claims;
pub(super) mod completions;
pub(super) mod info;
pub(super) mod man;
pub(super) mod methods;
pub(super) mod mutations;
pub(super) mod scenes;
