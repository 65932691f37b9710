//! `fragloom adapters`, `crosscheck` and `bench --gpu`: rows, bad input, and a machine without any driver. What devices
//! compute is in `gpu/`.

#![cfg(feature = "gpu")]

#[path = "support/command.rs"]
mod support;

use std::fs;

use serde_json::Value;
use support::{Dir, Run};

fn rows(run: &Run) -> Vec<Value> {
    let Value::Array(rows) = run.json() else { panic!("a list: {run:?}") };
    rows
}

/// The adapters there are; or none, and a line that says so, unless they are demanded.
fn adapters(dir: &Dir, test: &str) -> Vec<Value> {
    let run = dir.run("adapters --json");
    if run.code == 2 {
        assert!(std::env::var_os("FRAGLOOM_ADAPTERS").is_none(), "{run:?}");
        run.is_error(&["--adapter:", "install"]);
        println!("skipped: {test} needs a Vulkan driver");
        return Vec::new();
    }
    assert_eq!(run.code, 0, "{run:?}");
    rows(&run)
}

#[test]
fn commands_have_help() {
    let dir = Dir::new();
    for command in ["crosscheck", "adapters", "bench"] {
        let help = dir.run(&format!("{command} --help"));
        assert_eq!((help.code, help.stderr.as_str()), (0, ""), "{command}");
        assert!(help.stdout.contains("--json"), "{command}");
    }
}

#[test]
fn bad_input_is_one_line() {
    let dir = Dir::new();
    for (line, words) in [
        ("crosscheck -m exact", &["-m:", "exact", "kplus-array"][..]),
        ("crosscheck -m kplus-aray", &["-m:", "kplus-aray", "kplus-array"]),
        ("crosscheck -k 0", &["-k:", "at least 1"]),
        ("crosscheck -m kb -k 65", &["-k:", "kb", "at most"]),
        ("crosscheck --size 0x4", &["--size:", "16384"]),
        ("crosscheck --size 4x4,4y", &["--size:", "\"4y\"", "640x480"]),
        ("crosscheck --size 4x4 --quick", &["--size", "--quick"]),
        ("crosscheck --path both", &["--path", "raster", "compute"]),
        ("crosscheck --order sorted", &["--order", "shuffled"]),
        ("crosscheck --litmus --repeats 0", &["--repeats:", "at least 1"]),
        ("crosscheck --litmus --tune 0", &["--tune", "1 to 10000"]),
        ("crosscheck --litmus --stress apart=1", &["--stress:", "apart=64"]),
        ("crosscheck --stress apart=1", &["--litmus"]),
        ("crosscheck missing.obj", &["missing.obj"]),
        ("bench --repeats 0", &["--repeats:", "1 to 1000"]),
        ("bench --thickness thin", &["--thickness:", "\"thin\"", "10x"]),
        ("bench -m nonsense", &["-m:", "nonsense"]),
        ("bench --adapter any", &["--gpu"]),
        ("bench --gpu --exec sim", &["--exec:", "sim"]),
        ("bench --gpu --scaling threads", &["--gpu", "--scaling"]),
        ("bench --gpu --explore kb", &["--gpu", "--explore"]),
        ("bench missing.obj", &["missing.obj"]),
    ] {
        dir.run(line).is_error(words);
    }
    let broken = "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n";
    fs::write(dir.path("broken.obj"), broken).unwrap();
    dir.run("crosscheck broken.obj").is_error(&["broken.obj"]);
    assert_eq!(dir.names(), ["broken.obj"]);
    assert_eq!(dir.read("broken.obj"), broken.as_bytes());
}

/// Vulkan's loader finds no driver.
#[cfg(target_os = "linux")]
#[test]
fn without_a_driver_it_says_what_to_install() {
    let dir = Dir::new();
    for line in ["crosscheck", "crosscheck --litmus", "adapters", "bench --gpu"] {
        let mut command = dir.command();
        command.args(line.split(' '));
        for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(name, "/nonexistent/driver.json");
        }
        command.env_remove("VK_ADD_DRIVER_FILES");
        let output = command.output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(2), &b""[..]), "{line}");
        let last = stderr.lines().last().unwrap_or_default();
        assert!(last.starts_with("error: --adapter:"), "{line}: {stderr}");
        assert!(last.contains("install") && last.contains("mesa-vulkan-drivers"), "{stderr}");
    }
}

#[test]
fn rows_name_their_adapters() {
    let dir = Dir::new();
    let all = adapters(&dir, "the cross-check's rows");
    if all.is_empty() {
        return;
    }
    dir.run("crosscheck --adapter nonsense").is_error(&["--adapter:", "nonsense", "install"]);
    let line = "crosscheck cubes --size 40x24 -m ab-ll,kb-ll";
    let run = dir.run(&format!("{line} --json"));
    assert_eq!(run.code, 0, "{run:?}");
    let found = rows(&run);
    assert_eq!(found.len(), all.len() * 2 * 2);
    for row in &found {
        assert!(all.iter().any(|adapter| adapter["name"] == row["adapter"]), "{row}");
        assert_eq!(row["status"], "equal", "{row}");
        assert!(row["fragments"].as_u64().unwrap() > 500, "{row}");
        let said = row["reason"].as_str().unwrap();
        assert_eq!(said.contains("not guaranteed by WGSL"), row["method"] == "kb-ll", "{row}");
        for field in ["driver", "scene", "size", "path", "sub_pixel_bits", "repeated"] {
            assert!(row.get(field).is_some(), "{field} of {row}");
        }
    }
    let two = dir.run("crosscheck cubes --size 40x24,24x40 -m ab-ll --path compute --json");
    let sizes: Vec<Value> = rows(&two).iter().map(|row| row["size"].clone()).collect();
    let [wide, high] = [serde_json::json!([40, 24]), serde_json::json!([24, 40])];
    let both = all.iter().flat_map(|_| [wide.clone(), high.clone()]);
    assert_eq!(sizes, both.collect::<Vec<_>>());
    // In one process, scene by scene, the rows are the same.
    let place = |row: &Value| {
        let of = |field: &str| row[field].to_string();
        ["adapter", "path", "method", "size"].map(of).join(" ")
    };
    let sorted = |run: &Run| {
        let mut rows = rows(run);
        rows.sort_by_key(place);
        rows
    };
    assert_eq!(sorted(&dir.run(&format!("{line} --json --in-process"))), sorted(&run));
    let table = dir.run(&format!("{line} --path compute --order submission"));
    assert_eq!(table.code, 0, "{table:?}");
    for adapter in &all {
        let name = adapter["name"].as_str().unwrap();
        assert!(table.stdout.contains(name), "{name} in {}", table.stdout);
    }
    assert!(table.stdout.contains("compute") && !table.stdout.contains("raster"), "{table:?}");
}

/// A k that no device has room for.
#[test]
fn unsupported_is_no_pass() {
    let dir = Dir::new();
    if adapters(&dir, "what devices cannot do").is_empty() {
        return;
    }
    let line = "crosscheck cubes --size 16x16 -m kplus-array -k 100000000";
    let run = dir.run(&format!("{line} --json"));
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.stderr.contains("violation: nothing was compared"), "{run:?}");
    for row in rows(&run) {
        assert_eq!(
            (&row["status"], &row["fragments"]),
            (&"unsupported".into(), &0.into()),
            "{row}"
        );
        assert!(row["reason"].as_str().unwrap().contains("no room"), "{row}");
    }
    assert!(dir.run(line).stdout.contains("nothing compared"));
}

#[test]
fn devices_are_timed_beside_the_simulator() {
    let dir = Dir::new();
    let all = adapters(&dir, "bench --gpu");
    if all.is_empty() {
        return;
    }
    let run = dir.run("bench layers:count=4 --size 64x64 --repeats 2 -m ab-ll --gpu --json");
    assert_eq!(run.code, 0, "{run:?}");
    let document = run.json();
    let list = |field: &str| document[field].as_array().unwrap().clone();
    let (found, means) = (list("rows"), list("means"));
    assert_eq!([found.len(), means.len()], [2 * all.len(); 2], "{means:?}");
    for adapter in &all {
        let row = found.iter().find(|row| row["adapter"] == adapter["name"]).unwrap();
        assert_eq!(row["parts"], 1, "{row}");
        let is_same =
            |mean: &&Value| ["adapter", "exec", "threads"].iter().all(|f| mean[f] == row[f]);
        let mean = means.iter().find(is_same).unwrap();
        assert_eq!(
            (mean["rows"].as_u64(), mean["smallest_method"].as_str()),
            (Some(1), Some("ab-ll"))
        );
        assert_eq!(mean["smallest"], row["ratio"], "{mean}");
        let [ratio, low, high] = [&row["ratio"], &row["ratio_spread"][0], &row["ratio_spread"][1]]
            .map(|v| {
                let Some(value) = v.as_f64() else { panic!("a number in {row}") };
                value
            });
        assert!(0.0 < low && low <= ratio && ratio <= high, "{row}");
        assert_eq!(row["fragments"], 4 * 64 * 64, "{row}");
    }
}

/// Litmus pixels have processes of their own, too, and say the same as in one.
#[test]
fn litmus_pixels_are_run_apart() {
    let dir = Dir::new();
    let all = adapters(&dir, "litmus pixels in processes of their own");
    if all.is_empty() {
        return;
    }
    let line = "crosscheck --litmus --repeats 1 -m ab-array --json";
    let [apart, here] = ["", " --in-process"].map(|more| dir.run(&format!("{line}{more}")));
    assert_eq!((apart.code, here.code), (0, 0), "{apart:?} {here:?}");
    assert_eq!(apart.json()["conformance"], here.json()["conformance"]);
    let runs = |run: &Run| {
        let Value::Array(rows) = run.json()["stress"].clone() else { panic!("a list: {run:?}") };
        let of = |row: &Value| ["adapter", "method", "runs", "possible"].map(|f| row[f].clone());
        rows.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(runs(&apart), runs(&here));
    assert_eq!(runs(&apart).len(), all.len());
}

/// Contention that was found is contention that can be given.
#[test]
fn contention_is_searched_for() {
    let dir = Dir::new();
    let all = adapters(&dir, "contention");
    if all.is_empty() {
        return;
    }
    let line = "crosscheck --litmus --tune 2 --repeats 1 --seed 5";
    let run = dir.run(&format!("{line} --json"));
    assert_eq!(run.code, 0, "{run:?}");
    let tried = rows(&run);
    assert_eq!(tried.len(), 3 * all.len());
    for row in &tried {
        assert_eq!(row["runs"], 2 * 3 * 4_096, "{row}");
        assert!(row["wrong"].as_u64() < row["runs"].as_u64(), "{row}");
    }
    // Each adapter's first row has the fixed orders, and the others the same settings.
    assert_eq!(tried[0]["pressure"], Value::Null);
    let settings = |row: usize| tried[row]["pressure"].clone();
    assert!(settings(1).is_object() && settings(1) != settings(2));
    assert!((0..tried.len()).all(|row| settings(row) == settings(row % 3)), "{tried:?}");
    let of = |field: &str| settings(1)[field].to_string();
    let [apart, group, hammer, burst] = ["apart", "group", "hammer", "burst"].map(of);
    let stress = format!("apart={apart},group={group},hammer={hammer},burst={burst}");
    let line = "crosscheck --litmus --repeats 1 -m kplus-array";
    let run = dir.run(&format!("{line} --stress {stress} --json"));
    assert_eq!(run.code, 0, "{run:?}");
    for row in run.json()["stress"].as_array().unwrap() {
        assert_eq!((&row["outside"], &row["wrong"]), (&0.into(), &0.into()), "{row}");
    }
}
