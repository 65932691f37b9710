//! Parts that several methods share: lists and ranges in pools, locks and the interlock, ordered slots and heaps.

pub mod ends;
#[cfg(test)]
pub(super) mod hand_made;
pub mod interlock;
pub mod list;
pub mod lock;
pub mod locked_row;
pub mod max_array;
pub mod max_heap;
pub mod ranges;
pub mod select;
pub mod slots;
pub mod visible;
