//! Commands that hold methods to what they promise, and papers to what they claim.

pub(super) mod check;
#[cfg(feature = "gpu")]
pub(super) mod crosscheck;
pub(super) mod replay;
pub(super) mod reproduce;
