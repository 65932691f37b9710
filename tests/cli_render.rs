//! What the binary draws and reports: documents, files, hashes and exit codes, on built-in scenes.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/command.rs"]
mod support;

use std::io::{Cursor, Read};

use serde_json::Value;
use sha2::{Digest, Sha256};
use support::Dir;

const SMALL: &str = "--size 48x32";

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A sum of fields of a report; `dropped` is the sum of its reasons.
fn sum(report: &Value, fields: &[&str]) -> u64 {
    let value = |field: &&str| match &report[field] {
        Value::Object(reasons) => reasons.values().map(|count| count.as_u64().unwrap()).sum(),
        count => count.as_u64().unwrap(),
    };
    fields.iter().map(value).sum()
}

#[track_caller]
fn balances(report: &Value) {
    let [sources, sinks] = [
        &["generated", "duplicated", "torn"][..],
        &["kept", "merged", "culled", "evicted", "dropped"],
    ];
    assert_eq!(sum(report, sources), sum(report, sinks), "{report}");
    assert_eq!(report["violations"], Value::Array(Vec::new()));
}

#[test]
fn the_document_has_every_key_and_balances() {
    let run = Dir::new().run(&format!("render layers:count=4 {SMALL} -m exact --json"));
    assert_eq!(run.code, 0, "{run:?}");
    let report = run.json();
    for key in [
        "method",
        "scene",
        "width",
        "height",
        "triangles",
        "degenerate",
        "generated",
        "duplicated",
        "torn",
        "kept",
        "merged",
        "culled",
        "evicted",
        "dropped",
        "deterministic",
        "max_depth_complexity",
        "bytes",
        "passes",
        "image_hash",
        "fragments_hash",
        "counters",
        "seconds",
        "warnings",
        "violations",
    ] {
        assert!(report.get(key).is_some(), "{key}");
    }
    assert_eq!((&report["width"], &report["height"]), (&48.into(), &32.into()));
    assert_eq!(report["max_depth_complexity"], 4);
    assert_eq!((sum(&report, &["generated"]), sum(&report, &["kept"])), (6_144, 6_144));
    balances(&report);
}

#[test]
fn k_fragments_are_kept_and_the_rest_accounted_for() {
    let dir = Dir::new();
    for exec in ["tile", "threads --threads 2", "sim --resident 64"] {
        let line = format!("render layers:count=4 {SMALL} -k 3 --exec {exec} --json");
        let run = dir.run(&line);
        assert_eq!(run.code, 0, "{run:?}");
        let report = run.json();
        balances(&report);
        assert_eq!(sum(&report, &["kept"]), 3 * 48 * 32, "{exec}");
        assert_eq!(sum(&report, &["culled", "evicted"]), 48 * 32, "{exec}");
    }
}

#[test]
fn the_table_tells_the_same_numbers() {
    let dir = Dir::new();
    let table = dir.run(&format!("render layers:count=4 {SMALL} -m exact"));
    assert_eq!(table.code, 0, "{table:?}");
    let report = dir.run(&format!("render layers:count=4 {SMALL} -m exact --json")).json();
    assert!(table.stdout.contains("6,144") && table.stdout.contains("\nbalanced\n"));
    for hash in ["image_hash", "fragments_hash"] {
        assert!(table.stdout.contains(report[hash].as_str().unwrap()), "{hash}");
    }
}

/// The data of one array of an `.npz`, its header cut off.
fn member(archive: &[u8], name: &str) -> Vec<u8> {
    let mut zip = zip::ZipArchive::new(Cursor::new(archive)).unwrap();
    let mut bytes = Vec::new();
    zip.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\x00");
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes.split_off(10 + header)
}

#[test]
fn files_hold_what_the_hashes_say() {
    let dir = Dir::new();
    let line = format!(
        "render cubes {SMALL} -m exact --json -o out.png --fragments out.npz --stats out.json"
    );
    let run = dir.run(&line);
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(dir.names(), ["out.json", "out.npz", "out.png"]);
    assert_eq!(dir.read("out.json"), run.stdout.as_bytes());
    let report = run.json();

    let archive = dir.read("out.npz");
    let arrays = ["width", "height", "offsets", "depth", "data"].map(|name| member(&archive, name));
    assert_eq!(arrays[2].len(), 8 * (48 * 32 + 1));
    assert_eq!(arrays[3].len() as u64, 4 * sum(&report, &["kept"]));
    assert_eq!(report["fragments_hash"], hex(&Sha256::digest(arrays.concat())));

    let mut reader = png::Decoder::new(Cursor::new(dir.read("out.png"))).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let mut image = [48u32.to_le_bytes(), 32u32.to_le_bytes()].concat();
    image.extend(pixels);
    assert_eq!(report["image_hash"], hex(&Sha256::digest(image)));
}

#[test]
fn two_runs_give_the_same_bytes() {
    let dir = Dir::new();
    let draw = |name: &str, more: &str| {
        let line =
            format!("render cubes {SMALL} {more} --json -o {name}.png --fragments {name}.npz");
        let run = dir.run(&line);
        assert_eq!(run.code, 0, "{run:?}");
        let mut report = run.json();
        for varying in ["seconds", "counters", "exec", "threads", "culled", "evicted"] {
            report.as_object_mut().unwrap().remove(varying);
        }
        (dir.read(&format!("{name}.png")), dir.read(&format!("{name}.npz")), report)
    };
    let first = draw("first", "");
    for more in ["", "--threads 1", "--exec threads --threads 3", "--exec sim --seed 5"] {
        let again = draw("again", more);
        assert_eq!(first.0, again.0, "{more}");
        assert_eq!(first.1, again.1, "{more}");
        assert_eq!(first.2["fragments_hash"], again.2["fragments_hash"], "{more}");
        assert_eq!(first.2["generated"], again.2["generated"], "{more}");
    }
}

#[test]
fn a_recorded_schedule_runs_again() {
    let dir = Dir::new();
    let sim = format!("render cubes {SMALL} -m kb --exec sim --resident 64 --json");
    let first = dir.run(&format!("{sim} --schedule random --seed 3 --record schedule"));
    let again = dir.run(&format!("{sim} --schedule recorded:schedule"));
    assert_eq!(dir.names(), ["schedule"]);
    let [first, again] = [first.json(), again.json()];
    for field in ["fragments_hash", "image_hash", "kept", "dropped"] {
        assert_eq!(first[field], again[field], "{field}");
    }
}

#[test]
fn options_without_effect_are_warned_of() {
    let run = Dir::new().run(&format!("render layers:count=4 {SMALL} --seed 1 --json"));
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stderr.starts_with("warning: --seed"), "{run:?}");
    assert!(run.json()["warnings"][0].as_str().unwrap().starts_with("--seed"));
}

#[test]
fn too_little_memory_is_refused() {
    let dir = Dir::new();
    let run = dir.run(&format!("render layers:count=4 {SMALL} --max-memory 1K -o out.png"));
    run.is_error(&["--max-memory"]);
    assert!(dir.names().is_empty());
}

#[test]
fn correct_methods_agree_with_the_reference() {
    let dir = Dir::new();
    let line = format!("compare layers:count=4 {SMALL} -m exact,kplus-array -k 2 --json -o .");
    let run = dir.run(&line);
    assert_eq!(run.code, 0, "{run:?}");
    let rows = run.json();
    let row = &rows[1];
    assert_eq!((&row["method"], &row["reference_k"]), (&"kplus-array".into(), &2.into()));
    assert_eq!((&row["lists_equal"], &row["lost"]), (&true.into(), &0.into()));
    assert_eq!(row["from_reference"]["differing"], 0);
    assert_eq!(row["from_all"]["differing"], 48 * 32, "two of four layers are missing");
    assert_eq!(dir.names(), ["compare-exact.png", "compare-kplus-array.png"]);
}

/// A budget chooses a k for every method, and each is held to its own.
#[test]
fn methods_within_a_budget_are_held_to_the_k_it_chose() {
    let dir = Dir::new();
    let line = "compare layers:count=6 --size 64x64 -m kplus-array,kplus-sb --memory-budget 100K";
    let ran = dir.run(&format!("{line} --json"));
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    let rows: Value = serde_json::from_str(&ran.stdout).unwrap();
    let kept: Vec<u64> =
        rows.as_array().unwrap().iter().map(|row| row["kept"].as_u64().unwrap()).collect();
    assert_eq!(kept, [2 * 64 * 64, 64 * 64], "k = 2 and k = 1");
}

#[test]
fn a_method_that_loses_fragments_is_found() {
    let dir = Dir::new();
    let line = format!("compare layers:count=4 {SMALL} -m kb,kplus-array --exec sim --json");
    let run = dir.run(&line);
    assert_eq!(run.code, 1, "{run:?}");
    let rows = run.json();
    assert!(rows[0]["lost"].as_u64().unwrap() > 0, "{rows}");
    assert_eq!((&rows[0]["lists_equal"], &rows[1]["lists_equal"]), (&false.into(), &true.into()));
    assert!(dir.names().is_empty(), "without -o nothing is written");
}

#[test]
fn a_camera_goes_around_and_tables_follow() {
    let dir = Dir::new();
    let line = "render cubes --size 64x48 -m ha64 --frames 4 --json";
    let run = dir.run(&format!("{line} -o turn.png"));
    assert_eq!(run.code, 0, "{run:?}");
    let frames = run.json();
    let frames = frames.as_array().unwrap();
    assert_eq!(frames.len(), 4);
    assert_eq!(dir.names(), ["turn-0000.png", "turn-0001.png", "turn-0002.png", "turn-0003.png"]);
    let cells = |frame: &Value| {
        let edge = |name: &str| frame["table"][name].as_u64().unwrap();
        edge("width") * edge("height")
    };
    assert_eq!(cells(&frames[0]), 64 * 48, "it begins with the screen");
    for pair in frames.windows(2) {
        let (load, before, after) =
            (pair[0]["table"]["load"].as_f64().unwrap(), cells(&pair[0]), cells(&pair[1]));
        let grows = load >= 80.0;
        assert_eq!(after > before, grows, "{load} {before} {after}");
    }
    let hashes: Vec<&Value> = frames.iter().map(|frame| &frame["image_hash"]).collect();
    assert!(hashes.windows(2).all(|pair| pair[0] != pair[1]), "the view changes");
    frames.iter().for_each(balances);
    assert!(frames[0]["dropped"].as_object().unwrap().contains_key("full"), "one frame of latency");

    let frames = dir.run(&format!("{line} --resize at-once")).json();
    for frame in frames.as_array().unwrap() {
        assert_eq!(frame["generated"], frame["kept"], "nothing is lost");
    }
    assert!(frames[0]["retries"].as_u64().unwrap() > 0);
    assert_eq!(frames[1]["frame"], 1);
    let table = dir.run("render cubes --size 64x48 -m ha64 --frames 2").stdout;
    assert!(table.contains("cells") && table.contains("retries"), "{table}");
    let other = dir.run("render cubes --size 64x48 -m ab-ll --frames 2 --json").json();
    assert!(other[0].get("table").is_none());
    dir.run("render cubes --size 64x48 -m ha64 --age-limit 2 --frames 1 --resize at-once")
        .is_error(&["--age-limit", "frame 0"]);
}

#[test]
fn experiments_write_tables_and_plots() {
    let dir = Dir::new();
    let run = dir.run("reproduce ha-table1 ha-fig8 --edge 32 --repeats 1 -o .");
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stdout.contains("21 of 21 printed values"), "{run:?}");
    assert_eq!(dir.names(), ["ha-fig8.csv", "ha-fig8.svg", "ha-table1.csv"]);
    assert!(String::from_utf8(dir.read("ha-fig8.svg")).unwrap().contains("<polyline"));
    assert_eq!(String::from_utf8(dir.read("ha-table1.csv")).unwrap().lines().count(), 22);
    let json = dir.run("reproduce ha-table1 --json").json();
    assert_eq!(json[0]["experiment"], "ha-table1");
    assert_eq!(json[0]["rows"].as_array().unwrap().len(), 21);
}

#[test]
fn methods_with_tables_agree_with_the_reference() {
    let dir = Dir::new();
    let methods = "ha64,ha32,ha64-multiset,hash-coherent,ha64-cull";
    for exec in ["tile", "threads", "sim"] {
        let run = dir.run(&format!("compare cubes --size 40x30 --exec {exec} -m {methods} --json"));
        assert_eq!(run.code, 0, "{exec} {run:?}");
    }
    let run = dir.run("compare cubes --size 40x30 -m ha64@published");
    assert_eq!(run.code, 1, "{run:?}");
    let warned = dir.run("render cubes --size 40x30 -m ab-ll --load 80");
    assert!(warned.stderr.contains("--load has no effect"), "{warned:?}");
}
