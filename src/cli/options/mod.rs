//! Command-line options, checked and completed.

pub(super) mod approximation;
pub(super) mod effects;
pub(super) mod flags;
pub(super) mod importance;
pub(super) mod measures;
pub(super) mod page;
pub(super) mod scene;
pub(super) mod settings;
pub(super) mod sweep;
pub(super) mod values;
