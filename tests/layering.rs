//! Data flows one way: a top-level module uses only modules that stand before it in the order that `src/lib.rs`
//! writes down. The order is read from there, so that it is written once.
//!
//! What counts is code, `#[cfg(test)]` included, not what comments and strings say: every path that begins at the
//! crate's root, by `crate::` or by as many `super::` as lead there. Each rule is shown to fail on a file made up
//! for it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// One file's code.
struct Source {
    /// Relative to `src`.
    path: PathBuf,
    tokens: Vec<String>,
}

impl Source {
    fn new(path: impl Into<PathBuf>, text: &str) -> Self {
        Self { path: path.into(), tokens: tokens(&code(text)) }
    }

    /// The names from the root to this file's module.
    fn module(&self) -> Vec<String> {
        let parts = self.path.with_extension("");
        let names = parts.iter().map(|part| part.to_string_lossy().into_owned());
        names.filter(|name| name != "mod").collect()
    }

    /// The first names of all paths from the root.
    fn uses(&self) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        let mut depth = Depth::new(self.module().len());
        for (i, token) in self.tokens.iter().enumerate() {
            depth.pass(&self.tokens, i);
            let supers = self.supers(i);
            let root = token == "crate" || (supers > 0 && supers == depth.modules());
            let last = i + 2 * supers.saturating_sub(1);
            if root && self.tokens.get(last + 1).is_some_and(|next| next == "::") {
                found.extend(heads(&self.tokens[last + 2..]));
            }
        }
        found
    }

    /// The length of the chain `super::super::...` that begins at `i`; 0 inside of one.
    fn supers(&self, i: usize) -> usize {
        let is_super = |at: usize| self.tokens.get(at).is_some_and(|token| token == "super");
        if i >= 2 && is_super(i - 2) {
            return 0;
        }
        (0..).take_while(|n| is_super(i + 2 * n)).count()
    }
}

/// How many modules deep a token stands: the file's own, and those opened by `mod x {`.
struct Depth {
    file: usize,
    braces: usize,
    /// The number of braces outside each open inline module.
    open: Vec<usize>,
}

impl Depth {
    fn new(file: usize) -> Self {
        Self { file, braces: 0, open: Vec::new() }
    }

    fn modules(&self) -> usize {
        self.file + self.open.len()
    }

    fn pass(&mut self, tokens: &[String], i: usize) {
        match tokens[i].as_str() {
            "{" => {
                if i >= 2 && tokens[i - 2] == "mod" {
                    self.open.push(self.braces);
                }
                self.braces += 1;
            }
            "}" => {
                self.braces = self.braces.saturating_sub(1);
                if self.open.last() == Some(&self.braces) {
                    self.open.pop();
                }
            }
            _ => {}
        }
    }
}

/// The first names after `crate::`: one, or those of a group.
fn heads(tokens: &[String]) -> BTreeSet<String> {
    if tokens.first().is_none_or(|token| token != "{") {
        return tokens.first().cloned().into_iter().collect();
    }
    let mut depth = 0;
    let mut names = BTreeSet::new();
    for (before, token) in tokens.iter().zip(&tokens[1..]) {
        depth += usize::from(before == "{");
        if depth == 1 && (before == "{" || before == ",") {
            names.insert(token.clone());
        }
        depth -= usize::from(token == "}");
        if depth == 0 {
            break;
        }
    }
    names.remove("}");
    names
}

/// Names and signs; `::` is one sign.
fn tokens(code: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut word = false;
    let mut colon = false;
    for c in code.chars() {
        let in_word = c.is_alphanumeric() || c == '_';
        match tokens.last_mut() {
            Some(last) if (in_word && word) || (c == ':' && colon) => last.push(c),
            _ if !c.is_whitespace() => tokens.push(c.to_string()),
            _ => {}
        }
        colon = c == ':' && !colon;
        word = in_word;
    }
    tokens
}

/// The text without comments, strings and characters.
fn code(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = not_code(rest);
        code.push(if skipped > 0 { ' ' } else { c });
        rest = &rest[skipped.max(c.len_utf8())..];
    }
    code
}

/// The bytes of the comment or literal that `text` begins with, or 0.
fn not_code(text: &str) -> usize {
    let until = |end: &str, from: usize| {
        text[from..].find(end).map_or(text.len(), |at| from + at + end.len())
    };
    if text.starts_with("//") {
        return text.find('\n').unwrap_or(text.len());
    }
    if text.starts_with("/*") {
        return until("*/", 2);
    }
    if let Some(quote) = text.strip_prefix('r').and_then(raw_quote) {
        let hashes = "#".repeat(quote - 1);
        return until(&format!("\"{hashes}"), quote + 1);
    }
    match text.as_bytes() {
        [b'"', ..] => quoted(text, b'"'),
        [b'\'', b'\\', ..] | [b'\'', _, b'\'', ..] => quoted(text, b'\''),
        _ => 0,
    }
}

/// Bytes of `#...#"` that open a raw string after its `r`.
fn raw_quote(text: &str) -> Option<usize> {
    let hashes = text.bytes().take_while(|&b| b == b'#').count();
    (text.as_bytes().get(hashes) == Some(&b'"')).then_some(hashes + 1)
}

/// The bytes from one quote to the next that no backslash escapes.
fn quoted(text: &str, quote: u8) -> usize {
    let bytes = text.as_bytes();
    let mut at = 1;
    while at < bytes.len() && bytes[at] != quote {
        at += 1 + usize::from(bytes[at] == b'\\');
    }
    (at + 1).min(text.len())
}

/// Every file of the library.
fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    collect(&root, &root, &mut found);
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found.retain(|source| !["lib.rs", "main.rs"].iter().any(|name| source.path == Path::new(name)));
    found
}

fn collect(root: &Path, folder: &Path, found: &mut Vec<Source>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(root, &path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).expect("a file in UTF-8");
            found.push(Source::new(path.strip_prefix(root).expect("below"), &text));
        }
    }
}

/// The modules in the order of the crate's documentation.
fn order() -> Vec<String> {
    let text = include_str!("../src/lib.rs");
    let docs = text.lines().filter_map(|line| line.strip_prefix("//!"));
    let arrows: String = docs.filter(|line| line.contains('\u{2192}') || ends_flow(line)).collect();
    arrows.split('\u{2192}').map(|name| name.trim().trim_matches('`').to_owned()).collect()
}

/// The last line of the flow: names without an arrow behind them.
fn ends_flow(line: &str) -> bool {
    line.trim() == "`cli`"
}

/// What a file uses that does not stand before its own module.
fn upward(source: &Source, order: &[String]) -> Vec<String> {
    let place = |name: &String| order.iter().position(|known| known == name);
    let module = &source.module()[0];
    let own = place(module).unwrap_or_else(|| panic!("{module} has no place in lib.rs"));
    let used = source.uses().into_iter().filter(|name| name != module);
    used.filter(|name| place(name).is_none_or(|at| at > own))
        .map(|name| format!("{} uses {name}", source.path.display()))
        .collect()
}

/// Whether a file names the standard library's atomics.
fn names_atomics(source: &Source) -> bool {
    let types =
        ["Bool", "Ptr", "U8", "U16", "U32", "U64", "Usize", "I8", "I16", "I32", "I64", "Isize"];
    let is_type =
        |token: &String| token.strip_prefix("Atomic").is_some_and(|rest| types.contains(&rest));
    let of_std = |w: &[String]| w[0] == "sync" && w[1..].iter().any(|token| token == "atomic");
    source.tokens.iter().any(is_type) || source.tokens.windows(4).any(of_std)
}

/// Where atomics may be named: memory is made of them, and the threads executor counts with them which packets
/// are taken, which no scheme sees.
fn may_name_atomics(source: &Source) -> bool {
    source.path.starts_with("memory") || source.path == Path::new("exec/threads.rs")
}

#[test]
fn the_order_names_every_module_once() {
    let declared = tokens(&code(include_str!("../src/lib.rs")));
    let modules = declared.windows(2).filter(|pair| pair[0] == "mod").map(|pair| pair[1].clone());
    let (order, modules) = (order(), modules.collect::<BTreeSet<_>>());
    assert_eq!(order.iter().cloned().collect::<BTreeSet<_>>(), modules);
    assert_eq!(order.len(), modules.len());
    assert_eq!((order[0].as_str(), order[order.len() - 1].as_str()), ("error", "cli"));
}

#[test]
fn every_module_uses_only_what_stands_before_it() {
    let (order, sources) = (order(), sources());
    assert!(sources.len() > 60, "{} files", sources.len());
    let wrong: Vec<_> = sources.iter().flat_map(|source| upward(source, &order)).collect();
    assert!(wrong.is_empty(), "against the order {order:?}:\n{}", wrong.join("\n"));
    let uses: usize = sources.iter().map(|source| source.uses().len()).sum();
    assert!(uses > 150, "only {uses} uses were found: is the parser blind?");
}

#[test]
fn only_memory_names_atomics() {
    let sources = sources();
    let named: Vec<_> = sources.iter().filter(|source| names_atomics(source)).collect();
    let wrong: Vec<_> = named.iter().filter(|source| !may_name_atomics(source)).collect();
    assert!(wrong.is_empty(), "{:?}", wrong.iter().map(|source| &source.path).collect::<Vec<_>>());
    assert!(named.len() >= 2, "memory has atomics");
}

/// Negative control: each way to reach up is found.
#[test]
fn a_file_that_reaches_up_is_found() {
    let found = |path: &str, text: &str| upward(&Source::new(path, text), &order());
    for text in [
        "use crate::render::Report;",
        "use crate::{error::Error, render};",
        "use crate::{num::{hex, color}, render::{self, Report}};",
        "fn f() { let _ = crate::render::render; }",
        "use super::super::render::Report;",
        "mod tests { use super::super::super::render; }",
        "mod a { } fn f() { super::super::render::f() }",
    ] {
        assert_eq!(found("raster/made_up.rs", text), ["raster/made_up.rs uses render"], "{text}");
    }
    assert_eq!(found("raster/mod.rs", "use super::render;"), ["raster/mod.rs uses render"]);
    assert_eq!(found("error.rs", "use crate::number;"), ["error.rs uses number"], "unknown");
}

#[test]
fn what_is_no_use_is_not_found() {
    let text = r##"
        //! See [`crate::render`].
        /* crate::render */
        use crate::raster::plane; use crate::num::hex; use super::render;
        const A: &str = "crate::render \" crate::render";
        const B: &str = r#"crate::render " crate::render"#;
        const C: [char; 3] = ['"', '\'', '"'];
        fn f<'a>(a: &'a str) -> &'a str { a } // crate::render
        mod tests { use super::super::render; }
    "##;
    assert_eq!(upward(&Source::new("raster/made_up.rs", text), &order()), Vec::<String>::new());
}

/// Negative control for the second rule.
#[test]
fn a_scheme_with_atomics_of_its_own_is_found() {
    let scheme = |text| Source::new("scheme/made_up.rs", text);
    for text in [
        "use std::sync::atomic::Ordering;",
        "use std::sync::{atomic, Arc};",
        "use core::sync::atomic as a;",
        "static A: AtomicU32 = x;",
    ] {
        assert!(names_atomics(&scheme(text)) && !may_name_atomics(&scheme(text)), "{text}");
    }
    assert!(!names_atomics(&scheme("// std::sync::atomic\nlet w: Words<Atomic> = mem.atomic();")));
}
