//! Storage that is kept from one frame to the next, so that the system need not hand out its pages again.
//!
//! What is reused holds what the frame before left there. No scheme may rely on more: a clear pass writes what its
//! method reads. A faulty scheme that reads other words may see another frame's, so what must be repeated bit for bit
//! starts with storage of its own ([`Reuse::default`]).

use std::sync::Mutex;

use super::arena::{Owned, Shared};
use super::layout::Sizes;

/// Storage that is not in use.
#[derive(Debug, Default)]
pub struct Reuse {
    shared: Mutex<Vec<Shared>>,
    owned: Mutex<Vec<Owned>>,
}

fn take<T>(all: &Mutex<Vec<T>>, fits: impl Fn(&T) -> bool) -> Option<T> {
    let mut all = all.lock().ok()?;
    let place = all.iter().position(fits)?;
    Some(all.swap_remove(place))
}

fn keep<T>(all: &Mutex<Vec<T>>, one: T) {
    if let Ok(mut all) = all.lock() {
        all.push(one);
    }
}

impl Reuse {
    /// So many records of the given sizes, for many threads: of a frame before, or new and zero.
    #[must_use]
    pub fn shared(&self, sizes: Sizes, records: usize) -> Shared {
        match take(&self.shared, |shared| shared.has(sizes, records)) {
            Some(shared) => shared.again(),
            None => Shared::new(sizes, records),
        }
    }

    /// The same, for one thread.
    #[must_use]
    pub fn owned(&self, sizes: Sizes, records: usize) -> Owned {
        match take(&self.owned, |owned| owned.has(sizes, records)) {
            Some(owned) => owned.again(),
            None => Owned::new(sizes, records),
        }
    }

    /// Keep storage for the next frame.
    pub fn keep_shared(&self, shared: Shared) {
        keep(&self.shared, shared);
    }

    /// The same, for one thread.
    pub fn keep_owned(&self, owned: Owned) {
        keep(&self.owned, owned);
    }

    /// Give everything back that is not in use: before a frame of other sizes.
    pub fn forget(&self) {
        if let Ok(mut shared) = self.shared.lock() {
            shared.clear();
        }
        if let Ok(mut owned) = self.owned.lock() {
            owned.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(words32: u64) -> Sizes {
        Sizes { words32, words64: 1 }
    }

    #[test]
    fn storage_comes_back_if_it_fits() {
        let reuse = Reuse::default();
        let owned = reuse.owned(sizes(2), 3);
        owned.fill(7);
        owned.miss();
        reuse.keep_owned(owned);
        assert_eq!(reuse.owned(sizes(1), 3).all().0, [0; 3], "another size is new");
        assert_eq!(reuse.owned(sizes(2), 2).all().0, [0; 4]);
        let again = reuse.owned(sizes(2), 3);
        assert_eq!((again.all().0, again.outside()), (vec![7; 6], 0));
        assert_eq!(reuse.owned(sizes(2), 3).all().0, [0; 6], "it is in use");
        reuse.keep_owned(again);
        reuse.forget();
        assert_eq!(reuse.owned(sizes(2), 3).all().0, [0; 6], "it was given back");
    }
}
