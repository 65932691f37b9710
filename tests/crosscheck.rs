//! `fragloom crosscheck` survives its devices: rows are told as they finish, what a driver does to its process costs one
//! row, a run that was cut goes on, and reports become a page. The device is a double that fails as it is told, so that
//! no driver is needed. What devices compute is in `gpu/`.

#![cfg(feature = "gpu")]

#[path = "support/command.rs"]
mod support;

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

use serde_json::Value;
use support::{Dir, Run};

/// Three methods, two paths, three pictures.
const LINE: &str = "crosscheck layers:count=3 cubes sphere:sides=8 --size 24x16 -m ab-ll,s-buffer,kplus-array --limit 1";
const ROWS: usize = 18;

fn run(dir: &Dir, more: &str) -> Run {
    dir.run(&format!("{LINE} {more}"))
}

fn rows(run: &Run) -> Vec<Value> {
    let Value::Array(rows) = run.json() else { panic!("a list: {run:?}") };
    rows
}

/// `METHOD/SCENE/PATH`, as the double's faults name rows.
fn place(row: &Value) -> String {
    let of = |field: &str| row[field].as_str().unwrap_or_default().to_owned();
    [of("method"), of("scene"), of("path")].join("/")
}

fn row<'a>(rows: &'a [Value], at: &str) -> &'a Value {
    rows.iter().find(|row| place(row) == at).unwrap_or_else(|| panic!("{at} in {rows:?}"))
}

#[test]
fn without_a_fault_all_is_equal() {
    let dir = Dir::new();
    let run = run(&dir, "--test-double none --json");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let rows = rows(&run);
    assert_eq!(rows.len(), ROWS);
    for row in &rows {
        assert_eq!((&row["status"], &row["finding"]), (&"equal".into(), &false.into()), "{row}");
        assert!(row["fragments"].as_u64().unwrap() > 100, "{row}");
        // What is asked for is what is told: two scenes may have one name.
        let asked = row["asked"].as_str().unwrap();
        assert_eq!(asked.split(':').next().unwrap(), row["scene"], "{row}");
    }
    // What may hang comes last.
    let waits = |row: &Value| row["method"] == "kplus-array";
    assert!(rows.is_sorted_by_key(waits), "{rows:?}");
}

/// Each fault costs exactly the row that it is at.
#[test]
fn a_fault_costs_its_row() {
    let dir = Dir::new();
    let faults = [
        ("hangs", "ab-ll/cubes/compute", "hung", "no sign of life for 7 s"),
        ("times-out", "kplus-array/layers/raster", "hung", "no answer within 1 seconds"),
        ("is-lost", "s-buffer/layers/compute", "device lost", "told to"),
        ("crashes", "s-buffer/sphere/raster", "failed", "its process ended early: signal"),
        ("gives-garbage", "ab-ll/sphere/raster", "different", "excluded by the checker"),
        // Of a method that may lose fragments, that is no finding.
        ("gives-garbage", "kplus-array/cubes/compute", "different", "as the checker expects"),
    ];
    let told: Vec<String> =
        faults.iter().map(|(fault, row, ..)| format!("{fault}={row}")).collect();
    let run = run(&dir, &format!("--json --test-double {}", told.join(",")));
    assert_eq!(run.code, 1, "{run:?}");
    let all = rows(&run);
    assert_eq!(all.len(), ROWS);
    for (_, at, status, reason) in faults {
        let row = row(&all, at);
        assert_eq!(row["status"], status, "{row}");
        assert!(row["reason"].as_str().unwrap().contains(reason), "{row}");
        assert_eq!(row["finding"], reason != "as the checker expects", "{row}");
        let told = |line: &&str| line.starts_with("violation: ") && line.contains(status);
        let [method, _, path] = at.split('/').collect::<Vec<_>>().try_into().unwrap();
        let asked = row["asked"].as_str().unwrap();
        let place = format!("{method} on {asked}, {path} path");
        let found = run.stderr.lines().filter(told).any(|line| line.contains(&place));
        assert_eq!(found, row["finding"] == true, "{place} in {}", run.stderr);
    }
    let others = all.iter().filter(|row| !faults.iter().any(|fault| fault.1 == place(row)));
    assert_eq!(others.clone().count(), ROWS - faults.len());
    others.for_each(|row| assert_eq!(row["status"], "equal", "{row}"));
}

/// A device that no process can open any more is given up, and every row says so.
#[test]
fn a_dead_device_is_given_up() {
    let dir = Dir::new();
    let at = "s-buffer/cubes/compute";
    let run = run(&dir, &format!("--json --test-double dies:dead.txt={at}"));
    assert_eq!(run.code, 1, "{run:?}");
    let all = rows(&run);
    assert_eq!(all.len(), ROWS);
    let dead = all.iter().position(|row| place(row) == at).unwrap();
    for (i, row) in all.iter().enumerate() {
        let status = match i {
            _ if i < dead => "equal",
            _ if i == dead => "hung",
            _ => "device lost",
        };
        assert_eq!(row["status"], status, "{row}");
        let gone = row["reason"].as_str().unwrap().contains("cannot be opened");
        assert_eq!(gone, i > dead, "{row}");
    }
    // Before anything was drawn, too.
    let run = self::run(&dir, &format!("--json --test-double dies:dead.txt={at}"));
    assert_eq!(run.code, 1, "{run:?}");
    assert!(rows(&run).iter().all(|row| row["status"] == "device lost"), "{run:?}");
    assert!(run.stderr.contains("nothing was compared"), "{run:?}");
}

/// Rows are told while later ones run.
#[test]
fn rows_are_told_as_they_finish() {
    let dir = Dir::new();
    let mut command = dir.command();
    command.args(LINE.split(' ')).args(["--test-double", "hangs=ab-ll/sphere/compute"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut next = || lines.next().unwrap().unwrap();
    let heading = next();
    let words = ["row", "method", "scene", "fragments", "expected", "status"];
    assert!(words.iter().all(|word| heading.contains(word)), "{heading}");
    for (number, scene) in [(1, "layers:count=3"), (2, "cubes")] {
        let line = next();
        assert!(line.trim_start().starts_with(&format!("{number}/{ROWS} ")), "{line}");
        assert!(line.contains(scene) && line.contains("must be equal"), "{line}");
    }
    assert!(child.try_wait().unwrap().is_none(), "the third row hangs");
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    let hung = rest.iter().position(|line| line.contains("hung: no sign of life")).unwrap();
    assert_eq!(hung, 0, "{rest:?}");
    assert!(rest[1].trim_start().starts_with("4/18 ") && rest[1].ends_with("equal"), "{rest:?}");
    assert_eq!(child.wait().unwrap().code(), Some(1));
}

/// What the checker expects is computed, and its token shows it.
#[test]
fn expectations_can_be_replayed() {
    let dir = Dir::new();
    let run = run(&dir, "--test-double none --json");
    let all = rows(&run);
    for row in &all {
        let expected = &row["expected"];
        let loses = row["method"] == "kplus-array";
        assert_eq!(expected["expects"], if loses { "loss" } else { "equal" }, "{row}");
        assert!(expected["fragments"].as_u64().unwrap() >= 2, "{row}");
        let Some(token) = expected["token"].as_str() else {
            assert!(!loses, "{row}");
            continue;
        };
        let replayed = dir.run(&format!("replay {token}"));
        assert_eq!(replayed.code, 1, "{replayed:?}");
        assert!(replayed.stdout.contains("kplus-array"), "{replayed:?}");
    }
}

/// A run that was cut goes on: what the report has is not run again, half a line at its end is.
#[test]
fn a_cut_run_goes_on() {
    let dir = Dir::new();
    let whole = run(&dir, "--test-double none --json --report whole.jsonl");
    assert_eq!(whole.code, 0, "{whole:?}");
    let text = fs::read_to_string(dir.path("whole.jsonl")).unwrap();
    assert_eq!(text.lines().count(), 1 + ROWS + 3, "and what is expected of three methods");
    let cut: usize = text.split_inclusive('\n').take(6).map(str::len).sum();
    fs::write(dir.path("cut.jsonl"), &text[..cut + 40]).unwrap();
    // The second row is there, and the last one is not.
    let faults = "crashes=ab-ll/cubes/compute,crashes=kplus-array/sphere/raster";
    let resumed = run(&dir, &format!("--test-double {faults} --json --resume cut.jsonl"));
    assert_eq!(resumed.code, 1, "{resumed:?}");
    let all = rows(&resumed);
    assert_eq!(all.len(), ROWS);
    assert_eq!(row(&all, "ab-ll/cubes/compute")["status"], "equal");
    assert_eq!(row(&all, "kplus-array/sphere/raster")["status"], "failed");
    assert_eq!(all[..ROWS - 1], rows(&whole)[..ROWS - 1]);
    let written = fs::read_to_string(dir.path("cut.jsonl")).unwrap();
    let own: Vec<Value> = written.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let own: Vec<Value> = own.into_iter().filter(|line| line.get("method").is_some()).collect();
    let without = |row: &Value| {
        let mut row = row.clone();
        row.as_object_mut().unwrap().remove("expected");
        row
    };
    assert_eq!(own, all.iter().map(without).collect::<Vec<_>>());

    let resume = |file: &str, more: &str| {
        dir.run(&format!("{LINE} {more} --test-double none --resume {file}"))
    };
    resume("whole.jsonl", "--seed 3").is_error(&[
        "--resume: whole.jsonl",
        "\"seed\":0",
        "\"seed\":3",
    ]);
    resume("missing.jsonl", "").is_error(&["--resume: missing.jsonl", "cannot be read"]);
    fs::write(dir.path("text.jsonl"), "row 1\n").unwrap();
    resume("text.jsonl", "").is_error(&["--resume: text.jsonl", "line 1", "--report"]);
    let newer = text.replacen("\"report\":1", "\"report\":2", 1);
    fs::write(dir.path("newer.jsonl"), newer).unwrap();
    resume("newer.jsonl", "").is_error(&["line 1", "format 2", "must be 1"]);
    fs::write(dir.path("empty.jsonl"), "").unwrap();
    resume("empty.jsonl", "").is_error(&["--resume: empty.jsonl", "empty"]);
    assert_eq!(fs::read_to_string(dir.path("whole.jsonl")).unwrap(), text);
}

#[test]
fn a_report_is_no_input() {
    let dir = Dir::new();
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(dir.path("one.obj"), file).unwrap();
    let line = "crosscheck one.obj -m ab-ll --test-double none --report one.obj";
    dir.run(line).is_error(&["--report", "one.obj"]);
    assert_eq!((dir.names(), dir.read("one.obj")), (vec!["one.obj".into()], file.into()));
    dir.run("crosscheck --limit 0").is_error(&["--limit:", "1 to 3600"]);
}

/// A page of reports: what is not expected stands out.
#[test]
fn reports_become_a_page() {
    let dir = Dir::new();
    let fault = "gives-garbage=ab-ll/cubes/raster,is-lost=s-buffer/sphere/compute";
    run(&dir, &format!("--test-double {fault} --report one.jsonl"));
    let page = dir.run("crosscheck --tabulate one.jsonl");
    assert_eq!((page.code, page.stderr.as_str()), (0, ""), "{page:?}");
    let line = |begin: &str| page.stdout.lines().find(|line| line.starts_with(begin)).unwrap();
    assert!(line("| A | test double |").contains("| 18 |"), "{page:?}");
    let list = line("| `ab-ll` | must be equal (n <= 3) |");
    assert!(list.contains("| = ") && list.contains("≠ ") && list.contains("1/3"), "{list}");
    assert!(list.contains("**not expected**"), "{list}");
    assert!(line("| `s-buffer` |").contains("**device lost** 1/3"), "{page:?}");
    let array = line("| `kplus-array` | may lose, double or tear (n <= 2) | ");
    assert_eq!(array.matches("= ").count(), 3, "{array}");
    assert!(page.stdout.contains("fl2-"), "{page:?}");
    dir.run("crosscheck --tabulate missing.jsonl").is_error(&["--tabulate: missing.jsonl"]);
}

/// The page in `docs/` is what its reports say; the checker still expects what they say that it expects; and no device
/// has shown what it excludes.
#[test]
fn the_page_of_devices_is_made_of_its_reports() {
    let home = env!("CARGO_MANIFEST_DIR");
    let mut reports: Vec<String> = fs::read_dir(format!("{home}/docs/crosscheck"))
        .unwrap()
        .map(|entry| entry.unwrap().path().to_str().unwrap().to_owned())
        .filter(|path| path.ends_with(".jsonl"))
        .collect();
    reports.sort_unstable();
    let dir = Dir::new();
    let page = dir.run(&format!("crosscheck --tabulate {}", reports.join(",")));
    let written = fs::read_to_string(format!("{home}/docs/crosscheck.md")).unwrap();
    let how = "write it anew: fragloom crosscheck --tabulate REPORT,... > docs/crosscheck.md";
    assert!(page.stdout == written, "{how}");

    let mut expected: BTreeMap<String, Value> = BTreeMap::new();
    let (mut compared, mut differing) = (0, 0);
    for report in &reports {
        for line in fs::read_to_string(report).unwrap().lines() {
            let line: Value = serde_json::from_str(line).unwrap();
            if let Some(method) = line["expected_of"].as_str() {
                let said = expected.entry(method.to_owned()).or_insert_with(|| line.clone());
                assert_eq!(*said, line, "reports agree");
            } else if let Some(method) = line["method"].as_str() {
                assert_eq!(line["finding"], false, "{line}");
                let differs = line["status"] == "different";
                // What arrival decides may differ whatever memory does.
                let allowed = line["reason"].as_str().unwrap().contains("depends on arrival");
                let must_be_equal = expected[method]["expects"] == "equal";
                assert!(!(differs && must_be_equal) || allowed, "{line}");
                compared += usize::from(must_be_equal && line["status"] == "equal");
                differing += usize::from(differs);
            }
        }
    }
    assert!(compared >= 96 && differing > 50, "{compared} {differing}");
    let methods: Vec<&str> = expected.keys().map(String::as_str).collect();
    let line = "crosscheck cubes --size 8x8 --path compute --test-double none --json -m";
    let now = dir.run(&format!("{line} {}", methods.join(",")));
    for row in rows(&now) {
        let mut now = row["expected"].clone();
        now["expected_of"] = row["method"].clone();
        assert_eq!(now, expected[row["method"].as_str().unwrap()], "docs/crosscheck.md is old");
    }
}
