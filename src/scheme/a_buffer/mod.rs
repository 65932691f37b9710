//! A-buffers: every fragment is kept, in arrays, in linked lists (plain, paged, doubly linked, by buckets of depth), or
//! in ranges whose lengths an earlier pass counted.

pub mod ab_array;
pub mod ab_ll;
pub mod ab_ll_bucket;
pub mod ab_ll_double;
pub mod ab_ll_paged;
pub mod dfb;
pub mod s_buffer;
