//! Searching a machine's states: for results that break a `property`, and for invocations that never end.

mod constants;
pub(super) mod exhaustive;
mod expand;
pub(super) mod explored;
pub(super) mod graph;
pub(super) mod live;
#[cfg(test)]
mod naive;
pub mod progress;
pub(super) mod property;
pub mod random;
pub(super) mod space;
mod waiting;

use super::program::guard::guarded;
use super::program::{Conditions, Litmus, Subject};

pub use self::explored::{Explored, Found, Limits, Stopped};
pub use self::progress::Progress;
pub use self::property::Property;

/// Explore the orders of arrival of one instance, one invocation after another.
pub(super) fn orders(subject: &Subject, litmus: &Litmus, limits: &Limits<'_>) -> Explored {
    guarded(|| exhaustive::orders(&subject.case(litmus), limits)).unwrap_or_else(Explored::panicked)
}

/// Explore one instance of a method. A panic of its code outside of its invocations is a violation without a schedule.
#[must_use]
pub fn explore(
    subject: &Subject,
    litmus: &Litmus,
    conditions: Conditions,
    limits: &Limits<'_>,
) -> Explored {
    guarded(|| exhaustive::explore(&subject.case(litmus), conditions, limits))
        .unwrap_or_else(Explored::panicked)
}
