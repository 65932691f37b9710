//! Selecting the k nearest of a pixel's keys.

/// From number `first` on, keep the `k` smallest, in any order; those before stay as they are.
pub fn nearest(keys: &mut Vec<u64>, first: usize, k: usize) {
    if k < keys.len() - first {
        keys[first..].select_nth_unstable(k);
        keys.truncate(first + k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_are_kept() {
        let keys = [9, 3, 3, 7, 1, 8, 3, 2];
        for k in 0..10 {
            let (mut kept, mut expected) = (keys.to_vec(), keys.to_vec());
            kept.splice(0..0, [5, 4]);
            nearest(&mut kept, 2, k);
            assert_eq!(kept.drain(..2).collect::<Vec<_>>(), [5, 4]);
            kept.sort_unstable();
            expected.sort_unstable();
            expected.truncate(k);
            assert_eq!(kept, expected, "{k}");
        }
    }
}
