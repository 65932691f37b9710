//! What is explored: a method's invocations on a few fragments, as a machine that moves from state to state.
//!
//! A [`litmus`] pixel says which invocations there are; a [`case`] is one of them with a method's words. Its invocations
//! are replayed from their answers, and where they can stand is kept once in a [`forest`]. The [`machine`] puts forest
//! and memory together: a state, the moves from it, and what a move leads to. A [`schedule`] is a list of moves.

pub(super) mod case;
pub(super) mod forest;
pub mod litmus;
pub(super) mod machine;
pub mod schedule;
pub(super) mod subject;

pub use self::case::Case;
pub use self::litmus::{Family, Litmus, Stage};
pub use self::machine::{Conditions, Final};
pub use self::schedule::{Move, Schedule};
pub use self::subject::Subject;
