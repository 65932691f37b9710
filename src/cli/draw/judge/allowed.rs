//! `--allow`: how many pixels a class may have.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::catalogue::nearest;
use crate::error::{Error, Result};
use crate::judge::dump::DumpVerdict;
use crate::judge::{Class, Counted, Runs, Verdict};

/// What was allowed.
#[derive(Debug, Default)]
pub(super) struct Allowed(BTreeMap<Class, u64>);

/// A class with more pixels than are allowed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Exceeded {
    /// The file, or `runs`.
    pub(super) of: String,
    pub(super) class: Class,
    pub(super) pixels: u64,
    pub(super) allowed: u64,
}

impl Allowed {
    /// # Errors
    /// No class of that name, no number, or a class that is given twice.
    pub(super) fn parse(typed: &[String]) -> Result<Self> {
        let wrong = |problem: String| Err(Error::new("--allow", problem));
        let mut allowed = BTreeMap::new();
        for text in typed {
            let Some((name, pixels)) = text.split_once('=') else {
                return wrong(format!("{text:?} must be CLASS=PIXELS, as edge=100"));
            };
            let (name, pixels) = (name.trim(), pixels.trim());
            let names: Vec<&str> = Class::ALL.into_iter().skip(1).map(Class::name).collect();
            let class = Class::named(&name.to_ascii_lowercase());
            let Some(class) = class.filter(|&class| class != Class::Equal) else {
                let all = || format!(". The classes are {}", names.join(", "));
                let guess = nearest(name, &names).map(|near| format!("; did you mean {near}?"));
                return wrong(format!("no class {name:?}{}", guess.unwrap_or_else(all)));
            };
            let Ok(pixels) = pixels.parse() else {
                return wrong(format!("{text:?}: {pixels:?} must be a number of pixels"));
            };
            if allowed.insert(class, pixels).is_some() {
                return wrong(format!("{name} is given twice"));
            }
        }
        Ok(Self(allowed))
    }

    /// What is beyond.
    pub(super) fn exceeded(
        &self,
        pictures: &[Verdict],
        dumps: &[DumpVerdict],
        runs: Option<&Runs>,
    ) -> Vec<Exceeded> {
        let pictures = pictures.iter().map(|own| (&own.picture[..], &own.classes[..]));
        let dumps = dumps.iter().map(|own| (&own.dump[..], &own.classes[..]));
        let runs = runs.iter().map(|own| ("runs", &own.classes[..]));
        let all = pictures.chain(dumps).chain(runs);
        all.flat_map(|(of, counts)| counts.iter().filter_map(|count| self.beyond(of, count)))
            .collect()
    }

    fn beyond(&self, of: &str, count: &Counted) -> Option<Exceeded> {
        let usual = if count.class.is_right() { u64::MAX } else { 0 };
        let allowed = self.0.get(&count.class).copied().unwrap_or(usual);
        let Counted { class, pixels, .. } = *count;
        (pixels > allowed).then(|| Exceeded { of: of.to_owned(), class, pixels, allowed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &[&str]) -> Result<Allowed> {
        Allowed::parse(&words.iter().map(|&word| word.to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn limits_hold_for_their_class() {
        let count = |class: Class, pixels| Counted {
            class,
            meaning: class.meaning(),
            pixels,
            max_difference: 0,
            first: [0, 0],
        };
        let allowed = parse(&["edge=5", "Rounding=7", "beyond-k=0"]).unwrap();
        for (class, pixels, beyond) in [
            (Class::Edge, 5, false),
            (Class::Edge, 6, true),
            (Class::Rounding, 7, false),
            (Class::Rounding, 8, true),
            (Class::Equal, u64::MAX, false),
            (Class::BeyondK, 1, true),
            (Class::Unexplained, 1, true),
        ] {
            assert_eq!(allowed.beyond("a", &count(class, pixels)).is_some(), beyond, "{class:?}");
        }
        assert!(Allowed::default().beyond("a", &count(Class::Rounding, 9)).is_none());
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (words, told) in [
            (&["edges=5"][..], "did you mean edge?"),
            (&["nonsense=5"], "The classes are rounding, "),
            (&["equal=5"], "no class"),
            (&["edge"], "CLASS=PIXELS"),
            (&["edge=-1"], "number of pixels"),
            (&["edge=1", "edge=2"], "twice"),
        ] {
            let error = parse(words).unwrap_err();
            assert!(error.place() == "--allow" && error.problem().contains(told), "{error}");
        }
    }
}
