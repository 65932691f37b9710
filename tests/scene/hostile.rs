//! Arbitrary bytes never make a loader panic, and what a loader accepts keeps the promises of a scene.

use std::cell::RefCell;

use fragloom::error::{Error, Result};
use fragloom::scene::volume::{Grid, npy, nrrd};
use fragloom::scene::{Model, Overrides, check, file, gltf, obj, pcd, ply, stl};
use proptest::prelude::*;

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0.5 0 0 1\nvn 0 0 1\nvt 0 1\no a\nusemtl a\n\
    f 1/1/1 2/1/1 3/1/1\nf -3//-1 -2//1 -1//1\n";

const MTL: &[u8] = b"newmtl a\nKa 1 1 1\nKd 0.5 0.25 1\nd 0.5\nTr 0.5\nillum 2\nmap_Kd a.png\n";

const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n\
    1 0 0 2\n0 1 0 3\n3 0 1 2\n";

const POINTS: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar alpha\nproperty float nx\nproperty float radius\nend_header\n0 0 0 1 0 1\n1 0 0 2 1 1\n0 1 1e99 3 1 2\n";

const PCD: &[u8] =
    b"VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n\
    VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 0 1\n1 0 0 256\nnan 1 0 65536\n";

const PACKED: &[u8] =
    b"FIELDS x y z\nSIZE 4 1 1\nTYPE F I U\nPOINTS 2\nDATA binary_compressed\n\x0d\0\0\0\x0c\0\0\0\
    \x0b\0\0\x80\x3f\0\0\0\x40\x01\x02\x03\x04";

const GLTF: &[u8] = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[1,2,3]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":36,"byteStride":12}],"buffers":[{"uri":"a.bin","byteLength":36}]}"#;

const TOML: &[u8] = b"size = [8, 8]\n[camera]\neye = [0.0, 0.0, 4.0]\ntarget = [0, 0, 0]\nfov_y = 45.0\n\
    [[material]]\nname = \"m\"\ncolor = [0.1, 0.2, 0.3]\n[[object]]\nfile = \"a\"\nmaterial = \"m\"\nscale = 1.5\n\
    rotate = [0, 1, 0, 30]\n[[object]]\nprocedural = \"cubes\"\nsides = 8\n[[screen]]\n\
    points = [[1, 2, 0.5], [3, 4, 0.5], [5, 6, 1]]\ncolor = [1, 1, 1, 0.5]\n";

const NPY: &[u8] =
    b"\x93NUMPY\x01\x00\x3c\x00{'descr': '<i2', 'fortran_order': True, 'shape': (2, 1, 3)}\n\
    \x01\x00\x02\x00\x03\x00\x04\x00\x05\x00\x06\x00";

const NRRD: &[u8] =
    b"NRRD0004\n# it\ntype: int16\ndimension: 3\nsizes: 3 1 2\nendian: big\nspacings: 1 2 0.5\n\
    encoding: raw\n\n\x00\x01\x00\x02\x00\x03\x00\x04\x00\x05\x00\x06";

fn assert_grid(result: Result<Grid>) {
    let Ok(grid) = result else { return };
    assert_eq!(grid.values().len(), grid.size().iter().product::<usize>());
    assert!(grid.values().iter().all(|value| value.is_finite()));
}

fn assert_whole(result: Result<Model>) {
    let Ok(model) = result else { return };
    assert!(!model.objects.is_empty());
    for object in &model.objects {
        check::mesh("it", &object.mesh).unwrap();
        assert!(object.material < model.materials.len());
    }
}

/// Shows bytes to every loader that could mean them, however unlikely.
fn load_as_all(bytes: &[u8]) {
    assert_whole(obj::parse(bytes, "it", &mut |_| Some(MTL.to_vec())));
    assert_whole(obj::parse(OBJ, "it", &mut |_| Some(bytes.to_vec())));
    assert_whole(ply::parse(bytes, "it"));
    assert_whole(pcd::parse(bytes, "it"));
    assert_whole(stl::parse(bytes, "it"));
    assert_grid(npy::parse(bytes, "it"));
    assert_grid(nrrd::parse(bytes, "it", &mut |_| Ok(bytes.to_vec())));
    let reads = RefCell::new(0);
    assert_whole(gltf::parse(bytes, "it", &mut |_| {
        *reads.borrow_mut() += 1;
        if *reads.borrow() < 9 { Ok(vec![0; 36]) } else { Err(Error::new("it", "enough")) }
    }));
    assert_whole(gltf::parse(GLTF, "it", &mut |_| Ok(bytes.to_vec())));
    if let Ok(description) = file::parse(bytes, "it") {
        let mut model = |_: file::Source<'_>| obj::parse(OBJ, "it", &mut |_| None);
        if let Ok(scene) =
            description.build(&Overrides::default(), &mut model, &mut |_| Ok(Vec::new()))
        {
            check::scene(&scene).unwrap();
        }
    }
}

#[test]
fn the_seeds_are_good() {
    assert_eq!(obj::parse(OBJ, "it", &mut |_| Some(MTL.to_vec())).unwrap().warnings.len(), 1);
    ply::parse(PLY, "it").unwrap();
    ply::parse(POINTS, "it").unwrap();
    pcd::parse(PCD, "it").unwrap();
    assert_eq!(pcd::parse(PACKED, "it").unwrap().triangles(), 2);
    gltf::parse(GLTF, "it", &mut |_| Ok(vec![0; 36])).unwrap();
    npy::parse(NPY, "it").unwrap();
    nrrd::parse(NRRD, "it", &mut |_| Ok(Vec::new())).unwrap();
    let description = file::parse(TOML, "it").unwrap();
    description
        .build(&Overrides::default(), &mut |_| ply::parse(PLY, "it"), &mut |_| Ok(Vec::new()))
        .unwrap();
}

/// One change of a file: a byte set, a piece cut out, or a piece repeated elsewhere.
#[derive(Clone, Debug)]
enum Edit {
    Set(usize, u8),
    Cut(usize, usize),
    Copy(usize, usize, usize),
}

impl Edit {
    fn apply(&self, bytes: &mut Vec<u8>) {
        let end = bytes.len().max(1);
        match *self {
            Self::Set(at, byte) if !bytes.is_empty() => bytes[at % end] = byte,
            Self::Cut(at, length) if !bytes.is_empty() => {
                let at = at % end;
                bytes.drain(at..(at + length).min(end));
            }
            Self::Copy(from, length, to) if !bytes.is_empty() => {
                let from = from % end;
                let piece = bytes[from..(from + length).min(end)].to_vec();
                let to = to % end;
                bytes.splice(to..to, piece);
            }
            _ => {}
        }
    }
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let byte =
        prop_oneof![any::<u8>(), b'0'..=b'9', Just(b'-'), Just(b' '), Just(b'\n'), Just(b'.')];
    let edit = prop_oneof![
        (any::<usize>(), byte).prop_map(|(at, byte)| Edit::Set(at, byte)),
        (any::<usize>(), 1..40_usize).prop_map(|(at, length)| Edit::Cut(at, length)),
        (any::<usize>(), 1..40_usize, any::<usize>()).prop_map(|(a, l, b)| Edit::Copy(a, l, b)),
    ];
    prop::collection::vec(edit, 1..8)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        load_as_all(&bytes);
        load_as_all(&[b"glTF\x02\0\0\0", &bytes[..]].concat());
        load_as_all(&[b"ply\nformat binary_little_endian 1.0\n", &bytes[..]].concat());
        for end in ["DATA ascii", "DATA binary"] {
            let head = b"FIELDS x y z rgb\nSIZE 4 1 2 4\nTYPE F U I F\nPOINTS 7\n";
            load_as_all(&[&head[..], end.as_bytes(), b"\n", &bytes[..]].concat());
        }
    }

    #[test]
    fn damaged_files_never_panic(
        which in 0..10_usize,
        edits in edits(),
    ) {
        let seeds = [OBJ, MTL, PLY, GLTF, TOML, POINTS, PCD, PACKED, NPY, NRRD];
        let mut bytes = seeds[which].to_vec();
        edits.iter().for_each(|edit| edit.apply(&mut bytes));
        load_as_all(&bytes);
    }
}
