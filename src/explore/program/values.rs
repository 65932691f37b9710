//! Which depths and data words an instance has. An instance is a pattern of order and equality; a method that compares
//! values otherwise than it should (their upper bits, or as floats) may be right for some values of a pattern and wrong
//! for others. So every pattern is also explored with values that lie close together, or at the ends of their range.

use super::litmus::{Entry, Litmus};
use crate::fragment::key;
use crate::num::depth::{FARTHEST, Format};
use crate::scheme::Contract;
use crate::scheme::contract::Keeps;

/// A choice of values for the levels of a pattern.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// What is special about them.
    pub name: &'static str,
    /// The depth code of a level, from 0, of so many; codes are multiples of the third.
    depth: fn(u32, u32, u32) -> u32,
    /// A data word: of the level, the number among the data of that level, and the number among all.
    data: fn(Place) -> u32,
}

/// Where a fragment stands in its pattern.
#[derive(Clone, Copy)]
struct Place {
    /// Its number among the distinct data of its level.
    of_level: u32,
    /// Its number among the distinct (depth, data).
    of_all: u32,
    /// Its depth.
    depth: u32,
}

/// All interleavings are explored with these, beside the values that instances are made with: codes whose upper 24 bits
/// and whose roundings to f32 are equal, with the upper bit set; the data words 0 and all ones.
pub const CLOSE: Values = Values {
    name: "close",
    depth: |level, _, step| (1 << 31) + (level + 1) * step,
    data: |place| ends(place.of_all),
};

/// All orders of arrival, one invocation after another, are explored with these.
pub const OTHERS: [Values; 8] = [
    Values {
        name: "adjacent, across 2^31; equal data at all depths",
        depth: |level, _, step| (1 << 31) - 2 * step + level * step,
        data: |place| 0x10 + place.of_level,
    },
    Values {
        name: "equal upper 16 bits; data one bit apart",
        depth: |level, _, _| 0x1234_0000 + (level + 1) * 0x100,
        data: |place| 0x40 ^ (1 << place.of_all),
    },
    Values {
        name: "equal upper 24 bits; data one bit apart, the upper one set",
        depth: |level, _, step| 0x1234_5600 + level * step,
        data: |place| (1 << 31) ^ (1 << place.of_all),
    },
    Values {
        name: "around the rounding of f32; data 0 and all ones",
        depth: |level, _, step| (1 << 24) - step + level * step,
        data: |place| ends(place.of_all + 1),
    },
    Values {
        name: "0 and adjacent; data from 0 at all depths",
        depth: |level, _, step| level * step,
        data: |place| place.of_level,
    },
    Values {
        name: "the far plane and adjacent; data up to all ones at all depths",
        depth: |level, levels, step| FARTHEST - (levels - 1 - level) * step,
        data: |place| u32::MAX - place.of_level,
    },
    Values {
        name: "lower bits in the opposite order; data like the depth",
        depth: |level, levels, step| (level << 28) + (levels - level) * step,
        data: |place| place.depth.wrapping_add(place.of_level),
    },
    Values {
        name: "0 and the far plane; data all ones and 0",
        depth: |level, levels, step| match level {
            0 => 0,
            _ => FARTHEST - (levels - 1 - level) * step,
        },
        data: |place| !ends(place.of_all),
    },
];

/// 0, all ones, 1, all ones but one, 2 ...
fn ends(number: u32) -> u32 {
    if number.is_multiple_of(2) { number / 2 } else { u32::MAX - number / 2 }
}

impl Values {
    /// An instance's pattern with these values; `None` if it has none of them to change. Data words stay where they
    /// mean something: a colour, or a place in an input.
    #[must_use]
    pub fn of(&self, litmus: &Litmus, contract: &Contract) -> Option<Litmus> {
        let format = contract.depth_format.unwrap_or(Format::D32);
        let step = if format == Format::D32 { 1 } else { 256 };
        let mut depths: Vec<u32> = litmus.fragments.iter().map(|f| f.1).collect();
        depths.sort_unstable();
        depths.dedup();
        let mut keys: Vec<u64> = litmus.fragments.iter().map(|f| key(f.1, f.2)).collect();
        keys.sort_unstable();
        keys.dedup();
        let named = contract.keeps == Keeps::Visible
            || contract.data.is_some()
            || !litmus.inputs.is_empty();
        let new = |&Entry(pixel, depth, data, thickness): &Entry| {
            let level = depths.partition_point(|&d| d < depth) as u32;
            let code = (self.depth)(level, depths.len() as u32, step);
            let number = |key: u64| keys.partition_point(|&k| k < key) as u32;
            let of_all = number(key(depth, data));
            let of_level = of_all - number(key(depth, 0));
            let depth = format.encode(code);
            let new = (self.data)(Place { of_level, of_all, depth });
            Entry(pixel, depth, if named { data } else { new }, thickness)
        };
        let fragments: Vec<_> = litmus.fragments.iter().map(new).collect();
        let other = Litmus { fragments, ..litmus.clone() };
        (other != *litmus).then_some(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue;
    use crate::explore::program::instances::{Family, instances};
    use crate::explore::program::subject::Subject;

    /// Values change, the pattern of order and equality does not, in any format of depths.
    #[test]
    fn values_keep_the_pattern() {
        let family = Family { fragments: 4, ks: vec![2], helpers: 0 };
        for method in ["kplus-array", "kb-mdt32", "ab-ll", "ha32", "ha64"] {
            let subject =
                Subject::new(catalogue::method(method).expect("known")).expect("a scheme");
            let mut made = 0;
            for litmus in instances(&subject, &family) {
                for values in [CLOSE].iter().chain(&OTHERS) {
                    let Some(other) = values.of(&litmus, subject.contract) else { continue };
                    made += 1;
                    let name = format!("{method}, {}: {}", values.name, other.describe());
                    for (a, x) in litmus.fragments.iter().zip(&other.fragments) {
                        for (b, y) in litmus.fragments.iter().zip(&other.fragments) {
                            assert_eq!(a.1.cmp(&b.1), x.1.cmp(&y.1), "depths of {name}");
                            assert!(a.1 != b.1 || (a.2 == b.2) == (x.2 == y.2), "data of {name}");
                        }
                    }
                    assert!(other.fragments.iter().all(|f| f.1 != u32::MAX), "{name}");
                }
            }
            assert!(made > 100, "{method}: {made}");
        }
    }

    /// What a faulty comparison would take for equal is among them.
    #[test]
    fn close_codes_are_equal_to_who_looks_at_less() {
        let [a, b] = [0, 1].map(|level| (CLOSE.depth)(level, 2, 1));
        assert_eq!((a >> 8, (a as f32).to_bits()), (b >> 8, (b as f32).to_bits()));
        assert!(a < b && (a as i32) < 0);
        let across = [0, 1, 2].map(|level| (OTHERS[0].depth)(level, 3, 1));
        assert!((across[1] as i32) > (across[2] as i32), "compared with a sign");
        assert_eq!([0, 1, 2, 3].map(ends), [0, u32::MAX, 1, u32::MAX - 1]);
    }
}
