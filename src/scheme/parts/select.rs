//! Selecting the k nearest of a pixel's keys.

/// Keep the `k` smallest, in any order.
pub fn nearest(keys: &mut Vec<u64>, k: usize) {
    if k < keys.len() {
        keys.select_nth_unstable(k);
        keys.truncate(k);
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
            nearest(&mut kept, k);
            kept.sort_unstable();
            expected.sort_unstable();
            expected.truncate(k);
            assert_eq!(kept, expected, "{k}");
        }
    }
}
