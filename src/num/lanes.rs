//! Loops over lanes, compiled for the vectors that the machine has.
//!
//! The code is the scalar code: the same operations on every lane, in the same order, so the bits are the same whatever
//! the machine has (nothing is ever fused). `FRAGLOOM_LANES=narrow` in the environment leaves the vectors out that not
//! every machine has, for tests and comparisons.

use std::sync::LazyLock;

use pulp::{Arch, WithSimd};

/// The name of the environment variable.
pub const VARIABLE: &str = "FRAGLOOM_LANES";

static ARCH: LazyLock<Arch> = LazyLock::new(|| {
    let narrow = std::env::var_os(VARIABLE).is_some_and(|value| value == "narrow");
    if narrow { Arch::Scalar } else { Arch::new() }
});

/// Do `work`, compiled for the widest vectors of this machine. What it calls is compiled so only where it is inlined.
/// What a loop sums up must be its own and returned: a sum outside of `work` is a reference to memory, and the loop stays
/// scalar.
#[allow(clippy::inline_always, reason = "what is not inlined is not compiled for these vectors")]
#[inline(always)]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    ARCH.dispatch(work)
}

/// As [`wide`], for work that names its vectors, where the compiler would not find them.
#[inline]
pub fn explicit<W: WithSimd>(work: W) -> W::Output {
    ARCH.dispatch(work)
}
