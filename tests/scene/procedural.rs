//! Procedural scenes: the same bytes every time and everywhere, and what each promises.

use std::collections::BTreeMap;

use fragloom::scene::{Object, Overrides, Scene, builtin, load};
use glam::DVec2;
use sha2::{Digest, Sha256};

use super::World;
use super::load::assert_framed;

/// The hash of all numbers of a scene.
fn hash(scene: &Scene) -> String {
    let mut hash = Sha256::new();
    let mut floats = |values: &[f32]| values.iter().for_each(|v| hash.update(v.to_le_bytes()));
    for object in &scene.objects {
        let mesh = &object.mesh;
        // Generators make single precision.
        for place in &mesh.positions {
            floats(&place.map(|c| c as f32));
        }
        for values in [&mesh.normals, &mesh.colors] {
            floats(values.as_flattened());
        }
        for disc in &mesh.discs {
            floats(&disc.center.map(|c| c as f32));
            floats(disc.axes.as_flattened());
            floats(&disc.color);
            floats(&[disc.alpha, disc.sigmas]);
        }
        let material = &scene.materials[object.material];
        floats(&material.color);
        floats(&[material.alpha]);
    }
    scene.screen.iter().for_each(|triangle| floats(&triangle.color));
    let points = scene.screen.iter().flat_map(|t| t.points.as_flattened().to_vec());
    let places = scene.objects.iter().flat_map(|o| o.transform.to_cols_array());
    let camera = scene.camera.view_projection(scene.size).to_cols_array();
    let light = scene.light.towards.to_array();
    for value in points.chain(places).chain(camera).chain(light) {
        hash.update(value.to_le_bytes());
    }
    let triangles = scene.objects.iter().flat_map(|o| o.mesh.triangles.as_flattened());
    triangles.for_each(|index| hash.update(index.to_le_bytes()));
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Source and hash, one per line.
const LEDGER: &str = include_str!("procedural.txt");

#[test]
fn scenes_are_what_the_ledger_says() {
    let hashes = LEDGER.lines().filter_map(|line| line.split_once("  "));
    let mut wrong = String::new();
    for (expected, source) in hashes {
        let scene = load(source, &Overrides::default()).unwrap();
        let again = load(source, &Overrides::default()).unwrap();
        assert_eq!(hash(&scene), hash(&again), "{source}: differs between two runs");
        if hash(&scene) != expected {
            wrong += &format!("{}  {source}\n", hash(&scene));
        }
    }
    assert!(wrong.is_empty(), "tests/scene/procedural.txt differs from:\n{wrong}");
    let names = builtin().iter().map(|b| b.name);
    assert!(names.into_iter().all(|name| LEDGER.contains(&format!("  {name}\n"))), "all are in it");
}

#[test]
fn seeds_matter() {
    for builtin in builtin().iter().filter(|b| b.keys.iter().any(|key| key.name == "seed")) {
        let with = |seed| {
            hash(&load(&format!("{}:seed={seed}", builtin.name), &Overrides::default()).unwrap())
        };
        assert_ne!(with(1), with(2), "{}", builtin.name);
    }
}

#[test]
fn placed_scenes_are_framed() {
    for builtin in builtin().iter().filter(|builtin| !builtin.in_pixels) {
        for size in [[640, 360], [100, 900]] {
            let overrides = Overrides { size: Some(size), ..Overrides::default() };
            assert_framed(&load(builtin.name, &overrides).unwrap());
        }
    }
}

/// The layers' depths in drawing order.
fn depths(source: &str) -> Vec<f64> {
    let scene = load(source, &Overrides::default()).unwrap();
    let mut depths: Vec<_> = scene.screen.iter().map(|triangle| triangle.points[0][2]).collect();
    depths.dedup();
    depths
}

#[test]
fn synthetic_layers_are_distinct_and_ordered_as_asked() {
    let near = depths("synthetic:n=8,order=front-to-back,tessellation=3");
    assert_eq!(near.len(), 8);
    assert!(near.is_sorted_by(|a, b| a < b));
    let far = depths("synthetic:n=8,order=back-to-front");
    assert!(far.iter().rev().eq(&near));
    let mut random = depths("synthetic:n=8");
    assert_ne!(random, near);
    random.sort_by(f64::total_cmp);
    assert_eq!(random, near);
}

#[test]
fn synthetic_colours_belong_to_depths() {
    let colors = |source: &str| {
        let scene = load(source, &Overrides::default()).unwrap();
        let entry = |t: &fragloom::scene::ScreenTriangle| {
            (t.points[0][2].to_bits(), t.color.map(f32::to_bits))
        };
        scene.screen.iter().map(entry).collect::<BTreeMap<_, _>>()
    };
    assert_eq!(colors("synthetic:n=9"), colors("synthetic:n=9,order=back-to-front"));
}

#[test]
fn every_covered_pixel_gets_n_fragments() {
    let overrides = Overrides { size: Some([37, 23]), ..Overrides::default() };
    let scene = load("synthetic:n=5,density=40,tessellation=7", &overrides).unwrap();
    let mut pixels = vec![0; 37 * 23];
    for triangle in &scene.screen {
        for (i, count) in pixels.iter_mut().enumerate() {
            *count +=
                u32::from(covers(&triangle.points, (i % 37) as f64 + 0.5, (i / 37) as f64 + 0.5));
        }
    }
    let covered = pixels.iter().filter(|&&count| count == 5).count();
    assert!(pixels.iter().all(|&count| count == 0 || count == 5), "{pixels:?}");
    assert_eq!(covered, 23 * 15, "15 rows of 23 are 40.5 %");
}

/// The top-left rule in real numbers snapped to 1/256 pixel.
fn covers(points: &[[f64; 3]; 3], x: f64, y: f64) -> bool {
    let p = points.map(|[x, y, _]| [(x * 256.0).round_ties_even(), (y * 256.0).round_ties_even()]);
    let (x, y) = (x * 256.0, y * 256.0);
    let cross = |a: [f64; 2], b: [f64; 2], x: f64, y: f64| {
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
    };
    let area = cross(p[0], p[1], p[2][0], p[2][1]);
    area != 0.0
        && [(0, 1), (1, 2), (2, 0)].iter().all(|&(i, j)| {
            // Clockwise on the screen, where y points down.
            let (a, b) = if area > 0.0 { (p[i], p[j]) } else { (p[j], p[i]) };
            let side = cross(a, b, x, y);
            let top_left = b[1] < a[1] || (b[1] == a[1] && b[0] > a[0]);
            side > 0.0 || (side == 0.0 && top_left)
        })
}

#[test]
fn gears_are_195_parts_and_neighbours_mesh() {
    let scene = load("gears", &Overrides::default()).unwrap();
    assert_eq!((scene.objects.len(), scene.materials.len()), (195, 195));
    // Nine on the first plate, in rows of three.
    let gears: Vec<_> = scene.objects.chunks(15).map(Gear::new).collect();
    let apart = |i: usize, j: usize| (gears[i].middle - gears[j].middle).length();
    for (i, j) in [(0, 1), (1, 2), (0, 3), (1, 4), (4, 7), (9, 10), (9, 12)] {
        assert!(apart(i, j) < gears[i].reach + gears[j].reach, "{i} and {j} touch");
        assert!(
            !gears[i].overlaps(&gears[j]) && !gears[j].overlaps(&gears[i]),
            "{i} and {j} collide"
        );
    }
    for (i, j) in [(0, 4), (1, 3), (0, 2), (10, 12)] {
        assert!(apart(i, j) > gears[i].reach + gears[j].reach, "{i} and {j} are apart");
    }
}

/// A gear's outline on its plate.
struct Gear {
    middle: DVec2,
    reach: f64,
    teeth: Vec<[DVec2; 4]>,
}

impl Gear {
    fn new(parts: &[Object]) -> Self {
        let middle = parts[0].transform.w_axis.truncate().truncate();
        let outline = |tooth: &Object| [0, 1, 2, 3].map(|i| tooth.world(i).truncate());
        let teeth: Vec<_> = parts[3..].iter().map(outline).collect();
        let reach = teeth.iter().flatten().map(|&p| (p - middle).length()).fold(0.0, f64::max);
        Self { middle, reach, teeth }
    }

    /// Whether a corner of one of its teeth is inside one of the other's, which are anticlockwise.
    fn overlaps(&self, other: &Self) -> bool {
        let inside = |p: DVec2, tooth: &[DVec2; 4]| {
            (0..4).all(|i| (tooth[(i + 1) % 4] - tooth[i]).perp_dot(p - tooth[i]) > 0.0)
        };
        let corners = self.teeth.as_flattened();
        corners.iter().any(|&p| other.teeth.iter().any(|tooth| inside(p, tooth)))
    }
}

#[test]
fn too_many_triangles_are_refused_before_they_are_made() {
    for source in [
        "synthetic:n=4096,tessellation=64",
        "hairball:strands=100000,segments=1024,sides=64",
        "bottles:columns=64,rows=64,levels=64,sides=512",
    ] {
        super::assert_fails(
            load(source, &Overrides::default()),
            &[source.split(':').next().unwrap()],
        );
    }
}
