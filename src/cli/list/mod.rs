//! Commands that list what there is.

#[cfg(feature = "gpu")]
pub(super) mod adapters;
pub(super) mod claims;
pub(super) mod methods;
pub(super) mod mutations;
pub(super) mod scenes;
