//! k-buffers: the k nearest fragments of a pixel, or what their authors took for it; and the Z-buffer, which is k = 1.

pub mod kb;
pub mod kb_ab;
pub mod kb_ll;
pub mod kb_mdt32;
pub mod kb_mdt64;
pub mod kb_multi;
pub mod kb_ps;
pub mod kb_sr;
pub mod z_buffer;
