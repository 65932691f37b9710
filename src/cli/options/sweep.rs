//! `--sweep NAME=VALUES`: a numeric option at several values. An option becomes sweepable by a line in [`PARAMETERS`].

use super::flags::Drawing;
use crate::error::{Error, Result};
use crate::scheme::contract::{Contract, Demand, Keeps};

/// The most values in a list: more are a slip of the keyboard.
const MOST: usize = 256;

/// A numeric option that may be swept.
#[derive(Debug)]
pub(in crate::cli) struct Parameter {
    /// Without its dashes.
    pub(in crate::cli) name: &'static str,
    /// Its smallest and largest value.
    range: [f64; 2],
    whole: bool,
    set: fn(&mut Drawing, f64),
    /// Whether it was given, besides.
    is_given: fn(&Drawing) -> bool,
    /// Whether it does anything for a method; else the method is drawn once.
    pub(in crate::cli) concerns: fn(&Contract) -> bool,
}

/// Whole numbers are in range by then.
const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "k",
        range: [1.0, 65_535.0],
        whole: true,
        set: |drawing, value| drawing.k = Some(value as u32),
        is_given: |drawing| drawing.k.is_some(),
        concerns: |method| method.default_k.is_some() || method.keeps == Keeps::FirstArrivals,
    },
    Parameter {
        name: "k-average",
        range: [0.0, 65_535.0],
        whole: false,
        set: |drawing, value| drawing.importance.k_average = Some(value),
        is_given: |drawing| drawing.importance.k_average.is_some(),
        concerns: |method| method.demand == Demand::Records,
    },
    Parameter {
        name: "beta",
        range: [0.0, 1.0],
        whole: false,
        set: |drawing, value| drawing.beta = value,
        is_given: |_| false,
        concerns: |method| method.name.split('@').next() == Some("dfb+sfm"),
    },
    Parameter {
        name: "moments",
        range: [4.0, 8.0],
        whole: true,
        set: |drawing, value| drawing.approximation.moments = value as u32,
        is_given: |_| false,
        concerns: |method| method.base_name() == "mbt",
    },
    Parameter {
        name: "samples",
        range: [1.0, 64.0],
        whole: true,
        set: |drawing, value| drawing.approximation.samples = value as u32,
        is_given: |_| false,
        concerns: |method| method.base_name() == "stochastic",
    },
    Parameter {
        name: "load",
        range: [1.0, 100.0],
        whole: true,
        set: |drawing, value| drawing.load = Some(value as u32),
        is_given: |drawing| drawing.load.is_some(),
        concerns: Contract::crosses,
    },
    Parameter {
        name: "age-limit",
        range: [1.0, 255.0],
        whole: true,
        set: |drawing, value| drawing.age_limit = value as u32,
        is_given: |_| false,
        concerns: Contract::crosses,
    },
];

/// What can be swept.
pub(in crate::cli) fn names() -> impl Iterator<Item = &'static str> {
    PARAMETERS.iter().map(|known| known.name)
}

/// A parameter and its values.
#[derive(Debug)]
pub(in crate::cli) struct Sweep {
    pub(in crate::cli) parameter: &'static Parameter,
    /// In range, from the smallest, each once; at least one.
    pub(in crate::cli) values: Vec<f64>,
}

impl Sweep {
    /// `NAME=VALUES`: values and ranges `A..B` of whole numbers, both ends included, separated by commas.
    ///
    /// # Errors
    /// Another form, no such parameter, a value out of range, or too many; or an option that is also given by itself.
    pub(in crate::cli) fn parse(text: &str, typed: &Drawing) -> Result<Self> {
        let (name, list) = text.split_once('=').ok_or_else(|| malformed(text))?;
        let parameter = PARAMETERS.iter().find(|known| known.name == name).ok_or_else(|| {
            let names: Vec<&str> = names().collect();
            let problem = format!("{name:?} is nothing that can be swept: must be one of");
            wrong(format!("{problem} {}", names.join(", ")))
        })?;
        if (parameter.is_given)(typed) {
            let dashes = if name.len() == 1 { "-" } else { "--" };
            return Err(wrong(format!(
                "{text:?}: {dashes}{name} is given as well: give one of them"
            )));
        }
        let mut values = Vec::new();
        for part in list.split(',') {
            let (from, to) = part.split_once("..").unwrap_or((part, part));
            let is_range = from.len() < part.len();
            let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
            let (Some(from), Some(to)) = (number(from), number(to)) else {
                return Err(malformed(text));
            };
            let [from, to] = [parameter.check(from, is_range)?, parameter.check(to, is_range)?];
            if from > to {
                return Err(wrong(format!(
                    "{part:?} goes down: must be from the smaller to the larger"
                )));
            }
            let count = (to - from) as usize + 1;
            if values.len() + count > MOST {
                return Err(wrong(format!("{text:?} has too many values: at most {MOST}")));
            }
            values.extend((0..count).map(|step| from + step as f64));
        }
        values.sort_by(f64::total_cmp);
        values.dedup();
        Ok(Self { parameter, values })
    }

    /// The options with that value.
    pub(in crate::cli) fn at(&self, typed: &Drawing, value: f64) -> Drawing {
        let mut typed = typed.clone();
        (self.parameter.set)(&mut typed, value);
        typed
    }
}

impl Parameter {
    fn check(&self, value: f64, whole: bool) -> Result<f64> {
        let [low, high] = self.range;
        let fits = value.fract() == 0.0 || !(whole || self.whole);
        if fits && (low..=high).contains(&value) {
            return Ok(value + 0.0);
        }
        let kind =
            if self.whole { "whole numbers" } else { "numbers (in ranges A..B, whole ones)" };
        Err(wrong(format!("{}={value}: must be {kind} from {low} to {high}", self.name)))
    }
}

fn malformed(text: &str) -> Error {
    wrong(format!("{text:?} must be NAME=VALUES, like k=1..32 or k=1,2,4,8"))
}

fn wrong(problem: String) -> Error {
    Error::new("--sweep", problem)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        drawing: Drawing,
    }

    fn typed(line: &str) -> Drawing {
        Line::try_parse_from(std::iter::once("test").chain(line.split_whitespace()))
            .unwrap()
            .drawing
    }

    fn values(text: &str) -> Vec<f64> {
        Sweep::parse(text, &typed("")).unwrap().values
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(values("k=3"), [3.0]);
        assert_eq!(values("k=1..4"), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(values("k=8,1,2..3,2"), [1.0, 2.0, 3.0, 8.0]);
        assert_eq!(values("beta=0,0.25,1"), [0.0, 0.25, 1.0]);
        assert_eq!(values("beta=-0,0..1"), [0.0, 1.0]);
        assert_eq!(values("k=1..256").len(), MOST);
    }

    #[test]
    fn what_is_wrong_says_what_is_right() {
        for (text, words) in [
            ("k", "k=1..32"),
            ("k=", "k=1,2,4,8"),
            ("k=1,,2", "NAME=VALUES"),
            ("k=1..", "NAME=VALUES"),
            ("k=1..2..3", "NAME=VALUES"),
            ("k=one", "NAME=VALUES"),
            ("k=nan", "NAME=VALUES"),
            ("", "NAME=VALUES"),
            ("kay=1", "k, k-average, beta, moments, samples, load, age-limit"),
            ("k=0", "k=0: must be whole numbers from 1 to 65535"),
            ("k=1.5", "whole numbers"),
            ("k=-1..3", "from 1 to 65535"),
            ("k=1..257", "at most 256"),
            ("k=1..200,1..200", "at most 256"),
            ("k=4..1", "goes down"),
            ("beta=0..0.5", "whole ones"),
            ("beta=1.5", "from 0 to 1"),
            ("load=101", "from 1 to 100"),
        ] {
            let error = Sweep::parse(text, &typed("")).unwrap_err();
            assert_eq!(error.place(), "--sweep", "{text}");
            assert!(error.problem().contains(words), "{text}: {error}");
        }
        let both = Sweep::parse("k=1..4", &typed("-k 8")).unwrap_err();
        assert!(both.problem().contains("-k is given as well"), "{both}");
        let both = Sweep::parse("load=9", &typed("--load 8")).unwrap_err();
        assert!(both.problem().contains("--load is given as well"), "{both}");
    }

    #[test]
    fn every_parameter_sets_its_option() {
        for parameter in PARAMETERS {
            let (name, most) = (parameter.name, parameter.range[1]);
            let sweep = Sweep::parse(&format!("{name}={most}"), &typed("")).unwrap();
            let dashes = if name.len() == 1 { "-" } else { "--" };
            let (set, other) = (sweep.at(&typed(""), most), format!("{dashes}{name} {most}"));
            assert_eq!(format!("{set:?}"), format!("{:?}", typed(&other)), "{}", parameter.name);
        }
    }
}
