//! The built-in faults of `k-variable`.

use super::{CONTRACT, COUNT_PASS, IMPORTANCE_PASS, PLACE_PASS, Quotient, SUMS, Variant};
use crate::scheme::Contract;
use crate::scheme::contract::Accounting;
use crate::scheme::program::{Barrier, Pass, PassKind, Program};

/// Shares are rounded to the nearest.
#[derive(Debug)]
pub enum Rounded {}

/// Shares are quotients of floats over a rounded sum.
#[derive(Debug)]
pub enum FloatQuotient {}

/// k(p) is computed before all importances are added up.
#[derive(Debug)]
pub enum NoBarrier {}

/// The last frame's counts are used.
#[derive(Debug)]
pub enum StaleCount {}

/// The shares are computed while the sum is.
const WITHOUT_BARRIER: &[Pass] = &[
    COUNT_PASS,
    IMPORTANCE_PASS,
    SUMS[0],
    SUMS[1],
    Pass::new("k", PassKind::Screen, Barrier::Missing),
    SUMS[0],
    SUMS[1],
    PLACE_PASS,
    Pass::store(Barrier::Pixel),
];

/// What faults here have in common: the accounting compares lists.
const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract {
        accounting: Accounting::Judged,
        ..CONTRACT.fault(name, title, "where shares happen to fit")
    }
}

impl Variant for Rounded {
    const CONTRACT: Contract =
        fault("k-variable@rounded", "Fault rounded: k(p) is rounded to the nearest");
    const QUOTIENT: Quotient = Quotient::Nearest;
}

impl Variant for FloatQuotient {
    const CONTRACT: Contract =
        fault("k-variable@float-quotient", "Fault float-quotient: floats over a rounded sum");
    const QUOTIENT: Quotient = Quotient::Float;
}

impl Variant for NoBarrier {
    const CONTRACT: Contract = Contract {
        program: Program::of(WITHOUT_BARRIER),
        ..fault("k-variable@M17", "Fault M17: no barrier before shares are computed")
    };
}

impl Variant for StaleCount {
    const CONTRACT: Contract =
        fault("k-variable@stale-count", "Fault stale-count: the count of the frame before");
    const COUNTS: bool = false;
}
