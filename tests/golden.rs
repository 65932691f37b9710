//! Goldens as a text ledger: `tests/golden/ledger.txt` has one line per scene and options, which is a command line of
//! `fragloom render` and what came out of it.
//!
//! Each is drawn again by the real binary and must give the same. `FRAGLOOM_BLESS=1` rewrites the ledger instead, so
//! that a change is reviewed as a diff; a new case is a line with `?` in place of its results. One ledger holds for
//! every machine and for debug and release builds: run this test in both.

use std::fmt;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

/// One line of the ledger.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Entry {
    name: String,
    /// `generated`, `kept`, `fragments_hash` and `image_hash`, as written.
    results: [String; 4],
    /// What follows `fragloom render`.
    arguments: String,
}

const FIELDS: [&str; 4] = ["generated", "kept", "fragments_hash", "image_hash"];

impl Entry {
    /// `None` for comments and empty lines.
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let name = words.next().filter(|word| !word.starts_with('#'))?.to_owned();
        let results = FIELDS.map(|_| words.next().unwrap_or("?").to_owned());
        Some(Self { name, results, arguments: words.collect::<Vec<_>>().join(" ") })
    }

    /// Draw it now.
    fn drawn(&self) -> Self {
        let report = report(&self.arguments);
        let text = |field: &str| match &report[field] {
            Value::String(text) => text.clone(),
            number => number.to_string(),
        };
        Self { results: FIELDS.map(text), ..self.clone() }
    }

    /// One line per field that is not as written.
    fn differences(&self, drawn: &Self) -> Vec<String> {
        let fields = FIELDS.iter().zip(self.results.iter().zip(&drawn.results));
        fields
            .filter(|(_, (written, found))| written != found)
            .map(|(field, (written, found))| {
                format!("{} ({}): {field} is {found}, not {written}", self.name, self.arguments)
            })
            .collect()
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [generated, kept, fragments, image] = &self.results;
        let Self { name, arguments, .. } = self;
        write!(f, "{name:<24} {generated:>8} {kept:>8} {fragments} {image} {arguments}")
    }
}

/// The JSON report of `fragloom render`, run in the project's folder.
fn report(arguments: &str) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fragloom"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["render", "--json", "-q"]);
    let output = command.args(arguments.split(' ')).output().expect("the binary runs");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "render {arguments}: {stderr}");
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/ledger.txt")
}

fn ledger() -> String {
    std::fs::read_to_string(path()).expect("the ledger")
}

fn entries() -> Vec<Entry> {
    ledger().lines().filter_map(Entry::parse).collect()
}

/// The ledger with the results of now.
fn blessed(ledger: &str) -> String {
    let line = |line: &str| match Entry::parse(line) {
        Some(entry) => format!("{}\n", entry.drawn()),
        None => format!("{line}\n"),
    };
    ledger.lines().map(line).collect()
}

#[test]
fn everything_is_as_the_ledger_says() {
    if std::env::var_os("FRAGLOOM_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(path(), blessed(&ledger())).expect("the ledger can be written");
        return;
    }
    let entries = entries();
    assert!(entries.len() >= 16, "only {} entries", entries.len());
    let wrong: Vec<_> =
        entries.iter().flat_map(|entry| entry.differences(&entry.drawn())).collect();
    assert!(wrong.is_empty(), "{}\n(FRAGLOOM_BLESS=1 rewrites the ledger)", wrong.join("\n"));
}

#[test]
fn the_ledger_is_in_its_own_form() {
    let entries = entries();
    for (entry, line) in entries.iter().zip(ledger().lines().filter(|l| Entry::parse(l).is_some()))
    {
        assert_eq!(entry.to_string(), line);
        assert!(entry.results[2..].iter().all(|h| h.len() == 64 || h == "null"), "{line}");
    }
    let mut names: Vec<_> = entries.iter().map(|entry| &entry.name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), entries.len(), "names are unique");
}

/// Lines that say the same must agree: for every executor, and for every method that keeps everything.
#[test]
fn lines_that_must_agree_do() {
    let entries = entries();
    let results = |name: &str| {
        let found = entries.iter().find(|entry| entry.name == name);
        &found.unwrap_or_else(|| panic!("no {name}")).results
    };
    for (one, other) in [
        ("cubes-exact", "cubes-ab-ll-sim"),
        ("cubes-exact-k3-d24", "cubes-kplus-k3-d24"),
        ("glass-tile", "glass-threads"),
        ("bottles-k1", "bottles-z-buffer"),
    ] {
        assert_eq!(results(one)[1..], results(other)[1..], "{one} and {other}");
    }
}

/// Negative control: a change of any field of a line is reported, and so is a change of what is drawn.
#[test]
fn a_changed_line_is_reported() {
    let entry = entries().swap_remove(0);
    let drawn = entry.drawn();
    assert_eq!(entry.differences(&drawn), Vec::<String>::new());
    for (i, field) in FIELDS.iter().enumerate() {
        let mut changed = entry.clone();
        let last = changed.results[i].pop();
        changed.results[i].push(if last == Some('0') { '1' } else { '0' });
        let found = changed.differences(&drawn);
        assert!(found.len() == 1 && found[0].contains(field), "{found:?}");
    }
    let other = Entry { arguments: format!("{} --alpha 0.125", entry.arguments), ..entry.clone() };
    assert!(!entry.differences(&other.drawn()).is_empty());
}
