//! STL, and packed files.

use std::fs;
use std::io::Write;

use fragloom::scene::{Overrides, load, stl};

use super::assert_fails;

const TEXT: &str = "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1e0 0 0\n   vertex 0 .5 0\n\
    endloop\n endfacet\nendsolid a\n";

fn binary(head: &[u8], count: u32) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, 0);
    bytes.extend(count.to_le_bytes());
    for value in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0, 0]);
    bytes
}

#[test]
fn text_and_binary_are_the_same() {
    let expected = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]];
    let returns = TEXT.replace('\n', "\r");
    let upper = TEXT.to_uppercase();
    let commented = format!("# first\n{}", TEXT.replace("0 0\n", "0 0 # a\n#b\n"));
    let mut longer = binary(b"solid it is", 1);
    longer.push(7);
    for bytes in [
        TEXT.as_bytes(),
        returns.as_bytes(),
        upper.as_bytes(),
        commented.as_bytes(),
        &binary(b"", 1),
        &binary(b"solid it is", 1),
        &longer,
    ] {
        let mesh = stl::parse(bytes, "a.stl").unwrap().objects[0].mesh.clone();
        assert_eq!((&mesh.positions[..], &mesh.triangles[..]), (&expected[..], &[[0, 1, 2]][..]));
    }
}

#[test]
fn what_is_wrong_is_named() {
    for (bytes, message) in [
        (binary(b"", 2), "a.stl: header: 2 facets do not fit into 134 bytes"),
        (binary(b"", u32::MAX), "header: 4294967295 facets"),
        (b"solid".to_vec(), "facet: there is none"),
        (vec![b'#'; 200], "facet: there is none"),
        (format!("# a\n{}", TEXT.replace("1e0", "#")).into(), "line 6: vertex: needs 3"),
        (Vec::new(), "facet: there is none"),
        (TEXT.replace("1e0", "nan").into(), "line 5: vertex: needs 3 finite numbers"),
        (TEXT.replace("vertex 1e0 0 0", "").into(), "line 8: a facet needs 3 vertices"),
        (TEXT[..57].into(), "the file ends within a facet"),
    ] {
        assert_fails(stl::parse(&bytes, "a.stl"), &[message]);
    }
}

#[test]
fn packed_files_are_unpacked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.STL.gz");
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(TEXT.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    fs::write(&path, &packed).unwrap();
    let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
    assert_eq!(scene.triangles(), 1);
    fs::write(&path, &packed[..packed.len() - 9]).unwrap();
    assert_fails(
        load(path.to_str().unwrap(), &Overrides::default()),
        &["gzip: the compressed data"],
    );
}
