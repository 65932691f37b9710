//! Commands that list what is available.

#[cfg(feature = "gpu")]
pub(super) mod adapters;
pub(super) mod claims;
pub(super) mod methods;
pub(super) mod mutations;
pub(super) mod scenes;
