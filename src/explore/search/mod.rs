//! Searching a machine's states: for results that break a `property`, and for invocations that never end.

pub(super) mod exhaustive;
pub(super) mod graph;
pub mod progress;
pub(super) mod property;
pub(super) mod space;

use super::program::{Conditions, Litmus, Subject};

pub use self::exhaustive::{Explored, Found, Limits};
pub use self::progress::Progress;
pub use self::property::Property;

/// Explore one instance of a method.
#[must_use]
pub fn explore(
    subject: &Subject,
    litmus: &Litmus,
    conditions: Conditions,
    limits: &Limits<'_>,
) -> Explored {
    exhaustive::explore(&subject.case(litmus), conditions, limits)
}
