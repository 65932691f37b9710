//! Files of volumes.

mod element;
pub mod npy;
pub mod nrrd;

pub(super) use element::Element;
