//! Point sets: PLY without faces, radii, options, Gaussian splats.

use std::fs;

use fragloom::error::Result;
use fragloom::scene::{Disc, Model, Overrides, PointSize, Scene, Shading, load, ply};
use glam::DVec3;

use super::assert_fails;

/// A PLY file of float properties.
fn text(properties: &str, rows: &[&str]) -> String {
    let properties: Vec<String> =
        properties.split_whitespace().map(|name| format!("property float {name}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\n{}end_header\n{}\n",
        rows.len(),
        properties.concat(),
        rows.join("\n")
    )
}

fn parse(properties: &str, rows: &[&str]) -> Result<Model> {
    ply::parse(text(properties, rows).as_bytes(), "p.ply")
}

fn discs(model: &Model) -> &[Disc] {
    assert_eq!(model.objects.len(), 1);
    &model.objects[0].mesh.discs
}

fn normal(disc: &Disc) -> DVec3 {
    let [a, b] = disc.axes.map(|axis| DVec3::from(axis.map(f64::from)));
    a.cross(b)
}

#[test]
fn what_a_point_has_is_taken() {
    let model = parse(
        "x y z nx ny nz r green diffuse_blue alpha radius",
        &["1 2 3 0 0 5 0.5 0.25 1 0.75 0.5", "4 5 6 -2 0 0 0 0 0 1 2"],
    )
    .unwrap();
    let [first, second] = discs(&model) else { panic!("two points") };
    assert_eq!((first.center, first.color, first.alpha), ([1.0, 2.0, 3.0], [0.5, 0.25, 1.0], 0.75));
    assert_eq!((normal(first), normal(second)), (DVec3::Z * 0.25, DVec3::X * -4.0));
    assert_eq!((first.sigmas, model.triangles()), (0.0, 2));
    assert!(model.warnings.is_empty());
}

#[test]
fn integers_are_shares_of_the_largest() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty char y\nproperty double z\n\
        property uchar red\nproperty uchar green\nproperty ushort blue\nproperty uchar alpha\n\
        property uchar radius\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n\
        7 -8 0.5 255 51 65535 102 2\n";
    let model = ply::parse(text.as_bytes(), "p.ply").unwrap();
    let [disc] = discs(&model) else { panic!("one point") };
    assert_eq!(disc.center, [7.0, -8.0, 0.5]);
    assert_eq!((disc.color, disc.alpha), ([1.0, 0.2, 1.0], 0.4));
    assert_eq!(disc.axes.map(|a| DVec3::from(a.map(f64::from)).length()), [2.0, 2.0]);
}

/// A square grid in a plane: the normal is exact, and the radius is one step; at a corner, where nothing is on two sides,
/// the distance to the fourth neighbour.
#[test]
fn a_grid_gets_exact_normals_and_radii() {
    for axis in 0..3 {
        let place = |i: usize| {
            let mut p = [(i % 9) as f32, (i / 9) as f32, -3.0];
            p.rotate_left(axis);
            format!("{} {} {}", p[0], p[1], p[2])
        };
        let rows: Vec<String> = (0..81).map(place).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let model = parse("x y z", &rows).unwrap();
        let mut across = [0.0, 0.0, 1.0];
        across.rotate_left(axis);
        for disc in discs(&model) {
            let normal = normal(disc);
            assert_eq!(normal.abs() / normal.length(), DVec3::from(across));
        }
        let radius = |i: usize| DVec3::from(discs(&model)[i].axes[0].map(f64::from)).length();
        assert_eq!([radius(40), radius(4), radius(0)], [1.0, 1.0, 2.0]);
    }
}

/// Points on a sphere, in a spiral: normals within 3 degrees of the radius, and outwards.
#[test]
fn a_sphere_gets_normals_outwards() {
    const POINTS: usize = 2_000;
    let place = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / POINTS as f64;
        let (r, angle) = ((1.0 - z * z).sqrt(), i as f64 * 2.399_963_229_728_653);
        [r * libm::cos(angle), r * libm::sin(angle), z].map(|c| c as f32)
    };
    let rows: Vec<String> =
        (0..POINTS).map(place).map(|[x, y, z]| format!("{x} {y} {z}")).collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let model = parse("x y z", &rows).unwrap();
    let worst = discs(&model).iter().map(|disc| {
        let center = DVec3::from(disc.center).normalize();
        normal(disc).normalize().dot(center)
    });
    let worst = worst.fold(1.0, f64::min);
    assert!(worst > 0.998_63, "cos {worst}");
}

#[test]
fn what_is_not_known_is_left_out_or_named() {
    let model = parse("x y z radius", &["1e99 0 0 1", "1 2 3 1", "0 -1e99 0 1"]).unwrap();
    assert_eq!(discs(&model).len(), 1);
    assert_eq!(model.warnings, ["p.ply: 2 of 3 points have no finite position and are left out"]);
    for (properties, rows, message) in [
        ("x y z", &["0 0 0"][..], "point 0: radius: has no neighbour"),
        ("x y z", &["1e99 0 0", "1 0 0", "1 0 -0"], "point 1: radius: has no neighbour"),
        ("x y z radius", &["0 0 0 1", "1 0 0 0"], "point 1: radius: 0 must be finite and above 0"),
        ("x y z radius", &["0 0 0 -1"], "point 0: radius: -1 must be finite and above 0"),
        ("x y z radius", &["0 0 0 1e99"], "point 0: radius: inf must be finite and above 0"),
        ("x y z", &["1e99 0 0"], "points: needs at least one with finite x, y and z"),
        ("x y", &["0 0"], "element vertex: property z: is missing"),
        ("x y z", &[], "points: needs at least one"),
        ("x y z scale_0 opacity", &["0 0 0 0 0"], "splat needs f_dc_0, f_dc_1, f_dc_2, scale_1"),
    ] {
        assert_fails(parse(properties, rows), &["p.ply: ", message]);
    }
    let clamped = parse("x y z alpha red", &["0 0 0 1 0", "1 0 0 -1 7"]).unwrap();
    assert_eq!(discs(&clamped)[1].alpha, 0.0);
    assert!(clamped.warnings[0].contains("vertex 1: alpha: -1: is not within 0 to 1"));
}

/// The same whatever the order of the points: ties among neighbours do not hang on it.
#[test]
fn the_order_of_points_does_not_matter() {
    let rows: Vec<String> =
        (0..125).map(|i| format!("{} {} {}", i % 5, i / 5 % 5, i / 25)).collect();
    let forth: Vec<&str> = rows.iter().map(String::as_str).collect();
    let back: Vec<&str> = forth.iter().rev().copied().collect();
    let (forth, back) = (parse("x y z", &forth).unwrap(), parse("x y z", &back).unwrap());
    assert!(discs(&forth).iter().eq(discs(&back).iter().rev()));
}

#[test]
fn points_at_one_place_share_what_is_estimated() {
    let model = parse("x y z", &["0 0 0", "1 0 0", "0 0 0", "0 1 0", "0 0 0"]).unwrap();
    let [a, _, b, _, c] = discs(&model) else { panic!("five points") };
    assert_eq!((a, a), (b, c));
    assert_eq!(normal(a).abs().normalize(), DVec3::Z);
}

/// A point far from all others does not become larger than sixteen medians.
#[test]
fn a_stray_point_stays_small() {
    let mut rows: Vec<String> = (0..49).map(|i| format!("{} {} 0", i % 7, i / 7)).collect();
    rows.push("1000 0 0".to_owned());
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let model = parse("x y z", &rows).unwrap();
    let radius = |i: usize| DVec3::from(discs(&model)[i].axes[0].map(f64::from)).length();
    assert_eq!((radius(24), radius(49)), (1.0, 16.0));
}

/// A scan whose lines are eight times as far from each other as the points on them: discs reach the next line, and lie
/// in the plane.
#[test]
fn sparse_lines_are_closed() {
    let rows: Vec<String> = (0..660).map(|i| format!("{} 0 {}", i % 60, i / 60 * 8)).collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let model = parse("x y z", &rows).unwrap();
    let middle = discs(&model)[5 * 60 + 30];
    assert_eq!(DVec3::from(middle.axes[0].map(f64::from)).length(), 8.0);
    assert!(discs(&model).iter().all(|disc| normal(disc).abs().normalize() == DVec3::Y));
}

const SPLAT: &str =
    "x y z f_dc_0 f_dc_1 f_dc_2 f_rest_0 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";

#[test]
fn splats_are_flat_discs() {
    // The shortest axis is y, turned by 90 degrees around z: to -x.
    let rows = ["1 2 3 0 10 -10 9 0 0.5 -2 0 2 0 0 2", "0 0 0 0 0 0 0 5 0 0 0 1 0 0 0"];
    let model = parse(SPLAT, &rows).unwrap();
    let [disc, _] = discs(&model) else { panic!("two splats") };
    let linear = libm::pow((0.5 + 0.055) / 1.055, 2.4) as f32;
    assert_eq!((disc.color, disc.alpha, disc.sigmas), ([linear, 1.0, 0.0], 0.5, 3.0));
    let [a, b] = disc.axes.map(|axis| DVec3::from(axis.map(f64::from)));
    let (long, short) = (DVec3::Y * 3.0 * libm::exp(0.5), DVec3::Z * 3.0);
    // Rounded to f32 once, and the rotation a few times to f64.
    assert!((a - long).length() < 1e-6 && (b - short).length() < 1e-6, "{a} {b}");
    assert_eq!(model.materials[0].shading, Shading::Flat);
    for (row, message) in [
        ("0 0 0 0 0 0 0 0 0 0 0 0 0 0 0", "point 0: rot_0: rot_0 to rot_3 must not all be 0"),
        ("0 0 0 0 1e99 0 0 0 0 0 0 1 0 0 0", "point 0: f_dc_1: must be finite"),
        ("0 0 0 0 0 0 0 0 0 99 0 1 0 0 0", "point 0: scale_1: its exponential is too large"),
    ] {
        assert_fails(parse(SPLAT, &[row]), &["p.ply: ", message]);
    }
    let without = SPLAT.replace(" rot_2", "").replace(" f_dc_0", "");
    let row = "0 0 0 0 0 0 0 0 0 0 1 0 0";
    assert_fails(parse(&without, &[row]), &["p.ply: a Gaussian splat needs f_dc_0, rot_2 as well"]);
    let size = PointSize { radius: Some(1.0), scale: None };
    let sized = ply::parse_sized(text(SPLAT, &rows).as_bytes(), "p.ply", size);
    assert_fails(sized, &["p.ply: radius: Gaussian splats have their own"]);
}

/// Loads scene files and point sets from a folder of their own.
fn loaded(toml: Option<&str>, points: &str, size: PointSize) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(place("p.ply"), points).unwrap();
    fs::write(place("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(place("s.toml"), toml.unwrap_or_default()).unwrap();
    let overrides = Overrides { points: size, ..Overrides::default() };
    load(&place(if toml.is_some() { "s.toml" } else { "p.ply" }), &overrides)
}

#[test]
fn radii_are_given_or_scaled() {
    let points = text("x y z radius", &["0 0 0 0.5", "2 0 0 0.25"]);
    let none = PointSize::default();
    let radii = |scene: &Scene| -> Vec<f64> {
        let discs = scene.objects.iter().flat_map(|object| &object.mesh.discs);
        discs.map(|disc| DVec3::from(disc.axes[1].map(f64::from)).length()).collect()
    };
    let own = "[[object]]\nfile = \"p.ply\"\n";
    let given = |line: &str, size| loaded(Some(&format!("{own}{line}\n{own}")), &points, size);
    assert_eq!(radii(&loaded(None, &points, none).unwrap()), [0.5, 0.25]);
    assert_eq!(radii(&given("", none).unwrap()), [0.5, 0.25, 0.5, 0.25]);
    assert_eq!(radii(&given("radius = 2", none).unwrap()), [2.0, 2.0, 0.5, 0.25]);
    assert_eq!(radii(&given("radius_scale = 2.0", none).unwrap()), [1.0, 0.5, 0.5, 0.25]);
    let option = PointSize { radius: Some(0.125), scale: None };
    assert_eq!(radii(&given("radius_scale = 2.0", option).unwrap()), [0.125; 4]);
    let option = PointSize { radius: None, scale: Some(4.0) };
    assert_eq!(radii(&loaded(None, &points, option).unwrap()), [2.0, 1.0]);
    for (line, message) in [
        ("radius = 0", "object 0: radius: 0 must be finite and above 0"),
        ("radius_scale = nan", "object 0: radius_scale: NaN must be finite and above 0"),
        ("radius = \"big\"", "object 0: radius: \"big\" must be a number"),
        ("radius = 1\nradius_scale = 1", "radius: must not be given together with radius_scale"),
        ("sides = 1", "object 0: sides: is not a key of an object with a file"),
    ] {
        assert_fails(given(line, none), &[message]);
    }
    let mesh = "[[object]]\nfile = \"m.obj\"\nradius = 1";
    assert_fails(loaded(Some(mesh), &points, none), &["object 0: radius, radius_scale: are keys"]);
    let option = PointSize { radius: Some(-1.0), scale: None };
    assert_fails(loaded(None, &points, option), &["--point-radius: -1 must be finite and above 0"]);
    let option = PointSize { radius: Some(1.0), scale: None };
    let idle = loaded(Some("[[object]]\nfile = \"m.obj\""), &points, option).unwrap();
    assert!(idle.warnings[0].contains("--point-radius"), "{:?}", idle.warnings);
}

#[test]
fn a_bare_point_set_is_half_transparent_where_it_is_opaque() {
    let alpha = |points: &str| {
        let scene = loaded(None, points, PointSize { radius: Some(0.5), scale: None }).unwrap();
        scene.materials[0].alpha
    };
    assert_eq!(alpha(&text("x y z", &["0 0 0"])), 0.5);
    assert_eq!(alpha(&text("x y z alpha", &["0 0 0 1", "1 0 0 1"])), 0.5);
    assert_eq!(alpha(&text("x y z alpha", &["0 0 0 1", "1 0 0 0.5"])), 1.0);
}
