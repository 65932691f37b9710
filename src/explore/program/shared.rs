//! A table that only grows, and that several machines look things up in.
//!
//! While there are several, it does not grow: one that needs more than is there has *missed* it, and nothing that it
//! did since counts. So numbers that a table gives out do not depend on which machine was there first.

use std::ops::Deref;
use std::sync::Arc;

/// A table. A clone is the same table.
#[derive(Debug)]
pub(in crate::explore) struct Shared<T> {
    table: Arc<T>,
    missed: bool,
}

impl<T> Shared<T> {
    /// A table that nobody else has.
    pub(in crate::explore) fn new(table: T) -> Self {
        Self { table: Arc::new(table), missed: false }
    }

    /// Let it grow; `None`, and missed, if others have it, too.
    pub(in crate::explore) fn grow<R>(&mut self, by: impl FnOnce(&mut T) -> R) -> Option<R> {
        let grown = Arc::get_mut(&mut self.table).map(by);
        self.missed |= grown.is_none();
        grown
    }

    /// Whether something was missed.
    pub(in crate::explore) fn has_missed(&self) -> bool {
        self.missed
    }

    /// The same; from now on nothing was.
    pub(in crate::explore) fn take_missed(&mut self) -> bool {
        std::mem::take(&mut self.missed)
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self { table: Arc::clone(&self.table), missed: false }
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        &self.table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_grows_in_the_hands_of_one() {
        let mut one = Shared::new(vec![1]);
        assert_eq!(one.grow(|table| table.push(2)), Some(()));
        let mut other = one.clone();
        assert_eq!((one.grow(|table| table.push(3)), one.take_missed()), (None, true));
        assert_eq!((one.has_missed(), other.has_missed()), (false, false), "each for itself");
        assert_eq!(other.grow(|table| table.len()), None);
        assert!(other.has_missed());
        drop(other);
        assert_eq!(one.grow(|table| table.push(4)), Some(()));
        assert_eq!((&**one, one.has_missed()), (&[1, 2, 4][..], false));
    }
}
