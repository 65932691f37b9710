//! Verify or refute: what a method does under every interleaving.
//!
//! A check asks whether a method keeps its contract, whatever its invocations' timing. It makes small programs from
//! the contract ([`litmus`]), explores them under a memory model ([`explore`]), and answers *verified* with its
//! bound, *violated* with a schedule that can be run again, or *unknown*.

mod case;
pub mod check;
pub mod claims;
mod exhaustive;
pub mod expect;
mod forest;
pub mod litmus;
mod machine;
pub mod matrix;
pub mod minimise;
mod model;
pub mod progress;
mod property;
mod relaxed;
pub mod replay;
pub mod run;
pub mod scene;
pub mod schedule;
mod sequential;
mod sites;
mod space;
pub mod stability;
pub mod token;
mod verdict;
mod walk;

pub use case::{Case, Ended, Subject, Task};
pub use check::{Plan, Survey, check, properties, termination};
pub use exhaustive::{Explored, Found, Limits};
pub use litmus::{Family, Litmus};
pub use machine::{Device, Final};
pub use model::{MemoryModel, Profile};
pub use progress::Progress;
pub use property::Property;
pub use scene::{Executions, cut, sampled, survey};
pub use token::Token;
pub use verdict::{Row, Verdict};

/// Explore one instance of a method.
#[must_use]
pub fn explore(
    subject: &Subject,
    litmus: &Litmus,
    device: Device,
    limits: &Limits<'_>,
) -> Explored {
    exhaustive::explore(&subject.case(litmus), device, limits)
}
