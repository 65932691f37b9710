//! What makes a pixel important, for methods that give important pixels more records: options as given, checked and
//! completed.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::values;
use crate::error::{Error, Result};
use crate::render::{Factors, Importance, ImportanceMap, Reach};

/// Options about importance.
#[derive(Clone, Debug, Args)]
pub(in crate::cli) struct Typed {
    /// For k-variable, records per pixel on average, 0 or more, not only whole numbers [default: -k]
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub(in crate::cli) k_average: Option<f64>,

    /// For k-variable, what makes a pixel important, separated by commas: depth (its number of fragments), periphery
    /// (its distance from the middle or the gaze), fresnel (the nearest surface of the frame before, of --frames), map
    /// (--importance-map); these are multiplied, and noise is added [default: depth,periphery,fresnel,noise; with
    /// --importance-map: map]
    #[arg(long = "importance", value_name = "FACTOR,...", value_delimiter = ',')]
    pub(in crate::cli) factors: Vec<Factor>,

    /// For k-variable, a picture of importance, black (0) to white (1), as PNG; stretched over the picture (bilinear)
    /// [default: none]
    #[arg(long, value_name = "FILE.png")]
    pub(in crate::cli) importance_map: Option<PathBuf>,

    /// For k-variable, where the viewer looks, in pixels from the top left, within the picture [default: its middle]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub(in crate::cli) gaze: Option<String>,

    /// Factor depth: importance of a pixel with hardly any fragments, 0 to 1 (the paper: 0.25 to 0.5)
    #[arg(long, value_name = "ALPHA", default_value_t = 0.25, allow_negative_numbers = true)]
    pub(in crate::cli) importance_alpha: f64,

    /// Factor depth: fragments above which a pixel is no more important, 1 to 65535 (the paper: 20 to 30)
    #[arg(long, value_name = "N", default_value_t = 30, allow_negative_numbers = true)]
    pub(in crate::cli) importance_layers: u32,

    /// Factor periphery: exponent of the distance, above 0; 10 or more falls off only near the edges
    #[arg(long, value_name = "D", default_value_t = 3.0, allow_negative_numbers = true)]
    pub(in crate::cli) periphery_falloff: f64,

    /// Factor periphery: what the distance is divided by: the picture's diagonal, as in the paper, or 1.1 times half of
    /// it, as in its authors' shader
    #[arg(long, value_enum, value_name = "LENGTH", default_value = "diagonal")]
    pub(in crate::cli) periphery_reach: Length,

    /// Noise: its width, 0 to 1
    #[arg(long, value_name = "LAMBDA", default_value_t = 0.1, allow_negative_numbers = true)]
    pub(in crate::cli) importance_noise: f64,

    /// Noise: its seed, 64 bits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub(in crate::cli) importance_seed: u64,
}

/// One of `--importance`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Factor {
    Depth,
    Periphery,
    Fresnel,
    Map,
    Noise,
}

/// `--periphery-reach`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Length {
    Diagonal,
    HalfDiagonal,
}

impl Typed {
    /// Read the map, and fill defaults in.
    ///
    /// # Errors
    /// A map that is no picture, or a gaze of another form. Ranges are checked where it is drawn.
    pub(in crate::cli) fn complete(&self) -> Result<Importance> {
        let map = self.importance_map.as_deref().map(map).transpose()?;
        let factors = match (&self.factors[..], &map) {
            ([], None) => Factors::COMPUTED,
            ([], Some(_)) => Factors::MAPPED,
            (given, _) => Factors {
                depth: given.contains(&Factor::Depth),
                periphery: given.contains(&Factor::Periphery),
                fresnel: given.contains(&Factor::Fresnel),
                map: given.contains(&Factor::Map),
                noise: given.contains(&Factor::Noise),
            },
        };
        let reach = match self.periphery_reach {
            Length::Diagonal => Reach::Diagonal,
            Length::HalfDiagonal => Reach::HalfDiagonal,
        };
        Ok(Importance {
            factors,
            map,
            gaze: self.gaze.as_deref().map(|text| values::place("--gaze", text)).transpose()?,
            alpha: self.importance_alpha,
            layers: self.importance_layers,
            falloff: self.periphery_falloff,
            reach,
            noise: self.importance_noise,
            seed: self.importance_seed,
            ..Importance::default()
        })
    }
}

fn map(path: &Path) -> Result<ImportanceMap> {
    let place = path.display().to_string();
    let file = File::open(path)
        .map_err(|error| Error::new(place.as_str(), format!("cannot be opened: {error}")))?;
    ImportanceMap::from_png(&place, BufReader::new(file))
}

/// `occupancy` or `occupancy:D`, as words of a mask.
///
/// # Errors
/// Another form.
pub(in crate::cli) fn culling(text: &str) -> Result<u32> {
    let words = match text.split_once(':') {
        None if text == "occupancy" => Some(crate::render::DEFAULT_WORDS),
        Some(("occupancy", words)) => words.parse().ok(),
        _ => None,
    };
    words.ok_or_else(|| {
        let right = "must be occupancy or occupancy:D, with D words of 32 intervals a pixel";
        Error::new("--cull", format!("{text:?} {right}"))
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        typed: Typed,
    }

    fn completed(line: &str) -> Result<Importance> {
        let words = std::iter::once("test").chain(line.split_whitespace());
        Line::try_parse_from(words).unwrap().typed.complete()
    }

    #[test]
    fn defaults_are_the_papers() {
        assert_eq!(completed("").unwrap(), Importance::default());
        let depth = completed("--importance depth,noise --importance-noise 0.5").unwrap();
        assert_eq!(depth.factors.names(), ["depth", "noise"]);
        assert_eq!(depth.noise, 0.5);
        let gaze = completed("--gaze 3.5,-2 --periphery-reach half-diagonal").unwrap();
        assert_eq!((gaze.gaze, gaze.reach), (Some([3.5, -2.0]), Reach::HalfDiagonal));
    }

    #[test]
    fn wrong_values_name_their_option() {
        for (line, place) in [
            ("--gaze 3", "--gaze"),
            ("--gaze a,b", "--gaze"),
            ("--gaze nan,1", "--gaze"),
            ("--importance-map /no/such.png", "/no/such.png"),
            ("--importance-map Cargo.toml", "Cargo.toml"),
        ] {
            assert_eq!(completed(line).unwrap_err().place(), place, "{line}");
        }
    }

    #[test]
    fn culling_has_a_number_of_words() {
        assert_eq!(culling("occupancy").unwrap(), 32);
        assert_eq!(culling("occupancy:2").unwrap(), 2);
        for bad in ["", "occupancy:", "occupancy:x", "occupancy:-1", "depth"] {
            assert_eq!(culling(bad).unwrap_err().place(), "--cull", "{bad}");
        }
    }
}
