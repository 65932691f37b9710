//! Rows read many at once say the same as rows read one after the other.

use proptest::prelude::*;

use super::{PointSize, read};

/// What is found and said, in pieces of a size.
fn outcome(bytes: &[u8], piece: usize) -> String {
    format!("{:?}", read(bytes, "it", PointSize::default(), piece))
}

#[track_caller]
fn assert_same(bytes: &[u8]) {
    let right = outcome(bytes, 0);
    for piece in (1..60).chain([bytes.len()]) {
        assert_eq!(outcome(bytes, piece), right, "{piece}");
    }
}

const HEADER: &str = "element vertex 4\nproperty double x\nproperty float y\nproperty float z\nproperty float nx\n\
    property float ny\nproperty float nz\nproperty uchar red\nproperty float green\nproperty uchar blue\n\
    property float quality\nelement face 5\nproperty list uchar int vertex_indices\nproperty float area\n\
    element edge 1\nproperty int from\nproperty int to\nend_header\n";

const VERTICES: &str =
    "0 0 0 0 0 1 255 1 0 7\n1 0 .1 0 0 1 0 0.5 0 7\r\n1 1 0 0 0 1 0 0 0 7\n\n0 1 0 0 0 1 9 0 0 7\n";

fn text(rest: &str) -> String {
    format!("ply\nformat ascii 1.0\n{HEADER}{VERTICES}{rest}")
}

#[test]
fn text_in_pieces_says_the_same() {
    let rest = "3 0 1 2 1\n3 0 2 3 1\n2 1 2 0\n4 0 1 2 3 9\n3 3 2 1 1\n0 1\n";
    assert!(outcome(text(rest).as_bytes(), 0).starts_with("Ok"));
    for (right, other) in [
        (rest, rest),
        ("3 0 1 2 1\n", "3 0 1 2 1 8\n"),
        ("3 0 1 2 1\n", "3 0 1\n2 1\n"),
        ("3 0 1 2 1\n", "3 0 1 2\n"),
        ("3 0 2 3 1\n", "3 0 2 4 1\n"),
        ("3 0 2 3 1\n", "3 0 -1 1.5 1\n"),
        ("4 0 1 2 3 9\n", "4 0 1 x 3 9\n"),
        ("4 0 1 2 3 9\n", "-1 9\n"),
        ("4 0 1 2 3 9\n", "4 0 1 3 2 9\n"),
        ("3 3 2 1 1\n0 1\n", "3 3 2"),
    ] {
        assert!(rest.contains(right));
        assert_same(text(&rest.replacen(right, other, 1)).as_bytes());
    }
    for (right, other) in [
        ("255 1 0", "255 1.5 0"),
        ("255 1 0", "256 1 nan"),
        ("0 0 1 9 0 0 7\n", "0 0 1 9 0 0\n"),
        ("1 0 .1", "1 0 nan"),
        ("1 0 .1", "1 0 ,1"),
        ("\r\n", "\r"),
        ("0 7\n1 0", "0 7 1 0"),
    ] {
        assert!(text(rest).contains(right));
        assert_same(text(rest).replacen(right, other, 1).as_bytes());
    }
    assert_same(text(rest).replace("element face 5", "element tristrips 5").as_bytes());
}

/// The same in binary, little-endian, with the length and corners of each face as they are given.
fn binary(vertices: &[[f32; 3]], faces: &[Vec<i32>]) -> Vec<u8> {
    let (count, sides) = (vertices.len(), faces.len());
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar flags\nproperty float red\nproperty float green\nproperty float blue\n\
         element face {sides}\nproperty uchar flags\nproperty list uchar int vertex_indices\nproperty short part\n\
         end_header\n"
    )
    .into_bytes();
    for vertex in vertices {
        vertex.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.push(1);
        vertex.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    for face in faces {
        bytes.extend([7, face.len() as u8]);
        face.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
        bytes.extend([8, 9]);
    }
    bytes
}

#[test]
fn long_binary_files_say_the_same_and_lost_bytes_are_found() {
    let count = 10_000;
    let vertices: Vec<[f32; 3]> =
        (0..count).map(|i| [i as f32, (i * i % 97) as f32, (i % 89) as f32 / 88.0]).collect();
    let face = |i: i32| match i % 5_000 {
        0 => vec![i, i + 1],
        1 => vec![i, i + 1, i + 2, i + 3],
        _ => vec![i, i + 1, i + 2],
    };
    let mut faces: Vec<Vec<i32>> = (0..count - 4).map(face).collect();
    let bytes = binary(&vertices, &faces);
    let right = outcome(&bytes, 0);
    assert!(
        right.starts_with("Ok")
            && right.contains("clamped (")
            && right.contains("left out (2 in all)")
    );
    assert_eq!(outcome(&bytes, 1), right);
    assert_ne!(outcome(&bytes, 1), outcome(&binary(&vertices[1..], &faces), 0));
    let short = &bytes[..bytes.len() - 1];
    assert_eq!(outcome(short, 1), outcome(short, 0));
    assert!(outcome(short, 1).contains("face 9995: part: the file ends before it"));
    (faces[9_000][1], faces[8_000][2]) = (-1, count);
    let bytes = binary(&vertices, &faces);
    assert_eq!(outcome(&bytes, 1), outcome(&bytes, 0));
    assert!(outcome(&bytes, 1).contains("face 8000: vertex_indices: 10000 is not below"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_faces_say_the_same(
        faces in prop::collection::vec(prop::collection::vec(-1..6_i32, 0..6), 0..12),
        cut in 0..40_usize,
        piece in 1..60_usize,
    ) {
        let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 1.0, 2.0], [0.0, 1.0, f32::NAN], [0.5, 0.5, 1.0]];
        let bytes = binary(&vertices, &faces);
        let bytes = &bytes[..bytes.len() - cut.saturating_sub(30)];
        prop_assert_eq!(outcome(bytes, piece), outcome(bytes, 0));
        let lines: String = faces.iter().map(|face| {
            let words: Vec<String> = face.iter().map(i32::to_string).collect();
            format!("{} {} 1\n", face.len(), words.join(" "))
        }).collect();
        let text = text(&lines).replace("element face 5", &format!("element face {}", faces.len()));
        let text = &text[..text.len() - cut.saturating_sub(30).min(lines.len())];
        prop_assert_eq!(outcome(text.as_bytes(), piece), outcome(text.as_bytes(), 0));
    }
}
