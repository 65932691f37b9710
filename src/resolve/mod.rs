//! What happens to the kept fragments of a pixel after the store passes: shared by all schemes.

pub mod hash;
