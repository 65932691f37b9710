//! Hair, leaves, needles and smoke: thousands of small surfaces, one behind the other.

pub(super) mod beard;
pub(super) mod greenhouse;
pub(super) mod hairball;
pub(super) mod needle_tree;
pub(super) mod smoke;
pub(super) mod strand;
