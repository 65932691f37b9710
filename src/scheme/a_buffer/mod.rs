//! A-buffers: every fragment is kept, in arrays, in linked lists (plain, paged, doubly linked, by buckets of depth), or
//! in ranges whose lengths an earlier pass counted.

pub mod ab_array;
pub mod ab_ll;
pub mod ab_ll_bucket;
pub mod ab_ll_double;
pub mod ab_ll_paged;
pub mod dfb;
pub mod s_buffer;

use super::contract::{Contract, Demand, Keeps, Overflow};

/// What A-buffers in linked lists have in common: one pool for the frame, with a node for every fragment.
const fn linked(name: &'static str) -> Contract {
    Contract {
        words: "1",
        frame_words: "3F + 1",
        exact_when: "the pool holds F nodes (it does)",
        overflow: Overflow::Drops("drop, counted"),
        demand: Demand::Generated,
        ..Contract::new(name, Keeps::All)
    }
}
