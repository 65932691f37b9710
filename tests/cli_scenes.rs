//! Where scenes come from on the command line: files, stdin, archives; and the camera that is told.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/command.rs"]
mod support;

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::process::Stdio;

use fragloom::image::{Image, png};
use serde_json::Value;
use support::Dir;

const QUAD: &str = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n";
const LIBRARY: &str = "newmtl a\nKd 1 0 0\nd 0.25\nmap_Kd -s 2 2 2 wood.png\nmap_Ks -clamp on -mm 0 1 \"old wood.png\"\n";
const SMALL: &str = "--size 32 --json -q";

/// A folder with these files.
fn folder(files: &[(&str, &[u8])]) -> Dir {
    let dir = Dir::new();
    files.iter().for_each(|(name, bytes)| fs::write(dir.path(name), bytes).unwrap());
    dir
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The report of a run that must succeed.
#[track_caller]
fn report(dir: &Dir, line: &str) -> Value {
    let run = dir.run(line);
    assert_eq!(run.code, 0, "{line}: {run:?}");
    run.json()
}

/// A run with `bytes` on stdin: exit code, stdout and stderr.
fn piped(dir: &Dir, line: &str, bytes: &[u8]) -> (i32, String, String) {
    let mut command = dir.command();
    command.args(line.split_whitespace()).stdin(Stdio::piped());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The other end may be closed before all is written.
    let _ = child.stdin.take().unwrap().write_all(bytes);
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

#[test]
fn what_comes_in_on_stdin_is_what_the_file_is() {
    let dir = folder(&[("a.obj", QUAD.as_bytes()), ("a.mtl", LIBRARY.as_bytes())]);
    let of_file = report(&dir, &format!("render a.obj {SMALL}"));
    let (code, stdout, stderr) =
        piped(&dir, &format!("render - --format obj {SMALL}"), QUAD.as_bytes());
    assert_eq!(code, 0, "{stderr}");
    let piped_report: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(piped_report["scene"], "stdin");
    for key in ["image_hash", "fragments_hash", "generated", "triangles"] {
        assert_eq!(piped_report[key], of_file[key], "{key}");
    }
    let toml = b"[[object]]\nfile = \"a.obj\"\n";
    assert_eq!(piped(&dir, &format!("render - --format toml {SMALL}"), toml).0, 0);
    for (line, bytes, words) in [
        ("render - -q", QUAD, ["--format", "stdin"]),
        ("render - --format obj -q", "", ["stdin", "empty"]),
        ("render - --format obj -q", "v 0 0 x\nf 1 1 1", ["stdin", "line 2"]),
        ("render - --format obj -o a.mtl", QUAD, ["a.mtl", ".png"]),
    ] {
        let (code, stdout, stderr) = piped(&dir, line, bytes.as_bytes());
        assert_eq!((code, stdout.as_str()), (2, ""), "{line}: {stderr}");
        assert!(words.iter().all(|word| stderr.contains(word)), "{line}: {stderr}");
    }
    let renamed = folder(&[("model", QUAD.as_bytes()), ("a.mtl", LIBRARY.as_bytes())]);
    renamed.run("render model").is_error(&["model", "--format"]);
    let told = report(&renamed, &format!("render model --format obj {SMALL}"));
    assert_eq!(told["image_hash"], of_file["image_hash"]);
}

#[test]
fn zipped_models_bring_what_they_name() {
    let dir = folder(&[("a.obj", QUAD.as_bytes()), ("a.mtl", LIBRARY.as_bytes())]);
    let of_file = report(&dir, &format!("render a.obj {SMALL}"));
    let packed = zip(&[
        ("__MACOSX/model/a.obj", b"junk"),
        ("model/readme.txt", b"text"),
        ("model/a.obj", QUAD.replace("a.mtl", "..\\\\model\\\\a.mtl").as_bytes()),
        ("model/a.mtl", LIBRARY.as_bytes()),
    ]);
    fs::write(dir.path("model.zip"), &packed).unwrap();
    let found = report(&dir, &format!("render model.zip {SMALL}"));
    assert_eq!(found["image_hash"], of_file["image_hash"]);
    // Files that are packed twice.
    let twice = zip(&[("a.obj.gz", &gzip(QUAD.as_bytes())), ("a.mtl", LIBRARY.as_bytes())]);
    fs::write(dir.path("twice.zip"), twice).unwrap();
    let found = report(&dir, &format!("render twice.zip {SMALL}"));
    assert_eq!(found["image_hash"], of_file["image_hash"]);
    let many = zip(&[("b.obj", QUAD.as_bytes()), ("a.stl", b"x")]);
    for (bytes, words) in [
        (b"no archive".to_vec(), ["zip archive", "z.zip"]),
        (packed[..packed.len() / 2].to_vec(), ["zip archive", "whole"]),
        (zip(&[("readme.txt", b"text")]), ["no .obj", "z.zip"]),
        (many, ["2 models", "a.stl and b.obj"]),
        (zip(&[("a.stl.gz", b"\x1F\x8Bjunk")]), ["z.zip: a.stl.gz", "gzip"]),
        (zip(&[("a/m.obj", b"f 1 2 3")]), ["z.zip: a/m.obj", "line 1"]),
    ] {
        fs::write(dir.path("z.zip"), bytes).unwrap();
        dir.run("render z.zip").is_error(&words);
    }
}

/// Whatever a material names is an input, drawn or not.
#[test]
fn pictures_of_materials_are_not_overwritten() {
    let pixels = vec![[1, 2, 3, 255]];
    let picture = png::encode(&Image { width: 1, height: 1, pixels }).unwrap();
    let document = r#"{"asset": {"version": "2.0"}, "scene": 0, "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}], "images": [{"uri": "wood.png"}],
        "buffers": [{"byteLength": 36, "uri": "b.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}"#;
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    let dir = folder(&[
        ("a.obj", QUAD.as_bytes()),
        ("a.mtl", LIBRARY.as_bytes()),
        ("m.gltf", document.as_bytes()),
        ("b.bin", &bytes),
        ("wood.png", &picture),
        ("s.toml", b"[[object]]\nfile = \"a.obj\"\n"),
    ]);
    for scene in ["a.obj", "m.gltf", "s.toml"] {
        for output in ["wood.png", "./wood.png"] {
            let run = dir.run(&format!("render {scene} --size 32 -o {output}"));
            run.is_error(&["wood.png", "input"]);
        }
    }
    fs::write(dir.path("old wood.png"), &picture).unwrap();
    let mut command = dir.command();
    let output = command.args(["render", "a.obj", "-o", "old wood.png"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "options and blanks before a name do not hide it");
    fs::remove_file(dir.path("old wood.png")).unwrap();
    assert_eq!(dir.read("wood.png"), picture);
    assert_eq!(dir.names(), ["a.mtl", "a.obj", "b.bin", "m.gltf", "s.toml", "wood.png"]);
}

#[test]
fn the_camera_is_what_is_told() {
    let dir = folder(&[("a.obj", QUAD.as_bytes()), ("a.mtl", LIBRARY.as_bytes())]);
    let generated = |options: &str| {
        let report = report(&dir, &format!("render a.obj -m exact {options} {SMALL}"));
        report["generated"].as_u64().unwrap()
    };
    // 4 units of 8 are 16 pixels of 32.
    assert_eq!(generated("--view front --ortho 8"), 256);
    assert_eq!(generated("--eye 2,2,9 --target 2,2,0 --ortho 8"), 256);
    assert_eq!(generated("--eye 2,2,9 --target 2,2,0 --ortho 8 --near 10 --far 11"), 0);
    assert_eq!(generated("--view top --ortho 8"), 0, "from above it is a line");
    assert_eq!(generated("--view top --up z --ortho 8"), 256);
    assert_eq!(generated("--view back --cull-face back --ortho 8"), 0);
    // At a distance of 4, 4 units are half of what 90 degrees show.
    assert_eq!(generated("--eye 2,2,4 --target 2,2,0 --fov 90"), 256);
    for (options, words) in [
        ("--eye 1,2", &["--eye", "1,2"][..]),
        ("--eye 0,0,0 --target 0,0,0", &["--target", "apart"]),
        ("--eye 2,2,9 --target 2,2,0 --up z", &["--up", "parallel"]),
        ("--fov 180", &["--fov", "179"]),
        ("--near 5 --far 2", &["--near", "--far"]),
        ("--camera front", &["--camera", "\"front\"", "no camera"]),
        ("--eye 1,2,3 --view top", &["--view"]),
    ] {
        dir.run(&format!("render a.obj {options}")).is_error(words);
    }
}

#[test]
fn cameras_of_files_have_names() {
    let scene = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0},
            {"name": "Over the shoulder", "camera": 0, "translation": [1, 1, 9]},
            {"camera": 1, "translation": [1, 1, 9], "name": "broken"}],
        "cameras": [{"type": "orthographic", "name": "plan",
            "orthographic": {"xmag": 2, "ymag": 2, "znear": 1, "zfar": 20}}, {"type": "wide"}],
        "buffers": [{"byteLength": 36, "uri": "b.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}"#;
    let corners = [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    let dir = folder(&[
        ("m.gltf", scene.as_bytes()),
        ("b.bin", &bytes),
        ("s.toml", b"[[object]]\nfile = \"m.gltf\"\ntranslate = [5, 0, 0]\n"),
    ]);
    // A right triangle of 16 pixels by 16, with half of its diagonal.
    for line in ["m.gltf --camera plan", "m.gltf --camera 0", "s.toml --camera plan"] {
        let report = report(&dir, &format!("render {line} -m exact {SMALL}"));
        let generated = report["generated"].as_u64().unwrap();
        assert!((120..=136).contains(&generated), "{line}: {generated}");
    }
    let mut command = dir.command();
    command.args(["render", "m.gltf", "--camera", "Over the shoulder", "--json", "-q"]);
    assert!(command.output().unwrap().status.success());
    dir.run("render m.gltf --camera nobody").is_error(&["--camera", "nobody", "\"plan\""]);
    let run = dir.run("render m.gltf --size 32");
    assert!(run.stderr.contains("camera") && run.stderr.contains("broken"), "{run:?}");
}

/// A fresh copy of a folder of `tests/inputs`.
fn input(name: &str) -> Dir {
    let dir = Dir::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs").join(name);
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        fs::write(dir.path(path.file_name().unwrap().to_str().unwrap()), fs::read(&path).unwrap())
            .unwrap();
    }
    dir
}

/// Outputs that are inputs, and files whose format is not written: refused, and every byte is as before.
#[test]
fn inputs_are_not_overwritten() {
    for (name, line, words) in [
        ("over-input", "render a.obj -o a.obj", ["-o", "a.obj"]),
        ("over-scene-picture", "render s.toml -o s.toml", ["-o", "s.toml"]),
        ("over-referenced", "render s.toml -o a.obj", ["-o", "a.obj"]),
        ("output-jpg", "render a.obj -o o.jpg", [".png", ".exr"]),
    ] {
        let dir = input(name);
        let read = |dir: &Dir| dir.names().iter().map(|n| dir.read(n)).collect::<Vec<_>>();
        let (names, before) = (dir.names(), read(&dir));
        dir.run(line).is_error(&words);
        assert_eq!((dir.names(), read(&dir)), (names, before), "{name}");
    }
}

/// What people type who know other programs.
#[test]
fn habits_give_what_is_meant() {
    let run = |name: &str, line: &str| {
        let dir = input(name);
        let mut command = dir.command();
        let words = line.split('|').map(str::trim);
        let output = command.args(words).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{line}: {text}");
        (dir, output.stdout, text)
    };
    let (_, stdout, stderr) = run("stdout-png", "render | a.obj | -o | - | -q");
    assert!(stdout.starts_with(b"\x89PNG") && stdout.ends_with(b"IEND\xAE\x42\x60\x82"));
    assert_eq!(stderr, "");
    let (_, stdout, _) =
        run("methods-spaces", "compare | cubes | --size | 32x32 | -m | ab-ll, s-buffer | -q");
    let table = String::from_utf8(stdout).unwrap();
    assert!(table.contains("ab-ll") && table.contains("s-buffer"), "{table}");
    let (_, stdout, _) = run("size-one-number", "render | a.obj | --size | 64 | --json | -q");
    let report: Value = serde_json::from_slice(&stdout).unwrap();
    assert_eq!((&report["width"], &report["height"]), (&64.into(), &64.into()));
    for size in ["64X64", " 64 x 64 ", "64,64"] {
        let (_, stdout, _) =
            run("size-one-number", &format!("render | a.obj | --size | {size} | --json | -q"));
        let report: Value = serde_json::from_slice(&stdout).unwrap();
        assert_eq!((&report["width"], &report["height"]), (&64.into(), &64.into()), "{size}");
    }
    run("size-one-number", "render | a.obj | --size | 8 | -m | KPLUS-Array | --view | Front | -q");
    let (dir, ..) =
        run("new-folder", "compare | cubes | --size | 8 | -m | ab-ll | -o | a/b/c | -q");
    assert!(dir.path("a/b/c").is_dir());
    let (dir, ..) =
        run("new-folder", "compare | cubes | --size | 32x32 | -m | ab-ll | -o | sheets | -q");
    assert!(dir.path("sheets").is_dir());
    let (_, stdout, stderr) = run("nothing-in-view", "render | s.toml | --json | -q");
    let report: Value = serde_json::from_slice(&stdout).unwrap();
    assert_eq!(report["generated"], 0);
    assert!(stderr.contains("nothing is in view"), "{stderr}");
}

#[test]
fn a_model_on_stdin_is_the_file() {
    let dir = input("stdin");
    let (code, stdout, stderr) = piped(&dir, "render - --format obj --json -q", &dir.read("a.obj"));
    assert_eq!(code, 0, "{stderr}");
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let of_file = self::report(&dir, "render a.obj --json -q");
    assert_eq!(report["image_hash"], of_file["image_hash"]);
}

/// The link stays, and what it names is there, as any new file is.
#[cfg(unix)]
#[test]
fn a_dangling_link_is_followed() {
    use std::os::unix::fs::PermissionsExt;
    let dir = input("dangling");
    std::os::unix::fs::symlink("target.png", dir.path("o.png")).unwrap();
    let run = dir.run("render a.obj --size 32x32 -o o.png -q");
    assert_eq!(run.code, 0, "{run:?}");
    assert!(dir.path("o.png").is_symlink() && dir.read("target.png").starts_with(b"\x89PNG"));
    let mode = |name: &str| fs::metadata(dir.path(name)).unwrap().permissions().mode() & 0o777;
    fs::write(dir.path("new"), "").unwrap();
    assert_eq!(mode("target.png"), mode("new"));
}

/// The reader goes away before anything is written: no panic, and no word about it.
#[test]
fn a_reader_that_goes_away_hears_nothing() {
    let dir = input("guard-closed-pipe-render");
    let mut command = dir.command();
    command.args(["render", "a.obj", "--size", "64", "-q", "--json"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(!stderr.contains("panicked") && stderr.is_empty(), "{stderr}");
}
