//! Transfer functions: from a value of 0 to 1 to a colour and an opacity.

use crate::scene::model::Unplaced;

/// Value, linear straight red, green and blue, and opacity per step unit, each 0 to 1.
type Point = [f64; 5];

/// A transfer function that has a name.
#[derive(Clone, Copy, Debug)]
pub struct Named {
    /// The name.
    pub name: &'static str,
    points: &'static [Point],
}

/// All that have one.
pub const NAMED: [Named; 4] = [
    Named { name: "grey", points: &[[0.0, 0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0, 0.95]] },
    Named { name: "mist", points: &[[0.0, 0.8, 0.85, 0.9, 0.0], [1.0, 0.8, 0.85, 0.9, 0.95]] },
    Named {
        name: "fire",
        points: &[
            [0.0, 0.0, 0.0, 0.0, 0.0],
            [0.35, 0.5, 0.02, 0.0, 0.4],
            [0.7, 1.0, 0.35, 0.02, 0.8],
            [1.0, 1.0, 0.95, 0.6, 0.98],
        ],
    },
    Named {
        name: "cool-warm",
        points: &[
            [0.0, 0.04, 0.07, 0.53, 0.0],
            [0.5, 0.72, 0.72, 0.72, 0.5],
            [1.0, 0.46, 0.0, 0.02, 0.95],
        ],
    },
];

/// Piecewise linear in the value. Two points of one value make a step there, up from the second.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    points: Vec<Point>,
}

impl Transfer {
    /// The one of a name.
    ///
    /// # Errors
    /// Lists the names.
    pub fn named(name: &str) -> Unplaced<Self> {
        let known = NAMED.iter().find(|named| named.name == name);
        known.map(|named| Self { points: named.points.to_vec() }).ok_or_else(|| {
            let names = NAMED.map(|named| named.name).join(", ");
            format!("transfer: {name:?} is none of {names}, and no list of [value, r, g, b, a]")
        })
    }

    /// From points: value, red, green, blue and opacity.
    ///
    /// # Errors
    /// No point, a number outside of 0 to 1, or values that fall.
    pub fn new(points: &[[f64; 5]]) -> Unplaced<Self> {
        if points.is_empty() {
            return Err("transfer: needs at least one [value, r, g, b, a]".to_owned());
        }
        for (i, point) in points.iter().enumerate() {
            if !point.iter().all(|x| (0.0..=1.0).contains(x)) {
                return Err(format!("transfer[{i}]: {point:?} must be five numbers, each 0 to 1"));
            }
        }
        match points.windows(2).position(|pair| pair[0][0] > pair[1][0]) {
            Some(i) => Err(format!("transfer[{}]: values must not fall", i + 1)),
            None => Ok(Self { points: points.to_vec() }),
        }
    }

    /// Straight linear colour and opacity of a value, 0 to 1.
    #[inline]
    #[must_use]
    pub fn at(&self, value: f64) -> [f64; 4] {
        let next = self.points.partition_point(|point| point[0] <= value);
        let (Some(from), Some(to)) = (next.checked_sub(1), self.points.get(next)) else {
            let end = self.points[next.saturating_sub(1)];
            return [end[1], end[2], end[3], end[4]];
        };
        let from = self.points[from];
        let share = (value - from[0]) / (to[0] - from[0]);
        std::array::from_fn(|i| from[i + 1] + (to[i + 1] - from[i + 1]) * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_joined_by_lines() {
        let points = [[0.25, 0.0, 0.5, 1.0, 0.0], [0.75, 1.0, 0.5, 0.0, 0.5]];
        let transfer = Transfer::new(&points).unwrap();
        assert_eq!(transfer.at(0.0), [0.0, 0.5, 1.0, 0.0]);
        assert_eq!(transfer.at(0.25), [0.0, 0.5, 1.0, 0.0]);
        assert_eq!(transfer.at(0.375), [0.25, 0.5, 0.75, 0.125]);
        assert_eq!(transfer.at(0.75), [1.0, 0.5, 0.0, 0.5]);
        assert_eq!(transfer.at(1.0), [1.0, 0.5, 0.0, 0.5]);
        let step = Transfer::new(&[[0.0; 5], [0.5, 0.0, 0.0, 0.0, 0.0], [0.5, 1.0, 1.0, 1.0, 1.0]]);
        assert_eq!(step.as_ref().unwrap().at(0.49), [0.0; 4]);
        assert_eq!(step.unwrap().at(0.5), [1.0; 4]);
    }

    #[test]
    fn named_ones_are_valid_and_others_are_told() {
        for named in NAMED {
            assert!(Transfer::new(named.points).is_ok(), "{}", named.name);
            assert!(named.points[0][4] == 0.0, "{}: nothing is empty", named.name);
        }
        let error = Transfer::named("gray").unwrap_err();
        assert!(error.contains("grey, mist, fire, cool-warm"), "{error}");
        assert!(Transfer::new(&[]).is_err());
        assert!(Transfer::new(&[[0.0, 0.0, 0.0, 0.0, f64::NAN]]).is_err());
        assert!(Transfer::new(&[[1.0; 5], [0.0; 5]]).is_err());
    }
}
