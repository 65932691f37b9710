//! Parts of a manifest, for several machines: each entry is in exactly one of them, whatever the others are.

use std::fmt;

use sha2::{Digest, Sha256};

use crate::error::{Error, Result};

const OPTION: &str = "--partition";

/// Part `index` of `count`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partition {
    /// From 1.
    index: u64,
    count: u64,
}

/// What `auto` reads: the variables of the index and of the count, and the first index; or the variable that says it.
/// The first pair that is set counts.
const VARIABLES: [(&str, &str, First); 5] = [
    ("SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", First::Slurm),
    ("CI_NODE_INDEX", "CI_NODE_TOTAL", First::One),
    ("CIRCLE_NODE_INDEX", "CIRCLE_NODE_TOTAL", First::Zero),
    ("BUILDKITE_PARALLEL_JOB", "BUILDKITE_PARALLEL_JOB_COUNT", First::Zero),
    ("SEMAPHORE_JOB_INDEX", "SEMAPHORE_JOB_COUNT", First::One),
];

/// The first index.
#[derive(Clone, Copy)]
enum First {
    Zero,
    One,
    /// `SLURM_ARRAY_TASK_MIN` (else 0), in steps of `SLURM_ARRAY_TASK_STEP` (else 1).
    Slurm,
}

impl Partition {
    /// `hash:i/n`, or `auto`: what the variables of a SLURM array or of a CI service say. `variable` gives a variable of
    /// the environment.
    ///
    /// # Errors
    /// Another form, a part that does not exist, or variables that are not set or do not go together.
    pub fn parse(text: &str, variable: &dyn Fn(&str) -> Option<String>) -> Result<Self> {
        if text.eq_ignore_ascii_case("auto") {
            return Self::auto(variable);
        }
        let numbers = text.strip_prefix("hash:").and_then(|text| text.split_once('/'));
        let numbers = numbers.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let part = numbers.map(|(index, count)| Self { index, count }).filter(Self::exists);
        part.ok_or_else(|| {
            let right = "must be hash:I/N, part I of N counted from 1, like hash:1/3, or auto";
            Error::new(OPTION, format!("{text:?} {right}"))
        })
    }

    fn exists(&self) -> bool {
        (1..=self.count).contains(&self.index)
    }

    fn auto(variable: &dyn Fn(&str) -> Option<String>) -> Result<Self> {
        let found = VARIABLES.iter().find_map(|(index, count, first)| {
            variable(index).map(|value| (*index, value, *count, *first))
        });
        let Some((index, value, count, first)) = found else {
            let names: Vec<&str> = VARIABLES.iter().map(|(index, ..)| *index).collect();
            let problem = format!("auto: none of {} is set; give hash:I/N", names.join(", "));
            return Err(Error::new(OPTION, problem));
        };
        let wrong = |problem: String| Error::new(OPTION, format!("auto: {problem}; give hash:I/N"));
        let number = |name: &str, text: &str| {
            let parsed = text.trim().parse::<u64>();
            parsed.map_err(|_| wrong(format!("{name} is {text:?}, and no whole number from 0")))
        };
        let optional = |name: &str, default: u64| {
            variable(name).map_or(Ok(default), |text| number(name, &text))
        };
        let all =
            variable(count).ok_or_else(|| wrong(format!("{index} is set, but not {count}")))?;
        let (own, all) = (number(index, &value)?, number(count, &all)?);
        let (least, step) = match first {
            First::Zero => (0, 1),
            First::One => (1, 1),
            First::Slurm => {
                (optional("SLURM_ARRAY_TASK_MIN", 0)?, optional("SLURM_ARRAY_TASK_STEP", 1)?.max(1))
            }
        };
        let place = own.checked_sub(least).filter(|place| place % step == 0);
        let part = place.map(|place| Self { index: place / step + 1, count: all });
        part.filter(Self::exists).ok_or_else(|| {
            let from = format!("counted from {least}{}", if step == 1 { "" } else { ", in steps" });
            wrong(format!("{index} = {own} is not among the {all} of {count}, {from}"))
        })
    }

    /// Whether an entry of that name is in this part.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        share(name, self.count) + 1 == self.index
    }
}

/// Which of `count` parts, from 0, a name is in: the first 8 bytes of its SHA-256, as a number with the highest byte
/// first, modulo `count`. This never changes.
///
/// # Panics
/// If `count` is 0.
#[must_use]
pub fn share(name: &str, count: u64) -> u64 {
    let bytes = Sha256::digest(name.as_bytes());
    bytes[..8].iter().fold(0, |number, &byte| number << 8 | u64::from(byte)) % count
}

impl fmt::Display for Partition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "hash:{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, set: &[(&str, &str)]) -> Result<String> {
        let variable = |name: &str| {
            set.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
        };
        Partition::parse(text, &variable).map(|part| part.to_string())
    }

    #[test]
    fn every_name_is_in_exactly_one_part() {
        for count in 1..=9 {
            let parts: Vec<Partition> =
                (1..=count).map(|index| Partition { index, count }).collect();
            let mut sizes = vec![0; parts.len()];
            for name in (0..500).map(|i| format!("entry-{i}")) {
                let within: Vec<usize> =
                    (0..parts.len()).filter(|&part| parts[part].has(&name)).collect();
                assert_eq!(within.len(), 1, "{name} of {count}");
                sizes[within[0]] += 1;
            }
            assert!(sizes.iter().all(|&size| size > 500 / count / 2), "{sizes:?}");
        }
    }

    /// The shares of some names, from `sha256sum`: they must never change.
    #[test]
    fn shares_are_fixed() {
        // e3b0c44298fc1c14 and ba7816bf8f01cfea
        assert_eq!(
            [share("", 10), share("abc", 10)],
            [0xE3B0_C442_98FC_1C14 % 10, 0xBA78_16BF_8F01_CFEA % 10]
        );
    }

    #[test]
    fn parts_are_read() {
        for text in ["hash:1/1", "hash:3/7", "hash:7/7"] {
            assert_eq!(parse(text, &[]).unwrap(), text);
        }
        for bad in
            ["hash:0/3", "hash:4/3", "hash:1/0", "1/3", "hash:1", "hash:a/3", "hash:-1/3", ""]
        {
            let error = parse(bad, &[]).unwrap_err();
            assert!(
                error.place() == "--partition" && error.problem().contains("hash:1/3"),
                "{bad}"
            );
        }
    }

    #[test]
    fn auto_reads_the_variables_of_arrays_and_matrices() {
        let slurm = |id, rest: &[(&'static str, &'static str)]| {
            let own = [("SLURM_ARRAY_TASK_ID", id), ("SLURM_ARRAY_TASK_COUNT", "4")];
            parse("auto", &[&own[..], rest].concat())
        };
        assert_eq!(slurm("0", &[]).unwrap(), "hash:1/4");
        assert_eq!(slurm("4", &[("SLURM_ARRAY_TASK_MIN", "1")]).unwrap(), "hash:4/4");
        let steps = [("SLURM_ARRAY_TASK_MIN", "10"), ("SLURM_ARRAY_TASK_STEP", "5")];
        assert_eq!(slurm("20", &steps).unwrap(), "hash:3/4");
        for (id, rest) in [("4", &[][..]), ("12", &steps), ("9", &steps), ("x", &[]), ("", &[])] {
            assert_eq!(slurm(id, rest).unwrap_err().place(), "--partition", "{id} {rest:?}");
        }
        for (names, first) in [
            (["CI_NODE_INDEX", "CI_NODE_TOTAL"], 1),
            (["CIRCLE_NODE_INDEX", "CIRCLE_NODE_TOTAL"], 0),
            (["BUILDKITE_PARALLEL_JOB", "BUILDKITE_PARALLEL_JOB_COUNT"], 0),
            (["SEMAPHORE_JOB_INDEX", "SEMAPHORE_JOB_COUNT"], 1),
        ] {
            let at = |index: i32| {
                parse("auto", &[(names[0], index.to_string().as_str()), (names[1], "3")])
            };
            for part in 0..3 {
                assert_eq!(at(first + part).unwrap(), format!("hash:{}/3", part + 1));
            }
            assert!(at(first - 1).is_err() && at(first + 3).is_err());
            let alone = parse("auto", &[(names[0], "1")]).unwrap_err();
            assert!(alone.problem().contains(names[1]), "{alone}");
        }
        let none = parse("AUTO", &[]).unwrap_err();
        assert!(none.problem().contains("SLURM_ARRAY_TASK_ID"), "{none}");
    }
}
