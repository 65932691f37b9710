//! Verify or refute: what a method does under every interleaving.
//!
//! A check asks whether a method keeps its contract, whatever its invocations' timing. It makes small programs from the
//! contract ([`litmus`](program::litmus)), explores them under a memory model ([`explore`]), and answers *verified*
//! with its bound, *violated* with a schedule that can be replayed, or *unknown*.
//!
//! It goes through these modules, in this order, and a module uses only those before it (`tests/layering.rs` checks
//! that):
//!
//! `memory` → `program` → `search` → `replay` → `verdict` → `sample`

mod memory;
pub mod program;
pub mod replay;
pub mod sample;
pub mod search;
pub mod verdict;

pub use memory::{MemoryModel, Profile};
pub use program::{Case, Conditions, Entry, Family, Final, Litmus, Subject};
pub use replay::token::Token;
pub use sample::{Executions, cut, sampled};
pub use search::{Explored, Found, Limits, Progress, Property, Stopped, explore};
pub use verdict::check::{check, inherit};
pub use verdict::endings::termination;
pub use verdict::plan::Plan;
pub use verdict::predict::{Expects, Prediction, predict};
pub use verdict::survey::{Survey, properties};
pub use verdict::{Finding, Scope, Verdict};

pub use crate::scheme::task::{Ended, Task};
