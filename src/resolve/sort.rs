//! Sorting a pixel's keys into canonical order, front to back. Equal keys are identical fragments, so any correct sort
//! gives the same list.

/// Up to here insertion sort is the faster one.
const INSERTION: usize = 20;

/// Sort ascending.
#[inline]
pub fn canonical(keys: &mut [u64]) {
    if keys.len() <= INSERTION { insertion(keys) } else { keys.sort_unstable() }
}

fn insertion(keys: &mut [u64]) {
    for i in 1..keys.len() {
        let key = keys[i];
        let mut place = i;
        while place > 0 && keys[place - 1] > key {
            keys[place] = keys[place - 1];
            place -= 1;
        }
        keys[place] = key;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::Random;

    #[test]
    fn sorts_like_the_standard_library() {
        let mut random = Random::new(3, 0);
        for len in 0..80 {
            let mut keys: Vec<u64> = (0..len).map(|_| random.below(40)).collect();
            let mut expected = keys.clone();
            expected.sort();
            canonical(&mut keys);
            assert_eq!(keys, expected);
        }
    }
}
