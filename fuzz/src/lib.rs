//! What the fuzz targets do, as plain functions, so that a test replays their corpus without libFuzzer.
//!
//! All but one show bytes to one loader. A loader may refuse them; if it does not, what it gives must keep the
//! promises that `fragloom::scene` makes. The last, `raster`, makes triangles of bytes, and holds the rasterizer against
//! the reference.

mod raster;

use std::sync::Arc;

pub use raster::raster;

use fragloom::error::{Error, Result};
use fragloom::scene::texture::{Opacity, Picture, Wrap};
use fragloom::scene::volume::{self, Grid, Interpolation};
use fragloom::scene::{
    Model, Overrides, PointSize, Texture, check, file, gltf, obj, pcd, ply, stl, zipped,
};

/// An OBJ file up to the first zero byte, with the rest as its material library.
pub fn obj(bytes: &[u8]) {
    let split = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    let (text, library) = bytes.split_at(split);
    check_model(obj::parse(text, "fuzz", &mut |_| library.get(1..).map(<[u8]>::to_vec)));
}

/// A glTF or GLB file whose external buffers are all the same 64 bytes.
pub fn gltf(bytes: &[u8]) {
    let buffer: Vec<u8> = (0..64).collect();
    check_model(gltf::parse(bytes, "fuzz", &mut |_| Ok(buffer.clone())));
}

/// A PLY file.
pub fn ply(bytes: &[u8]) {
    check_model(ply::parse(bytes, "fuzz"));
}

/// An STL file, binary or text.
pub fn stl(bytes: &[u8]) {
    check_model(stl::parse(bytes, "fuzz"));
}

/// A zip archive with a model.
pub fn zip(bytes: &[u8]) {
    check_model(zipped(bytes, "fuzz", PointSize::default()));
}

/// A PNG or JPEG file as a texture: all of it has a colour.
pub fn picture(bytes: &[u8]) {
    let Ok(picture) = Picture::of_file(bytes) else { return };
    let picture = Arc::new(picture);
    for (wrap, nearest) in [(Wrap::Repeat, true), (Wrap::Mirror, false), (Wrap::Clamp, false)] {
        let picture = Arc::clone(&picture);
        let texture = Texture { picture, wrap: [wrap; 2], nearest, opacity: Opacity::Blend };
        for place in [[0.0, 1.0], [-0.3, 7.7], [f32::MAX, f32::MIN], [f32::NAN, 0.5]] {
            let texel = texture.at(place);
            assert!(texel.iter().all(|c| (0.0..=1.0).contains(c)), "a colour and an opacity");
        }
    }
}

/// A PCD file.
pub fn pcd(bytes: &[u8]) {
    check_model(pcd::parse(bytes, "fuzz"));
}

/// A NumPy file as a volume.
pub fn npy(bytes: &[u8]) {
    check_grid(volume::npy::parse(bytes, "fuzz"));
}

/// A NRRD file as a volume, whose detached file is 64 bytes.
pub fn nrrd(bytes: &[u8]) {
    check_grid(volume::nrrd::parse(bytes, "fuzz", &mut |_| Ok((0..64).collect())));
}

/// A scene file whose objects are all the same triangle; files whose names begin with `x` are missing.
pub fn toml(bytes: &[u8]) {
    let Ok(description) = file::parse(bytes, "fuzz") else { return };
    let mut model = |source: file::Source<'_>| match source {
        file::Source::File(name) if name.starts_with('x') => Err(Error::new(name, "is missing")),
        _ => obj::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "triangle", &mut |_| None),
    };
    if let Ok(scene) = description.build(&Overrides::default(), &mut model, &mut |_| Ok(Vec::new()))
    {
        check::scene(&scene).expect("a scene that was built keeps its promises");
    }
}

fn check_grid(result: Result<Grid>) {
    let Ok(grid) = result else { return };
    let [x, y, z] = grid.size();
    assert_eq!(grid.values().len(), x * y * z, "a value for each voxel");
    assert!(grid.values().iter().all(|value| value.is_finite()), "values are finite");
    for interpolation in [Interpolation::Linear, Interpolation::Nearest] {
        for place in [0.0, 0.3, 1.0] {
            let value = grid.at([place; 3], interpolation);
            assert!((0.0..=1.0).contains(&value), "values are within their range");
        }
    }
}

fn check_model(result: Result<Model>) {
    let Ok(model) = result else { return };
    assert!(!model.objects.is_empty(), "a model has an object");
    for object in &model.objects {
        check::mesh("fuzz", &object.mesh).expect("a loaded mesh keeps its promises");
        assert!(object.material < model.materials.len(), "materials are there");
    }
}
