//! HA-buffers: every fragment is an entry of one open-addressing [`table`] for the whole picture.

pub mod ha;
pub mod ha_cull;
pub mod hash_coherent;
pub mod table;
