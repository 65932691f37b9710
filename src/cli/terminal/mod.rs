//! The terminal: where words go, a sign of life, and Ctrl-C.

pub(super) mod interrupt;
pub(super) mod say;
pub(super) mod wait;
