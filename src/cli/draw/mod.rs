//! Commands that draw.

pub(super) mod bench;
pub(super) mod compare;
mod frames;
pub(super) mod inspect;
mod picture;
mod reference;
pub(super) mod render;
