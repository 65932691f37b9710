//! PLY.

use fragloom::error::Result;
use fragloom::scene::{Model, ply};

use super::assert_fails;

fn parse(text: &str) -> Result<Model> {
    ply::parse(text.as_bytes(), "test.ply")
}

const HEADER: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\n\
    property float y\nproperty double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n";

const VERTICES: &str = "0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 0 51 51 51\n";

#[test]
fn ascii_with_colours_and_a_polygon() {
    let model = parse(&format!("{HEADER}{VERTICES}4 0 1 2 3\n")).unwrap();
    let mesh = &model.objects[0].mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions[2], [1.0, 1.0, 0.0]);
    assert_eq!(mesh.colors[0], [1.0, 0.0, 0.0]);
    assert_eq!(mesh.colors[3], [0.2; 3]);
    assert!(mesh.normals.is_empty());
}

/// A triangle with normals and float colours in either byte order, its face list of the given types.
fn binary(big: bool) -> Vec<u8> {
    let endian = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{endian}_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\n\
         property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float red\n\
         property float green\nproperty float blue\nelement face 1\nproperty uchar flag\n\
         property list ushort uint vertex_index\nelement extra 1\nproperty int a\nend_header\n"
    )
    .into_bytes();
    let mut put = |le: &[u8]| {
        let mut word = le.to_vec();
        if big {
            word.reverse();
        }
        bytes.extend(word);
    };
    for i in 0..3_u8 {
        put(&f64::from(i).to_le_bytes());
        for value in [f32::from(i * i), 0.0, 0.0, 0.0, 1.0, 0.5, 0.25, 1.0] {
            put(&value.to_le_bytes());
        }
    }
    put(&[7]);
    put(&3_u16.to_le_bytes());
    for index in [2_u32, 1, 0] {
        put(&index.to_le_bytes());
    }
    put(&5_i32.to_le_bytes());
    bytes
}

#[test]
fn binary_of_both_byte_orders() {
    let little = ply::parse(&binary(false), "test.ply").unwrap();
    let mesh = &little.objects[0].mesh;
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 4.0, 0.0]]);
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(mesh.colors, [[0.5, 0.25, 1.0]; 3]);
    assert_eq!(mesh.triangles, [[2, 1, 0]]);
    let big = ply::parse(&binary(true), "test.ply").unwrap();
    assert_eq!(big.objects[0].mesh, little.objects[0].mesh);
}

#[test]
fn every_truncation_is_an_error() {
    for whole in [binary(false), format!("{HEADER}{VERTICES}4 0 1 2 3").into_bytes()] {
        let end = whole.len();
        // Without its last digit, an ASCII index is still missing: "3" is one character.
        for length in 0..end {
            assert!(ply::parse(&whole[..length], "t.ply").is_err(), "{length} of {end} bytes");
        }
    }
}

#[test]
fn lying_headers_are_refused_before_reading() {
    for (from, to, message) in [
        (
            "element vertex 4",
            "element vertex 99999999999",
            "element vertex: count: 99999999999 do not fit",
        ),
        ("element face 1", "element face 18446744073709551615", "element face: count"),
        (
            "element face 1",
            "element none 18446744073709551615\nelement face 1",
            "needs at least one property",
        ),
        ("property float x", "property float u", "element vertex: property x: is missing"),
        ("vertex_indices", "corners", "element face: property vertex_indices: is missing"),
        ("element vertex", "element vertices", "element vertex: is missing"),
        ("property float x", "property list uchar float x", "property x: is missing"),
        ("list uchar int", "list uchar word", "line 12: type \"word\" is none of PLY's"),
        ("format ascii 1.0\n", "", "header: format is missing"),
        ("format ascii", "format text", "line 2: format: must be ascii"),
        ("end_header\n", "", "header: end_header is missing"),
        ("element face 1", "element vertex 1", "element vertex: is there twice"),
        ("element face 1", "element face x", "element face: count: \"x\" is not a whole number"),
        ("ply\n", "plx\n", "line 1: must be \"ply\""),
    ] {
        let text = format!("{HEADER}{VERTICES}4 0 1 2 3\n").replacen(from, to, 1);
        assert_fails(parse(&text), &["test.ply: ", message]);
    }
}

#[test]
fn bad_faces_and_vertices_are_named() {
    for (face, message) in [
        ("2 0 1", "element face: no face has 3 corners"),
        ("3 0 1 4", "face 0: vertex_indices: 4 is not below the 4 vertices"),
        ("3 0 1 -1", "face 0: vertex_indices: -1 is not below"),
        ("3 0 1 0.5", "face 0: vertex_indices: 0.5 is not below"),
        ("9 0 1 2", "face 0: vertex_indices: line 18: a list of 9 items does not fit"),
        ("4 0 1 2", "face 0: vertex_indices: line 19: the file ends before it"),
        ("3 0 1 x", "face 0: vertex_indices: line 18: \"x\" is not a number"),
    ] {
        assert_fails(parse(&format!("{HEADER}{VERTICES}{face}\n")), &["test.ply: ", message]);
    }
    let infinite = VERTICES.replace("1 1 0", "1 1e999 0");
    assert_fails(parse(&format!("{HEADER}{infinite}3 0 1 2\n")), &["vertex 2: position"]);
    let spared = parse(&format!("{HEADER}{infinite}3 0 1 3\n")).unwrap();
    assert!(spared.warnings[0].contains("vertex 2: position"), "{:?}", spared.warnings);
    let bright = HEADER.replace("uchar red", "float red");
    let bright = parse(&format!("{bright}{VERTICES}3 0 1 2\n")).unwrap();
    assert!(bright.warnings[0].contains("vertex 0: red: 255: is not within 0 to 1"));
    assert_eq!(bright.objects[0].mesh.colors[0], [1.0, 0.0, 0.0]);
    let gone = parse(
        &format!("{HEADER}{VERTICES}2 0 1\n")
            .replace("face 1", "face 2")
            .replace("2 0 1\n", "2 0 1\n3 0 1 2\n"),
    )
    .unwrap();
    assert!(gone.warnings[0].contains("face 0: faces of fewer than 3 corners"));
}

/// Elements in any order, strips that begin anew, opacities, numbers as C prints them, any line ends.
#[test]
fn what_other_programs_write() {
    let text = "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list uint64 int8 vertex_indices\n\
        element edge 1\nproperty int vertex1\nelement vertex 4\nproperty float64 x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
        property float nx\nproperty float ny\nproperty float nz\nend_header\n8 0 1 2 3 -1 0 2 3\n0\n\
        .5 +1 1.\n255 255 255 51 0 0 1\n1e-3 0 0 0 0 0 255 0 0 1\n-.5 0 0 0 0 0 255 -nan(ind) 0 1\n\
        0.1 0 7 0 0 0 255 0 0 1\n";
    for ends in ["\n", "\r", "\r\n"] {
        let text = format!("\u{feff}{}", text.replace('\n', ends));
        let model = parse(&text).unwrap();
        let mesh = &model.objects[0].mesh;
        assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [0, 2, 3]]);
        assert_eq!((mesh.positions[0], mesh.positions[3]), ([0.5, 1.0, 1.0], [0.1, 0.0, 7.0]));
        assert_eq!((mesh.alphas[0], mesh.alphas[1]), (0.2, 1.0));
        assert_eq!(mesh.normals[2], [0.0; 3], "shaded by the face's own");
        assert_eq!(model.materials[0].color, [1.0; 3], "grey would darken colours");
        assert_eq!(model.warnings.len(), 2, "{:?}", model.warnings);
    }
}

/// Words behind what the header declares belong to nothing, if every element has its own line; otherwise, lines mean
/// nothing.
#[test]
fn lines_may_hold_more_or_less_than_an_element() {
    let expected = parse(&format!("{HEADER}{VERTICES}4 0 1 2 3\n")).unwrap();
    let longer = VERTICES.replace('\n', " 7 8\n") + "\n4 0 1 2 3 9\n\n";
    let split = VERTICES.replace(" 0 255 0\n", "\n0 255 0\n") + "4\n0 1 2 3\n";
    let one_line = VERTICES.replace('\n', " ") + "4 0 1 2 3";
    for (text, warnings) in [(longer, 1), (split, 0), (one_line, 0)] {
        let model = parse(&format!("{HEADER}{text}")).unwrap();
        assert_eq!(model.objects[0].mesh, expected.objects[0].mesh, "{text}");
        assert_eq!(model.warnings.len(), warnings, "{text}: {:?}", model.warnings);
    }
}

#[test]
fn lines_of_the_header_that_nobody_knows_are_named() {
    let header = HEADER.replace("comment by hand", "Created by a program 2.4");
    let model = parse(&format!("{header}{VERTICES}4 0 1 2 3\n")).unwrap();
    assert_eq!(
        model.warnings,
        ["test.ply: line 3: \"Created\": is not a line of a PLY header, and is left out"]
    );
}

#[test]
fn long_texts_and_binary_files_are_the_same() {
    let count = 30_000_u32;
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            count - 3
        )
    };
    let (mut text, mut bytes) = (header("ascii"), header("binary_big_endian").into_bytes());
    for i in 0..count {
        let place = [i as f32 * 0.1, (i * i % 977) as f32 / 977.0, (i % 89) as f32];
        let color = [i as u8, (i / 7) as u8, 255];
        text += &format!(
            "{} {} {} {} {} {}\n",
            place[0], place[1], place[2], color[0], color[1], color[2]
        );
        place.iter().for_each(|c| bytes.extend(c.to_be_bytes()));
        bytes.extend(color);
    }
    for i in 0..count - 3 {
        // A run of triangles, then of squares.
        let corners = &[i, i + 1, i + 2, i + 3][..if i < 20_000 { 3 } else { 4 }];
        text += &format!("{}", corners.len());
        bytes.push(corners.len() as u8);
        for corner in corners {
            text += &format!(" {corner}");
            bytes.extend(corner.to_be_bytes());
        }
        text += "\n";
    }
    assert!(text.len() > 1_000_000, "several pieces");
    let mesh = ply::parse(&bytes, "it").unwrap().objects[0].mesh.clone();
    assert_eq!(mesh.triangles[19_999], [19_999, 20_000, 20_001]);
    assert_eq!(mesh.triangles.len(), 20_000 + 2 * 9_997);
    assert_eq!(mesh.positions[29_999][0], f64::from(29_999_f32 * 0.1));
    assert_eq!(ply::parse(text.as_bytes(), "it").unwrap().objects[0].mesh, mesh);
    let wrong = text.replace("3 15000 15001 15002\n", "3 15000 15001 30000\n");
    assert_fails(
        ply::parse(wrong.as_bytes(), "it"),
        &["face 15000: vertex_indices: 30000 is not below the 30000 vertices"],
    );
    let wrong = wrong.replace("3 19000 19001 19002\n", "3 19000 x 19002\n");
    assert_fails(ply::parse(wrong.as_bytes(), "it"), &["line 49013: \"x\" is not a number"]);
}
