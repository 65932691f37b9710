//! NumPy opens what fragloom writes, and computes the same from it: the page docs/numpy.md, run block by block.
//!
//! These tests need a Python with NumPy: the one that `FRAGLOOM_PYTHON` names, or one that is found. Without one they
//! are skipped with a line that says so, unless `FRAGLOOM_PYTHON` is in the environment, as CI has it.

#[path = "support/command.rs"]
#[allow(dead_code, reason = "its other users use the rest")]
mod support;

use std::fs;
use std::path::Path;
use std::process::Command;

use support::Dir;

const PAGE: &str = include_str!("../docs/numpy.md");

/// Stands between the outputs of two blocks.
const MARK: &str = "----";

/// A Python with NumPy; or none, and a line that says so, unless it is demanded.
fn python(test: &str) -> Option<String> {
    let demanded = std::env::var("FRAGLOOM_PYTHON").ok();
    let has_numpy = |python: &&String| {
        let run = Command::new(python).args(["-c", "import numpy"]).output();
        run.is_ok_and(|run| run.status.success())
    };
    let names = match &demanded {
        Some(named) => vec![named.clone()],
        None => ["python3", "/usr/bin/python3", "python"].map(str::to_owned).to_vec(),
    };
    let found = names.iter().find(has_numpy).cloned();
    if found.is_none() {
        assert!(demanded.is_none(), "FRAGLOOM_PYTHON={demanded:?} has no NumPy");
        println!("skipped: {test} needs Python with NumPy");
    }
    found
}

/// Run Python in a folder; what it prints.
fn run(python: &str, dir: &Dir, script: &str) -> Result<String, String> {
    fs::write(dir.path("script.py"), script).expect("a file");
    let mut command = Command::new(python);
    let run = command.arg("script.py").current_dir(dir.path("")).output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    if run.status.success() { Ok(text(run.stdout)) } else { Err(text(run.stderr)) }
}

/// The contents of a page's blocks of one language, each with what the page shows it to print.
fn blocks(page: &str, language: &str) -> Vec<(String, Option<String>)> {
    let open = format!("```{language}\n");
    let block = |rest: &str| {
        let (code, behind) = rest.split_once("```").expect("a block ends");
        let shown = behind.strip_prefix("\n\n```text\n");
        let shown = shown.and_then(|text| text.split_once("```")).map(|(text, _)| text.to_owned());
        (code.to_owned(), shown)
    };
    page.split(&open).skip(1).map(block).collect()
}

/// Run the page's command lines in a folder.
fn commands(dir: &Dir) {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let [(lines, None)] = &blocks(PAGE, "console")[..] else { panic!("one block of commands") };
    for line in lines.lines() {
        let line = line.strip_prefix("$ fragloom ").expect("a command");
        let (line, into) = line.split_once(" > ").map_or((line, None), |(a, b)| (a, Some(b)));
        let run = dir.run(&line.replace("scenes/", &format!("{}/", scenes.display())));
        assert_eq!(run.code, 0, "{run:?}");
        if let Some(name) = into {
            fs::write(dir.path(name), run.stdout).expect("a file");
        }
    }
}

/// All blocks of the page as one script, and what each shows.
fn script() -> (String, Vec<Option<String>>) {
    let (code, shown): (Vec<String>, Vec<_>) = blocks(PAGE, "python").into_iter().unzip();
    (code.join(&format!("\nprint({MARK:?})\n")), shown)
}

#[test]
fn the_page_prints_what_it_shows() {
    let Some(python) = python("the page on NumPy") else { return };
    let dir = Dir::new();
    commands(&dir);
    let (script, shown) = script();
    assert!(shown.len() >= 6 && shown.iter().flatten().count() >= 5, "{shown:?}");
    let printed = run(&python, &dir, &script).expect("it runs");
    let printed: Vec<&str> = printed.split(&format!("{MARK}\n")).collect();
    assert_eq!(printed.len(), shown.len());
    for (printed, shown) in printed.iter().zip(shown) {
        assert_eq!(*printed, shown.unwrap_or_default());
    }
}

/// Negative control: one bit of a fragment, and hash and picture are others.
#[test]
fn a_changed_fragment_is_found() {
    let Some(python) = python("a changed fragment") else { return };
    let dir = Dir::new();
    commands(&dir);
    let change = "import numpy\nold = dict(numpy.load('glass.npz'))\nold['data'][1000] ^= 0x40\n\
                  numpy.savez('glass.npz', **old)\n";
    run(&python, &dir, change).expect("it is written");
    let printed = run(&python, &dir, &script().0).expect("it runs");
    assert!(printed.contains("False True\n"), "the hash of fragments: {printed}");
    assert!(printed.contains("pixels that differ: 1 of 5760"), "{printed}");
}

/// Every kind of file: arrays, their types and shapes.
#[test]
fn every_file_opens() {
    let Some(python) = python("files of every kind") else { return };
    let dir = Dir::new();
    let list = "import numpy, sys\nfor name in sorted(numpy.load('f.npz').files):\n    \
                a = numpy.load('f.npz', allow_pickle=False)[name]\n    print(name, a.dtype, a.shape)\n";
    let opened = |line: &str| {
        let made = dir.run(line);
        assert_eq!(made.code, 0, "{made:?}");
        run(&python, &dir, list).unwrap_or_else(|error| panic!("{line}: {error}"))
    };
    let lists = "height uint32 ()\noffsets uint64 (61,)\nwidth uint32 ()\n";
    let size = "layers:count=4 --size 10x6 -q";
    for data in ["color", "primitive"] {
        let text = opened(&format!("render {size} -m ab-ll --data {data} --fragments f.npz"));
        assert_eq!(text, format!("data uint32 (240,)\ndepth uint32 (240,)\n{lists}"));
    }
    let text = opened(&format!("render {size} -m skb+ofm -k 2 --fragments f.npz"));
    assert!(text.contains("rgba float64 (") && text.contains(", 4)\n"), "{text}");
    assert!(text.contains("thickness float64 (") && text.contains("weight float64 ("), "{text}");
    let line = "render cubes --size 10x6 -q -m ab-ll --effect ldi --voxels 8 --ldi f.npz";
    let text = opened(line);
    assert!(text.contains("voxels bool (8, 6, 10)\n"), "{text}");
}
