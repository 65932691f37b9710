//! Commands that check what methods promise and what papers claim.

pub(super) mod check;
#[cfg(feature = "gpu")]
pub(super) mod crosscheck;
pub(super) mod replay;
pub(super) mod reproduce;
