//! Operations in a row, as one future.
//!
//! A loop in an `async fn` with an operation in it keeps its counter, and what it has read, in the invocation's state,
//! which is memory: `kb-multi` took 1.4 times as long. In this future's poll they are local variables, so that a loop over
//! ready operations is unrolled where the number is known and small, and what was read are registers. With 16 operations
//! that was not so any more, and it was slower than a plain loop.
//!
//! What makes the operations should hold all that it needs by value (`move`): a reference to a variable of the invocation
//! leads into its state, which then is memory after all.

use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll};

/// Operations 0, 1, ... and their results; the results beyond the last are the default.
#[derive(Debug)]
pub struct Each<M, F, T, const MOST: usize> {
    count: usize,
    make: M,
    done: usize,
    /// The operation that is waited for.
    current: Option<F>,
    results: [T; MOST],
}

/// Perform `make(0)`, then `make(1)`, and so on up to `count` operations, at most `MOST`.
#[allow(clippy::inline_always, reason = "see the module's text")]
#[inline(always)]
pub fn each<const MOST: usize, M, F>(count: usize, make: M) -> Each<M, F, F::Output, MOST>
where
    M: FnMut(usize) -> F + Unpin,
    F: Future<Output: Copy + Default + Unpin> + Unpin,
{
    let results = [F::Output::default(); MOST];
    Each { count: count.min(MOST), make, done: 0, current: None, results }
}

impl<M, F, const MOST: usize> Future for Each<M, F, F::Output, MOST>
where
    M: FnMut(usize) -> F + Unpin,
    F: Future<Output: Copy + Default + Unpin> + Unpin,
{
    type Output = [F::Output; MOST];

    #[allow(clippy::inline_always, reason = "see the module's text")]
    #[inline(always)]
    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let this = &mut *self;
        let (mut results, mut current) = (this.results, this.current.take());
        for (i, result) in results.iter_mut().enumerate().take(this.count).skip(this.done) {
            let mut operation = current.take().unwrap_or_else(|| (this.make)(i));
            match Pin::new(&mut operation).poll(context) {
                Poll::Ready(value) => *result = value,
                Poll::Pending => {
                    (this.done, this.current, this.results) = (i, Some(operation), results);
                    return Poll::Pending;
                }
            }
        }
        Poll::Ready(results)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::task::Waker;

    use super::*;

    /// Ready when it is polled so often.
    struct After(u32, usize);

    impl Future for After {
        type Output = usize;

        fn poll(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<usize> {
            match self.0.checked_sub(1) {
                Some(left) => {
                    self.0 = left;
                    Poll::Pending
                }
                None => Poll::Ready(self.1),
            }
        }
    }

    #[test]
    fn one_after_another_whenever_they_are_ready() {
        for count in 0..6 {
            for waits in [[0, 0, 0, 0], [1, 0, 2, 0], [0, 3, 0, 1]] {
                let made = RefCell::new(Vec::new());
                let mut all = each::<4, _, _>(count, |i| {
                    made.borrow_mut().push(i);
                    After(waits[i], 10 + i)
                });
                let mut context = Context::from_waker(Waker::noop());
                let mut pending = 0;
                let results = loop {
                    match Pin::new(&mut all).poll(&mut context) {
                        Poll::Ready(results) => break results,
                        Poll::Pending => pending += 1,
                    }
                    let before: u32 = waits[..made.borrow().len()].iter().sum();
                    assert!(pending <= before, "nothing is made before it is its turn");
                };
                let count = count.min(4);
                assert_eq!(*made.borrow(), (0..count).collect::<Vec<_>>());
                assert_eq!(pending, waits[..count].iter().sum::<u32>());
                let of = |i: usize| if i < count { 10 + i } else { 0 };
                assert_eq!(results, std::array::from_fn(of));
            }
        }
    }
}
