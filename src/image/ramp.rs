//! The heat map's colours: a difference of 0..=255 becomes a colour by integer interpolation between named
//! anchors. Zero stands apart, near black, so that "equal" and "differs by one" are never confused.

/// No difference at all.
pub const EQUAL: [u8; 3] = [14, 14, 18];

/// The differences at which the colour is given, with the colours; lightness rises throughout.
pub const ANCHORS: [(u8, [u8; 3]); 5] =
    [(1, INDIGO), (32, VIOLET), (96, VERMILION), (176, AMBER), (255, IVORY)];

const INDIGO: [u8; 3] = [62, 60, 178];
const VIOLET: [u8; 3] = [156, 50, 168];
const VERMILION: [u8; 3] = [226, 82, 68];
const AMBER: [u8; 3] = [250, 176, 46];
const IVORY: [u8; 3] = [255, 252, 214];

/// The colour of a difference.
#[must_use]
pub fn color(difference: u8) -> [u8; 3] {
    if difference == 0 {
        return EQUAL;
    }
    let above = ANCHORS.partition_point(|&(at, _)| at < difference);
    let (high, end) = ANCHORS[above];
    if high == difference {
        return end;
    }
    let (low, start) = ANCHORS[above - 1];
    let (part, whole) = (u32::from(difference - low), u32::from(high - low));
    std::array::from_fn(|c| {
        let sum = u32::from(start[c]) * (whole - part) + u32::from(end[c]) * part;
        ((sum + whole / 2) / whole) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_and_anchors_are_hit() {
        assert_eq!((color(0), color(1), color(255)), (EQUAL, INDIGO, IVORY));
        assert!(ANCHORS.iter().all(|&(at, expected)| color(at) == expected));
    }

    #[test]
    fn lightness_rises_and_one_is_far_from_zero() {
        let light = |d| color(d).iter().zip([3, 6, 1]).map(|(&c, w)| u32::from(c) * w).sum::<u32>();
        assert!((1..=255).all(|d| light(d - 1) <= light(d)));
        assert!(light(1) > light(0) + 400);
    }
}
