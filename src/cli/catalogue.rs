//! Methods by name, and what a misspelt name may have meant.

use crate::error::{Error, Result};
use crate::scheme::{Contract, Form, contracts};

/// The contract of a method.
///
/// # Errors
/// An unknown name: the nearest known one, and all but the faults.
pub(super) fn find(option: &str, name: &str) -> Result<&'static Contract> {
    let all = contracts();
    if let Some(contract) = all.iter().find(|contract| contract.name == name) {
        return Ok(contract);
    }
    let names: Vec<&str> = all.iter().map(|contract| contract.name).collect();
    let guess = nearest(name, &names).map(|near| format!("; did you mean {near}?"));
    let listed = all.iter().filter(|contract| contract.form != Form::Mutation);
    let listed: Vec<&str> = listed.map(|contract| contract.name).collect();
    let problem = format!(
        "unknown method {name:?}{} The methods are {} (and faults: see fragloom mutations)",
        guess.unwrap_or_else(|| ".".to_owned()),
        listed.join(", ")
    );
    Err(Error::new(option, problem))
}

/// The name with the fewest edits, if they are few for its length.
fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let near = names.iter().min_by_key(|known| edits(name, known))?;
    (edits(name, near) <= 1 + near.len() / 4).then_some(near)
}

/// Levenshtein's distance: insertions, deletions and replacements of bytes.
fn edits(from: &str, to: &str) -> usize {
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.bytes().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in to.bytes().enumerate() {
            let replaced = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_levenshteins() {
        let cases =
            [("", "abc", 3), ("kb", "kb", 0), ("kitten", "sitting", 3), ("ab-l", "ab-ll", 1)];
        assert!(cases.iter().all(|&(a, b, d)| edits(a, b) == d && edits(b, a) == d));
    }

    #[test]
    fn near_names_are_suggested_and_far_ones_not() {
        let names = ["z-buffer", "kplus-array", "kb"];
        assert_eq!(nearest("kplus-aray", &names), Some("kplus-array"));
        assert_eq!(nearest("zbuffer", &names), Some("z-buffer"));
        assert_eq!(nearest("something", &names), None);
    }

    #[test]
    fn an_unknown_method_names_the_option_and_the_catalogue() {
        let error = find("-m", "exakt").unwrap_err();
        assert_eq!(error.place(), "-m");
        assert!(error.problem().contains("did you mean exact?"), "{error}");
        assert!(error.problem().contains("kplus-array"), "{error}");
    }
}
