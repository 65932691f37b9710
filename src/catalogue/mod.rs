//! The catalogue: methods by name. It is a value: the built-in methods and any added ones.

mod built_in;
pub mod faults;

use crate::error::{Error, Result};
use crate::exec::Method;
use crate::scheme::{Contract, Form};

/// Methods with distinct names.
#[derive(Clone, Debug)]
pub struct Catalogue {
    methods: Vec<Method>,
}

impl Default for Catalogue {
    fn default() -> Self {
        Self::built_in()
    }
}

impl Catalogue {
    /// The built-in methods; the oracle, `exact`, comes first.
    #[must_use]
    pub fn built_in() -> Self {
        Self { methods: built_in::METHODS.to_vec() }
    }

    /// Add another method.
    ///
    /// # Errors
    /// A method of that name exists.
    pub fn with(mut self, method: Method) -> Result<Self> {
        if self.methods.contains(&method) {
            let problem = "is the name of an existing method: give the new one another";
            return Err(Error::new(method.name(), problem));
        }
        self.methods.push(method);
        Ok(self)
    }

    /// All methods, in their order.
    #[must_use]
    pub fn methods(&self) -> &[Method] {
        &self.methods
    }

    /// The methods that promise something: all but the oracle and the built-in faults.
    pub fn promised(&self) -> impl Iterator<Item = Method> + '_ {
        let promises = |m: &&Method| !m.is_exact() && m.contract().form != Form::Mutation;
        self.methods.iter().filter(promises).copied()
    }

    /// All contracts, in the methods' order.
    pub fn contracts(&self) -> impl Iterator<Item = &'static Contract> + '_ {
        self.methods.iter().map(Method::contract)
    }

    /// The methods of these names, each once: `all` are those in their correct form, and `*` stands for any letters of
    /// the name of a method that promises something. Blanks around a name do not count.
    ///
    /// # Errors
    /// As [`Self::find`]; a pattern that no method matches.
    pub fn select(&self, place: &str, names: &[String]) -> Result<Vec<Method>> {
        let mut selected = Vec::new();
        for name in names.iter().map(|name| name.trim()) {
            let correct = |m: &Method| m.contract().form == Form::Correct;
            let found: Vec<Method> = match name {
                all if all.eq_ignore_ascii_case("all") => self.promised().filter(correct).collect(),
                name if name.contains('*') => {
                    self.promised().filter(|method| matches(name, method.name())).collect()
                }
                name => vec![self.find(place, name)?],
            };
            if found.is_empty() {
                let problem = format!("no method is called like {name:?}; see fragloom methods");
                return Err(Error::new(place, problem));
            }
            for method in found {
                if !selected.contains(&method) {
                    selected.push(method);
                }
            }
        }
        Ok(selected)
    }

    /// The method of that name. `place` is where the name was given, for the message.
    ///
    /// # Errors
    /// No method has that name: the message gives the nearest name, and all names but those of faults.
    pub fn find(&self, place: &str, name: &str) -> Result<Method> {
        let exact = |method: &&Method| method.name() == name;
        // No two names differ in case alone.
        let alike = |method: &&Method| method.name().eq_ignore_ascii_case(name);
        if let Some(method) = self.methods.iter().find(exact).or(self.methods.iter().find(alike)) {
            return Ok(*method);
        }
        let names: Vec<&str> = self.methods.iter().map(Method::name).collect();
        let guess = nearest(name, &names).map(|near| format!("; did you mean {near}?"));
        let listed = self.contracts().filter(|contract| contract.form != Form::Mutation);
        let listed: Vec<&str> = listed.map(|contract| contract.name).collect();
        let problem = format!(
            "unknown method {name:?}{} The methods are {} (and faults: see fragloom mutations)",
            guess.unwrap_or_else(|| ".".to_owned()),
            listed.join(", ")
        );
        Err(Error::new(place, problem))
    }
}

/// Whether a name is of a pattern in which `*` stands for any letters.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, rest)) => {
            let Some(tail) = name.strip_prefix(head) else { return false };
            (0..=tail.len()).any(|at| tail.get(at..).is_some_and(|tail| matches(rest, tail)))
        }
    }
}

/// The default method: `kplus-array`.
pub const DEFAULT: Method = built_in::DEFAULT;

/// The culling passes that other methods can follow.
pub const OCCUPANCY: Method = built_in::OCCUPANCY;

/// The built-in method of that name.
///
/// # Errors
/// No method has that name.
///
/// # Examples
/// ```
/// let method = fragloom::catalogue::method("kplus-array")?;
/// assert_eq!(method.contract().default_k, Some(8));
/// # Ok::<(), fragloom::error::Error>(())
/// ```
pub fn method(name: &str) -> Result<Method> {
    Catalogue::built_in().find("--method", name)
}

/// The name with the fewest edits, if they are few for its length.
pub(crate) fn nearest<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let near = names.iter().min_by_key(|known| edits(name, known))?;
    (edits(name, near) <= 1 + near.len() / 4).then_some(near)
}

/// The Levenshtein distance: insertions, deletions and replacements of bytes.
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
    fn patterns_and_blanks_are_understood() {
        let select = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            let found = Catalogue::built_in().select("-m", &names);
            found.map(|all| all.iter().map(Method::name).collect::<Vec<_>>())
        };
        assert_eq!(select(&["ab-ll", " s-buffer", "ab-ll"]).unwrap(), ["ab-ll", "s-buffer"]);
        assert_eq!(select(&["depth-peel*"]).unwrap().len(), 4);
        assert!(select(&["*@published"]).unwrap().contains(&"kplus-array@published"));
        assert_eq!(select(&["KPLUS-array"]), select(&["kplus-array"]));
        let mut names: Vec<String> =
            Catalogue::built_in().methods().iter().map(|m| m.name().to_lowercase()).collect();
        names.sort();
        assert!(names.windows(2).all(|two| two[0] != two[1]), "no two differ in case alone");
        assert!(select(&["ALL"]).unwrap().len() > 40 && select(&["nothing*"]).is_err());
        assert!([("a*c", "abc"), ("*", ""), ("a**b", "ab")].iter().all(|(p, n)| matches(p, n)));
        assert!(![("a*c", "abd"), ("", "a")].iter().any(|(p, n)| matches(p, n)));
    }

    #[test]
    fn every_name_is_there_once() {
        let all = Catalogue::built_in();
        for method in all.methods() {
            assert_eq!(all.find("-m", method.name()), Ok(*method));
            assert_eq!(all.methods().iter().filter(|m| *m == method).count(), 1, "{method}");
            assert!(all.clone().with(*method).is_err(), "{method}");
        }
        assert!(all.methods()[0].is_exact());
    }

    #[test]
    fn an_unknown_method_names_the_option_and_the_catalogue() {
        let error = Catalogue::built_in().find("-m", "exakt").unwrap_err();
        assert_eq!(error.place(), "-m");
        assert!(error.problem().contains("did you mean exact?"), "{error}");
        assert!(error.problem().contains("kplus-array"), "{error}");
    }
}
