//! Well-known models, where they lie beside the project; `procedural` tests the same without them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fragloom::scene::{Overrides, load};

use super::load::assert_framed;

/// The path of a model, or `None` and a line that says so.
fn model(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("FRAGLOOM_MODELS").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: there is no {}", path.display());
    None
}

#[test]
fn models_have_as_many_triangles_as_they_should() {
    for (name, triangles, warnings) in [
        ("spot.obj", 5_856, 0),
        ("bunny.obj", 69_451, 0),
        ("teapot.obj", 6_320, 0),
        ("dragon.obj", 100_000, 0),
        ("hair_ribbons.obj", 138_136, 0),
        // 44 meshes of 115,580 triangles, which its 170 nodes draw 262,087 of.
        ("sponza/Sponza.gltf", 262_087, 0),
    ] {
        let Some(path) = model(name) else { continue };
        let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
        let count: usize = scene.objects.iter().map(|o| o.mesh.triangles.len()).sum();
        assert_eq!(
            (count, scene.warnings.len()),
            (triangles, warnings),
            "{name}: {:?}",
            scene.warnings
        );
        assert_framed(&scene);
    }
}

#[test]
fn repeated_meshes_are_shared() {
    let Some(path) = model("sponza/Sponza.gltf") else { return };
    let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
    let mut meshes: Vec<_> =
        scene.objects.iter().map(|o| (Arc::as_ptr(&o.mesh), o.mesh.triangles.len())).collect();
    meshes.sort_unstable();
    meshes.dedup();
    let triangles: usize = meshes.iter().map(|(_, triangles)| triangles).sum();
    assert_eq!((scene.objects.len(), meshes.len(), triangles), (170, 44, 115_580));
}

#[test]
fn a_point_set_has_as_many_points_as_it_should() {
    let Some(path) = model("tabletop_points.ply") else { return };
    let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
    let count: usize = scene.objects.iter().map(|o| o.mesh.discs.len()).sum();
    assert_eq!((count, scene.triangles(), scene.warnings.len()), (259_847, 259_847, 0));
    assert_framed(&scene);
}
