//! HA-buffers: every fragment is an entry of one open-addressing [`table`] for the whole picture.

pub mod ha;
pub mod ha_cull;
pub mod hash_coherent;
pub mod table;
mod walks;

use super::contract::{Accounting, Contract, Demand, Keeps, Overflow};

/// What methods on one hash table for the frame have in common.
const fn hashed(name: &'static str, keeps: Keeps) -> Contract {
    Contract {
        frame_words: "2C + B",
        overflow: Overflow::Drops(OVERFLOW),
        accounting: Accounting::Crossing,
        needs: "64-bit atomic maximum, relaxed",
        wgsl: Some("storage buffers; 64-bit atomicMax (not in the standard)"),
        demand: Demand::Generated,
        ..Contract::new(name, keeps)
    }
}

/// What finds no room in a table.
const OVERFLOW: &str = "beyond the largest age, or where the table is full: drop, counted";

/// What becomes of ties where records that are alike are one.
const TIES: &str =
    "canonical after resolve; of records that are alike, one is kept, and the others are counted";
