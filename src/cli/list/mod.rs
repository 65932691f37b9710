//! Commands that list what is available, and what is in a scene.

#[cfg(feature = "gpu")]
pub(super) mod adapters;
pub(super) mod claims;
pub(super) mod info;
pub(super) mod methods;
pub(super) mod mutations;
pub(super) mod scenes;
