//! Commands that draw.

pub(super) mod bench;
pub(super) mod compare;
pub(super) mod export;
mod frames;
pub(super) mod inspect;
pub(super) mod judge;
mod picture;
mod reference;
pub(super) mod render;
pub(super) mod report;
