//! Loops over lanes, compiled for the vectors that the machine has.
//!
//! The code is the scalar code: the same operations on every lane, in the same order, so the bits are the same whatever
//! the machine has (nothing is ever fused). `FRAGLOOM_LANES=narrow` in the environment leaves the vectors out that not
//! every machine has, for tests and comparisons.

use std::any::Any;
use std::sync::LazyLock;

use pulp::{Arch, Simd, WithSimd};

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

/// The bits of those of a row that are negative. The compiler does not find the machine's instruction for it.
#[allow(clippy::inline_always, reason = "as above")]
#[inline(always)]
pub fn negative<S: Simd>(simd: S, row: [i32; 8]) -> u8 {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = (&simd as &dyn Any).downcast_ref::<pulp::x86::V3>() {
        return simd.avx._mm256_movemask_ps(pulp::cast(row)) as u8;
    }
    let _ = simd;
    row.iter().zip(0..).fold(0, |all, (&value, x)| all | u8::from(value < 0) << x)
}
