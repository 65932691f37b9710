//! Goldens: `tests/golden/golden.toml` says what `fragloom render` gives for many command lines.
//!
//! Each is drawn again and must give the same, as `fragloom golden verify tests/golden` has it; with `--bless` that
//! rewrites what differs, so that a change is reviewed as a diff. A new case is an entry with a name, a scene and
//! options. One manifest holds for every machine and for debug and release builds: run this test in both.

use std::fs;
use std::path::Path;

use fragloom::catalogue::Catalogue;
use fragloom::cli::CommandLine;
use fragloom::golden::{Manifest, Report, Settings, Status, Work, table, verify};

fn read(path: &Path) -> Manifest {
    Manifest::read(path).expect("a manifest")
}

fn manifest() -> Manifest {
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden"))
}

fn verified(manifest: &mut Manifest) -> Report {
    let catalogue = Catalogue::built_in();
    let draw = CommandLine { catalogue: &catalogue };
    verify(manifest, &draw, &Settings::default(), &Work::SILENT).expect("nothing is written")
}

#[test]
fn everything_is_as_the_manifest_says() {
    let mut manifest = manifest();
    assert!(manifest.entries().len() >= 80, "only {} entries", manifest.entries().len());
    let report = verified(&mut manifest);
    assert!(report.is_clean(), "{}(fragloom golden verify tests/golden --bless)", table(&report));
}

/// Entries that must agree: for every executor, and for every method that keeps everything.
#[test]
fn entries_that_must_agree_do() {
    let manifest = manifest();
    let results = |name: &str| {
        let results = manifest.entry(name).and_then(|entry| entry.results.clone());
        let results = results.unwrap_or_else(|| panic!("no {name}"));
        (results.kept, results.fragments_hash, results.image_hash)
    };
    for (one, other) in [
        ("cubes-exact", "cubes-ab-ll-sim"),
        ("cubes-exact-k3-d24", "cubes-kplus-k3-d24"),
        ("glass-tile", "glass-threads"),
        ("bottles-k1", "bottles-z-buffer"),
    ] {
        assert_eq!(results(one), results(other), "{one} and {other}");
    }
}

/// Negative control: a change of any line of an entry is reported.
#[test]
fn a_changed_entry_is_reported() {
    const ENTRY: &str = r#"format = 1
[[entry]]
name = "pixel"
scene = "layers:count=16"
options = ["--size", "1x1", "-m", "kplus-array", "-k", "3"]
generated = 16
kept = 3
fragments_hash = "e6430f2a9f8860973fb5aee1d7d2fdd0c14e1342c1737bc6a6eb7b9498e8759b"
image_hash = "734ac33c2538a2a3f971f937420ce8980c9c91c43f49e5ad1c94bc8b30ebc94f"
program = "PROGRAM"
"#;
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("golden.toml");
    let entry = ENTRY.replace("PROGRAM", fragloom::golden::PROGRAM);
    let outcome = |text: &str| {
        fs::write(&path, text).expect("written");
        verified(&mut read(&path)).outcomes.swap_remove(0)
    };
    assert_eq!(outcome(&entry).status, Status::Same);
    for (field, old, new) in [
        ("generated", "generated = 16", "generated = 17"),
        ("kept", "kept = 3", "kept = 2"),
        ("fragments_hash", "e643", "e644"),
        ("image_hash", "734a", "734b"),
    ] {
        let changed = outcome(&entry.replace(old, new));
        assert_eq!(
            (changed.status, &changed.results[..]),
            (Status::Different, &[field.to_owned()][..])
        );
    }
    for (old, new) in
        [("count=16", "count=15"), ("\"3\"", "\"2\""), ("kplus-array\", \"-k", "ab-ll\", \"-k")]
    {
        assert!(!outcome(&entry.replace(old, new)).status.is_clean(), "{new}");
    }
}
