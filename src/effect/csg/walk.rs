//! One pixel's walk: where a Boolean expression over its objects changes.

use super::Expression;
use crate::fragment::{data_of, depth_of};

/// A surface of the combination.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// The fragment: of those at this depth, the first whose object is entered or left here.
    pub key: u64,
    /// The expression's value behind it.
    pub inside: bool,
}

/// Call `change` for every surface along a pixel's sorted keys. `bit` is the place of a data word's object in the
/// expression, if it has one. The result has a bit for every object that is not left as often as it is entered.
pub fn walk(
    expression: &Expression,
    keys: &[u64],
    bit: impl Fn(u32) -> Option<u32>,
    mut change: impl FnMut(Change),
) -> u64 {
    let mut stack = Vec::new();
    let mut inside = 0u64;
    let mut value = expression.evaluate_on(inside, &mut stack);
    let turn = |key: &u64| bit(data_of(*key)).map_or(0, |bit| 1u64 << bit);
    for run in keys.chunk_by(|&a, &b| depth_of(a) == depth_of(b)) {
        let turned = run.iter().fold(0, |turned, key| turned ^ turn(key));
        if turned == 0 {
            continue;
        }
        inside ^= turned;
        let now = expression.evaluate_on(inside, &mut stack);
        if now != value {
            value = now;
            let of_it = run.iter().find(|key| turn(key) & turned != 0);
            change(Change { key: *of_it.unwrap_or(&run[0]), inside: now });
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fragment::key;

    fn changes(text: &str, keys: &[u64]) -> (Vec<(u32, u32, bool)>, u64) {
        let mut found = Vec::new();
        let expression = Expression::parse(text).unwrap();
        let odd = walk(
            &expression,
            keys,
            |data| (data < 2).then_some(data),
            |c| {
                found.push((depth_of(c.key), data_of(c.key), c.inside));
            },
        );
        (found, odd)
    }

    #[test]
    fn boxes_face_to_face() {
        // a from 1 to 3, b from 3 to 5: one solid together, and nothing to cut away.
        let keys = [key(1, 0), key(3, 0), key(3, 1), key(5, 1)];
        assert_eq!(changes("a | b", &keys), (vec![(1, 0, true), (5, 1, false)], 0));
        assert_eq!(changes("a & b", &[key(1, 0), key(3, 0), key(3, 1), key(5, 1)]).0, []);
        assert_eq!(changes("a - b", &keys).0, [(1, 0, true), (3, 0, false)]);
    }

    #[test]
    fn what_does_not_turn_is_passed() {
        // An edge of a, seen twice at one depth, and an object of no name.
        let keys = [key(1, 7), key(2, 0), key(2, 0), key(2, 1), key(4, 1), key(6, 0)];
        assert_eq!(changes("a | b", &keys), (vec![(2, 1, true), (4, 1, false), (6, 0, true)], 1));
    }

    #[test]
    fn the_eye_may_be_inside() {
        assert_eq!(changes("~a & ~b", &[key(1, 0), key(3, 0)]).0, [(1, 0, false), (3, 0, true)]);
    }
}
