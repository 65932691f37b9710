//! `fragloom golden`: what is recorded is verified, what changed is told apart, and nothing is ever half written.

#![expect(clippy::unwrap_used, reason = "a test that cannot read its own files fails")]

#[path = "support/command.rs"]
mod support;

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::thread;
use std::time::Duration;

use fragloom::image::png;
use serde_json::Value;
use support::{Dir, Run};

const SCENE: &str = r#"size = [40, 30]
[camera]
eye = [0.0, 0.0, 3.0]
target = [0.0, 0.0, 0.0]
[[material]]
name = "glass"
color = [0.2, 0.5, 0.9]
alpha = 0.5
shading = "flat"
[[object]]
file = "pane.obj"
material = "glass"
[[object]]
procedural = "layers"
count = 4
alpha = 0.25
"#;

const PANE: &str = "# a pane\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3\n";

/// A folder with a scene and its model.
fn dir() -> Dir {
    let dir = Dir::new();
    fs::write(dir.path("scene.toml"), SCENE).unwrap();
    fs::write(dir.path("pane.obj"), PANE).unwrap();
    dir
}

fn text(dir: &Dir, name: &str) -> String {
    String::from_utf8(dir.read(name)).unwrap()
}

/// Replace text in a file that has it once.
#[track_caller]
fn edit(dir: &Dir, name: &str, old: &str, new: &str) {
    let before = text(dir, name);
    assert_eq!(before.matches(old).count(), 1, "{old} in {before}");
    fs::write(dir.path(name), before.replace(old, new)).unwrap();
}

#[track_caller]
fn is(run: &Run, code: i32, words: &[&str]) {
    assert_eq!(run.code, code, "{run:?}");
    assert!(words.iter().all(|word| run.stdout.contains(word)), "{words:?} in {run:?}");
}

/// The outcome of an entry in a report.
fn outcome(run: &Run, name: &str) -> Value {
    let report = run.json();
    let outcomes = report["outcomes"].as_array().unwrap();
    outcomes.iter().find(|outcome| outcome["name"] == name).unwrap().clone()
}

#[test]
fn what_is_recorded_is_the_same() {
    let dir = dir();
    is(
        &dir.run("golden record g scene.toml -k 3 --threads 1"),
        0,
        &["scene", "40x30", "scene.png"],
    );
    assert_eq!(dir.names(), ["g", "pane.obj", "scene.toml"]);
    let manifest = text(&dir, "g/golden.toml");
    for line in [
        "scene = \"../scene.toml\"",
        "options = [\"-m\", \"kplus-array\", \"-k\", \"3\", \"--threads\", \"1\"]",
        "    { file = \"../pane.obj\", sha256 = \"",
        "picture = \"scene.png\"",
    ] {
        assert!(manifest.contains(line), "{line} in {manifest}");
    }
    let image = png::decode(Cursor::new(dir.read("g/scene.png")), 64).unwrap();
    assert!(manifest.contains(&image.hash()));
    let drawn = dir.run("render scene.toml -k 3 --json").json();
    assert!(manifest.contains(drawn["fragments_hash"].as_str().unwrap()));
    for line in ["golden verify g", "golden verify g/golden.toml -j 1 -q"] {
        is(&dir.run(line), 0, &["1 entry: 1 same"]);
    }
    assert_eq!(text(&dir, "g/golden.toml"), manifest);
    // A manifest that moves with its files is still right.
    fs::create_dir(dir.path("other")).unwrap();
    for name in ["g", "pane.obj", "scene.toml"] {
        fs::rename(dir.path(name), dir.path(&format!("other/{name}"))).unwrap();
    }
    is(&dir.run("golden verify other/g"), 0, &["1 same"]);
}

#[test]
fn all_scenes_of_a_folder_are_recorded() {
    let dir = dir();
    is(&dir.run("golden record . -m exact,kplus-array --no-pictures"), 0, &["2 recorded"]);
    assert_eq!(dir.names(), ["golden.toml", "pane.obj", "scene.toml"]);
    assert!(text(&dir, "golden.toml").contains("\npictures = false\n"));
    is(&dir.run("golden record . cubes --size 20 --name boxes"), 0, &["boxes", "not kept"]);
    is(&dir.run("golden verify ."), 0, &["3 entries: 3 same"]);
    is(&dir.run("golden verify . --filter exact"), 0, &["3 entries: 1 same"]);
    fs::create_dir(dir.path("models")).unwrap();
    fs::write(dir.path("models/pane.obj"), PANE).unwrap();
    is(&dir.run("golden record models --size 9"), 0, &["1 recorded", "pane.png"]);
}

/// A model that changes by one byte is named, and is no difference of the drawing.
#[test]
fn a_changed_file_is_named() {
    let dir = dir();
    dir.run("golden record g scene.toml");
    let manifest = text(&dir, "g/golden.toml");
    edit(&dir, "pane.obj", "v 1 1 0", "v 1 0 0");
    let run = dir.run("golden verify g");
    is(
        &run,
        1,
        &["input-changed", "../pane.obj has changed", "pixels differ", "1 with changed files"],
    );
    assert!(!run.stdout.contains("1 different"), "{run:?}");
    let found = outcome(&dir.run("golden verify g --json"), "scene");
    assert_eq!(
        (&found["status"], &found["inputs"][0]),
        (&"input-changed".into(), &"../pane.obj".into())
    );
    // A comment changes nothing that is drawn; a model that is broken is a changed file, too.
    fs::write(dir.path("pane.obj"), PANE.replace("a pane", "b pane")).unwrap();
    is(&dir.run("golden verify g"), 1, &["../pane.obj has changed; what is drawn is the same"]);
    fs::write(dir.path("pane.obj"), PANE.replace("f 1 2 3", "f 1 2 9")).unwrap();
    is(&dir.run("golden verify g"), 1, &["../pane.obj has changed", "1 with changed files"]);
    fs::write(dir.path("pane.obj"), PANE).unwrap();
    is(&dir.run("golden verify g"), 0, &["1 same"]);
    edit(&dir, "scene.toml", "alpha = 0.5", "alpha = 0.6");
    is(&dir.run("golden verify g"), 1, &["../scene.toml has changed"]);
    is(&dir.run("golden verify g --bless"), 0, &["blessed", "1 blessed"]);
    is(&dir.run("golden verify g"), 0, &["1 same"]);
    // Its hashes and that of the file are other ones now; every other line is as it was.
    let blessed = text(&dir, "g/golden.toml");
    let changed = manifest.lines().zip(blessed.lines()).filter(|(a, b)| a != b).count();
    assert_eq!((changed, manifest.lines().count()), (3, blessed.lines().count()), "{blessed}");
}

/// Another k is another picture: how far it is, with a map.
#[test]
fn a_difference_has_a_map() {
    let dir = dir();
    dir.run("golden record g scene.toml layers:count=3 --size 40x30 -k 3");
    edit(
        &dir,
        "g/golden.toml",
        "scene = \"layers:count=3\"\noptions = [\"-m\", \"kplus-array\", \"-k\", \"3\"",
        "scene = \"layers:count=3\"\noptions = [\"-m\", \"kplus-array\", \"-k\", \"2\"",
    );
    let manifest = text(&dir, "g/golden.toml");
    let run = dir.run("golden verify g --json");
    assert_eq!(run.code, 1);
    let found = outcome(&run, "layers-count-3");
    assert_eq!(found["status"], "different");
    let difference = &found["difference"];
    assert_eq!([&difference["pixels"], &difference["differing"]], [1_200, 1_200]);
    assert_eq!(difference["first"], serde_json::json!([0, 0]));
    assert!(difference["max"].as_u64().unwrap() > 0);
    assert_eq!(outcome(&run, "scene")["status"], "same");
    let (map, drawn) = ("g/layers-count-3.difference.png", "g/layers-count-3.drawn.png");
    assert_eq!(found["map"], map);
    let map = png::decode(Cursor::new(dir.read(map)), 64).unwrap();
    assert_eq!([map.width, map.height], [40, 30]);
    let right = dir.run("render layers:count=3 --size 40x30 -k 2 -o right.png");
    assert_eq!((right.code, dir.read(drawn)), (0, dir.read("right.png")));
    is(&dir.run("golden verify g"), 1, &["by at most", "first at 0,0", "1 same, 1 different"]);
    is(&dir.run("golden verify g -o maps"), 1, &["maps/layers-count-3.difference.png"]);
    assert!(dir.path("maps/layers-count-3.drawn.png").is_file());
    assert_eq!(text(&dir, "g/golden.toml"), manifest, "verifying writes no manifest");
    // Only what differs is blessed.
    let scene = fs::metadata(dir.path("g/scene.png")).unwrap().modified().unwrap();
    is(&dir.run("golden verify g --bless"), 0, &["1 same, 1 blessed"]);
    assert_eq!(fs::metadata(dir.path("g/scene.png")).unwrap().modified().unwrap(), scene);
    assert_eq!(dir.read("g/layers-count-3.png"), dir.read("right.png"));
    is(&dir.run("golden verify g"), 0, &["2 same"]);
    // Without pictures, hashes say it, and -o writes what is drawn.
    dir.run("golden record h layers:count=3 --size 8 -k 3 --name x --no-pictures");
    edit(&dir, "h/golden.toml", "\"-k\", \"3\"", "\"-k\", \"2\"");
    is(&dir.run("golden verify h"), 1, &["the picture is another one"]);
    is(&dir.run("golden verify h -o maps"), 1, &["maps/x.drawn.png"]);
}

/// What another version recorded is not called a difference; what it drew alike is the same.
#[test]
fn another_program_is_named() {
    let dir = dir();
    dir.run("golden record g scene.toml -k 3");
    let version = format!("program = \"{}\"", env!("CARGO_PKG_VERSION"));
    edit(&dir, "g/golden.toml", &version, "program = \"0.0.9\"");
    is(&dir.run("golden verify g"), 0, &["1 same"]);
    edit(&dir, "g/golden.toml", "\"-k\", \"3\"", "\"-k\", \"2\"");
    let run = dir.run("golden verify g");
    is(&run, 1, &["program-changed", "recorded by 0.0.9", "1 of another version"]);
    assert!(!run.stdout.contains("1 different"), "{run:?}");
    is(&dir.run("golden verify g --bless"), 0, &["1 blessed"]);
    assert!(text(&dir, "g/golden.toml").contains(&version));
}

#[test]
fn what_is_missing_is_named() {
    let dir = dir();
    dir.run("golden record g scene.toml -k 3");
    let (manifest, picture) = (text(&dir, "g/golden.toml"), dir.read("g/scene.png"));
    fs::remove_file(dir.path("g/scene.png")).unwrap();
    is(&dir.run("golden verify g"), 1, &["missing", "scene.png is not there", "1 missing"]);
    fs::write(dir.path("g/scene.png"), &picture[..picture.len() / 2]).unwrap();
    is(&dir.run("golden verify g"), 1, &["missing", "scene.png must be a PNG picture"]);
    dir.run("render cubes --size 40x30 -o g/scene.png");
    is(&dir.run("golden verify g"), 1, &["missing", "not the picture that was recorded"]);
    is(&dir.run("golden verify g --bless"), 0, &["1 blessed"]);
    assert_eq!((text(&dir, "g/golden.toml"), dir.read("g/scene.png")), (manifest.clone(), picture));
    for name in ["pane.obj", "scene.toml"] {
        let was = dir.read(name);
        fs::remove_file(dir.path(name)).unwrap();
        let told = format!("../{name} is not there");
        for line in ["golden verify g", "golden verify g --bless"] {
            is(&dir.run(line), 1, &["missing", &told]);
        }
        assert_eq!(text(&dir, "g/golden.toml"), manifest);
        fs::write(dir.path(name), was).unwrap();
    }
    let by_hand = format!(
        "{manifest}\n[[entry]]\nname = \"new\"\nscene = \"layers:count=2\"\noptions = [\"--size\", \"9\"]\n"
    );
    fs::write(dir.path("g/golden.toml"), &by_hand).unwrap();
    is(&dir.run("golden verify g"), 1, &["new", "missing", "nothing is recorded"]);
    is(&dir.run("golden verify g --bless"), 0, &["1 same, 1 blessed"]);
    assert!(text(&dir, "g/golden.toml").starts_with(&by_hand));
    assert!(dir.path("g/new.png").is_file());
}

/// A file that was not there when it was recorded, and one that is named only now.
#[test]
fn a_file_that_appears_is_a_change() {
    let dir = Dir::new();
    fs::write(dir.path("pane.obj"), format!("mtllib pane.mtl\nusemtl red\n{PANE}")).unwrap();
    is(&dir.run("golden record g pane.obj --size 20"), 0, &["1 recorded"]);
    is(&dir.run("golden verify g"), 0, &["1 same"]);
    fs::write(dir.path("pane.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    is(&dir.run("golden verify g"), 1, &["../pane.mtl was not there before"]);
}

#[test]
fn paths_in_options_are_inputs() {
    let dir = dir();
    dir.run("render cubes --size 40x30 -o map.png");
    is(
        &dir.run("golden record g scene.toml -m k-variable --importance-map map.png"),
        0,
        &["1 recorded"],
    );
    let manifest = text(&dir, "g/golden.toml");
    assert!(manifest.contains("\"--importance-map\", \"../map.png\""), "{manifest}");
    assert!(manifest.contains("{ file = \"../map.png\""), "{manifest}");
    is(&dir.run("golden verify g"), 0, &["1 same"]);
    dir.run("render cubes --size 40x30 -k 1 -o map.png");
    is(&dir.run("golden verify g"), 1, &["../map.png has changed"]);
    let kb = "scene.toml --exec sim -m kb -k 2";
    assert_eq!(dir.run(&format!("render {kb} --record s.bin")).code, 0);
    is(&dir.run(&format!("golden record g {kb} --schedule recorded:s.bin")), 0, &["1 recorded"]);
    assert!(text(&dir, "g/golden.toml").contains("\"recorded:../s.bin\""));
    is(&dir.run("golden verify g --filter kb"), 0, &["1 same"]);
}

/// Parts cover every entry exactly once, and what they leave out is said.
#[test]
fn parts_are_joined() {
    let dir = Dir::new();
    for count in 1..=9 {
        let line = format!("golden record g layers:count={count} --size 4 --no-pictures");
        assert_eq!(dir.run(&line).code, 0);
    }
    let mut seen = BTreeMap::new();
    for part in 1..=3 {
        let run = dir.run(&format!("golden verify g --json --partition hash:{part}/3"));
        assert_eq!(run.code, 0, "{run:?}");
        for outcome in run.json()["outcomes"].as_array().unwrap() {
            *seen.entry(outcome["name"].as_str().unwrap().to_owned()).or_insert(0) += 1;
        }
        let auto = dir
            .command()
            .args(["golden", "verify", "g", "--json", "--partition", "auto"])
            .envs([
                ("SLURM_ARRAY_TASK_ID", (part - 1).to_string()),
                ("SLURM_ARRAY_TASK_COUNT", "3".into()),
            ])
            .output()
            .unwrap();
        let names = |text: &str| {
            let report: Value = serde_json::from_str(text).unwrap();
            report["outcomes"]
                .as_array()
                .unwrap()
                .iter()
                .map(|o| o["name"].clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(names(std::str::from_utf8(&auto.stdout).unwrap()), names(&run.stdout));
        fs::write(dir.path(&format!("{part}.json")), &run.stdout).unwrap();
    }
    assert!(seen.len() == 9 && seen.values().all(|&times| times == 1), "{seen:?}");
    is(&dir.run("golden merge 1.json 2.json 3.json"), 0, &["9 entries: 9 same"]);
    let left: Vec<String> = dir.run("golden merge 1.json 3.json --json").json()["not_run"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap().to_owned())
        .collect();
    assert!(!left.is_empty() && left.len() < 9);
    let merged = dir.run("golden merge 1.json 3.json --junit j.xml");
    is(&merged, 1, &[&format!("{} not run", left.len())]);
    assert!(left.iter().all(|name| merged.stdout.contains(name)));
    let junit = quick_junit::Report::deserialize_from_str(&text(&dir, "j.xml")).unwrap();
    assert_eq!((junit.tests, junit.test_suites[0].skipped), (9, left.len()));
    // Parts of another manifest do not go together with these.
    dir.run("golden record g cubes --size 4 --no-pictures");
    fs::write(dir.path("new.json"), dir.run("golden verify g --json").stdout).unwrap();
    dir.run("golden merge 1.json new.json").is_error(&["new.json:", "manifest"]);
    dir.run("golden merge g/golden.toml").is_error(&["golden.toml:", "report"]);
}

#[test]
fn junit_tells_failures_from_errors() {
    let dir = dir();
    dir.run("golden record g scene.toml layers:count=2 cubes --size 9 -k 3");
    edit(
        &dir,
        "g/golden.toml",
        "scene = \"cubes\"\noptions = [\"-m\", \"kplus-array\"",
        "scene = \"cubes\"\noptions = [\"-m\", \"kplus-aray\"",
    );
    edit(&dir, "g/golden.toml", "count=2\"", "count=3\"");
    let run = dir.run("golden verify g --junit out.xml");
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.stdout.contains("did you mean kplus-array?"), "{run:?}");
    assert!(run.stdout.contains("1 same, 1 different, 1 in error"), "{run:?}");
    let junit = quick_junit::Report::deserialize_from_str(&text(&dir, "out.xml")).unwrap();
    assert_eq!((junit.tests, junit.failures, junit.errors), (3, 1, 1));
}

#[test]
fn errors_are_one_line_and_write_nothing() {
    let dir = dir();
    dir.run("golden record g scene.toml");
    let before = dir.read("g/golden.toml");
    for (line, words) in [
        ("golden record g scene.toml", &["recorded already", "--bless", "--name"][..]),
        ("golden record g scene.toml cubes --name a", &["--name:", "one scene"]),
        ("golden record g cubes a/cubes.obj", &["--name:", "\"cubes\""]),
        ("golden record g cubes --name a/b", &["--name:", "a-z"]),
        ("golden record g cubes -m kb --exec threads", &["run to run", "--exec sim"]),
        ("golden record g none.obj", &["none.obj", "cannot be read"]),
        ("golden record g -", &["SCENE:", "stdin"]),
        ("golden record g cubes layers:count=0", &["layers"]),
        ("golden record g cubes --effect ldi --ldi x.npz", &["--ldi:"]),
        ("golden record new", &["SCENE:", "new"]),
        ("golden record scene.toml cubes", &["DIR:", "scene.toml"]),
        ("golden record g cubes -j 2000", &["--jobs:", "1024"]),
        ("golden verify nothing", &["nothing", "golden record"]),
        ("golden verify g --partition 1/2", &["--partition:", "hash:1/3"]),
        ("golden verify g --partition auto", &["--partition:", "SLURM_ARRAY_TASK_ID"]),
        ("golden verify g --partition hash:1/2 --bless", &["--bless", "--partition"]),
        ("golden verify g --filter zzz", &["--filter:", "zzz"]),
        ("golden verify g --junit g/golden.toml", &["--junit:", "input"]),
        ("golden verify g --junit pane.obj", &["--junit:", "input"]),
        ("golden verify g --junit no/where.xml", &["--junit:", "folder"]),
        ("golden verify g -o pane.obj", &["-o:", "folder"]),
        ("golden merge none.json", &["none.json:"]),
        ("golden", &["record"]),
        ("golden recrod g", &["golden record"]),
    ] {
        dir.run(line).is_error(words);
    }
    assert_eq!(
        (dir.names(), dir.read("g/golden.toml")),
        (vec!["g".into(), "pane.obj".into(), "scene.toml".into()], before)
    );
}

/// Files by name, without those that a killed process left beside.
fn files(dir: &Dir, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(dir.path(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let names = names.filter(|name| !name.starts_with(".fragloom-"));
    names.map(|name| (name.clone(), dir.read(&format!("{folder}/{name}")))).collect()
}

/// Killed at any moment, `--bless` and `record` leave the manifest as it was or as it should be, and every file whole.
#[test]
fn a_killed_process_leaves_whole_files() {
    let dir = Dir::new();
    let scenes = (1..=5).map(|n| format!("layers:count={n}")).collect::<Vec<_>>().join(" ");
    assert_eq!(dir.run(&format!("golden record g {scenes} --size 300 -k 3")).code, 0);
    let (whole, manifest) = (files(&dir, "g"), text(&dir, "g/golden.toml"));
    let changed = manifest.replace("\"300\"", "\"290\"");
    fs::write(dir.path("g/golden.toml"), &changed).unwrap();
    #[expect(clippy::disallowed_methods, reason = "a test that kills must know when")]
    let start = std::time::Instant::now();
    assert_eq!(dir.run("golden verify g --bless").code, 0);
    let took = start.elapsed().max(Duration::from_millis(20));
    let blessed = files(&dir, "g");
    let (mut before, mut after) = (0, 0);
    for moment in 0..60 {
        fs::remove_dir_all(dir.path("g")).unwrap();
        fs::create_dir(dir.path("g")).unwrap();
        whole
            .iter()
            .for_each(|(name, bytes)| fs::write(dir.path(&format!("g/{name}")), bytes).unwrap());
        fs::write(dir.path("g/golden.toml"), &changed).unwrap();
        let mut child = dir
            .command()
            .args(["golden", "verify", "g", "--bless", "-q"])
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(took * moment / 50);
        let _ = child.kill();
        child.wait().unwrap();
        let now = files(&dir, "g");
        for (name, bytes) in &now {
            let old = if name == "golden.toml" { changed.as_bytes() } else { &whole[name] };
            assert!(bytes == old || *bytes == blessed[name], "{name} at {moment}");
        }
        assert_eq!(now.len(), whole.len());
        if now["golden.toml"] == changed.as_bytes() {
            before += 1;
        } else {
            assert_eq!(now, blessed, "the manifest comes last");
            after += 1;
        }
    }
    println!("{before} times before the manifest was written, {after} times after");
    assert!(before > 0 && after > 0, "{before} {after}");
    for moment in 0..30 {
        let _ = fs::remove_dir_all(dir.path("new"));
        let line = format!("golden record new {scenes} --size 300 -k 3 -q");
        let mut child = dir
            .command()
            .args(line.split(' '))
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(took * moment / 25);
        let _ = child.kill();
        child.wait().unwrap();
        let now = if dir.path("new").exists() { files(&dir, "new") } else { BTreeMap::new() };
        assert!(now.iter().all(|(name, bytes)| *bytes == whole[name]), "{moment}");
        assert!(!now.contains_key("golden.toml") || now == whole, "the manifest comes last");
    }
}
