//! Data flows one way: a top-level module uses only modules that stand before it in the order that `src/lib.rs` writes
//! down, a folder of a module only folders that stand before it in the order of the module's `mod.rs`, and within a
//! module no files use each other in a circle. The orders are read from there, so that each is written once.
//!
//! What counts is code, `#[cfg(test)]` included (but for circles), not what comments and strings say: every path that
//! begins at the crate's root, by `crate::`, `super::` or `self::`. A name that a `mod.rs` re-exports counts as the
//! file that it comes from. Each rule is shown to fail on files made up for it.

use std::collections::{BTreeMap, BTreeSet};
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
        let from_root = |(path, _): Found| path.into_iter().next();
        self.paths().into_iter().filter_map(from_root).collect()
    }

    /// All paths that lead out of this file's module, from the root; and whether a name is made public there.
    fn paths(&self) -> Vec<Found> {
        let mut found = Vec::new();
        let mut depth = Depth::default();
        for (i, token) in self.tokens.iter().enumerate() {
            depth.pass(&self.tokens, i);
            let supers = self.supers(i);
            let own = self.module();
            let base = match token.as_str() {
                "crate" => Vec::new(),
                "self" if depth.open.is_empty() => own,
                "super" if supers >= depth.open.len().max(1) => {
                    let up = supers - depth.open.len();
                    own[..own.len().saturating_sub(up)].to_vec()
                }
                _ => continue,
            };
            let last = i + 2 * supers.saturating_sub(1);
            if self.tokens.get(last + 1).is_some_and(|next| next == "::") {
                let public = i >= 2 && self.tokens[i - 1] == "use" && self.tokens[i - 2] == "pub";
                let leaves = leaves(&self.tokens[last + 2..]).into_iter();
                found.extend(
                    leaves.map(|leaf| (base.iter().cloned().chain(leaf).collect(), public)),
                );
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

/// The inline modules, `mod x {`, that a token stands in.
#[derive(Default)]
struct Depth {
    braces: usize,
    /// The number of braces outside each open inline module.
    open: Vec<usize>,
}

impl Depth {
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

/// A path from the root, and whether it is re-exported.
type Found = (Vec<String>, bool);

/// The paths that begin here: one, or those of a group.
fn leaves(tokens: &[String]) -> Vec<Vec<String>> {
    let mut path = Vec::new();
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        if token == "{" {
            let group = members(&tokens[at..]).into_iter().flat_map(leaves);
            return group.map(|leaf| path.iter().cloned().chain(leaf).collect()).collect();
        }
        if token != "self" && token != "*" {
            path.push(token.clone());
        }
        if tokens.get(at + 1).is_none_or(|next| next != "::") {
            break;
        }
        at += 2;
    }
    vec![path]
}

/// What stands between the commas of a group, which `tokens` begins with.
fn members(tokens: &[String]) -> Vec<&[String]> {
    let (mut depth, mut from, mut found) = (0, 1, Vec::new());
    for (at, token) in tokens.iter().enumerate() {
        depth += usize::from(token == "{");
        depth -= usize::from(token == "}");
        if depth == 0 || (depth == 1 && token == ",") {
            if at > from {
                found.push(&tokens[from..at]);
            }
            from = at + 1;
        }
        if depth == 0 {
            break;
        }
    }
    found
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

/// The names in the order that a module's documentation gives: the lines with arrows, and the one they lead to.
fn order_in(text: &str) -> Vec<String> {
    let docs: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("//!")).collect();
    let arrow = |at: usize| docs.get(at).is_some_and(|line| line.contains('\u{2192}'));
    let goes_on = |at: usize| at > 0 && docs[at - 1].trim_end().ends_with('\u{2192}');
    let flow = (0..docs.len()).filter(|&at| arrow(at) || goes_on(at)).map(|at| docs[at]);
    let names = flow.flat_map(|line| line.split('\u{2192}')).map(str::trim);
    names.filter(|name| !name.is_empty()).map(|name| name.trim_matches('`').to_owned()).collect()
}

/// The modules in the order of the crate's documentation.
fn order() -> Vec<String> {
    order_in(include_str!("../src/lib.rs"))
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

/// The files of the library by module, and what each `mod.rs` re-exports.
struct House {
    sources: Vec<Source>,
    exports: BTreeMap<Vec<String>, Vec<String>>,
}

impl House {
    fn new(sources: Vec<Source>) -> Self {
        let mut exports = BTreeMap::new();
        for source in sources.iter().filter(|source| source.path.ends_with("mod.rs")) {
            for (path, _) in source.paths().into_iter().filter(|(_, public)| *public) {
                let name = path.last().cloned();
                exports.insert(source.module().into_iter().chain(name).collect(), path);
            }
        }
        Self { sources, exports }
    }

    /// The module whose file a path leads to, behind re-exports.
    fn home(&self, path: &[String]) -> Option<Vec<String>> {
        let exported = (1..=path.len()).rev().find_map(|n| self.exports.get(&path[..n]));
        if let Some(origin) = exported.filter(|origin| origin[..] != *path) {
            return self.home(origin);
        }
        let known = |n: &usize| self.sources.iter().any(|source| source.module() == path[..*n]);
        (1..=path.len()).rev().find(known).map(|n| path[..n].to_vec())
    }

    /// What the folders of `module` use that does not stand before them; a file that the order does not name stands
    /// before all folders. The `mod.rs` itself is free.
    fn upward_in(&self, module: &str, order: &[String]) -> Vec<String> {
        let place = |room: &String| order.iter().position(|known| known == room);
        let mut wrong = Vec::new();
        for source in self.sources.iter().filter(|s| s.module()[0] == module) {
            let Some(room) = source.module().get(1).cloned() else { continue };
            for (path, _) in source.paths() {
                let Some(home) = self.home(&path).filter(|home| home[0] == module) else {
                    continue;
                };
                let Some(used) = home.get(1).filter(|used| **used != room) else { continue };
                if place(used).is_some_and(|at| place(&room).is_none_or(|own| own < at)) {
                    wrong.push(format!("{} uses {used}", source.path.display()));
                }
            }
        }
        wrong
    }

    /// For each file, the files of its top-level module that it uses; what holds it, and what it holds, apart.
    fn edges(&self) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
        let edges = |source: &Source| {
            let own = source.module();
            let homes = source.paths().into_iter().filter_map(|(path, _)| self.home(&path));
            let used = homes.filter(|home| home[0] == own[0] && !own.starts_with(home));
            (own.clone(), used.filter(|home| !home.starts_with(&own)).collect())
        };
        self.sources.iter().map(edges).collect()
    }

    /// Pairs of files of which each leads to the other.
    fn circles(&self) -> Vec<String> {
        let edges = self.edges();
        let reach = |from: &Vec<String>| {
            let mut seen = BTreeSet::new();
            let mut next: Vec<&Vec<String>> = edges[from].iter().collect();
            while let Some(module) = next.pop() {
                if seen.insert(module) {
                    next.extend(edges.get(module).into_iter().flatten());
                }
            }
            seen
        };
        let all: BTreeMap<_, _> = edges.keys().map(|module| (module, reach(module))).collect();
        let circle = |(a, reached): (&&Vec<String>, &BTreeSet<&Vec<String>>)| {
            let back = reached.iter().filter(|b| a < *b && all[*b].contains(*a));
            back.map(|b| format!("{} and {}", a.join("::"), b.join("::"))).collect::<Vec<_>>()
        };
        all.iter().flat_map(circle).collect()
    }
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

/// Modules whose folders have an order, which their `mod.rs` writes down.
const ROOMS: [(&str, &str); 4] = [
    ("cli", include_str!("../src/cli/mod.rs")),
    ("explore", include_str!("../src/explore/mod.rs")),
    ("gpu", include_str!("../src/gpu/mod.rs")),
    ("scheme", include_str!("../src/scheme/mod.rs")),
];

#[test]
fn every_room_uses_only_rooms_that_stand_before_it() {
    let house = House::new(sources());
    for (module, text) in ROOMS {
        let order = order_in(text);
        let declared = tokens(&code(text));
        let is_folder = |name: &String| {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(module).join(name);
            folder.join("mod.rs").exists()
        };
        let modules =
            declared.windows(2).filter(|pair| pair[0] == "mod").map(|pair| pair[1].clone());
        let rooms: BTreeSet<String> = modules.filter(is_folder).collect();
        assert_eq!(order.iter().cloned().collect::<BTreeSet<_>>(), rooms, "{module}");
        assert!(rooms.len() >= 3, "{rooms:?}");
        let wrong = house.upward_in(module, &order);
        assert!(wrong.is_empty(), "against the order {order:?}:\n{}", wrong.join("\n"));
    }
}

#[test]
fn no_files_of_a_module_use_each_other_in_a_circle() {
    let house = House::new(sources());
    let edges: usize = house.edges().values().map(BTreeSet::len).sum();
    assert!(edges > 300, "only {edges} uses were found: is the parser blind?");
    assert_eq!(house.circles(), Vec::<String>::new());
}

/// No folder has more than a dozen files of code, and its `mod.rs`.
#[test]
fn no_folder_is_crowded() {
    let mut folders: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for source in sources() {
        let parent = source.path.parent().expect("a folder").to_owned();
        *folders.entry(parent).or_default() += usize::from(!source.path.ends_with("mod.rs"));
    }
    let crowded: Vec<_> = folders.iter().filter(|(_, files)| **files > 12).collect();
    assert!(crowded.is_empty(), "{crowded:?}");
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

/// Negative controls for folders and circles.
#[test]
fn a_room_that_reaches_up_and_a_circle_are_found() {
    let house = |files: &[(&str, &str)]| {
        House::new(files.iter().map(|(path, text)| Source::new(path, text)).collect())
    };
    let order = ["low", "high"].map(str::to_owned);
    for up in [
        "use crate::m::high::x::X;",
        "use super::super::high::{Y, x::{self, X}};",
        "use crate::m::X;",
        "use crate::m::{loose::L, X};",
        "fn f() { super::super::high::x::f() }",
        "mod tests { use super::super::super::high::x; }",
    ] {
        let files = [
            ("m/mod.rs", "pub mod low; pub mod high; pub use self::high::X;"),
            ("m/high/mod.rs", "pub mod x; pub use self::x::X;"),
            ("m/high/x.rs", "use crate::m::low::a::A; use super::super::low;"),
            ("m/low/mod.rs", ""),
            ("m/low/a.rs", up),
            ("m/loose.rs", "use crate::other::b;"),
        ];
        let mut wrong = house(&files).upward_in("m", &order);
        wrong.dedup();
        assert_eq!(wrong, ["m/low/a.rs uses high"], "{up}");
        assert!(!house(&files).circles().is_empty(), "{up}");
    }
    let circle = [
        ("m/mod.rs", ""),
        ("m/a.rs", "use super::b::B;"),
        ("m/b.rs", "use super::c::{self};"),
        ("m/c.rs", "fn f() { crate::m::a::f() }"),
    ];
    let found = house(&circle).circles();
    assert_eq!(found, ["m::a and m::b", "m::a and m::c", "m::b and m::c"]);
    let parents = [("m/mod.rs", "use self::a::A;"), ("m/a.rs", "use super::A; use crate::m;")];
    assert_eq!(house(&parents).circles(), Vec::<String>::new());
    let loose = [("m/mod.rs", ""), ("m/l.rs", "use super::low::a;"), ("m/low/a.rs", "")];
    assert_eq!(house(&loose).upward_in("m", &order), ["m/l.rs uses low"]);
}
