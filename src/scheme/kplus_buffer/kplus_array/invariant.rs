//! What holds of a max-array's words at every moment, and what more when the lock is free.

use super::{KPlusArray, Reach, pair_key};
use crate::memory::Snapshot;
use crate::scheme::Moment;

impl<R: Reach> KPlusArray<R> {
    /// The lock is free or taken, and free in the end; the counter does not exceed k; while the lock is free, entry 0
    /// is the farthest of those counted.
    pub(super) fn check(
        &self,
        words: &Snapshot<'_>,
        pixel: u32,
        moment: Moment,
    ) -> Result<(), String> {
        let held = self.lock.is_held(words, pixel)?;
        if moment == Moment::Quiet && held == Some(true) {
            return Err("the lock is held after the last invocation".to_owned());
        }
        let Some(count) = words.get(self.counter.at(pixel, 0)) else { return Ok(()) };
        if count > self.k {
            return Err(format!("the counter is {count}, of {} entries", self.k));
        }
        if held == Some(false) { self.check_first(words, pixel, count) } else { Ok(()) }
    }

    fn check_first(&self, words: &Snapshot<'_>, pixel: u32, count: u32) -> Result<(), String> {
        let entry = |i| {
            let depth = words.get(self.depth.at(pixel, i))?;
            Some(pair_key((depth, words.get(self.data.at(pixel, i))?)))
        };
        let known: Option<Vec<u64>> = (0..count).map(entry).collect();
        let Some([first, others @ ..]) = known.as_deref() else { return Ok(()) };
        match (1..).zip(others).find(|(_, entry)| *entry > first) {
            None => Ok(()),
            Some((i, entry)) => Err(format!(
                "the lock is free, but entry {i} ({entry:016x}) is farther than entry 0 ({first:016x})"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{KPlusArray, data_of, depth_of, key};
    use crate::scheme::Moment::{Always, Quiet};
    use crate::scheme::parts::hand_made::HandMade;
    use crate::scheme::parts::lock::FREE;

    /// k = 3, with the lock's word, the counter and as many entries as are given.
    fn pixel(lock: u32, count: u32, entries: &[u64]) -> HandMade<KPlusArray> {
        let mut pixel = HandMade::<KPlusArray>::new(Some(3), 0);
        let (word, counter) = (pixel.scheme.lock.word(0), pixel.scheme.counter.at(0, 0));
        pixel.set(word, lock);
        pixel.set(counter, count);
        for (i, &entry) in (0..).zip(entries) {
            let (depth, data) = (pixel.scheme.depth.at(0, i), pixel.scheme.data.at(0, i));
            pixel.set(depth, depth_of(entry));
            pixel.set(data, data_of(entry));
        }
        pixel
    }

    #[test]
    fn what_is_in_order_passes() {
        assert_eq!(
            HandMade::<KPlusArray>::new(Some(3), 0).check(Always),
            Ok(()),
            "nothing written"
        );
        for entries in [&[][..], &[7], &[key(9, 2), key(9, 1), 3]] {
            let pixel = pixel(FREE, entries.len() as u32, entries);
            assert_eq!(pixel.check(Always), Ok(()));
            assert_eq!(pixel.check(Quiet), Ok(()));
        }
    }

    #[test]
    fn the_lock_is_free_or_taken_and_free_in_the_end() {
        assert_eq!(pixel(1, 0, &[]).check(Always), Ok(()));
        assert!(pixel(1, 0, &[]).check(Quiet).unwrap_err().contains("held"));
        assert!(pixel(2, 0, &[]).check(Always).unwrap_err().contains("the lock holds 2"));
    }

    #[test]
    fn the_counter_stays_within_k() {
        let message = pixel(1, 4, &[]).check(Always).unwrap_err();
        assert!(message.contains("the counter is 4"), "{message}");
    }

    #[test]
    fn entry_0_is_the_farthest_while_the_lock_is_free() {
        let wrong = [key(9, 1), key(9, 2), 3];
        let message = pixel(FREE, 3, &wrong).check(Always).unwrap_err();
        assert!(message.contains("entry 1") && message.contains("farther"), "{message}");
        assert_eq!(pixel(1, 3, &wrong).check(Always), Ok(()), "the holder is at work");
        assert_eq!(pixel(FREE, 1, &wrong).check(Always), Ok(()), "only what is counted");
        assert_eq!(pixel(FREE, 3, &wrong[..2]).check(Always), Ok(()), "only what is known");
    }
}
