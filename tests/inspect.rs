//! One pixel's fragments before and after methods of every kind, on scenes whose answers can be read off: equal layers
//! over the whole picture, and triangles of equal depth.

mod support;
#[path = "support/toys/mod.rs"]
mod toys;

use fragloom::inspect::frame::Frame;
use fragloom::inspect::{Became, Inspected, Inspection, inspect};
use fragloom::num::depth::Format;
use fragloom::render::{Data, Effect, Exec, Options, Shadows, Sim, reference};
use fragloom::scene::Scene;
use support::{draw, options, scene, small_scenes};

const PIXEL: [u32; 2] = [9, 4];

fn layers(count: u32) -> Scene {
    scene(&format!("layers:count={count}"), [20, 12])
}

fn toy(name: &str, k: Option<u32>) -> Options {
    let method = toys::catalogue().find("-m", name).expect("a toy");
    Options { method, k, threads: 2, ..Options::default() }
}

fn look(scene: &Scene, options: Options) -> Inspected {
    inspect(scene, &[options], PIXEL).expect("inspected").methods.remove(0)
}

fn fates(found: &Inspected) -> Vec<Became> {
    found.fates.iter().map(|fate| fate.fate).collect()
}

fn count(found: &Inspected, became: Became) -> usize {
    fates(found).iter().filter(|&&fate| fate == became).count()
}

/// 1 - (1 - a)^i, multiplied out in the order of the layers.
fn absorbed(alpha: u8, layers: usize) -> f64 {
    1.0 - (0..layers).fold(1.0, |light, _| light * (1.0 - f64::from(alpha) / 255.0))
}

#[test]
fn fragments_are_in_canonical_order_with_their_distances() {
    let scene = layers(6);
    let found = inspect(&scene, &[options("exact", None)], PIXEL).expect("inspected");
    let all = reference(&scene, &options("exact", None)).expect("a reference").all;
    let keys = all.pixel(PIXEL[0], PIXEL[1]);
    assert_eq!(found.fragments.len(), 6);
    for (i, (fragment, key)) in found.fragments.iter().zip(keys).enumerate() {
        assert_eq!((fragment.index, &fragment.object), (i, &None));
        assert_eq!(u64::from(fragment.depth), key >> 32);
        assert_eq!(fragment.rgba, (*key as u32).to_le_bytes());
        let z = f64::from(fragment.depth) / f64::from(u32::MAX);
        let [near, far] = [scene.camera.near, scene.camera.far];
        assert_eq!(fragment.distance, (near * far) / (far - z * (far - near)), "a perspective");
    }
    let mut triangles: Vec<u32> = found.fragments.iter().map(|f| f.triangle / 2).collect();
    triangles.sort_unstable();
    assert_eq!(triangles, [0, 1, 2, 3, 4, 5], "a triangle of every rectangle");
}

#[test]
fn objects_are_named() {
    let scene = scene("box", [32, 32]);
    let found = inspect(&scene, &[Options::default()], [16, 16]).expect("inspected");
    assert_eq!(found.fragments.len(), 2);
    assert!(found.fragments.iter().all(|fragment| fragment.object == Some("a".to_owned())));
}

#[test]
fn the_absorbance_of_equal_layers_has_a_closed_form() {
    for count in [1, 2, 7, 40] {
        let scene = layers(count);
        let found = inspect(&scene, &[options("ab-ll", None)], PIXEL).expect("inspected");
        for curve in [&found.exact.absorbance, &found.methods[0].absorbance] {
            assert_eq!(curve.len(), 2 * count as usize);
            for (i, fragment) in found.fragments.iter().enumerate() {
                let at = |i| absorbed(fragment.rgba[3], i);
                assert_eq!(curve[2 * i], [fragment.distance, at(i)]);
                assert_eq!(curve[2 * i + 1], [fragment.distance, at(i + 1)]);
            }
        }
        assert_eq!(found.exact.absorbed, absorbed(64, count as usize));
        assert_eq!(found.methods[0].absorbed, found.exact.absorbed);
    }
}

#[test]
fn the_exact_colour_is_the_oracles() {
    for scene in small_scenes() {
        for data in [Data::Color, Data::Primitive] {
            let exact = Options { data, ..options("exact", None) };
            let image = draw(&scene, &exact).image;
            let middle = [scene.size[0] / 2, scene.size[1] / 2];
            for pixel in [[0, 0], middle, [11, 6]] {
                let found =
                    inspect(&scene, std::slice::from_ref(&exact), pixel).expect("inspected");
                assert_eq!(found.exact.color, image.pixel(pixel[0], pixel[1]), "{}", scene.name);
                assert_eq!(found.methods[0].difference, 0);
                assert!(fates(&found.methods[0]).iter().all(|&fate| fate == Became::Kept));
            }
        }
    }
}

#[test]
fn the_nearest_are_kept_and_the_rest_is_beyond() {
    let scene = layers(6);
    for (name, k, near) in
        [("kplus-array", Some(3), 3), ("z-buffer", None, 1), ("exact", Some(2), 2)]
    {
        let found = look(&scene, options(name, k));
        for (i, fate) in found.fates.iter().enumerate() {
            assert_eq!(fate.fate == Became::Kept, i < near, "{name} {i} {fate:?}");
            let beyond = format!("beyond the nearest {near}");
            assert_eq!(fate.reason, (i >= near).then_some(beyond), "{name} {i}");
        }
        assert_eq!(count(&found, Became::Lost), 0);
        assert_eq!(found.absorbed, absorbed(64, near), "{name}");
        assert_eq!(found.k, Some(near as u32));
    }
}

/// All layers in order from the front: those beyond k find k nearer ones, and are never stored. From the back, all are
/// stored, and pushed out.
#[test]
fn one_way_to_go_has_a_name() {
    let triangle = "points = [[-90.0, -90.0, Z], [200.0, -90.0, Z], [-90.0, 200.0, Z]]\n\
                    color = [0.5, 0.5, 0.5, 0.25]\n";
    let depths = ["0.2", "0.4", "0.6", "0.8"];
    let folder = tempfile::tempdir().expect("a folder");
    let drawn = |name: &str, depths: &[&str]| {
        let one = |z: &&str| format!("[[screen]]\n{}", triangle.replace('Z', z));
        let text: String = depths.iter().map(one).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, format!("size = [20, 12]\n{text}")).expect("written");
        look(&scene(path.to_str().expect("text"), [20, 12]), options("kplus-array", Some(2)))
    };
    let back: Vec<&str> = depths.iter().rev().copied().collect();
    assert_eq!(
        fates(&drawn("front.toml", &depths))[1..],
        [Became::Kept, Became::Culled, Became::Culled]
    );
    assert_eq!(
        fates(&drawn("back.toml", &back))[1..],
        [Became::Kept, Became::Evicted, Became::Evicted]
    );
}

/// Whatever `kb` loses, the sums of fates are the fragments, and its list is what was kept.
#[test]
fn a_race_loses_fragments() {
    let scene = layers(6);
    let mut lost = 0;
    for seed in 0..8 {
        let racing =
            Options { exec: Exec::Sim(Sim { seed, ..Sim::default() }), ..options("kb", Some(6)) };
        let list = draw(&scene, &racing).lists().expect("lists").pixel(PIXEL[0], PIXEL[1]).len();
        let found = look(&scene, racing);
        assert_eq!(found.fates.len(), 6);
        assert_eq!(list, count(&found, Became::Kept) + found.extra.len());
        assert_eq!(count(&found, Became::Kept) + count(&found, Became::Lost), 6, "{found:?}");
        lost += count(&found, Became::Lost);
    }
    assert!(lost > 0, "some schedule loses some");
}

#[test]
fn no_room_is_a_reason() {
    let dropped = look(&layers(6), options("ab-array", Some(4)));
    assert_eq!(count(&dropped, Became::Dropped), 2, "{dropped:?}");
    assert!(dropped.fates.iter().flat_map(|fate| &fate.reason).all(|why| why == "overflow"));
}

/// Three triangles of one depth: `kb-mdt32` keeps one of every depth.
#[test]
fn fragments_of_one_depth_are_told_apart() {
    let scene = scene(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/screen.toml"), [256, 256]);
    let look = |options| inspect(&scene, &[options], [64, 200]).expect("inspected");
    let all = look(options("kplus-array", None));
    assert_eq!(all.fragments.len(), 3);
    assert!(all.fragments.windows(2).all(|pair| pair[0].depth == pair[1].depth));
    assert_eq!(count(&all.methods[0], Became::Kept), 3);
    let some = look(options("kplus-array", Some(2)));
    assert_eq!(fates(&some.methods[0])[..2], [Became::Kept; 2]);
    let one = look(options("depth-peel@published", None));
    assert_eq!(
        (count(&one.methods[0], Became::Kept), count(&one.methods[0], Became::Lost)),
        (1, 2)
    );
}

/// The two nearest layers become one record, which stands at the second.
#[test]
fn merged_records_know_their_fragments() {
    let found = look(&layers(6), toy("merge-two", None));
    let records: Vec<Option<usize>> = found.fates.iter().map(|fate| fate.record).collect();
    assert_eq!(records, [Some(0), Some(0), Some(1), Some(2), Some(3), Some(4)]);
    let kept = [Became::Kept; 4];
    assert_eq!(fates(&found), [&[Became::Merged; 2], &kept[..]].concat());
    let weights: Vec<f64> = found.records.iter().map(|record| record.weight).collect();
    assert_eq!(weights, [2.0, 1.0, 1.0, 1.0, 1.0]);
    // Without a thickness, the record is a step at its far end.
    assert_eq!(found.absorbance[0][0], found.absorbance[1][0]);
    assert_eq!(found.absorbance[0][0], found.records[0].distance);
    let one = look(&layers(1), toy("merge-two", None));
    assert_eq!(fates(&one), [Became::Kept]);
}

#[test]
fn a_colour_has_no_curve() {
    let found = look(&layers(6), toy("blend-average", None));
    assert_eq!(fates(&found), [Became::Merged; 6]);
    assert!(found.absorbance.is_empty() && found.records.is_empty());
    assert!((found.absorbed - absorbed(64, 6)).abs() < 1e-4, "equal layers are their own average");
    let known = |k| look(&layers(6), toy("blend-nearest", Some(k))).fates[0].reason.clone();
    assert_eq!(known(6), Some("blended into the pixel's colour".to_owned()));
    assert!(known(3).expect("a reason").contains("not known"));
}

#[test]
fn every_built_in_method_is_told() {
    let scene = scene("synthetic:n=9,tessellation=3", [24, 20]);
    let all = fragloom::catalogue::Catalogue::built_in();
    for method in all.methods() {
        let contract = method.contract();
        let format = contract.depth_format.unwrap_or_default();
        let options = Options { depth_format: Some(format), ..toy("merge-two", None) };
        let result = inspect(&scene, &[Options { method: *method, ..options }], [12, 10]);
        if contract.keeps == fragloom::scheme::Keeps::Bound {
            assert_eq!(result.map(drop).expect_err("depths").place(), "-m");
            continue;
        }
        let found: Inspection = result.unwrap_or_else(|error| panic!("{method}: {error}"));
        assert_eq!(found.fragments.len(), found.methods[0].fates.len());
        assert!(found.fragments.len() > 3, "{method}");
        let one_by_one = count(&found.methods[0], Became::Kept) + found.methods[0].extra.len();
        let merges = contract.keeps == fragloom::scheme::Keeps::Merged;
        let list = if merges { found.methods[0].records.len() } else { one_by_one };
        assert_eq!(found.methods[0].absorbance.len(), 2 * list, "{method}");
    }
}

#[test]
fn a_pixel_without_fragments_is_empty() {
    let found = inspect(&scene("box", [32, 32]), &[Options::default()], [0, 0]).expect("inspected");
    assert!(found.fragments.is_empty() && found.methods[0].fates.is_empty());
    assert_eq!((found.exact.absorbed, found.methods[0].difference), (0.0, 0));
    assert!(found.plot().svg().contains("</svg>"));
    assert_eq!(found.plot().draw().width, 1_440);
}

#[test]
fn what_cannot_be_inspected_is_named() {
    let scene = layers(3);
    let plain = options("kplus-array", None);
    let place = |methods: &[Options], pixel| {
        inspect(&scene, methods, pixel).map(drop).expect_err("an error").place().to_owned()
    };
    let two = |other: Options| [plain.clone(), other];
    assert_eq!(place(std::slice::from_ref(&plain), [20, 0]), "--pixel");
    assert_eq!(place(&[], [0, 12]), "--pixel");
    let d24 = Options { depth_format: Some(Format::D24), ..plain.clone() };
    assert_eq!(place(&two(d24), PIXEL), "--depth-format");
    let coarse = Options { sub_pixel_bits: 4, ..plain.clone() };
    assert_eq!(place(&two(coarse), PIXEL), "--sub-pixel-bits or --cull-face");
    let effect = Options { effect: Effect::Ldi { voxels: None }, ..plain.clone() };
    assert_eq!(place(&two(effect), PIXEL), "--effect");
    let shadows = Options { shadows: Some(Shadows::default()), ..plain.clone() };
    assert_eq!(place(&two(shadows), PIXEL), "--shadows");
}

#[test]
fn curves_are_steps_from_end_to_end() {
    let methods = [options("kplus-array", Some(3)), toy("blend-average", None)];
    let plot = inspect(&layers(6), &methods, PIXEL).expect("inspected").plot();
    let names: Vec<&str> = plot.curves.iter().map(|curve| &curve.name[..]).collect();
    assert_eq!(names, ["exact", "kplus-array, k = 3", "blend-average"]);
    let [exact, kplus, color] = [0, 1, 2].map(|i| &plot.curves[i].points);
    assert_eq!([exact.len(), kplus.len(), color.len()], [14, 8, 2]);
    assert_eq!(exact[0], kplus[0], "all begin at one place");
    assert_eq!([exact[13][0], kplus[7][0]], [color[1][0]; 2], "and end at one");
    for curve in [exact, kplus] {
        for pair in curve.windows(2) {
            let moves = [pair[0][0] < pair[1][0], pair[0][1] < pair[1][1]];
            assert!(moves == [true, false] || moves == [false, true], "{pair:?}");
        }
    }
}

/// A frame says of every pixel what `inspect` says of it, for methods of every kind.
#[test]
fn a_frame_tells_the_same_of_every_pixel() {
    let sim = Exec::Sim(Sim { resident: 96, ..Sim::default() });
    let kinds = [
        ("kplus-array", Data::Color),
        ("kb", Data::Primitive),
        ("kb", Data::Color),
        ("ab-ll", Data::Color),
        ("ha64-cull", Data::Color),
        ("dfb+ofm", Data::Color),
        ("skb+ofm", Data::Color),
        ("wboit", Data::Color),
        ("stochastic", Data::Color),
    ];
    for scene in small_scenes() {
        let mut extra = 0;
        for (name, data) in kinds {
            let all = [Options { data, exec: sim.clone(), ..options(name, None) }];
            let frame = Frame::new(&scene, &all).expect("a frame");
            let [width, height] = scene.size;
            assert_eq!(frame.exact, draw(&scene, &options("exact", None)).image, "{}", scene.name);
            let pixels = [[0, 0], [width / 2, height / 2], [11, 6], [width - 1, height - 1]];
            frame
                .draw(&all[0], |drawn| {
                    for pixel in pixels {
                        let found = inspect(&scene, &all, pixel).expect("inspected");
                        let generated = frame.pixel(pixel);
                        assert_eq!(generated.len(), found.fragments.len());
                        for (own, other) in generated.iter().zip(&found.fragments) {
                            let rgba = own.color.to_le_bytes();
                            let own = (own.triangle, own.depth, rgba);
                            assert_eq!(own, (other.triangle, other.depth, other.rgba));
                        }
                        let method = &found.methods[0];
                        assert_eq!(drawn.title(), method.title());
                        let look = drawn.look(pixel);
                        assert_eq!(look.fates, method.fates, "{name} {pixel:?} {}", scene.name);
                        assert_eq!((&look.records, &look.extra), (&method.records, &method.extra));
                        assert_eq!(look.absorbed.to_bits(), method.absorbed.to_bits());
                        assert_eq!(look.absorbance, method.absorbance);
                        extra += look.extra.len();
                    }
                })
                .expect("drawn");
        }
        println!("{}: {extra} entries that are no fragment's", scene.name);
    }
}

#[test]
fn a_frame_that_does_not_fit_is_refused() {
    let small = Options { max_memory: 1_000, ..Options::default() };
    let error = Frame::new(&layers(6), &[small]).map(|_| ()).expect_err("too many fragments");
    assert_eq!(error.place(), "--max-memory");
    let scene = layers(2);
    let depths = Frame::new(&scene, &[options("occupancy", None)]);
    assert_eq!(depths.map(|_| ()).expect_err("no lists").place(), "-m");
}
