//! The one place where ready futures are polled.
//!
//! On native and exclusive memory every operation is ready at once, so one poll runs an invocation to its end and the
//! compiler removes the machinery, *if* the poll is inlined. It is when a (scheme, memory) pair is polled in a single
//! place: here, for executors, tests and benchmarks alike.

use std::future::Future;
use std::ops::Range;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::fragment::Fragment;
use crate::memory::Memory;
use crate::scheme::{Keys, Outcome, Scheme};

/// Outcomes of a batch, in the order of its fragments.
pub type Outcomes = [Outcome; 64];

/// The result of a future that never waits.
///
/// # Panics
/// If it waits, that is, if it runs on a memory whose operations are not ready.
#[allow(clippy::inline_always, reason = "see the module's text")]
#[inline(always)]
pub fn complete<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => panic!("an operation of this memory is not ready"),
    }
}

/// Clear the frame's own words.
pub fn clear_frame<S: Scheme, M: Memory>(scheme: &S, mem: &M) {
    complete(scheme.clear_frame(mem));
}

/// Clear a range of pixels.
#[inline(never)]
pub fn clear<S: Scheme, M: Memory>(scheme: &S, mem: &M, pixels: Range<u32>) {
    for pixel in pixels {
        complete(scheme.clear(mem, pixel));
    }
}

/// Store fragments one after another; at most 64.
#[inline(never)]
pub fn store<S: Scheme, M: Memory>(
    scheme: &S,
    mem: &M,
    fragments: &[Fragment],
    outcomes: &mut Outcomes,
) {
    for (fragment, outcome) in fragments.iter().zip(outcomes) {
        *outcome = complete(scheme.store(mem, *fragment));
    }
}

/// Append a pixel's fragments to `keys`.
#[inline]
pub fn resolve<S: Scheme, M: Memory>(scheme: &S, mem: &M, pixel: u32, keys: &mut Keys) {
    complete(scheme.resolve(mem, pixel, keys));
}
