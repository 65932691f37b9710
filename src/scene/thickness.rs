//! How thick surfaces are taken to be, for methods that merge what lies close together (z-thickness: "Fragment merging
//! with z-thickness", section 4.1.3).

use std::fmt;

/// How far a surface reaches from its depth towards the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Thickness {
    /// This many times the precision of 24-bit depths at that place, P(z) (equation 9): 256 depth codes each.
    Precision(f64),
    /// World units along the line of sight.
    World(f64),
}

impl Default for Thickness {
    /// Twice the precision, as published.
    fn default() -> Self {
        Self::Precision(2.0)
    }
}

impl fmt::Display for Thickness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Precision(times) => write!(f, "{times}x"),
            Self::World(units) => write!(f, "{units}"),
        }
    }
}

impl Thickness {
    /// From text: `10x` is ten times the precision, `0.02` is world units.
    ///
    /// # Errors
    /// What would be right: both must be numbers from 0 up.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (number, times) = match text.strip_suffix('x') {
            Some(number) => (number, true),
            None => (text, false),
        };
        let value: f64 = number.trim().parse().map_err(|_| wrong(text))?;
        let thickness = if times { Self::Precision(value) } else { Self::World(value) };
        if thickness.is_valid() { Ok(thickness) } else { Err(wrong(text)) }
    }

    /// Whether it is a finite number from 0 up.
    #[must_use]
    pub fn is_valid(self) -> bool {
        let (Self::Precision(value) | Self::World(value)) = self;
        value.is_finite() && value >= 0.0
    }
}

fn wrong(text: &str) -> String {
    format!(
        "{text:?} must be 0 or more: times the depth precision, like 10x, or world units, like 0.02"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts() {
        assert_eq!(Thickness::parse("10x"), Ok(Thickness::Precision(10.0)));
        assert_eq!(Thickness::parse("0.02"), Ok(Thickness::World(0.02)));
        assert_eq!(Thickness::parse("0"), Ok(Thickness::World(0.0)));
        for bad in ["", "x", "-1", "-2x", "NaN", "NaNx", "inf", "1e999x", "10 y", "é"] {
            assert!(Thickness::parse(bad).is_err(), "{bad}");
        }
        for thickness in [Thickness::Precision(2.5), Thickness::World(0.125)] {
            assert_eq!(Thickness::parse(&thickness.to_string()), Ok(thickness));
        }
    }
}
