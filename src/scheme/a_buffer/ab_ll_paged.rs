//! A-buffer in per-pixel linked lists of pages (Crassin, "Linked lists of fragment pages", 2010; LL-Paged).
//!
//! A page holds four fragments, so that a pixel asks the frame's counter a quarter as often and its fragments lie
//! together. Slots are handed out under a lock per pixel: the fragment counter says which slot of the current page is
//! next, and an invocation that finds the page full takes a new one and links it to the old. The record itself is
//! written after the lock is free again: no other invocation has its slot, and none reads it before the barrier.
//!
//! The lock is released by an ordered store, since counter and page are read by its next holder (the published shader
//! spends an atomic exchange on that, says the k+-buffer paper; a plain store is fault M1). Where a pixel gets no page,
//! its counter is not raised.

use std::marker::PhantomData;

use crate::fragment::{Fragment, key};
use crate::memory::{Access, Atomic, Global, Layout, Memory, Order, Pixel, Plain, Snapshot, Words};
use crate::scheme::contract::Demand;
use crate::scheme::parts::list::NONE;
use crate::scheme::parts::lock::reach::{Reach, Updated, updated};
use crate::scheme::parts::lock::{self, FREE, SpinLock};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// Fragments of a page.
const PAGE: u32 = 4;

/// Words of a page: which page comes next, then depth and data of each fragment.
const WORDS: u64 = 1 + 2 * PAGE as u64;

/// The correct form, or a fault in it.
pub trait Variant: Send + Sync + 'static {
    /// This form's contract.
    const CONTRACT: Contract;
    /// How the lock's holder reaches counter and page.
    type Reach: Reach;
    /// Whether slots are taken under the lock.
    const LOCKED: bool = true;
    /// How the lock is released, if not as that way has it.
    const UNLOCK: Option<Access> = None;
    /// Whether the first page beyond the pool is refused.
    const BOUNDED: bool = true;
}

/// No fault.
#[derive(Debug)]
pub enum Correct {}

/// M1: the lock is released by a plain store, as published.
#[derive(Debug)]
pub enum PlainUnlock {}

/// M14: the bound test lets one page too many through. It shows only where the pool is too small, which ours is not.
#[derive(Debug)]
pub enum OneTooMany {}

/// Slot and page are taken without the lock: two fragments share a slot, and pages are lost.
#[derive(Debug)]
pub enum NoLock {}

/// The method.
#[derive(Debug)]
pub struct AbPagedList<V: Variant = Correct> {
    lock: SpinLock,
    counter: Words<Pixel, <V::Reach as Reach>::Kind, u32>,
    page: Words<Pixel, <V::Reach as Reach>::Kind, u32>,
    taken: Words<Global, Atomic, u32>,
    pages: Words<Global, Plain, u32>,
    capacity: u64,
    variant: PhantomData<V>,
}

const CONTRACT: Contract = Contract {
    title: "A-buffer in per-pixel linked lists of pages of 4",
    paper: "Crassin 2010b",
    section: "k+-buffer paper, 2 (LL-Paged)",
    words: "3",
    frame_words: "9Q + 1",
    exact_when: "the pool holds Q pages (it does)",
    needs: lock::NEEDS,
    wgsl: lock::WGSL,
    demand: Demand::Bounded,
    page: PAGE,
    source: include_str!("ab_ll_paged.rs"),
    ..super::linked("ab-ll-paged")
};

impl Variant for Correct {
    const CONTRACT: Contract = CONTRACT;
    type Reach = Plain;
}

impl Variant for Atomic {
    const CONTRACT: Contract =
        CONTRACT.mended("ab-ll-paged@atomic", "A-buffer in lists of pages, all of a pixel atomic");
    type Reach = Self;
}

impl Variant for Updated {
    const CONTRACT: Contract =
        updated(CONTRACT, "ab-ll-paged@rmw", "A-buffer in lists of pages, all of a pixel updates");
    type Reach = Self;
}

impl Variant for PlainUnlock {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll-paged@M1",
        "Fault M1: unlock by a plain store",
        "under sequential consistency only",
    );
    type Reach = Plain;
    const UNLOCK: Option<Access> = Some(Access::Plain);
}

impl Variant for OneTooMany {
    const CONTRACT: Contract = Contract {
        dependence: CONTRACT.dependence,
        ..CONTRACT.fault(
            "ab-ll-paged@M14",
            "Fault M14: the bound test lets one page too many through",
            CONTRACT.exact_when,
        )
    };
    type Reach = Plain;
    const BOUNDED: bool = false;
}

impl Variant for NoLock {
    const CONTRACT: Contract = CONTRACT.fault(
        "ab-ll-paged@no-lock",
        "Fault no-lock: slot and page are taken without the lock",
        "no two invocations of a pixel overlap",
    );
    type Reach = Plain;
    const LOCKED: bool = false;
}

impl<V: Variant> Scheme for AbPagedList<V> {
    const CONTRACT: Contract = V::CONTRACT;

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        let capacity = config.pages.min(u64::from(NONE));
        Self {
            lock: SpinLock::new(layout),
            counter: layout.named("counter").pixel(1),
            page: layout.named("page").pixel(1),
            taken: layout.named("taken").global(1),
            pages: layout.named("pages").global(WORDS * capacity),
            capacity,
            variant: PhantomData,
        }
    }

    async fn clear_frame<M: Memory>(&self, mem: &M) {
        mem.store(self.taken.at(0), 0, Order::Relaxed).await;
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        self.lock.clear(mem, pixel).await;
        mem.write(self.counter.at(pixel, 0), 0, V::Reach::SETTLED).await;
        mem.write(self.page.at(pixel, 0), NONE, V::Reach::SETTLED).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let pixel = fragment.pixel;
        let last = if V::BOUNDED { self.capacity } else { self.capacity + 1 };
        let _attempts = mem.block();
        let mark = mem.mark();
        loop {
            let attempt = mem.block();
            let found = if V::LOCKED {
                self.lock.try_acquire(mem, pixel, V::Reach::ACQUIRE).await
            } else {
                FREE
            };
            if found == FREE {
                let count = V::Reach::read(mem, self.counter.at(pixel, 0)).await;
                let mut page = V::Reach::read(mem, self.page.at(pixel, 0)).await;
                let mut room = true;
                if count % PAGE == 0 {
                    let new = mem.add(self.taken.at(0), 1, Order::Relaxed).await;
                    room = u64::from(new) < last;
                    if room {
                        mem.plain_store(self.pages.at(first(new)), page).await;
                        V::Reach::write(mem, self.page.at(pixel, 0), new).await;
                        page = new;
                    }
                }
                if room {
                    V::Reach::write(mem, self.counter.at(pixel, 0), count + 1).await;
                }
                if V::LOCKED {
                    match V::UNLOCK {
                        None => _ = V::Reach::release(mem, self.lock, pixel).await,
                        Some(access) => self.lock.release(mem, pixel, access).await,
                    }
                }
                if !room {
                    return Outcome::Pool;
                }
                let record = record(page, count % PAGE);
                mem.plain_store(self.pages.at(record), fragment.depth).await;
                mem.plain_store(self.pages.at(record + 1), fragment.data).await;
                return Outcome::Kept;
            }
            mem.merge(attempt).await;
            mem.spin(mark).await;
        }
    }

    /// In the end, the lock is free, and the pages are as many as the fragments need.
    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        let held = self.lock.is_held(words, pixel)?;
        let count = words.get(self.counter.at(pixel, 0));
        let (Moment::Quiet, Some(count)) = (moment, count) else { return Ok(()) };
        if held == Some(true) {
            return Err("no invocation holds the lock, but it is not free".to_owned());
        }
        let mut page = words.get(self.page.at(pixel, 0)).unwrap_or(NONE);
        let needed = count.div_ceil(PAGE);
        for number in 0..needed {
            if u64::from(page) >= self.capacity {
                return Err(format!("{number} pages instead of {needed}, then page {page}"));
            }
            let next = words.get(self.pages.at(first(page)));
            page = next.ok_or_else(|| format!("page {page}'s link was never written"))?;
        }
        if page == NONE { Ok(()) } else { Err(format!("more than {needed} pages: {page}")) }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mut left = mem.read(self.counter.at(pixel, 0), V::Reach::SETTLED).await;
        let mut page = mem.read(self.page.at(pixel, 0), V::Reach::SETTLED).await;
        // Only the current page can be partly full; only a faulty form has fewer pages than it needs.
        while left > 0 && page != NONE {
            let full = (left - 1) % PAGE + 1;
            for slot in 0..full {
                let record = record(page, slot);
                let depth = mem.plain_load(self.pages.at(record)).await;
                keys.push(key(depth, mem.plain_load(self.pages.at(record + 1)).await));
            }
            left -= full;
            page = mem.plain_load(self.pages.at(first(page))).await;
        }
    }
}

/// The first word of a page.
fn first(page: u32) -> u64 {
    WORDS * u64::from(page)
}

/// The first word of a record of a page.
fn record(page: u32, slot: u32) -> u64 {
    first(page) + 1 + 2 * u64::from(slot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scheme::parts::hand_made::HandMade;

    /// A pool of 3 pages: a pixel with so many fragments, its current page, and where each page leads to.
    fn list(count: u32, page: u32, next: &[u32]) -> HandMade<AbPagedList> {
        let config = Config { pixels: 1, pages: 3, ..Config::default() };
        let mut list = HandMade::<AbPagedList>::of(&config);
        let scheme = &list.scheme;
        let (lock, counter) = (scheme.lock.word(0), scheme.counter.at(0, 0));
        let (current, pages) = (scheme.page.at(0, 0), scheme.pages);
        list.set(lock, FREE);
        list.set(counter, count);
        list.set(current, page);
        for (number, &next) in (0..).zip(next) {
            list.set(pages.at(first(number)), next);
        }
        list
    }

    #[test]
    fn as_many_pages_as_needed_pass() {
        assert_eq!(list(0, NONE, &[]).check(Moment::Quiet), Ok(()));
        assert_eq!(list(4, 1, &[NONE, NONE]).check(Moment::Quiet), Ok(()));
        assert_eq!(list(9, 1, &[NONE, 2, 0]).check(Moment::Quiet), Ok(()));
        assert_eq!(list(9, 0, &[NONE]).check(Moment::Always), Ok(()), "checked in the end only");
    }

    #[test]
    fn other_numbers_of_pages_are_found() {
        let cases = [
            (list(5, 0, &[NONE]), "1 pages instead of 2"),
            (list(1, 3, &[]), "0 pages instead of 1, then page 3"),
            (list(4, 1, &[NONE, 0]), "more than 1 pages: 0"),
            (list(1, 1, &[NONE]), "page 1's link was never written"),
        ];
        for (list, words) in cases {
            let message = list.check(Moment::Quiet).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
        let mut held = list(0, NONE, &[]);
        held.set(held.scheme.lock.word(0), 1);
        assert!(held.check(Moment::Quiet).unwrap_err().contains("not free"));
    }
}
