//! Where in the picture a pixel is.

/// How pixels lie, if not as they should.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::judge) enum Placement {
    /// The top row first, columns from the left.
    #[default]
    Right,
    /// The bottom row first.
    UpsideDown,
    /// Columns from the right.
    Mirrored,
    /// Both: turned by half a turn.
    Turned,
    /// Moved by whole pixels, right and down.
    Moved([i32; 2]),
}

impl Placement {
    /// All that are tried.
    pub(super) fn wrong() -> Vec<Self> {
        let mut all = vec![Self::UpsideDown, Self::Mirrored, Self::Turned];
        let ways = [-1, 0, 1].map(|dy| [-1, 0, 1].map(|dx| [dx, dy]));
        all.extend(ways.into_iter().flatten().filter(|way| *way != [0, 0]).map(Self::Moved));
        all
    }

    /// The pixel of the right picture that is seen at `pixel`, both counted row by row; none if it lies outside.
    #[inline]
    pub(in crate::judge) fn source(self, pixel: usize, [width, height]: [u32; 2]) -> Option<usize> {
        let (w, h) = (width as usize, height as usize);
        let (x, y) = (pixel % w, pixel / w);
        let (x, y) = match self {
            Self::Right => return Some(pixel),
            Self::UpsideDown => (x, h - 1 - y),
            Self::Mirrored => (w - 1 - x, y),
            Self::Turned => (w - 1 - x, h - 1 - y),
            Self::Moved([dx, dy]) => {
                let from = |v: usize, d: i32, most: usize| {
                    v.checked_add_signed(-(d as isize)).filter(|&v| v < most)
                };
                (from(x, dx, w)?, from(y, dy, h)?)
            }
        };
        Some(y * w + x)
    }

    pub(super) fn name(self) -> String {
        let text = match self {
            Self::Right => "",
            Self::UpsideDown => "the picture were upside down",
            Self::Mirrored => "the picture were mirrored, left to right",
            Self::Turned => "the picture were turned by half a turn",
            Self::Moved([dx, dy]) => {
                let across = ["", "a pixel left", "a pixel right"];
                let down = ["", "a pixel up", "a pixel down"];
                let pick = |d: i32| match d {
                    0 => 0,
                    d if d < 0 => 1,
                    _ => 2,
                };
                let ways = [across[pick(dx)], down[pick(dy)]];
                let ways: Vec<&str> = ways.into_iter().filter(|way| !way.is_empty()).collect();
                return format!("everything were {}", ways.join(" and "));
            }
        };
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_from_where_they_should() {
        let size = [3, 2];
        let sources = |placement: Placement| {
            (0..6).map(|pixel| placement.source(pixel, size)).collect::<Vec<_>>()
        };
        let some = |places: [usize; 6]| places.map(Some).to_vec();
        assert_eq!(sources(Placement::Right), some([0, 1, 2, 3, 4, 5]));
        assert_eq!(sources(Placement::UpsideDown), some([3, 4, 5, 0, 1, 2]));
        assert_eq!(sources(Placement::Mirrored), some([2, 1, 0, 5, 4, 3]));
        assert_eq!(sources(Placement::Turned), some([5, 4, 3, 2, 1, 0]));
        let right = sources(Placement::Moved([1, 0]));
        assert_eq!(right, [None, Some(0), Some(1), None, Some(3), Some(4)]);
        let up = sources(Placement::Moved([0, -1]));
        assert_eq!(up, [Some(3), Some(4), Some(5), None, None, None]);
        assert_eq!(Placement::wrong().len(), 11);
    }
}
