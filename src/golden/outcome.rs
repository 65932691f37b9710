//! What became of an entry.

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::image::{Image, difference};
use crate::report::text::thousands;

/// What was found of an entry; the worst comes last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// All is as recorded.
    Same,
    /// It was not as recorded, and now is what the manifest says (`--bless`).
    Blessed,
    /// A file that it was drawn from has changed, so nothing is said of the drawing.
    InputChanged,
    /// Another version of the program recorded it, and now something else is drawn.
    ProgramChanged,
    /// Something else is drawn from the same files by the same version.
    Different,
    /// The scene, a file that it names, the golden picture or its record is not there.
    Missing,
    /// It cannot be drawn.
    Error,
}

impl Status {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Blessed => "blessed",
            Self::InputChanged => "input-changed",
            Self::ProgramChanged => "program-changed",
            Self::Different => "different",
            Self::Missing => "missing",
            Self::Error => "error",
        }
    }

    /// Whether nothing is left to do.
    #[must_use]
    pub fn is_clean(self) -> bool {
        matches!(self, Self::Same | Self::Blessed)
    }
}

/// What was found of an entry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outcome {
    /// The entry's name.
    pub name: String,
    /// What was found.
    pub status: Status,
    /// The same in words; empty if all is as recorded.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
    /// The files that changed, as the manifest names them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<String>,
    /// The results that are not as recorded: `generated`, `kept`, `fragments_hash`, `image_hash`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub results: Vec<String>,
    /// How far the picture is from the golden one, if both are there, as large, and different.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difference: Option<Apart>,
    /// The heat map that was written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// How long it took.
    pub seconds: f64,
}

impl Outcome {
    /// Of an entry, with nothing but its status and the words for it.
    #[must_use]
    pub fn new(name: &str, status: Status, why: impl Into<String>) -> Self {
        Self {
            name: name.to_owned(),
            status,
            why: why.into(),
            inputs: Vec::new(),
            results: Vec::new(),
            difference: None,
            map: None,
            seconds: 0.0,
        }
    }
}

/// How two pictures of one size differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Apart {
    /// Pixels of each.
    pub pixels: u64,
    /// Pixels that differ in any channel.
    pub differing: u64,
    /// The largest difference of a channel, 1 to 255.
    pub max: u8,
    /// Column and row of the first pixel, row by row, that differs.
    pub first: [u32; 2],
}

impl Apart {
    /// Of two pictures of one size; `None` if they are equal.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn of(one: &Image, other: &Image) -> Result<Option<Self>> {
        let map = difference::map(one, other)?;
        let Some(first) = map.iter().position(|&d| d > 0) else { return Ok(None) };
        let width = one.width as usize;
        Ok(Some(Self {
            pixels: map.len() as u64,
            differing: map.iter().filter(|&&d| d > 0).count() as u64,
            max: map.iter().copied().fold(0, u8::max),
            first: [first % width, first / width].map(|place| place as u32),
        }))
    }

    /// In words.
    #[must_use]
    pub fn text(&self) -> String {
        let [differing, pixels] = [self.differing, self.pixels].map(thousands);
        let [x, y] = self.first;
        format!("{differing} of {pixels} pixels differ, by at most {}, first at {x},{y}", self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_pixel_is_the_first_row_by_row() {
        let one = Image::filled(4, 3, [10; 4]);
        assert_eq!(Apart::of(&one, &one).unwrap(), None);
        let mut other = one.clone();
        other.pixels[4 + 3][1] = 12;
        other.pixels[8][3] = 5;
        let apart = Apart::of(&one, &other).unwrap().unwrap();
        assert_eq!(apart, Apart { pixels: 12, differing: 2, max: 5, first: [3, 1] });
        assert_eq!(apart.text(), "2 of 12 pixels differ, by at most 5, first at 3,1");
        assert!(Apart::of(&one, &Image::filled(3, 4, [10; 4])).is_err());
    }

    #[test]
    fn words_are_those_of_the_report() {
        use Status::*;
        for status in [Same, Blessed, InputChanged, ProgramChanged, Different, Missing, Error] {
            assert_eq!(serde_json::to_string(&status).unwrap(), format!("{:?}", status.name()));
        }
    }
}
