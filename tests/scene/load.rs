//! Scene files, bare meshes, overrides.

use std::fs;
use std::path::Path;

use fragloom::error::Result;
use fragloom::scene::{Light, Overrides, Projection, Scene, Shading, load};
use glam::DVec3;

use super::{World, assert_fails, corners};

const TRIANGLE: &str = "mtllib m.mtl\nusemtl m\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";

/// Loads `text` as a scene file beside a mesh `t.obj`.
fn with(text: &str, overrides: &Overrides) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("t.obj", TRIANGLE);
    write("m.mtl", "newmtl m\nKd 0.1 0.2 0.3\nd 1\n");
    write("points.txt", "");
    write("s.toml", text);
    load(folder.path().join("s.toml").to_str().unwrap(), overrides)
}

fn scene(text: &str) -> Result<Scene> {
    with(text, &Overrides::default())
}

const FULL: &str = r#"
size = [64, 32]
background = [0.0, 0.5, 1.0]

[camera]
eye = [0, 0, 4]
target = [0.0, 0.0, 0.0]
up = [0.0, 2.0, 0.0]
ortho_height = 2.0
near = 1.0
far = 9.0

[light]
towards = [0, 3, 0]
ambient = 0.5

[[material]]
name = "glass"
color = [0.2, 0.6, 0.9]
alpha = 0.4
shading = "gooch"

[[object]]
file = "t.obj"
material = "glass"
translate = [1.0, 2.0, 3.0]
rotate = [0.0, 0.0, 1.0, 90.0]
scale = 2

[[object]]
file = "t.obj"

[[object]]
procedural = "cubes"
alpha = 0.75
sides = 8

[[screen]]
points = [[10.5, 20.25, 0.5], [100, 20, 0], [50.0, 90.0, 1]]
color = [1.0, 0.0, 0.0, 0.5]
"#;

#[test]
fn everything_in_a_scene_file() {
    let scene = scene(FULL).unwrap();
    assert_eq!(
        (scene.name.as_str(), scene.size, scene.background),
        ("s.toml", [64, 32], [0.0, 0.5, 1.0])
    );
    assert_eq!(scene.camera.projection, Projection::Orthographic { height: 2.0 });
    assert_eq!((scene.camera.near, scene.camera.far), (1.0, 9.0));
    assert_eq!(scene.light, Light { towards: DVec3::Y, ambient: 0.5 });
    let glass = &scene.materials[scene.objects[0].material];
    assert_eq!((glass.color, glass.alpha, glass.shading), ([0.2, 0.6, 0.9], 0.4, Shading::Gooch));
    // Doubled, turned a quarter around z, moved.
    assert!((scene.objects[0].world(0) - DVec3::new(1.0, 4.0, 3.0)).length() < 1e-15);
    let own = &scene.materials[scene.objects[1].material];
    assert_eq!(
        (own.color, own.alpha),
        ([0.1, 0.2, 0.3], 1.0),
        "a file's own material counts as it is"
    );
    assert_eq!(scene.objects.len(), 2 + 6);
    assert_eq!(scene.materials[scene.objects[7].material].alpha, 0.75);
    assert_eq!(scene.screen[0].points[1], [100.0, 20.0, 0.0]);
}

#[test]
fn overrides_win() {
    let overrides = Overrides {
        size: Some([7, 9]),
        alpha: Some(0.125),
        shading: Some(Shading::Flat),
        ..Overrides::default()
    };
    let scene = with(FULL, &overrides).unwrap();
    assert_eq!(scene.size, [7, 9]);
    assert!(scene.materials.iter().all(|m| m.alpha == 0.125 && m.shading == Shading::Flat));
    assert!(scene.screen.iter().all(|t| t.color[3] == 0.125));
    let layers = load("layers:count=3", &overrides).unwrap();
    assert_eq!(layers.screen.len(), 6);
    assert!(layers.screen.iter().flat_map(|t| t.points).all(|[x, y, _]| x <= 7.0 && y <= 9.0));
    for (size, at) in [([0, 5], "0x5"), ([16_385, 5], "16385x5")] {
        let overrides = Overrides { size: Some(size), ..Overrides::default() };
        assert_fails(load("cubes", &overrides), &["--size: size: ", at, "16384x16384"]);
    }
    let opaque = Overrides { alpha: Some(1.5), ..Overrides::default() };
    assert_fails(load("cubes", &opaque), &["--alpha: alpha: 1.5 is not within 0 to 1"]);
}

#[test]
fn a_bare_mesh_is_framed_and_half_transparent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("T.OBJ");
    fs::write(&path, TRIANGLE).unwrap();
    let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
    assert_eq!((scene.name.as_str(), scene.size, scene.warnings.len()), ("T.OBJ", [1024, 1024], 1));
    assert!(scene.materials.iter().all(|material| material.alpha == 0.5));
    assert_framed(&scene);
    fs::write(folder.path().join("m.mtl"), "newmtl m\nd 0.25\nnewmtl n\nd 1\n").unwrap();
    let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
    let alphas: Vec<_> = scene.materials.iter().map(|material| material.alpha).collect();
    assert_eq!(alphas, [0.25, 0.5, 0.5], "an opacity below 1 is kept");
}

/// All corners are inside the image and between the planes.
pub(crate) fn assert_framed(scene: &Scene) {
    let matrix = scene.camera.view_projection(scene.size);
    for corner in corners(scene).into_iter().flatten() {
        let clip = matrix * corner.extend(1.0);
        assert!(clip.x.abs() <= clip.w && clip.y.abs() <= clip.w, "{}: {corner}", scene.name);
        assert!(clip.z >= 0.0 && clip.z <= clip.w, "{}: {corner}", scene.name);
    }
}

#[test]
fn left_out_tables_have_defaults() {
    let framed = scene("[[object]]\nprocedural = \"gears\"").unwrap();
    assert_eq!((framed.size, framed.background), ([1024, 1024], [1.0; 3]));
    assert_framed(&framed);
    let planes =
        scene("camera = { eye = [0, 0, 9], target = [0, 0, 0] }\n[[object]]\nfile = \"t.obj\"");
    let camera = planes.unwrap().camera;
    assert!(camera.near > 7.8 && camera.near < 8.0 && camera.far > 9.0 && camera.far < 9.2);
    assert_eq!(camera.projection, Projection::Perspective { fov_y: 40.0 });
    let screen =
        scene("[[screen]]\npoints = [[0,0,0],[1,0,0],[0,1,0]]\ncolor = [1,1,1,1]").unwrap();
    assert_eq!((screen.objects.len(), screen.materials.len()), (0, 1));
    let ambient = scene("light = { ambient = 0.1 }\n[[object]]\nfile = \"t.obj\"").unwrap();
    assert_eq!(ambient.light.towards, ambient.camera.default_light().towards);
}

#[test]
fn bad_scene_files_are_named() {
    for (from, to, message) in [
        ("size = [64, 32]", "size = [64, 0]", "size: 64x0 is not within"),
        ("size = [64, 32]", "size = [64, 16385]", "size: 64x16385 is not within"),
        ("size = [64, 32]", "size = [64]", "line 2: size: is a list of 1, and must be a list of 2"),
        (
            "size = [64, 32]",
            "sise = [64, 32]",
            "line 2: sise is no key here; there are size, background",
        ),
        ("size = [64, 32]", "size = [", "line "),
        ("0.5, 1.0]\n\n[camera]", "0.5, 1.5]\n\n[camera]", "background: 1.5 is not within 0 to 1"),
        ("eye = [0, 0, 4]", "eye = [0, 0, 0]", "camera.target: must be apart from camera.eye"),
        ("eye = [0, 0, 4]", "eye = [0, 0, nan]", "camera.eye, camera.target and camera.up must be"),
        ("eye = [0, 0, 4]", "eyes = [0, 0, 4]", "line 6: eyes is no key here; there are eye"),
        ("eye = [0, 0, 4]", "", "eye is missing"),
        ("up = [0.0, 2.0, 0.0]", "up = [0, 0, 1]", "camera.up: must not be zero or parallel"),
        ("ortho_height = 2.0", "ortho_height = -1", "camera.ortho_height: must be above 0"),
        (
            "ortho_height = 2.0",
            "ortho_height = 2\nfov_y = 3",
            "camera.fov_y: must not be given together",
        ),
        ("ortho_height = 2.0", "fov_y = 180", "camera.fov_y: must be 0.001 to 179"),
        ("near = 1.0", "near = 9.0", "camera.near: must be below camera.far"),
        ("towards = [0, 3, 0]", "towards = [0, 0, 0]", "light.towards: must be a direction"),
        ("ambient = 0.5", "ambient = 2", "light.ambient: 2 is not within 0 to 1"),
        ("alpha = 0.4", "alpha = -0.5", "material \"glass\": alpha: -0.5 is not within"),
        ("[0.2, 0.6, 0.9]", "[0.2, 0.6, 9]", "material \"glass\": color: 9 is not within"),
        (
            "\"gooch\"",
            "\"phong\"",
            "line 21: shading: is phong, and must be one of flat, lambert, gooch",
        ),
        ("material = \"glass\"", "material = \"glas\"", "object 0: material: there is no \"glas\""),
        (
            "[[object]]\nfile",
            "[[material]]\nname = \"glass\"\ncolor = [0, 0, 0]\n[[object]]\nfile",
            "material 1: name: \"glass\" is taken",
        ),
        ("scale = 2", "scale = 0", "object 0: scale: 0 must be finite and not 0"),
        ("scale = 2", "scale = 1e300", "object 0: vertices: a place in the world is beyond"),
        ("[0.0, 0.0, 1.0, 90.0]", "[0, 0, 0, 90]", "object 0: rotate: the axis must be"),
        ("[0.0, 0.0, 1.0, 90.0]", "[0, 0, 1, inf]", "object 0: rotate: the angle must be"),
        ("[1.0, 2.0, 3.0]", "[1, 2, nan]", "object 0: translate: must be finite"),
        ("scale = 2", "scales = 2", "object 0: scales: is not a key of an object with a file"),
        ("scale = 2", "procedural = \"cubes\"", "object 0: file: needs either file or procedural"),
        (
            "file = \"t.obj\"\nmaterial",
            "material",
            "object 0: file: needs either file or procedural",
        ),
        ("\"t.obj\"\nmaterial", "\"none.obj\"\nmaterial", "none.obj: cannot be read"),
        ("\"t.obj\"\nmaterial", "\"points.txt\"\nmaterial", "points.txt: file: must end in .obj"),
        (
            "\"cubes\"",
            "\"cube\"",
            "object 2: procedural: cube: scene: is neither a file nor one of",
        ),
        ("sides = 8", "sides = 2", "cubes: sides: 2 is not within 4 to 1024"),
        ("sides = 8", "side = 8", "cubes: side: is not a key; there are sides, alpha"),
        ("alpha = 0.75", "alpha = \"x\"", "cubes: alpha: must be a number"),
        (
            "\"cubes\"\nalpha",
            "\"layers\"\nscale = 1\nalpha",
            "object 2: procedural: layers is drawn in pixels",
        ),
        ("20.25, 0.5]", "20.25, 1.5]", "screen 0: points[0]: z = 1.5 is not within 0 to 1"),
        ("20.25, 0.5]", "20.25, nan]", "screen 0: points[0]: z = NaN is not within 0 to 1"),
        ("[10.5, 20.25", "[40000, 20.25", "screen 0: points[0]: x, y = 40000, 20.25 is not within"),
        ("1.0, 0.0, 0.0, 0.5]", "1.0, 0.0, 0.0, 2]", "screen 0: color: 2 is not within 0 to 1"),
    ] {
        assert!(FULL.contains(from), "{from}");
        assert_fails(scene(&FULL.replacen(from, to, 1)), &[message]);
    }
    assert_fails(scene("size = [3, 3]"), &["s.toml: scene: has no triangle"]);
    assert_fails(scene(&format!("a = {}", "[".repeat(9_999))), &["line 1: "]);
}

#[test]
fn sources_that_are_no_scenes_are_named() {
    let none = Overrides::default();
    assert_fails(load("no.such.obj", &none), &["no.such.obj: cannot be read"]);
    assert_fails(load("spheres", &none), &["spheres: scene: ", "synthetic, layers, hairball"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xyz");
    fs::write(&path, "").unwrap();
    assert_fails(load(path.to_str().unwrap(), &none), &["a.xyz: extension: must be .obj"]);
    let nested = folder.path().join("d.ply");
    fs::create_dir(&nested).unwrap();
    assert_fails(load(nested.to_str().unwrap(), &none), &["d.ply: must be a file"]);
}

#[test]
fn the_bundled_scenes_load() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    assert!(names.len() >= 4);
    for path in names.iter().filter(|path| path.extension().is_some_and(|e| e == "toml")) {
        let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
        assert_eq!(scene.warnings, [""; 0]);
    }
}
