//! k+-buffers: fragments beyond the kept ones are culled before the lock is taken; a max-array or a max-heap holds the
//! kept ones.

pub mod k_variable;
pub mod kplus;
pub mod kplus_array;
pub mod kplus_array_published;
pub mod kplus_array_word64;
pub mod kplus_heap;
pub mod kplus_multi;
pub mod kplus_sb;

use super::contract::{Contract, Keeps};
use super::parts::lock;

/// What k+-buffers have in common: a lock per pixel.
const fn locked(name: &'static str, keeps: Keeps) -> Contract {
    Contract {
        paper: "Vasilakis, Fudos 2014",
        words: "2k + 2",
        needs: lock::NEEDS,
        wgsl: lock::WGSL,
        ..Contract::new(name, keeps)
    }
}
