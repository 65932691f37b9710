//! OBJ and MTL.

use fragloom::error::Result;
use fragloom::scene::{GREY, Model, obj};

use super::assert_fails;

fn parse(text: &str) -> Result<Model> {
    with_library(text, "")
}

fn with_library(text: &str, mtl: &str) -> Result<Model> {
    let mut library = |name: &str| (name == "a.mtl").then(|| mtl.as_bytes().to_vec());
    obj::parse(text.as_bytes(), "test.obj", &mut library)
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn square(face: &str) -> Result<Model> {
    parse(&format!("{SQUARE}{face}\n"))
}

#[test]
fn polygons_become_fans_and_negative_indices_count_back() {
    let model = square("f 1 2 3 4 # whole").unwrap();
    assert_eq!(model.objects[0].mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(model.materials[0].color, GREY);
    let relative = square("f -4 -3 -2 -1").unwrap();
    assert_eq!(relative.objects[0].mesh, model.objects[0].mesh);
    let pentagon = parse(&format!("{SQUARE}v 0 0.5 0\nf 1 2 3 4 5")).unwrap();
    assert_eq!(pentagon.objects[0].mesh.triangles.len(), 3);
}

#[test]
fn normals_and_colours_are_kept() {
    let text = "v 2 0 0 1 0 0\nv 0 2 0 0 1 0\nv 0 0 2 0 0 1\nvn 0 0 1\nvt 0.5\nf 1/1/1 2/1/1 3//1";
    let mesh = parse(text).unwrap().objects[0].mesh.clone();
    assert_eq!(mesh.colors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    let weighted = parse("v 2 4 6 2\nv 1 0 0\nv 0 1 0 1\nf 1 2 3").unwrap();
    assert_eq!(weighted.objects[0].mesh.positions[0], [2.0, 4.0, 6.0]);
    assert_eq!(weighted.warnings.len(), 1, "{:?}", weighted.warnings);
}

#[test]
fn materials_split_meshes_and_bring_colour_and_opacity() {
    let mtl =
        "newmtl red glass\nKd 1 0 0\nd 0.25\nnewmtl blue\nKd 0 0 1\nTr 0.25\nnewmtl grey\nKd 0.5\n";
    let text = format!(
        "mtllib a.mtl\n{SQUARE}usemtl red glass\nf 1 2 3\nusemtl blue\nf 1 3 4\nusemtl grey\nf 2 3 4"
    );
    let model = with_library(&text, mtl).unwrap();
    assert_eq!(model.warnings, [""; 0]);
    let looks: Vec<_> = model.objects.iter().map(|o| &model.materials[o.material]).collect();
    assert_eq!(
        (looks[0].name.as_str(), looks[0].color, looks[0].alpha),
        ("red glass", [1.0, 0.0, 0.0], 0.25)
    );
    assert_eq!((looks[1].color, looks[1].alpha), ([0.0, 0.0, 1.0], 0.75));
    assert_eq!((looks[2].color, looks[2].alpha), ([0.5; 3], 1.0));
    assert!(model.objects.iter().all(|o| o.mesh.positions.len() == 3));
}

#[test]
fn gaps_are_warnings() {
    let missing = format!("mtllib none.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4");
    let warnings = parse(&missing).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("test.obj: mtllib: \"none.mtl\""), "{warnings:?}");
    let unknown =
        with_library(&format!("mtllib a.mtl\n{SQUARE}usemtl b\nf 1 2 3"), "newmtl a").unwrap();
    assert!(unknown.warnings[0].contains("usemtl: \"b\""), "{:?}", unknown.warnings);
    assert_eq!(unknown.materials[unknown.objects[0].material].color, GREY);
    let colors = parse("v 0 0 0 1 1 1\nv 1 0 0\nv 0 1 0\nf 1 2 3").unwrap();
    assert!(colors.objects[0].mesh.colors.is_empty() && colors.warnings[0].contains("colours"));
    let mixed = parse(&format!("{SQUARE}vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4")).unwrap();
    assert!(mixed.objects[0].mesh.normals.is_empty() && mixed.warnings[0].contains("normals"));
    let line = square("f 1 2 3\nl 1 2 3\np 1").unwrap();
    assert_eq!(line.triangles(), 1, "lines and points are not faces");
}

#[test]
fn bad_lines_are_named() {
    for (line, message) in [
        ("f 1 2", "f: there is no face"),
        ("f", "f: there is no face"),
        ("f 1 2 9", "line 5: f: vertex 9 is not among the 4 so far"),
        ("f 0 1 2", "line 5: f: vertex 0 is not among"),
        ("f 1 2 -5", "line 5: f: vertex -5 is not among"),
        ("f 1 2 99999999999999999999", "is not an index"),
        ("f 1 2 9223372036854775807", "line 5: f: vertex 9223372036854775807"),
        ("f 1 2 -9223372036854775808", "line 5: f: vertex -9223372036854775808"),
        ("f 1/1/1/1 2 3", "line 5: f: "),
        ("f / / /", "line 5: f: \"/\" is not v, v/vt"),
        ("f a b c", "line 5: f: \"a\" is not an index"),
        ("v 1 2\nf 1 2 5", "line 6: f: vertex 5 of line 5: needs 3 to 7 numbers, not 2"),
        ("v 1 2 nan\nf 1 2 -1", "line 6: f: vertex 5 of line 5: \"nan\" is not a finite number"),
        ("v 1 2 1e999\nf 1 2 5", "\"1e999\" is not a finite number"),
        ("v 1 2 x\nf 1 2 5", "\"x\" is not a finite number"),
        ("", "f: there is no face"),
    ] {
        assert_fails(square(line), &["test.obj: ", message]);
    }
    assert_fails(obj::parse(b"v \xff", "x.obj", &mut |_| None), &["x.obj: f: there is no face"]);
}

#[test]
fn broken_attributes_are_left_out() {
    for (line, message) in [
        ("f 1/9223372036854775807 2 3", "line 5: f: texture coordinate 9223372036854775807 is not"),
        ("f 1/x 2 3", "line 5: f: \"x\" is not an index"),
        ("f 1//1 2//1 3//1", "line 5: f: normal 1 is not among the 0 so far"),
        ("vn 1 2\nf 1//1 2//1 3//1", "line 5: vn 1 2: is no normal"),
        ("vn 1 2 inf\nf 1//1 2//1 3//1", "line 5: vn 1 2 inf: is no normal"),
        ("vt\nvt nan\nf 1/1 2/1 3/2", "line 6: vt nan: texture coordinates are wrong"),
        ("f 1 2 3\nv 1 nan 3", "line 6: v: \"nan\" is not a finite number: no face uses"),
        ("f 1 2 3\nv 1 2 3 4 5", "line 6: v 1 2 3 4 5: what follows x y z"),
        ("f 1 2 3\nv 1 2 3 0", "line 6: v 1 2 3 0: w is a weight of free-form curves"),
        (
            "f 1 2 3\nf 1 2\nf\nf 4",
            "line 6: f 1 2: faces of fewer than 3 corners are left out (3 in all)",
        ),
        ("f 1 2 3\ncurv 0 1 1 2\nsurf 0 1", "line 6: curv 0 1 1 2: free-form curves and surfaces"),
    ] {
        let model = square(line).unwrap();
        assert_eq!((model.triangles(), model.objects[0].mesh.normals.len()), (1, 0), "{line}");
        let said = model.warnings.iter().any(|warning| warning.contains(message));
        assert!(said, "{line}: {:?}", model.warnings);
    }
}

#[test]
fn colours_are_clamped_and_may_have_an_opacity() {
    let text = "v 0 0 0 255 -1 0.5 0.25\nv 1 0 0 1 1 1 7\nv 0 1 0 0 0 0\nf 1 2 3";
    let model = parse(text).unwrap();
    let mesh = &model.objects[0].mesh;
    assert_eq!(mesh.colors, [[1.0, 0.0, 0.5], [1.0; 3], [0.0; 3]]);
    assert_eq!(mesh.alphas, [0.25, 1.0, 1.0]);
    assert_eq!(model.materials[0].color, [1.0; 3], "grey would darken them");
    assert_eq!(model.warnings.len(), 1);
    assert!(model.warnings[0].contains("line 1: v: color: 255: is not within 0 to 1"));
}

#[test]
fn lines_go_on_and_end_in_any_way() {
    for text in [
        "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "v 0 0 0\r\nv 1 0 0\nv 0 1 0\rf 1 2 3",
        "v 0 0 \\\n0\nv 1 \\\r\n0 0\nv 0 1 0\nf 1 \\  \n 2 \\\n 3",
        "# a comment, not \\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        "\u{feff}v 0 0 0\nv +1. 0 0\nv .0 1e0 -0\nf 1 2 3 # gr\u{fc}n",
    ] {
        let mesh = parse(text).unwrap().objects[0].mesh.clone();
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{text:?}");
        let latin: Vec<u8> = format!("#\n{text}").chars().map(|c| c as u8).collect();
        let model = obj::parse(&latin, "test.obj", &mut |_| None);
        assert!(text.starts_with('\u{feff}') || model.is_ok(), "{text:?}");
    }
}

#[test]
fn libraries_by_any_name() {
    let color = |line: &str, files: &[&str]| {
        let text = format!("{line}\n{SQUARE}usemtl m\nf 1 2 3");
        let mut library = |name: &str| {
            let there = files.contains(&name);
            there.then(|| if name == "b.mtl" { "newmtl n" } else { "newmtl m\nKd 0 0 1" }.into())
        };
        let model = obj::parse(text.as_bytes(), "test.obj", &mut library).unwrap();
        (model.materials[model.objects[0].material].color, model.warnings.len())
    };
    let blue = ([0.0, 0.0, 1.0], 0);
    assert_eq!(color("mtllib a b.mtl", &["a b.mtl"]), blue);
    assert_eq!(color("mtllib b.mtl  a.mtl # two", &["a.mtl", "b.mtl"]), blue);
    assert_eq!(color("mtllib \"a b.mtl\"", &["a b.mtl"]), blue);
    assert_eq!(color("mtllib \"b.mtl\" \"a b.mtl\"", &["a b.mtl", "b.mtl"]), blue);
    assert_eq!(color("mtllib x\\y\\a b.mtl", &["x/y/a b.mtl"]), blue);
    assert_eq!(color("mtllib \"x\\a.mtl\"", &["x/a.mtl"]), blue);
    assert_eq!(color("mtllib none.mtl a.mtl", &["a.mtl"]), ([0.0, 0.0, 1.0], 1));
    assert_eq!(color("mtllib", &[]), (GREY, 1));
}

#[test]
fn bad_materials_are_named() {
    for (mtl, message) in [
        ("newmtl a\nKd 1 2", "a.mtl: line 2: Kd: needs 3 numbers, not 2"),
        ("newmtl a\nKd", "a.mtl: line 2: Kd: needs 1 to 3 numbers, not 0"),
        ("newmtl a\nd x", "a.mtl: line 2: d: \"x\" is not a finite number"),
        ("newmtl a\nKd 2 0 0", "material \"a\": Kd: 2: is not within 0 to 1 and is clamped"),
        ("newmtl a\nTr 7", "material \"a\": opacity by d or Tr: -6: is not within"),
        (
            "newmtl a\nmap_Kd x.png",
            "material \"a\": map_Kd x.png: not found: the picture is left out",
        ),
    ] {
        let text = format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3");
        let warnings = with_library(&text, mtl).unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(message), "{mtl}: {warnings:?}");
    }
}

/// Blanks within names, several names on a line, and backslashes before blanks.
#[test]
fn names_of_libraries_may_have_blanks() {
    let read = |line: &str| {
        let mut asked = Vec::new();
        let text = format!("mtllib {line}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let model = obj::parse(text.as_bytes(), "m.obj", &mut |name| {
            let there = ["a b.mtl", "c.mtl", "d e f.mtl"].contains(&name);
            asked.extend(there.then(|| name.to_owned()));
            there.then(Vec::new)
        });
        (asked, model.unwrap().warnings.len())
    };
    let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    assert_eq!(read("a b.mtl c.mtl d e f.mtl"), (names(&["a b.mtl", "c.mtl", "d e f.mtl"]), 0));
    assert_eq!(read("a\\ b.mtl"), (names(&["a b.mtl"]), 0));
    assert_eq!(read("c.mtl gone.mtl a b.mtl"), (names(&["c.mtl", "a b.mtl"]), 1));
}

#[test]
fn files_of_several_pieces_are_read_as_one() {
    let count = 40_000_u32;
    let vertices: String = (0..count).map(|i| format!("v {i} {}.5 -{i}e-3\n", i % 97)).collect();
    assert!(vertices.len() > 600_000, "more than two pieces");
    let faces: String =
        (0..count - 2).map(|i| format!("f {} -{} {}\n", i + 1, count - i - 1, i + 3)).collect();
    let text = vertices + "# back over pieces\n" + &faces;
    let mesh = parse(&text).unwrap().objects[0].mesh.clone();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (40_000, 39_998));
    for (i, position) in (0_u32..).zip(&mesh.positions) {
        assert_eq!(*position, [f64::from(i), f64::from(i % 97) + 0.5, -f64::from(i) / 1_000.0]);
    }
    assert!((0..).zip(&mesh.triangles).all(|(i, triangle)| *triangle == [i, i + 1, i + 2]));
    let first = text.replace("f 5001 -34999 5003\n", "f 5001 -50000 5003\n") + "f 1 2 x\n";
    assert_fails(parse(&first), &["line 45002: f: vertex -50000 is not among the 40000 so far"]);
    let last = text.clone() + "f 1 2 x\n";
    assert_fails(parse(&last), &["line 80000: f: \"x\" is not an index"]);
    let said = parse(&(text + "l 1 2\nf 1 2\nl 2 3\n")).unwrap().warnings;
    let expected = [
        "test.obj: line 80000: l 1 2: lines are not drawn (2 in all)",
        "test.obj: line 80001: f 1 2: faces of fewer than 3 corners are left out",
    ];
    assert_eq!(said, expected);
}
