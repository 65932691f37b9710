//! What a user meets: errors that name option and place, warnings, files.

use serde_json::Value;

use self::command::Dir;

#[path = "../support/command.rs"]
#[allow(dead_code, reason = "its other users use the rest")]
mod command;

const CUBES: &str = "render cubes --size 40x32 -q";

#[test]
fn errors_name_the_option_and_the_place() {
    let dir = Dir::new();
    for (line, words) in [
        ("--effect csg=(a|", &["--effect", "column 4", "expected an object's name"][..]),
        ("--effect csg=a-q", &["--effect", "column 3", "\"q\"", "there are a, b, c, d, e, f"]),
        ("--effect fog", &["--effect", "csg=EXPRESSION"]),
        ("--effect csg=a --data color", &["--data", "primitive"]),
        ("--effect media --data color", &["--data", "primitive"]),
        ("--effect csg=a --cull-face back", &["--cull-face"]),
        ("--effect ldi --cull-face front", &["--cull-face"]),
        ("--effect media --density -1", &["--density", "0 or more"]),
        ("--effect ldi --voxels 0", &["--voxels", "1 to 16384"]),
        ("--effect ldi --voxels 4096 --max-memory 1M", &["--max-memory", "voxels"]),
        ("--voxels 4", &["--voxels", "--effect ldi"]),
        ("--shadow-size 4", &["--shadow-size", "--shadows"]),
        ("--shadows --shadow-size 0", &["--shadow-size", "1 to 16384"]),
        ("--shadows --shadow-bias -1", &["--shadow-bias"]),
        ("--shadows --exec sim --record x", &["--record", "--shadows"]),
    ] {
        dir.run(&format!("{CUBES} -o out.png {line}")).is_error(words);
    }
    for line in ["--shadows", "--effect media", "--effect csg=a"] {
        let option = line.split([' ', '=']).next().unwrap_or_default();
        dir.run(&format!("render layers -q --size 8x8 {line}")).is_error(&[option, "pixels"]);
    }
    assert!(dir.names().is_empty(), "nothing is written");
}

#[test]
fn names_in_scene_files() {
    let dir = Dir::new();
    let object = |name: &str| format!("[[object]]\n{name}\nprocedural = \"box\"\n");
    let write = |text: String| std::fs::write(dir.path("s.toml"), text).expect("written");
    for (names, words) in [
        (["name = \"x\"", "name = \"x\""], ["object 1: name", "\"x\" is the name of object 0"]),
        (["name = \"b\"", ""], ["object 1: name", "\"b\" is the name of object 0"]),
        (["", "name = \"2b\""], ["object 1: name", "\"2b\" must be letters"]),
    ] {
        write(names.map(object).concat());
        dir.run("render s.toml -q --size 8x8").is_error(&words);
    }
    write(["name = \"one\"", ""].map(object).concat());
    let run = dir.run("render s.toml -q --size 8x8 --effect csg=one-b --json -m exact");
    assert_eq!(run.code, 0, "{run:?}");
    dir.run("render s.toml -q --size 8x8 --effect csg=a").is_error(&["there are one, b"]);
}

#[test]
fn what_was_not_kept_is_told() {
    let run = Dir::new().run(&format!("{CUBES} --effect csg=a-f -k 2 --json"));
    assert_eq!(run.code, 0, "{run:?}");
    assert!(run.stderr.starts_with("warning: csg: kplus-array did not keep"), "{run:?}");
    let run = Dir::new().run(&format!("{CUBES} --shadows -k 1 --json"));
    assert!(run.stderr.contains("warning: shadows: kplus-array did not keep"), "{run:?}");
}

/// The names of an `.npz`'s arrays, and how many bytes each has after its header.
fn members(archive: &[u8]) -> Vec<(String, u64)> {
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(archive)).expect("a zip");
    (0..zip.len())
        .map(|i| {
            let file = zip.by_index(i).expect("a member");
            (file.name().expect("a name").into_owned(), file.size() - 128)
        })
        .collect()
}

#[test]
fn files_and_reports() {
    let dir = Dir::new();
    let line = "-m ab-ll --json --effect csg=(a|b)-c --surfaces s.npz --fragments f.npz -o p.png";
    let report = dir.run(&format!("{CUBES} {line}")).json();
    assert_eq!(report["effect"], "csg");
    assert_eq!(dir.names(), ["f.npz", "p.png", "s.npz"]);
    let kept = report["kept"].as_u64().expect("a number");
    let all = members(&dir.read("f.npz"));
    let surfaces = members(&dir.read("s.npz"));
    assert_eq!(all[1], ("depth.npy".to_owned(), 4 * kept));
    assert!(surfaces[1].1 < all[1].1 && surfaces[0] == all[0]);

    let run = dir.run(&format!("{CUBES} -m ab-ll --json --effect ldi --voxels 5 --ldi l.npz"));
    let report = run.json();
    assert!(report["solid_voxels"].as_u64().is_some_and(|solid| solid > 100), "{report}");
    let names: Vec<String> = members(&dir.read("l.npz")).into_iter().map(|m| m.0).collect();
    assert_eq!(names, ["offsets.npy", "depth.npy", "voxels.npy", "width.npy", "height.npy"]);
    assert_eq!(members(&dir.read("l.npz"))[2].1, 5 * 40 * 32);

    let report = dir.run(&format!("{CUBES} -m ab-ll --json --shadows --shadow-size 32")).json();
    let Value::Object(map) = &report["shadows"] else { panic!("{report}") };
    assert_eq!((&map["size"], map["kept"] == map["generated"]), (&32.into(), true));
    let table = dir.run(&format!("{CUBES} -m ab-ll --shadows --effect media"));
    assert!(table.stdout.contains("shadow map") && table.stdout.contains("\neffect "), "{table:?}");
}
