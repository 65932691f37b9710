//! Invocations by slot: a place for each is made once, and one invocation after another is put into it.

use std::future::Future;
use std::hint::black_box;
use std::pin::Pin;
use std::task::{Context, Poll};

/// The invocations in slots: made from work of type `W`, they give results of type `R`.
pub(super) trait Pool<W, R> {
    /// Put a new invocation into a slot.
    fn set(&mut self, slot: usize, work: &W);

    /// Poll a slot's invocation, and take it out if it has ended; `None` if there is none.
    fn poll(&mut self, slot: usize, context: &mut Context<'_>) -> Option<Poll<R>>;

    /// Bring a slot's invocation into the cache.
    fn touch(&self, slot: usize);
}

/// Invocations of one type, as `invoke` makes them.
pub(super) struct Places<F, I> {
    invoke: I,
    places: Vec<Pin<Box<Option<F>>>>,
}

impl<F, I> Places<F, I> {
    /// So many places, all empty.
    pub(super) fn new(count: usize, invoke: I) -> Self {
        let places = std::iter::repeat_with(|| Box::pin(None)).take(count).collect();
        Self { invoke, places }
    }
}

#[allow(clippy::inline_always, reason = "the invocation becomes part of the device's loop")]
impl<W, F: Future, I: Fn(&W) -> F> Pool<W, F::Output> for Places<F, I> {
    #[inline(always)]
    fn set(&mut self, slot: usize, work: &W) {
        self.places[slot].set(Some((self.invoke)(work)));
    }

    #[inline(always)]
    fn poll(&mut self, slot: usize, context: &mut Context<'_>) -> Option<Poll<F::Output>> {
        let place = self.places.get_mut(slot)?;
        let polled = place.as_mut().as_pin_mut()?.poll(context);
        if polled.is_ready() {
            place.set(None);
        }
        Some(polled)
    }

    #[inline(always)]
    fn touch(&self, slot: usize) {
        if let Some(place) = self.places.get(slot) {
            black_box(place.is_some());
        }
    }
}

/// A pool without the type of its invocations.
impl<W, R> Pool<W, R> for Box<dyn Pool<W, R> + '_> {
    fn set(&mut self, slot: usize, work: &W) {
        (**self).set(slot, work);
    }

    fn poll(&mut self, slot: usize, context: &mut Context<'_>) -> Option<Poll<R>> {
        (**self).poll(slot, context)
    }

    fn touch(&self, slot: usize) {
        (**self).touch(slot);
    }
}

#[cfg(test)]
mod tests {
    use std::task::Waker;

    use super::*;

    #[test]
    fn a_place_is_empty_before_and_after_its_invocation() {
        let context = &mut Context::from_waker(Waker::noop());
        let twice = |&work: &u32| {
            let mut left = 1;
            std::future::poll_fn(move |_| {
                left -= 1;
                if left < 0 { Poll::Ready(work) } else { Poll::Pending }
            })
        };
        let mut pool: Box<dyn Pool<u32, u32>> = Box::new(Places::new(2, twice));
        for work in [5, 6] {
            assert_eq!(pool.poll(1, context), None, "empty");
            pool.set(1, &work);
            pool.touch(1);
            assert_eq!(pool.poll(1, context), Some(Poll::Pending));
            assert_eq!(pool.poll(0, context), None, "another place");
            assert_eq!(pool.poll(1, context), Some(Poll::Ready(work)));
        }
        pool.touch(2);
        assert_eq!(pool.poll(2, context), None, "no such place");
    }
}
