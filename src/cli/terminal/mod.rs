//! The terminal: output, a progress spinner, and Ctrl-C.

pub(super) mod interrupt;
pub(super) mod say;
pub(super) mod wait;
