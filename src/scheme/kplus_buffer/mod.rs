//! k+-buffers: fragments beyond the kept ones are culled before the lock is taken; a max-array or a max-heap holds the
//! kept ones.

pub mod kplus;
pub mod kplus_array;
pub mod kplus_array_published;
pub mod kplus_heap;
pub mod kplus_multi;
pub mod kplus_sb;
