//! Polygons of any outline, from any corner, in any plane: each pixel once, and the area exact.

use fragloom::raster::CullFace;
use fragloom::scene::{Model, Overrides, file, obj, ply};

use super::real::shown;

/// A model seen along -z, one unit a pixel.
const VIEW: &str = "size = [64, 64]\n[camera]\neye = [32.0, 32.0, 50.0]\ntarget = [32.0, 32.0, 0.0]\n\
    up = [0.0, 1.0, 0.0]\northo_height = 64.0\nnear = 1.0\nfar = 100.0\n[[object]]\nfile = \"m\"\n";

fn counts(model: &Model) -> Vec<u32> {
    let description = file::parse(VIEW.as_bytes(), "s").unwrap();
    let mut give = |_: file::Source<'_>| Ok(model.clone());
    let scene = description.build(&Overrides::default(), &mut give, &mut |_| Ok(Vec::new()));
    shown(&scene.unwrap(), CullFace::None).counts
}

fn as_obj(corners: &[[f64; 3]]) -> Model {
    let mut text = String::new();
    for [x, y, z] in corners {
        text += &format!("v {x} {y} {z}\n");
    }
    let face: Vec<_> = (1..=corners.len()).map(|i| i.to_string()).collect();
    text += &format!("f {}\n", face.join(" "));
    obj::parse(text.as_bytes(), "m", &mut |_| None).unwrap()
}

/// The pixels whose centres are inside of an outline, by crossings to the right.
fn inside(outline: &[[f64; 2]]) -> Vec<u32> {
    let pixels =
        (0..64).flat_map(|row| (0..64).map(move |x| (f64::from(x) + 0.5, 63.5 - f64::from(row))));
    let crossings = |(x, y): (f64, f64)| {
        let edges = outline.iter().zip(outline.iter().cycle().skip(1));
        edges
            .filter(|(a, b)| (a[1] > y) != (b[1] > y))
            .filter(|(a, b)| x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
            .count()
    };
    pixels.map(|pixel| (crossings(pixel) % 2) as u32).collect()
}

const OUTLINES: [&[[f64; 2]]; 9] = [
    // An L, a U, a comb, a spiral.
    &[[8.0, 8.0], [48.0, 8.0], [48.0, 20.0], [24.0, 20.0], [24.0, 44.0], [8.0, 44.0]],
    &[
        [4.0, 4.0],
        [60.0, 4.0],
        [60.0, 60.0],
        [48.0, 60.0],
        [48.0, 16.0],
        [16.0, 16.0],
        [16.0, 60.0],
        [4.0, 60.0],
    ],
    &[
        [4.0, 4.0],
        [60.0, 4.0],
        [52.0, 40.0],
        [44.0, 12.0],
        [36.0, 50.0],
        [28.0, 12.0],
        [20.0, 60.0],
        [12.0, 13.0],
    ],
    &[
        [4.0, 4.0],
        [60.0, 4.0],
        [60.0, 60.0],
        [12.0, 60.0],
        [12.0, 20.0],
        [44.0, 20.0],
        [44.0, 44.0],
        [28.0, 44.0],
        [28.0, 36.0],
        [36.0, 36.0],
        [36.0, 28.0],
        [20.0, 28.0],
        [20.0, 52.0],
        [52.0, 52.0],
        [52.0, 12.0],
        [4.0, 12.0],
    ],
    // Corners on straight lines, at both kinds of edges, and twice.
    &[
        [8.0, 8.0],
        [28.0, 8.0],
        [48.0, 8.0],
        [48.0, 14.0],
        [48.0, 20.0],
        [36.0, 20.0],
        [24.0, 20.0],
        [24.0, 20.0],
        [24.0, 32.0],
        [24.0, 44.0],
        [8.0, 44.0],
        [8.0, 26.0],
    ],
    // A dart whose notch is nearly flat, and one whose tip is nearly closed.
    &[[8.0, 8.0], [56.0, 30.0], [8.0, 52.0], [8.015625, 30.0]],
    &[[8.0, 8.0], [56.0, 30.0], [8.0, 52.0], [55.984375, 30.0]],
    // A hole, by a bridge that is walked twice.
    &[
        [4.0, 4.0],
        [60.0, 4.0],
        [60.0, 60.0],
        [4.0, 60.0],
        [4.0, 4.0],
        [20.0, 20.0],
        [20.0, 44.0],
        [44.0, 44.0],
        [44.0, 20.0],
        [20.0, 20.0],
    ],
    // A convex one with all that: fans are enough.
    &[
        [8.0, 8.0],
        [8.0, 8.0],
        [20.0, 8.0],
        [56.0, 8.0],
        [56.0, 40.0],
        [30.0, 56.0],
        [8.0, 40.0],
        [8.0, 20.0],
    ],
];

#[test]
fn any_outline_from_any_corner_either_way_round() {
    for outline in OUTLINES {
        let expected = inside(outline);
        for start in 0..outline.len() {
            for backwards in [false, true] {
                let mut corners: Vec<_> = outline.to_vec();
                corners.rotate_left(start);
                if backwards {
                    corners.reverse();
                }
                // In a slanted plane, too.
                for slope in [0.0, 0.25] {
                    let place = |&[x, y]: &[f64; 2]| [x, y, (x - 32.0) * slope - y * 0.5 * slope];
                    let model = as_obj(&corners.iter().map(place).collect::<Vec<_>>());
                    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
                    assert!(counts(&model) == expected, "{corners:?} at {slope}");
                }
            }
        }
    }
}

/// Twice the area of a model's triangles as seen along each axis.
fn areas(model: &Model) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for object in &model.objects {
        for triangle in &object.mesh.triangles {
            let [a, b, c] = triangle.map(|i| object.mesh.positions[i as usize]);
            for (axis, sum) in sum.iter_mut().enumerate() {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                *sum += (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
            }
        }
    }
    sum
}

#[test]
fn areas_are_exact_in_every_plane_and_sides_stay() {
    let outline = OUTLINES[0];
    // 2 (40 x 12 + 16 x 24)
    let whole = 1728.0;
    let planes: [fn(f64, f64) -> [f64; 3]; 3] =
        [|x, y| [x, y, 3.0], |x, y| [3.0, x, y], |x, y| [y, 3.0, x]];
    for (plane, expected) in
        planes.into_iter().zip([[0.0, 0.0, whole], [whole, 0.0, 0.0], [0.0, whole, 0.0]])
    {
        for start in 0..outline.len() {
            let mut corners: Vec<_> = outline.iter().map(|&[x, y]| plane(x, y)).collect();
            corners.rotate_left(start);
            assert_eq!(areas(&as_obj(&corners)), expected);
            corners.reverse();
            assert_eq!(
                areas(&as_obj(&corners)),
                expected.map(|area| if area == 0.0 { 0.0 } else { -area })
            );
        }
    }
}

#[test]
fn ply_polygons_are_cut_the_same_way() {
    let outline = OUTLINES[1];
    let vertices: String = outline.iter().map(|[x, y]| format!("{x} {y} 0\n")).collect();
    let face: Vec<_> = (0..outline.len()).map(|i| i.to_string()).collect();
    let count = outline.len();
    let text = format!(
        "ply\nformat ascii 1.0\nelement face 1\nproperty list int64 double vertex_index\nelement vertex {count}\n\
         property double x\nproperty double y\nproperty double z\nend_header\n{count} {}\n{vertices}",
        face.join(" ")
    );
    let model = ply::parse(text.as_bytes(), "m").unwrap();
    assert_eq!(counts(&model), inside(outline));
}

#[test]
fn outlines_that_cross_themselves_are_named() {
    let model = as_obj(&[[8.0, 8.0, 0.0], [40.0, 30.0, 0.0], [40.0, 8.0, 0.0], [8.0, 50.0, 0.0]]);
    assert!(model.warnings[0].contains("crosses itself"), "{:?}", model.warnings);
    let bow = [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, -1.0, 0.0]];
    let model = as_obj(&bow);
    assert!(model.warnings[0].contains("crosses itself"), "its sides cancel: {:?}", model.warnings);
    let line = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [3.0, 3.0, 3.0]];
    assert!(as_obj(&line).warnings.is_empty(), "a line crosses nothing");
}

/// The edges of a model's triangles that no other triangle has the other way round, by place.
fn open_edges(model: &Model) -> usize {
    let mut edges = std::collections::BTreeMap::new();
    for object in &model.objects {
        for triangle in &object.mesh.triangles {
            let [a, b, c] = triangle.map(|i| object.mesh.positions[i as usize].map(f64::to_bits));
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from, to)).or_insert(0) += 1;
                *edges.entry((to, from)).or_insert(0) -= 1;
            }
        }
    }
    edges.values().filter(|count| **count != 0).count()
}

/// Whatever a polygon looks like from any side, it keeps its edges: boxes of bent, crossed and spiked polygons with
/// their other side stay closed.
#[test]
fn what_is_closed_stays_closed() {
    let polygons: [&[[f64; 3]]; 5] = [
        // Crosses itself as seen along z.
        &[[0.0, 0.0, 0.0], [4.0, 4.0, 1.0], [4.0, 0.0, 0.0], [0.0, 5.0, 3.0]],
        // Its fourth corner lies on a line as seen along z, and has an area of its own.
        &[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [2.0, 4.0, 3.0], [0.0, 4.0, 0.0]],
        &[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 0.0, 5.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]],
        &[[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, -1.0, 0.0]],
        &[
            [0.0, 0.0, 0.0],
            [9.0, 0.0, 1.0],
            [3.0, 1.0, 0.0],
            [4.0, 1.0, 2.0],
            [1.0, 8.0, 0.0],
            [1.0, 3.0, 9.0],
        ],
    ];
    for corners in polygons {
        let count = corners.len();
        // The polygon, its other side through a point, and that point's triangles.
        let vertices = corners.iter().chain([&[2.0, 2.0, -9.0]]);
        let mut text: String = vertices.map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let face: Vec<String> = (1..=count).map(|i| i.to_string()).collect();
        text += &format!("f {}\n", face.join(" "));
        for i in 1..=count {
            text += &format!("f {} {i} {}\n", i % count + 1, count + 1);
        }
        let model = obj::parse(text.as_bytes(), "m", &mut |_| None).unwrap();
        assert_eq!(open_edges(&model), 0, "{corners:?}");
        assert_eq!(model.triangles(), count - 2 + count, "{corners:?}");
    }
}
