//! The settings of a procedural scene: keys with defaults, units and ranges, checked on use.

use std::collections::BTreeMap;

use toml::Value;

use crate::error::{Error, Result};

/// One setting.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// As in TOML and on the command line.
    pub name: &'static str,
    /// As it would be written.
    pub default: &'static str,
    /// Its valid values.
    pub range: Range,
    /// What it is, with its unit.
    pub about: &'static str,
}

/// The valid values of a key; both ends are included.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    /// Whole numbers.
    Count(u32, u32),
    /// Real numbers.
    Real(f64, f64),
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Linear RGB, 0..1.
    Color,
    /// A whole number, 0 to 2^63 - 1, that starts the random numbers.
    Seed,
}

impl Key {
    /// The random seed, which most scenes have.
    pub(in crate::scene) const SEED: Self =
        Self { name: "seed", default: "1", range: Range::Seed, about: "of the random numbers" };

    /// The opacity of all surfaces.
    pub(super) const fn alpha(default: &'static str) -> Self {
        Self { name: "alpha", default, range: Range::Real(0.0, 1.0), about: "opacity" }
    }
}

/// The values of one scene's keys.
#[derive(Clone, Copy, Debug)]
pub struct Keys<'a> {
    /// Whose keys they are.
    owner: &'a str,
    known: &'a [Key],
    given: &'a BTreeMap<String, Value>,
}

impl<'a> Keys<'a> {
    /// Refuses keys that the owner does not have.
    pub(in crate::scene) fn new(
        owner: &'a str,
        known: &'a [Key],
        given: &'a BTreeMap<String, Value>,
    ) -> Result<Self> {
        let keys = Self { owner, known, given };
        match given.keys().find(|name| !known.iter().any(|key| key.name == **name)) {
            Some(name) => {
                let names: Vec<_> = known.iter().map(|key| key.name).collect();
                Err(keys.wrong(name, &format!("is not a key; there are {}", names.join(", "))))
            }
            None => Ok(keys),
        }
    }

    /// An error about one key.
    pub(in crate::scene) fn wrong(&self, name: &str, problem: &str) -> Error {
        Error::new(self.owner, format!("{name}: {problem}"))
    }

    /// A key's description and value.
    fn get(&self, name: &str) -> Result<(&'a Key, Value)> {
        let key = self.known.iter().find(|key| key.name == name);
        let key = key.ok_or_else(|| self.wrong(name, "is not a key"))?;
        let value = self.given.get(name).cloned();
        Ok((key, value.unwrap_or_else(|| super::value_of(key.default))))
    }

    /// A whole number in its range.
    pub(in crate::scene) fn count(&self, name: &str) -> Result<u32> {
        let (key, value) = self.get(name)?;
        let number =
            value.as_integer().ok_or_else(|| self.wrong(name, "must be a whole number"))?;
        match key.range {
            Range::Count(low, high) if (i64::from(low)..=i64::from(high)).contains(&number) => {
                Ok(number as u32)
            }
            Range::Count(low, high) => {
                Err(self.wrong(name, &format!("{number} is not within {low} to {high}")))
            }
            _ => Err(self.wrong(name, "is not a count")),
        }
    }

    /// The seed.
    pub(in crate::scene) fn seed(&self) -> Result<u64> {
        let (key, value) = self.get("seed")?;
        let seed = value.as_integer().and_then(|seed| u64::try_from(seed).ok());
        seed.ok_or_else(|| self.wrong(key.name, "must be a whole number, 0 to 2^63 - 1"))
    }

    /// A real number in its range.
    pub(in crate::scene) fn real(&self, name: &str) -> Result<f64> {
        let (key, value) = self.get(name)?;
        let number = real(&value).ok_or_else(|| self.wrong(name, "must be a number"))?;
        match key.range {
            Range::Real(low, high) if (low..=high).contains(&number) => Ok(number),
            Range::Real(low, high) => {
                Err(self.wrong(name, &format!("{number} is not within {low} to {high}")))
            }
            _ => Err(self.wrong(name, "is not a number")),
        }
    }

    /// The opacity.
    pub(super) fn alpha(&self) -> Result<f32> {
        Ok(self.real("alpha")? as f32)
    }

    /// One of the words of a choice.
    pub(super) fn choice(&self, name: &str) -> Result<&'static str> {
        let (key, value) = self.get(name)?;
        let Range::Choice(words) = key.range else { return Err(self.wrong(name, "not a choice")) };
        let chosen = words.iter().find(|word| value.as_str() == Some(**word)).copied();
        chosen.ok_or_else(|| self.wrong(name, &format!("must be one of {}", words.join(", "))))
    }

    /// Linear RGB.
    pub(super) fn color(&self, name: &str) -> Result<[f32; 3]> {
        let (_, value) = self.get(name)?;
        let channels: Option<Vec<f64>> =
            value.as_array().and_then(|v| v.iter().map(real).collect());
        match channels.as_deref() {
            Some(&[r, g, b]) if [r, g, b].iter().all(|c| (0.0..=1.0).contains(c)) => {
                Ok([r, g, b].map(|c| c as f32))
            }
            _ => Err(self.wrong(name, "must be three numbers, each 0 to 1")),
        }
    }
}

fn real(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}
