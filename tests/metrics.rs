//! How far pictures are from a reference: the numbers are those of other people's implementations, and every command
//! that prints them prints the same.
//!
//! `tests/metrics/ledger.txt` has what scikit-image and flip-evaluator say of pictures that fragloom draws, written by
//! `tests/metrics/check.py`. Here the same pictures are drawn and measured again. That a fault in a measure would show
//! is tested beside the measures, with the ledger's made-up pictures.

#[path = "support/command.rs"]
mod support;

use std::fs;

use serde_json::Value;
use support::{Dir, Run};

/// How far we may be from the others. FLIP's is in single precision there.
const BOUNDS: [(&str, f64); 4] =
    [("psnr", 1e-9), ("psnr_linear", 1e-9), ("ssim", 1e-9), ("flip", 2e-6)];

/// `line` with scenes of this repository.
fn at_home(line: &str) -> String {
    line.replace("scenes/", concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/"))
}

fn close(found: &Value, expected: f64, bound: f64) -> bool {
    match found.as_f64() {
        Some(found) => (found - expected).abs() <= bound,
        // Nothing is said of equal pictures, where the others say infinity.
        None => found.is_null() && expected.is_infinite(),
    }
}

#[test]
fn the_numbers_are_those_of_others() {
    let text = include_str!("metrics/ledger.txt");
    let mut count = 0;
    for line in text.lines().filter(|line| !line.starts_with('#') && line.contains('|')) {
        let [numbers, reference, picture] =
            line.split(" | ").collect::<Vec<_>>().try_into().expect("three parts");
        if reference.starts_with("pattern") {
            continue;
        }
        let dir = Dir::new();
        let (reference, picture) = (at_home(reference), at_home(picture));
        assert_eq!(dir.run(&format!("render {reference} -o reference.png")).code, 0, "{line}");
        let run = dir.run(&format!("render {picture} --reference reference.png --metrics json"));
        let found = &run.json()[0];
        let numbers = numbers.split(' ').skip(1).map(|n| n.parse::<f64>().expect("a number"));
        for ((name, bound), expected) in BOUNDS.into_iter().zip(numbers) {
            assert!(close(&found[name], expected, bound), "{line}: {name} is {}", found[name]);
        }
        count += 1;
    }
    assert!(count >= 6, "{count} cases");
}

const SMALL: &str = "--size 48x32";

/// The errors of kplus-array with k = 2, as one JSON value.
fn errors(dir: &Dir) -> Value {
    let run = dir.run(&format!("compare cubes {SMALL} -m kplus-array -k 2 --metrics json"));
    assert_eq!(run.code, 0, "{run:?}");
    run.json()[0].clone()
}

#[test]
fn every_command_prints_the_same_errors() {
    let dir = Dir::new();
    let expected = errors(&dir);
    for name in ["psnr", "psnr_linear", "ssim", "flip", "max_difference", "mean_difference"] {
        assert!(expected[name].is_number(), "{name}: {expected}");
    }
    let compared = dir.run(&format!("compare cubes {SMALL} -m kplus-array -k 2 --json")).json();
    let swept = dir.run(&format!("compare cubes {SMALL} -m kplus-array --sweep k=2 --json")).json();
    let line = format!("render cubes {SMALL} -k 2 --reference exact --json");
    let drawn = dir.run(&line).json();
    for (name, value) in expected.as_object().unwrap() {
        assert_eq!(&compared[0][name], value, "{name}");
        assert_eq!(&drawn["errors"][name], if name == "method" { &Value::Null } else { value });
        if name != "reference" {
            assert_eq!(&swept[0][name], value, "{name}");
        }
    }
    assert_eq!(drawn["method"], "kplus-array");
    assert!(dir.names().is_empty());
}

/// The worst pixel is where `inspect` shows that difference.
#[test]
fn the_worst_pixel_can_be_inspected() {
    let dir = Dir::new();
    let expected = errors(&dir);
    let [x, y] = [0, 1].map(|axis| expected["worst_pixel"][axis].as_u64().unwrap());
    let line = format!("inspect cubes {SMALL} -m kplus-array -k 2 --pixel {x},{y}");
    let run = dir.run(&line);
    assert_eq!(run.code, 0, "{run:?}");
    let row = run.stdout.lines().find(|line| line.starts_with("kplus-array, k = 2  ")).unwrap();
    let most = expected["max_difference"].to_string();
    assert!(row.split_whitespace().any(|word| word == most), "{most}: {row}");
}

#[test]
fn a_threshold_counts_pixels_beyond_it() {
    let dir = Dir::new();
    let most = errors(&dir)["max_difference"].as_u64().unwrap();
    let beyond = |threshold: u64| {
        let line = format!("render cubes {SMALL} -k 2 --reference exact --metrics json");
        let found = dir.run(&format!("{line} --threshold {threshold}")).json()[0].clone();
        assert_eq!(found["threshold"], threshold);
        (found["pixels_beyond"].as_u64().unwrap(), found["pixels_different"].as_u64().unwrap())
    };
    let (all, different) = beyond(0);
    assert_eq!(all, different);
    assert!((1..all).contains(&beyond(most - 1).0));
    assert_eq!(beyond(most).0, 0);
    dir.run("render cubes --threshold 256").is_error(&["--threshold", "256"]);
}

#[test]
fn tables_in_three_formats() {
    let dir = Dir::new();
    let line = format!("compare cubes {SMALL} -m ab-ll,kplus-array -k 2");
    let csv = dir.run(&format!("{line} --metrics csv")).stdout;
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..5], ["method", "psnr", "psnr_linear", "ssim", "flip"]);
    assert_eq!(rows[1][..5], ["ab-ll", "", "", "1", "0"]);
    let expected = errors(&dir);
    assert_eq!(rows[2][0], "kplus-array");
    for (name, cell) in rows[0].iter().zip(&rows[2]).skip(1) {
        let value = match *name {
            "worst_x" => &expected["worst_pixel"][0],
            "worst_y" => &expected["worst_pixel"][1],
            name => &expected[name],
        };
        // serde_json reads numbers to the last bit but one.
        assert!(close(value, cell.parse().unwrap(), 1e-12), "{name}: {cell} {value}");
    }
    let latex = dir.run(&format!("{line} --metrics latex")).stdout;
    assert!(latex.starts_with("\\begin{tabular}{lrr") && latex.ends_with("\\end{tabular}\n"));
    assert!(latex.contains("\nkplus-array & ") && latex.contains(" \\% & "), "{latex}");
    let table = dir.run(&line).stdout;
    for part in ["lists equal", "errors against all fragments of exact", "by more than 1", "FLIP"] {
        assert!(table.contains(part), "{part}: {table}");
    }
}

#[test]
fn a_reference_is_a_file_or_a_method() {
    let dir = Dir::new();
    assert_eq!(dir.run(&format!("render cubes {SMALL} -m exact -o exact.png")).code, 0);
    let line = format!("render cubes {SMALL} -k 2 --metrics csv --reference");
    let [file, method] = ["exact.png", "exact"].map(|name| dir.run(&format!("{line} {name}")));
    assert_eq!((file.code, method.code, &file.stdout), (0, 0, &method.stdout));
    let own = dir.run(&format!("render cubes {SMALL} -m exact --reference exact.png"));
    assert!(own.stdout.contains("\nerrors against exact.png\n"), "{own:?}");
    assert!(
        own.stdout.lines().last().unwrap().starts_with("exact") && own.stdout.contains("equal")
    );
    // The document on stdout and in the file is one.
    let both =
        dir.run(&format!("render cubes {SMALL} --reference exact --json --stats stats.json"));
    assert_eq!(both.stdout.as_bytes(), dir.read("stats.json"));
}

#[test]
fn wrong_references_are_one_line_and_nothing_is_written() {
    let dir = Dir::new();
    let is_wrong = |run: Run, words: &[&str]| {
        run.is_error(words);
        assert!(!dir.path("out.png").exists());
    };
    assert_eq!(dir.run("render layers:count=1 --size 9x9 -o nine.png").code, 0);
    fs::write(dir.path("text.png"), "no picture").unwrap();
    fs::write(dir.path("cut.png"), &dir.read("nine.png")[..60]).unwrap();
    let line = format!("render cubes {SMALL} -o out.png --reference");
    for (reference, words) in [
        ("nine.png", &["--reference:", "9x9", "48x32", "--size"][..]),
        ("missing.png", &["--reference:", "missing.png", "cannot be opened"]),
        ("text.png", &["--reference:", "text.png", "PNG"]),
        ("cut.png", &["--reference:", "cut.png", "PNG"]),
        ("picture.jpg", &["--reference:", "picture.jpg", "FILE.png", "exact"]),
        ("exakt", &["--reference:", "did you mean exact?"]),
        ("exact --frames 2", &["--reference:", "--frames"]),
        ("exact --metrics csv --json", &["--metrics:", "--json"]),
        ("exact --metrics xml", &["--metrics", "latex"]),
    ] {
        is_wrong(dir.run(&format!("{line} {reference}")), words);
    }
    is_wrong(dir.run("render cubes -o out.png --metrics csv"), &["--metrics:", "--reference"]);
    is_wrong(dir.run("compare cubes --metrics csv --json"), &["--metrics:", "--json"]);
}

#[test]
fn maps_of_errors_have_one_scale() {
    let dir = Dir::new();
    dir.run("compare cubes --heat flip").is_error(&["--heat:", "-o"]);
    dir.run("compare cubes --heat psnr -o .").is_error(&["--heat", "difference"]);
    dir.run("compare cubes -o . --heat flip --sweep k=1").is_error(&["--heat:", "--sweep"]);
    let map = |scene: &str, heat: &str| {
        let run =
            dir.run(&format!("compare {scene} {SMALL} -m kplus-array -k 2 -o . --heat {heat}"));
        assert_eq!(run.code, 0, "{run:?}");
        assert_eq!(dir.names(), ["compare-kplus-array.png", "heat-kplus-array.png"]);
        let picture = image(&dir.read("heat-kplus-array.png"));
        // Its scale, beneath the map.
        picture[picture.len() * 7 / 8..].to_vec()
    };
    let [flip, other] = ["cubes", "layers:count=4"].map(|scene| map(scene, "flip"));
    assert_eq!(flip, other, "whatever the largest error is");
    assert_ne!(flip, map("cubes", "difference"));
}

fn image(bytes: &[u8]) -> Vec<[u8; 4]> {
    fragloom::image::png::decode(std::io::Cursor::new(bytes), 16_384).expect("a picture").pixels
}

#[test]
fn a_sweep_is_a_table_and_a_plot() {
    let dir = Dir::new();
    let line = format!("compare layers:count=4 {SMALL} -m kplus-array,exact,dfb+sfm");
    let run = dir.run(&format!("{line} --sweep k=4,1..3 -o ."));
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    assert_eq!(dir.names(), ["sweep.csv", "sweep.png", "sweep.svg"]);
    let csv = String::from_utf8(dir.read("sweep.csv")).unwrap();
    assert_eq!(csv, dir.run(&format!("{line} --sweep k=1..4 --metrics csv")).stdout);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..5], ["method", "value", "bytes", "bytes_per_pixel", "psnr"]);
    let name = |method: &str| rows.iter().filter(|row| row[0] == method).collect::<Vec<_>>();
    let array = name("kplus-array");
    assert_eq!(array.iter().map(|row| row[1]).collect::<Vec<_>>(), ["1", "2", "3", "4"]);
    let number = |row: &[&str], column: usize| row[column].parse::<f64>().unwrap();
    for pair in array.windows(2) {
        assert_eq!(number(pair[1], 3) - number(pair[0], 3), 8.0, "a record is 8 bytes");
        assert!(number(pair[1], 7) < number(pair[0], 7), "more memory, smaller FLIP: {csv}");
    }
    assert_eq!((array[3][4], array[3][7]), ("", "0"), "all layers are there");
    let [exact] = name("exact")[..] else { panic!("one point: {csv}") };
    assert_eq!((exact[1], exact[4]), ("", ""));
    let svg = String::from_utf8(dir.read("sweep.svg")).unwrap();
    assert!(
        ["kplus-array", "exact", "k from 1 to 4", "FLIP"].iter().all(|word| svg.contains(word))
    );
    assert!(!image(&dir.read("sweep.png")).is_empty());
    let table = dir.run(&format!("{line} --sweep k=1..4")).stdout;
    assert!(table.contains("layers at 48x32, errors against all fragments of exact"), "{table}");
}

#[test]
fn other_options_can_be_swept() {
    let dir = Dir::new();
    for (sweep, method, points) in [
        ("beta=0,0.5,1", "dfb+sfm --thickness 1", 3),
        ("load=20,80", "ha64", 2),
        ("age-limit=1,255", "ha64", 2),
        ("k-average=0.5,2", "k-variable", 2),
    ] {
        let line = format!("compare cubes {SMALL} --sweep {sweep} --json -m exact,{method}");
        let run = dir.run(&line);
        let rows = run.json();
        let rows = rows.as_array().unwrap();
        assert_eq!(rows.len(), points + 1, "{sweep}: {run:?}");
        let words = rows.iter().map(|row| format!("{} {}", row["bytes"], row["image_hash"]));
        let mut words: Vec<String> = words.skip(1).collect();
        words.dedup();
        assert!(words.len() > 1, "{sweep} changes something: {words:?}");
        assert_eq!(rows[0]["value"], Value::Null);
    }
}

#[test]
fn wrong_sweeps_are_one_line() {
    let dir = Dir::new();
    fs::write(dir.path("taken"), "a file, not a folder").unwrap();
    for (line, words) in [
        ("--sweep k", &["--sweep:", "NAME=VALUES", "k=1..32"][..]),
        ("--sweep k=1,x", &["--sweep:", "NAME=VALUES"]),
        ("--sweep moons=4", &["--sweep:", "moons", "k, k-average"]),
        ("--sweep k=0..4", &["--sweep:", "k=0", "1 to 65535"]),
        ("--sweep beta=2 -m dfb+sfm", &["--sweep:", "beta=2", "0 to 1"]),
        ("--sweep k=1..4 -k 2", &["--sweep:", "-k", "one of them"]),
        ("--sweep k=1..256", &["--sweep:", "at most 512"]),
        ("--sweep beta=0..1 -m exact", &["--sweep:", "beta", "no method"]),
        ("--sweep k=1..4 -o taken", &["-o:", "taken"]),
        ("--sweep k=1..4 -m kplus-array --memory-budget 1G", &["--memory-budget:", "-k"]),
    ] {
        dir.run(&format!("compare layers:count=1 --size 4x4 {line}")).is_error(words);
    }
    assert_eq!(dir.names(), ["taken"]);
}
