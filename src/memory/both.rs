//! Futures of operations that are ready: two of them as one, and polling to the end.
//!
//! A scheme that reads or writes a record in several places would, with an `async fn` for it, poll one future type from
//! several places, which the compiler then does not inline (and an insertion takes 2.5 times as long). This future is
//! always inlined.

use std::future::Future;
use std::pin::{Pin, pin};
use std::task::{Context, Poll, Waker};

/// The first operation, then the second; both results.
#[derive(Debug)]
pub struct Both<A: Future, B> {
    first: A,
    result: Option<A::Output>,
    second: B,
}

/// Perform `first`, then `second`.
///
/// # Panics
/// If it is polled again after it was ready.
#[allow(clippy::inline_always, reason = "see the module's text")]
#[inline(always)]
pub fn both<A: Future, B: Future>(first: A, second: B) -> Both<A, B> {
    Both { first, result: None, second }
}

impl<A, B> Future for Both<A, B>
where
    A: Future<Output: Copy + Unpin> + Unpin,
    B: Future + Unpin,
{
    type Output = (A::Output, B::Output);

    #[allow(clippy::inline_always, reason = "see the module's text")]
    #[inline(always)]
    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let this = &mut *self;
        let first = match this.result {
            Some(result) => result,
            None => match Pin::new(&mut this.first).poll(context) {
                Poll::Ready(result) => *this.result.insert(result),
                Poll::Pending => return Poll::Pending,
            },
        };
        match Pin::new(&mut this.second).poll(context) {
            Poll::Ready(second) => Poll::Ready((first, second)),
            Poll::Pending => Poll::Pending,
        }
    }
}

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
