//! What is explored: a method's invocations on a few fragments, as a machine that moves from state to state.
//!
//! A [`litmus`] pixel defines the invocations; a `case` is a litmus pixel with a method's words. Its invocations are
//! replayed from their answers, and each place where one can be is kept once in a `forest`. The `machine` combines
//! forest and memory: a state, the moves from it, and where each move leads. What clears or resolves runs `alone`
//! where its order cannot matter. A [`schedule`] is a list of moves.

mod alone;
pub(super) mod case;
pub mod controls;
pub(super) mod forest;
pub(super) mod guard;
pub mod instances;
pub mod litmus;
pub(super) mod machine;
pub mod schedule;
mod shared;
pub(super) mod subject;
pub mod values;

pub use self::case::Case;
pub use self::instances::Family;
pub use self::litmus::{Entry, Litmus, Stage};
pub use self::machine::{Conditions, Final};
pub use self::schedule::{Move, Schedule};
pub use self::subject::Subject;
