//! Volumes of scene files: what is read, and the message for what is wrong.

use std::fs;

use fragloom::error::Result;
use fragloom::scene::{self, Bounds, Overrides, Scene};
use glam::DVec3;

use super::assert_fails;

/// A scene file beside which lie `a.npy` (1 x 2 x 4 voxels of u1 along x, y, z), `a.nrrd` and `a.raw` (u16).
fn load(text: &str) -> Result<Scene> {
    let dir = tempfile::tempdir().unwrap();
    let mut npy = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
    npy.extend(
        format!("{:<69}\n", "{'descr': '|u1', 'fortran_order': False, 'shape': (4, 2, 1), }")
            .bytes(),
    );
    npy.extend([0, 1, 2, 3, 4, 5, 6, 7]);
    fs::write(dir.path().join("a.npy"), npy).unwrap();
    let nrrd = "NRRD0001\ntype: short\ndimension: 3\nsizes: 2 1 1\nendian: big\nspacings: 0.5 2 3\n\
                encoding: raw\ndata file: a.raw\n";
    fs::write(dir.path().join("a.nhdr"), nrrd).unwrap();
    fs::write(dir.path().join("a.raw"), [1, 0, 0, 2]).unwrap();
    let path = dir.path().join("s.toml");
    fs::write(&path, text).unwrap();
    scene::load(path.to_str().unwrap(), &Overrides::default())
}

fn volume(rest: &str) -> Result<Scene> {
    load(&format!("size = [3, 3]\n[[volume]]\n{rest}"))
}

#[test]
fn files_of_every_kind() {
    let npy = &volume("file = \"a.npy\"").unwrap().volumes[0];
    assert_eq!((npy.grid.size(), npy.grid.range()), ([1, 2, 4], [0.0, 7.0]));
    assert_eq!(
        npy.step, 0.125,
        "half the smallest edge of a voxel, the longest edge of the box being 1"
    );
    let nrrd = &volume("file = \"a.nhdr\"").unwrap().volumes[0];
    assert_eq!((nrrd.grid.values(), nrrd.grid.extent()), (&[256.0, 2.0][..], [1.0, 2.0, 3.0]));
    let raw = "file = \"a.raw\"\nsize = [1, 2, 1]\ntype = \"u16\"\nrange = [0, 1024]";
    let raw = &volume(raw).unwrap().volumes[0];
    assert_eq!((raw.grid.values(), raw.grid.range()), (&[1.0, 512.0][..], [0.0, 1024.0]));
}

#[test]
fn boxes_are_placed_like_objects() {
    let text = "procedural = \"constant\"\nn = 2\nextent = [1, 2, 4]\nscale = 0.5\nrotate = [0, 0, 1, 90]\n\
                translate = [10, 20, 30]\nstep_unit = 2\ndensity = 3\ntransfer = [[0, 1, 1, 1, 0.5]]";
    let scene = volume(text).unwrap();
    let volume = &scene.volumes[0];
    for (point, expected) in [
        (DVec3::splat(0.5), DVec3::new(10.0, 20.0, 30.0)),
        (DVec3::ZERO, DVec3::new(10.5, 19.75, 29.0)),
        (DVec3::ONE, DVec3::new(9.5, 20.25, 31.0)),
    ] {
        let found = volume.place.transform_point3(point);
        assert!((found - expected).length() < 1e-12, "{found} {expected}");
    }
    assert_eq!(volume.step, 0.125);
    assert_eq!(volume.at(DVec3::splat(0.3)), [1.0, 1.0, 1.0, 0.5]);
    assert!((volume.opacity(0.5, 2.0) - 0.875).abs() < 1e-15, "3 / 2 of 2 units");
    let Bounds { min, max } = scene.bounds();
    assert!((max - min - DVec3::new(1.0, 0.5, 2.0)).length() < 1e-12, "{min} {max}");
    let camera = scene.camera;
    assert!(camera.near > 0.0 && (camera.target - scene.bounds().center()).length() < 1e-9);
}

#[test]
fn what_is_wrong_is_told() {
    let constant = |rest: &str| volume(&format!("procedural = \"constant\"\n{rest}"));
    assert_fails(volume(""), &["s.toml: volume 0: file: needs either file or procedural"]);
    assert_fails(volume("file = \"a.vol\""), &["volume 0: file:", ".npy, .nrrd, .nhdr or .raw"]);
    assert_fails(volume("file = \"b.npy\""), &["volume 0:", "b.npy: cannot be read"]);
    assert_fails(volume("file = \"a.npy\"\nn = 3"), &["n: is not a key of a volume with a file"]);
    assert_fails(volume("file = \"a.npy\"\nsize = [1, 1, 1]"), &["size: is not a key"]);
    assert_fails(volume("file = \"a.raw\""), &["size: a .raw file needs it"]);
    let raw = |rest: &str| volume(&format!("file = \"a.raw\"\n{rest}"));
    assert_fails(raw("size = [1, 1, 1]"), &["type: a .raw file needs it"]);
    assert_fails(raw("size = [1, 1, 1]\ntype = \"int\""), &["type:", "u8, i8, u16"]);
    assert_fails(raw("size = [5, 1, 1]\ntype = \"u8\""), &["a.raw: data: 4 bytes", "need 5"]);
    assert_fails(raw("size = [4294967296, 4294967296, 1]\ntype = \"u8\""), &["size:", "268435456"]);
    assert_fails(constant("transfer = \"gray\""), &["volume 0: transfer:", "grey, mist, fire"]);
    assert_fails(constant("transfer = [[0, 0, 0, 0, 2]]"), &["transfer[0]:", "0 to 1"]);
    assert_fails(constant("step = 0"), &["step: 0 must be above 0"]);
    assert_fails(constant("step = 1e-9"), &["step: 1e-9 makes more than"]);
    assert_fails(constant("density = -1"), &["density: -1 must be 0 or more"]);
    assert_fails(constant("density = nan"), &["density: NaN must be 0 or more"]);
    assert_fails(constant("extent = [1, 0, 1]"), &["extent:", "above 0"]);
    assert_fails(
        constant("extent = [1e-320, 1, 1]\nstep = 1"),
        &["extent: the box is too large or too small"],
    );
    assert_fails(constant("range = [1, 1]"), &["range: 1 must be below 1"]);
    assert_fails(constant("scale = 0"), &["scale: 0 must be finite and not 0"]);
    assert_fails(constant("colour = 1"), &["constant: colour: is not a key; there are n, value"]);
    assert_fails(volume("procedural = \"cube\""), &["volume 0: procedural:", "constant, sphere"]);
}
