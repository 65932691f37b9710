//! `fragloom info`: what is in a scene, as a table and as a document.

#[path = "support/command.rs"]
mod support;

use std::fs;
use std::io::Write as _;

use support::Dir;

/// A tetrahedron whose last face is the one at the bottom.
const TETRAHEDRON: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n";

#[test]
fn the_document_has_every_key() {
    let run = Dir::new().run("info layers:count=4 --size 48x32 --json");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let info = run.json();
    let keys: Vec<&String> = info.as_object().unwrap().keys().collect();
    let mut expected = [
        "background",
        "bounds",
        "camera",
        "cameras",
        "depth_complexity",
        "discs",
        "files",
        "height",
        "kind",
        "light",
        "materials",
        "objects",
        "scene",
        "screen_triangles",
        "triangles",
        "volumes",
        "warnings",
        "width",
    ]
    .to_vec();
    expected.sort_unstable();
    let mut keys: Vec<&str> = keys.into_iter().map(String::as_str).collect();
    keys.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!((&info["width"], &info["height"]), (&48.into(), &32.into()));
    assert_eq!((info["kind"].as_str(), &info["bounds"]), (Some("built-in scene"), &().into()));
    let found = serde_json::json!({
        "max": 4, "mean": 4.0, "covered_pixels": 1_536, "fragments": 6_144, "degenerate": 0
    });
    assert_eq!(info["depth_complexity"], found);
}

#[test]
fn fragments_are_those_that_are_drawn() {
    let dir = Dir::new();
    let info = dir.run("info cubes --size 64x48 --json").json();
    let report = dir.run("render cubes --size 64x48 -m exact --json").json();
    let complexity = &info["depth_complexity"];
    assert_eq!(complexity["fragments"], report["generated"]);
    assert_eq!(complexity["max"], report["max_depth_complexity"]);
    assert_eq!(complexity["degenerate"], report["degenerate"]);
    assert_eq!(info["triangles"], report["triangles"]);
    let covered = complexity["covered_pixels"].as_u64().unwrap();
    assert!(covered > 0 && covered < 64 * 48);
    let mean = complexity["fragments"].as_u64().unwrap() as f64 / covered as f64;
    assert_eq!(complexity["mean"].as_f64(), Some(mean));
}

#[test]
fn closed_objects_are_told_from_open_ones() {
    let dir = Dir::new();
    fs::write(dir.path("closed.obj"), TETRAHEDRON).unwrap();
    let open = TETRAHEDRON.replace("f 1 3 2\n", "f 1 1 2\n");
    fs::write(dir.path("open.obj"), open).unwrap();
    let info = dir.run("info closed.obj --json").json();
    let object = &info["objects"][0];
    assert_eq!((&object["closed"], &object["open_edges"]), (&true.into(), &0.into()));
    assert_eq!((&object["triangles"], &object["degenerate"]), (&4.into(), &0.into()));
    assert_eq!(info["kind"], "mesh (.obj)");
    assert_eq!(info["files"], serde_json::json!(["closed.obj"]));
    assert_eq!(info["bounds"]["max"], serde_json::json!([1.0, 1.0, 2.0]));
    let table = dir.run("info closed.obj").stdout;
    assert!(table.contains("closed") && table.contains("  yes "), "{table}");
    assert!(table.contains("(0, 0, 0) to (1, 1, 2)"), "{table}");
    let object = dir.run("info open.obj --json").json()["objects"][0].clone();
    assert_eq!((&object["closed"], &object["open_edges"]), (&false.into(), &3.into()));
    assert_eq!(object["degenerate"], 1);
    assert!(dir.run("info open.obj").stdout.contains("no, 3 open edges"));
    let packed = fs::File::create(dir.path("closed.OBJ.gz")).unwrap();
    let mut packer = flate2::write::GzEncoder::new(packed, flate2::Compression::fast());
    packer.write_all(&dir.read("closed.obj")).unwrap();
    packer.finish().unwrap();
    assert_eq!(dir.run("info closed.OBJ.gz --json").json()["kind"], "mesh (.obj.gz)");
    assert_eq!(dir.names(), ["closed.OBJ.gz", "closed.obj", "open.obj"], "nothing is written");
}

#[test]
fn points_volumes_and_cameras_are_there() {
    let dir = Dir::new();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    fs::write(dir.path("p.ply"), ply).unwrap();
    let info = dir.run("info p.ply --size 32 --point-radius 0.25 --json").json();
    assert_eq!((info["kind"].as_str(), &info["discs"]), (Some("point set (.ply)"), &3.into()));
    assert_eq!(info["objects"][0]["closed"], serde_json::Value::Null);
    let larger = dir.run("info p.ply --size 32 --point-radius 0.5 --json").json();
    let fragments = |info: &serde_json::Value| info["depth_complexity"]["fragments"].as_u64();
    assert!(fragments(&larger) > fragments(&info));
    let scene = "[camera]\neye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\northo_height = 3.0\n\
                 near = 1.0\nfar = 9.0\n[[volume]]\nprocedural = \"constant\"\nn = 4\n\
                 [[object]]\nfile = \"p.ply\"\n";
    fs::write(dir.path("s.toml"), scene).unwrap();
    let info = dir.run("info s.toml --size 32 --json").json();
    assert_eq!(info["kind"], "scene file (.toml)");
    assert_eq!(info["volumes"][0]["voxels"], serde_json::json!([4, 4, 4]));
    let camera = &info["camera"];
    assert_eq!(
        (camera["projection"].as_str(), &camera["fov_y"]),
        (Some("orthographic"), &().into())
    );
    assert_eq!((&camera["ortho_height"], &camera["far"]), (&3.0.into(), &9.0.into()));
    let table = dir.run("info s.toml --size 32").stdout;
    for part in ["4x4x4", "orthographic, 3 high", "1 to 9", "volumes", "(0, 0, 5)"] {
        assert!(table.contains(part), "{part} in {table}");
    }
}

#[test]
fn many_objects_are_summed_up_in_the_table() {
    let dir = Dir::new();
    fs::write(dir.path("a.obj"), TETRAHEDRON).unwrap();
    let scene = |count: usize| -> String {
        let object = |i: usize| format!("[[object]]\nname = \"part{i}\"\nfile = \"a.obj\"\n");
        (0..count).map(object).collect()
    };
    fs::write(dir.path("few.toml"), scene(20)).unwrap();
    fs::write(dir.path("many.toml"), scene(21)).unwrap();
    assert!(dir.run("info few.toml --size 8").stdout.contains("part19"));
    let table = dir.run("info many.toml --size 8").stdout;
    assert!(!table.contains("part19"), "{table}");
    let rows: Vec<Vec<&str>> =
        table.lines().map(|line| line.split_whitespace().collect()).collect();
    for row in [["number", "21"], ["triangles", "84"], ["closed", "21"]] {
        assert!(rows.iter().any(|found| **found == row), "{row:?} in {table}");
    }
    let info = dir.run("info many.toml --size 8 --json").json();
    assert_eq!(info["objects"].as_array().unwrap().len(), 21);
}

#[test]
fn warnings_are_part_of_the_result() {
    let dir = Dir::new();
    let run = dir.run("info cubes --size 8 --point-radius 1");
    assert!(run.stdout.contains("\nwarnings\n--point-radius") && run.stderr.is_empty(), "{run:?}");
    let info = dir.run("info cubes --size 8 --point-radius 1 --json").json();
    assert!(info["warnings"][0].as_str().unwrap().contains("no effect"));
}

#[test]
fn bad_input_is_one_line() {
    let dir = Dir::new();
    dir.run("info").is_error(&["SCENE"]);
    dir.run("info missing.obj").is_error(&["missing.obj"]);
    dir.run("info cubes --size 0x4").is_error(&["--size:", "16384"]);
    dir.run("info cubes --alpha 2").is_error(&["--alpha:", "0"]);
    dir.run("info nonsense").is_error(&["nonsense"]);
}

/// Cameras of files, pictures of materials, and what comes in on stdin.
#[test]
fn cameras_and_pictures_are_listed() {
    let dir = Dir::new();
    let picture = fragloom::image::png::encode(&fragloom::image::Image {
        width: 3,
        height: 2,
        pixels: vec![[255; 4]; 6],
    });
    std::fs::write(dir.path("p.png"), picture.unwrap()).unwrap();
    let corners = [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0];
    let places = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0];
    let bytes: Vec<u8> = corners.iter().chain(&places).flat_map(|c| c.to_le_bytes()).collect();
    std::fs::write(dir.path("b.bin"), bytes).unwrap();
    let scene = r#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}, {"camera": 0, "name": "n"}],
        "cameras": [{"type": "perspective", "name": "own", "perspective": {"yfov": 1, "znear": 1}}],
        "materials": [{"name": "wood", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": "p.png"}],
        "buffers": [{"byteLength": 60, "uri": "b.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}]}"#;
    std::fs::write(dir.path("m.gltf"), scene).unwrap();
    let document = dir.run("info m.gltf --json --camera own").json();
    assert_eq!(document["cameras"], serde_json::json!([["own", "n"]]));
    assert_eq!(document["materials"][0]["picture"], serde_json::json!([3, 2]));
    assert_eq!(document["camera"]["near"], 1.0);
    let table = dir.run("info m.gltf").stdout;
    assert!(table.contains("3x2") && table.contains("\"own\", \"n\""), "{table}");
}
