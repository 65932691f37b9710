//! Which operations a method's source has, so that a check can report which of them it never reached.
//!
//! An operation is a call that is awaited; the memory that asks knows each by line and column of the called name
//! ([`std::panic::Location`]), and here the same places are read from the source's text. Clear, resolve and invariant
//! are left out, and so is code guarded by a constant of a variant (`if V::SECOND_TEST`), of which a method has only
//! one branch.

use std::collections::{BTreeMap, BTreeSet};

/// A place in a file: line and column, from 1.
pub(super) type Place = (u32, u32);

/// Parts that several methods share: a call of theirs is not an operation, but contains some.
const SHARED: [&str; 4] = [
    include_str!("../../scheme/parts/ends.rs"),
    include_str!("../../scheme/parts/max_array.rs"),
    include_str!("../../scheme/parts/max_heap.rs"),
    include_str!("../../scheme/parts/ranges.rs"),
];

/// The operations of a source, by place, with the called name.
pub(super) fn operations(source: &str) -> BTreeMap<Place, String> {
    let code = Code::new(source);
    let mut found = BTreeMap::new();
    let skipped = code.skipped();
    for at in code.find_all(".await") {
        let Some(name) = code.called_before(at) else { continue };
        let text: String = code.chars[name.clone()].iter().collect();
        let defines = |code: &str| {
            code.contains(&format!("async fn {text}("))
                || code.contains(&format!("async fn {text}<"))
        };
        // Memory's own `store` is not one of the scheme's.
        let of_memory = code.chars[..name.start].ends_with(&['m', 'e', 'm', '.']);
        let local = !of_memory && (defines(&code.text) || SHARED.iter().any(|part| defines(part)));
        if text == "merge" || local || skipped.iter().any(|range| range.contains(&name.start)) {
            continue;
        }
        found.insert(code.place(name.start), text);
    }
    found
}

/// The operations that were not reached: in the file whose places fit best.
pub(super) fn missed(
    source: &str,
    reached: &BTreeSet<(&'static str, u32, u32)>,
) -> BTreeMap<Place, String> {
    let all = operations(source);
    let mut by_file: BTreeMap<&str, BTreeSet<Place>> = BTreeMap::new();
    for &(file, line, column) in reached {
        by_file.entry(file).or_default().insert((line, column));
    }
    let hits = |places: &BTreeSet<Place>| all.keys().filter(|place| places.contains(place)).count();
    let best = by_file.values().max_by_key(|places| hits(places)).cloned().unwrap_or_default();
    all.into_iter().filter(|(place, _)| !best.contains(place)).collect()
}

/// A source without comments and strings, places kept.
struct Code {
    chars: Vec<char>,
    text: String,
}

impl Code {
    fn new(source: &str) -> Self {
        let end = source.find("#[cfg(test)]").unwrap_or(source.len());
        let mut chars: Vec<char> = source[..end].chars().collect();
        let mut at = 0;
        while at < chars.len() {
            let next = chars.get(at + 1).copied();
            let end = match chars[at] {
                '/' if next == Some('/') => until(&chars, at, |c, _| c == '\n'),
                '"' => until(&chars, at + 1, |c, before| c == '"' && before != '\\') + 1,
                _ => {
                    at += 1;
                    continue;
                }
            };
            let end = end.min(chars.len());
            chars[at..end].iter_mut().filter(|c| **c != '\n').for_each(|c| *c = ' ');
            at = end;
        }
        let text = chars.iter().collect();
        Self { chars, text }
    }

    fn find_all(&self, text: &str) -> Vec<usize> {
        let pattern: Vec<char> = text.chars().collect();
        let windows = self.chars.windows(pattern.len()).enumerate();
        windows.filter(|(_, window)| *window == pattern.as_slice()).map(|(at, _)| at).collect()
    }

    fn place(&self, at: usize) -> Place {
        let before = &self.chars[..at];
        let line = before.iter().filter(|&&c| c == '\n').count();
        let column = before.iter().rev().take_while(|&&c| c != '\n').count();
        (line as u32 + 1, column as u32 + 1)
    }

    /// The name of the call that ends before `at`.
    fn called_before(&self, at: usize) -> Option<std::ops::Range<usize>> {
        let close = self.chars[..at].iter().rposition(|c| !c.is_whitespace())?;
        if self.chars[close] != ')' {
            return None;
        }
        let mut depth = 0;
        let open = (0..=close).rev().find(|&i| {
            depth += match self.chars[i] {
                ')' => 1,
                '(' => -1,
                _ => 0,
            };
            depth == 0
        })?;
        let start = self.chars[..open].iter().rposition(|&c| !(c.is_alphanumeric() || c == '_'));
        let start = start.map_or(0, |s| s + 1);
        (start < open).then_some(start..open)
    }

    /// The bodies of clear, resolve and invariant, and what depends on a variant's constant.
    fn skipped(&self) -> Vec<std::ops::Range<usize>> {
        let mut ranges = Vec::new();
        for name in ["clear_frame", "clear", "resolve", "invariant"] {
            for opened in ['<', '('] {
                let begins = self.find_all(&format!("fn {name}{opened}"));
                ranges.extend(begins.into_iter().map(|at| at..self.body_end(at)));
            }
        }
        let parameters = self.parameters();
        for word in ["if ", "match "] {
            for at in self.find_all(word) {
                let head_end = until(&self.chars, at, |c, _| c == '{');
                let head = &self.chars[at..head_end];
                if is_constant(head) || parameters.iter().any(|name| names(head, name)) {
                    ranges.push(at..self.chain_end(at));
                }
            }
        }
        ranges
    }

    /// The names of constant parameters: of `<const BROKEN: bool>`, `BROKEN`.
    fn parameters(&self) -> Vec<String> {
        let word = |from: usize| -> String {
            self.chars[from..].iter().take_while(|c| c.is_alphanumeric() || **c == '_').collect()
        };
        let is_parameter = |at: &usize| {
            let before = self.chars[..*at].iter().rev().find(|c| !c.is_whitespace());
            matches!(before, Some('<' | ','))
        };
        let all = self.find_all("const ").into_iter().filter(is_parameter);
        all.map(|at| word(at + "const ".len())).collect()
    }

    /// The end of the first pair of braces after `at`.
    fn body_end(&self, at: usize) -> usize {
        let mut depth = 0;
        for (i, &c) in self.chars.iter().enumerate().skip(at) {
            match c {
                '{' => depth += 1,
                '}' => {
                    depth -= 1;
                    if depth == 0 {
                        return i + 1;
                    }
                }
                _ => {}
            }
        }
        self.chars.len()
    }

    /// The end of an `if` with all its `else`.
    fn chain_end(&self, at: usize) -> usize {
        let mut end = self.body_end(at);
        loop {
            let rest: String = self.chars[end..].iter().take(64).collect();
            if !rest.trim_start().starts_with("else") {
                return end;
            }
            end = self.body_end(end);
        }
    }
}

/// Whether a condition names a constant of a type, like `V::ATOMIC`.
fn is_constant(head: &[char]) -> bool {
    let text: String = head.iter().collect();
    let constant = |rest: &str| {
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        name.len() > 1
            && name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
    };
    let is_parameter = |before: &str| {
        let name: String =
            before.chars().rev().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        name.len() == 1
    };
    text.match_indices("::").any(|(i, _)| constant(&text[i + 2..]) && is_parameter(&text[..i]))
}

/// Whether a condition has this word in it.
fn names(head: &[char], word: &str) -> bool {
    let text: String = head.iter().collect();
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|part| part == word)
}

/// The first place from `at` on where `ends` holds for a character and the one before.
fn until(chars: &[char], at: usize, ends: impl Fn(char, char) -> bool) -> usize {
    (at..chars.len())
        .find(|&i| ends(chars[i], if i > 0 { chars[i - 1] } else { ' ' }))
        .unwrap_or(chars.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = r#"
impl S {
    // mem.load(x).await in a comment
    async fn clear(&self) { mem.store(1).await; }
    async fn store(&self) {
        let a = mem.load("mem.load(x).await").await;
        mem.store(a).await;
        if self.lock.try_acquire(mem, f(1)).await == 0 && x(self
            .entry(mem)
            .await) {
            mem.merge(b).await;
        }
        if V::TEST { mem.one().await } else { mem.two().await }
        self.helper(mem).await;
        self.after(V::ORDER).await;
    }
    async fn helper(&self) { mem.min(3).await; }
}
"#;

    #[test]
    fn operations_are_found_by_the_place_of_their_name() {
        let found = operations(SOURCE);
        let names: Vec<&str> = found.values().map(String::as_str).collect();
        assert_eq!(names, ["load", "store", "try_acquire", "entry", "after", "min"]);
        let places: Vec<Place> = found.keys().copied().collect();
        assert_eq!(places, [(6, 21), (7, 13), (8, 22), (9, 14), (15, 14), (17, 34)]);
    }

    #[test]
    fn what_depends_on_a_constant_parameter_is_left_out() {
        let source = "impl<const ATOMIC: bool, const N: u32> S<ATOMIC, N> {
            async fn store(&self) {
                if ATOMIC { mem.add(1).await } else { mem.load(1).await }
                if ATOMICS { mem.min(1).await }
                match N { 0 => mem.max(1).await, _ => {} }
                const LIMIT: u32 = 3;
                if LIMIT > 2 { mem.store(2).await }
            }
        }";
        let names: Vec<String> = operations(source).into_values().collect();
        assert_eq!(names, ["min", "store"]);
    }

    #[test]
    fn what_was_not_reached_is_named() {
        let reached = BTreeSet::from([
            ("a.rs", 6, 21),
            ("a.rs", 7, 13),
            ("a.rs", 8, 22),
            ("a.rs", 15, 14),
            ("a.rs", 17, 34),
            ("b.rs", 9, 14),
        ]);
        let missed = missed(SOURCE, &reached);
        assert_eq!(missed.into_iter().collect::<Vec<_>>(), [((9, 14), "entry".to_owned())]);
    }

    #[test]
    fn locations_are_places_of_names() {
        #[track_caller]
        fn here() -> Place {
            let site = std::panic::Location::caller();
            (site.line(), site.column())
        }
        struct S;
        impl S {
            #[track_caller]
            fn method(&self) -> Place {
                here()
            }
        }
        let line = line!() + 1;
        assert_eq!(S.method(), (line, 22), "the column of the name, not of its object");
    }
}
