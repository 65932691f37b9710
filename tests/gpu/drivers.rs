//! What drivers compute.

use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use fragloom::gpu::check::compare::compare;
use fragloom::gpu::check::conform::{self, conform};
use fragloom::gpu::check::crosscheck::{self, Agreement, Options, Path, Status};
use fragloom::gpu::check::open::{Opened, devices};
use fragloom::gpu::check::stress::{self, stress};
use fragloom::gpu::driver::device::{Device, adapters};
use fragloom::gpu::driver::failure::Failure;
use fragloom::gpu::twin::expected::{Expected, Lists};
use fragloom::gpu::twin::picture::Picture;
use fragloom::gpu::twin::program::Program;
use fragloom::gpu::twin::raster::{Raster, Triangles};
use fragloom::gpu::twin::resolve::Downloaded;
use fragloom::gpu::twin::resolve::resolve;
use fragloom::gpu::twin::shape::{Shape, constants};
use fragloom::gpu::twin::source::{self, Twin, twins};
use fragloom::scene::Scene;

use super::mutants::mutant;
use super::support::{contract, method, scene, small_scenes};

/// Drivers on CPUs take all cores, and what depends on time has them alone.
static TURN: RwLock<()> = RwLock::new(());

pub(super) fn turn() -> RwLockReadGuard<'static, ()> {
    TURN.read().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn alone() -> RwLockWriteGuard<'static, ()> {
    TURN.write().unwrap_or_else(PoisonError::into_inner)
}

/// All devices; or none, and a line that says so, unless they are demanded.
pub(super) fn all(test: &str) -> Vec<Opened> {
    let demanded = std::env::var("FRAGLOOM_ADAPTERS").map_or(0, |n| n.parse().expect("a number"));
    let found = devices(None).unwrap_or_default().opened;
    assert!(found.len() >= demanded, "{} adapters instead of {demanded}", found.len());
    if found.is_empty() {
        println!("skipped: {test} needs a Vulkan driver");
    }
    found
}

pub(super) fn crosscheck(opened: &Opened, scene: &Scene, options: &Options) -> Vec<Agreement> {
    let picture = Picture::new(scene, opened.bits());
    let options = opened.paths(options);
    crosscheck::run(&opened.device, scene, &picture, opened.bits(), &options)
}

#[test]
fn devices_compute_what_the_simulator_computes() {
    let _turn = turn();
    for opened in all("the cross-check") {
        let mut compared = 0;
        for scene in small_scenes() {
            for row in crosscheck(&opened, &scene, &Options::default()) {
                assert!(!row.is_finding, "{row:?}");
                let contract = contract(&row.method);
                if contract.order_independent() && row.status != Status::Unsupported {
                    assert_eq!(row.status, Status::Equal, "{row:?}");
                    compared += row.differences.fragments;
                }
            }
        }
        println!("{}: {compared} fragments compared, 0 differences", opened.device.name.name);
        assert!(compared > 200_000, "{compared}");
    }
}

/// Polygons that the near plane cut.
#[test]
fn clipped_triangles_are_equal_too() {
    let _turn = turn();
    let mut scene = scene("hairball:strands=40", [71, 53]);
    scene.camera.eye = glam::DVec3::new(0.2, 0.1, 0.3);
    scene.camera.near = 0.05;
    for opened in all("clipping") {
        for row in crosscheck(&opened, &scene, &methods(&["ab-ll"])) {
            assert_eq!(row.status, Status::Equal, "{row:?}");
            assert!(row.differences.fragments > 0);
        }
    }
}

/// Triangles far larger than the picture: one that the viewport of devices contains, and one that leaves even that.
const HUGE: &str = "
size = [64, 48]

[[screen]]
points = [[-20000.0, -9000.0, 0.9], [30000.0, -100.0, 0.2], [50.0, 30000.0, 0.5]]
color = [0.8, 0.1, 0.1, 0.5]

[[screen]]
points = [[3.0, 1.5, 0.25], [60.0, 7.25, 0.5], [21.0, 47.0, 0.75]]
color = [0.1, 0.1, 0.8, 0.5]

[[screen]]
points = [[-4000.0, 1.5, 0.25], [4050.0, 7.25, 0.5], [21.0, 4050.0, 0.75]]
color = [0.1, 0.8, 0.1, 0.5]
";

#[test]
fn what_leaves_the_viewport_goes_the_compute_way() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("huge.toml");
    std::fs::write(&file, HUGE).expect("a file");
    let scene = scene(file.to_str().expect("a path"), [64, 48]);
    for opened in all("huge triangles") {
        for row in crosscheck(&opened, &scene, &methods(&["ab-ll", "s-buffer"])) {
            assert_eq!(row.status, Status::Equal, "{row:?}");
            let outside = if row.path == Path::Raster { 64 * 48 } else { 0 };
            assert_eq!(row.by_compute, outside, "{row:?}");
            assert!(row.differences.fragments > 2 * 64 * 48, "{row:?}");
        }
    }
}

/// On a device with little room a picture is drawn in bands, with the same result; one without room for a band says so.
#[test]
fn pictures_are_cut_to_fit() {
    let _turn = turn();
    let scene = scene("hairball:strands=60", [70, 90]);
    let methods = methods(&["ab-ll", "s-buffer", "kplus-array", "ha32"]);
    for mut opened in all("bands") {
        let whole = crosscheck(&opened, &scene, &methods);
        opened.device.limits.max_storage_buffer_binding_size = 100_000;
        for (row, whole) in crosscheck(&opened, &scene, &methods).iter().zip(whole) {
            assert_eq!((row.status, whole.status), (Status::Equal, Status::Equal), "{row:?}");
            assert_eq!(row.differences.fragments, whole.differences.fragments, "{row:?}");
        }
        opened.device.limits.max_storage_buffer_binding_size = 10_000;
        for row in crosscheck(&opened, &scene, &methods).iter().skip(4).take(2) {
            assert_eq!((row.method.as_str(), row.status), ("kplus-array", Status::Unsupported));
            assert!(row.reason.contains("no room") && row.reason.contains("10000"), "{row:?}");
        }
    }
}

/// The twin of a method that has one.
pub(super) fn twin(method: &str) -> Twin {
    source::twin(self::method(method)).expect("a twin")
}

pub(super) fn methods(names: &[&'static str]) -> Options {
    let twins = names.iter().map(|name| twin(name)).collect();
    Options { twins, ..Options::default() }
}

/// With as many slots as fragments none is dropped; with fewer, the contract allows any of them, and no others.
#[test]
fn arrival_decides_only_where_the_contract_says_so() {
    let _turn = turn();
    let scene = scene("synthetic:n=14,tessellation=3", [40, 28]);
    for opened in all("arrival") {
        let few = Options { k: Some(5), paths: vec![Path::Compute], ..methods(&["ab-array"]) };
        let row = crosscheck(&opened, &scene, &few).remove(0);
        assert_eq!(row.status, Status::Different, "{row:?}");
        assert!(!row.is_finding && row.differences.not_allowed == 0, "{row:?}");
        assert!(row.reason.contains("depends on arrival"), "{row:?}");
    }
}

#[test]
fn a_race_is_counted_and_is_no_finding() {
    let _turn = turn();
    let scene = scene("layers:count=24", [64, 64]);
    for opened in all("races") {
        for row in crosscheck(&opened, &scene, &methods(&["kb"])) {
            assert!(!row.is_finding, "{row:?}");
            assert!(row.reason.contains("race"), "{row:?}");
            // Drivers on CPUs draw a tile, or a row, in order and on one thread.
            if row.path == Path::Raster && opened.device.name.kind == "Cpu" {
                assert_eq!(row.status, Status::Equal, "{row:?}");
                assert!(row.reason.contains("proves nothing"), "{row:?}");
            }
        }
    }
}

/// Of equal depths, `kb-mdt32` may keep either; other depths are a finding.
#[test]
fn ties_may_be_confused_and_nothing_else() {
    let contract = contract("kb-mdt32");
    let lists = |keys: &[u64]| Lists { starts: vec![0, keys.len() as u32], keys: keys.to_vec() };
    let key = |depth: u64, data: u64| depth << 32 | data;
    let expected = Expected {
        generated: lists(&[key(1, 1), key(1, 2), key(5, 3)]),
        kept: lists(&[key(1, 1), key(1, 2)]),
        colors: vec![0],
        merged: None,
        light: None,
    };
    let found = |keys: [u64; 2]| {
        let got = Downloaded {
            counts: vec![2],
            keys: keys.to_vec(),
            colors: vec![0],
            rooms: vec![(0, 2)],
        };
        compare(contract, Some(2), &expected, &got)
    };
    assert!(found([key(1, 1), key(1, 2)]).is_equal());
    let confused = found([key(1, 2), key(1, 2)]);
    assert_eq!((confused.list_differences, confused.not_allowed), (1, 0), "{confused:?}");
    assert_eq!((confused.lost, confused.duplicated), (1, 1), "{confused:?}");
    for wrong in [[key(1, 1), key(5, 3)], [key(1, 1), key(1, 3)], [key(1, 1), key(2, 2)]] {
        let found = found(wrong);
        assert_eq!((found.list_differences, found.not_allowed), (1, 1), "{found:?}");
    }
}

/// An invocation that gives up waiting is run again, on both paths, and counted; one that would wait forever is a
/// failure.
#[test]
fn an_invocation_that_gives_up_waiting_is_run_again() {
    let _turn = alone();
    let second_time = "attempt < select(0u, PATIENCE, fragment.outcome == STUCK)";
    let late = mutant("kplus-array", "attempt < PATIENCE", second_time);
    let never = mutant("kplus-array", "attempt < PATIENCE", "attempt < 0u");
    for opened in all("waiting") {
        // The second has three submissions: when the later ones come, two layers are behind those that are kept.
        for (twin, count, size, right) in [
            (late, 3, 64, Ok(3 * 64 * 64)),
            (late, 17, 64, Ok(15 * 64 * 64)),
            (never, 3, 8, Err(Failure::Stuck(3 * 8 * 8))),
        ] {
            let scene = scene(&format!("layers:count={count}"), [size, size]);
            let picture = Picture::new(&scene, opened.bits());
            let method = method("kplus-array");
            let contract = method.contract();
            let record = crosscheck::record(contract);
            let band = picture.whole();
            let shape = Shape::new(method, band.config(contract, None)).expect("a method");
            let constants = constants(&shape, record, picture.background);
            let program = Program::new(&opened.device, twin, shape, constants).expect("a program");
            let triangles = Triangles::new(&band, record, true);
            let raster = Raster::new(&program, &band, &triangles).expect("triangles");
            let drawn = program.run(|function| raster.draw(function)).map(|()| program.again());
            assert_eq!(drawn, right);
            if right.is_ok() {
                let expected = band.expected(method, record, None);
                let starts = expected.starts();
                let got = resolve(&program, &picture.palette, starts).expect("resolved");
                assert!(compare(contract, None, &expected, &got).is_equal());
            }
            if count == 3 {
                let before = program.again();
                let fragments = band.stream(contract, record, Some(1));
                let run = program.run(|function| program.compute(function, &fragments));
                assert_eq!(run.map(|()| program.again() - before), right);
            }
        }
    }
}

/// Words, outcomes, one invocation at a time.
#[test]
fn twins_do_what_schemes_do() {
    let _turn = turn();
    for opened in all("conformance") {
        for twin in twins() {
            let extent = conform::Extent { fragments: 3, programs: 16 };
            let found = conform(&opened.device, twin, extent).expect("a device");
            assert_eq!(found.difference, None, "{found:?}");
            if found.unsupported.is_none() {
                assert!(found.steps > 100 && found.words > 500, "{found:?}");
            }
        }
    }
}

/// What comes out of copies that race is what interleavings can give; a lock that is not taken gives more.
#[test]
fn litmus_pixels_have_outcomes_of_interleavings() {
    let _turn = turn();
    for opened in all("litmus pixels") {
        for method in [
            "ab-ll",
            "kplus-array",
            "kb-ll",
            "kb",
            "kb-ab-ll",
            "ab-ll-bucket",
            "kplus-multi",
            "depth-peel",
            "ha32",
            "skb+ofm",
            "dfb+ofm",
            "mlab",
            "wboit",
            "mbt",
            "stochastic",
        ] {
            // `crosscheck --litmus` runs all instances, of slabs with three fragments, too.
            let fragments = if method.contains("+ofm") { 2 } else { 3 };
            // Of those of a hash table, nearly all are the same to a device, and are left out.
            let instances = if method == "ha32" { usize::MAX } else { 64 };
            let extent = stress::Extent { fragments, repeats: 1, instances, pressure: None };
            let twin = twin(method);
            let found = stress(&opened.device, twin, extent).expect("a device");
            if twin.needs_atomics64() && !opened.device.atomics64 {
                assert_eq!(found.status, Status::Unsupported, "{found:?}");
                continue;
            }
            assert_eq!((found.outside, found.unexplored), (0, 0), "{found:?}");
            assert!(found.relaxed == 0 || method == "kb", "{found:?}");
            assert!(found.runs >= 6 * 3 * 4_096 && found.seen > 0, "{found:?}");
        }
        for (method, fragments) in [("kplus-array", 3), ("skb+ofm", 2)] {
            let unlocked = mutant(method, "if acquire_lock(pixel)", "if true");
            let extent = stress::Extent { fragments, repeats: 1, instances: 64, pressure: None };
            let found = stress(&opened.device, unlocked, extent).expect("a device");
            assert!(found.outside + found.relaxed > 0, "{found:?}");
        }
    }
}

/// The negative control: one bit of what came back, anywhere, is seen.
#[test]
fn a_flipped_bit_is_seen() {
    let _turn = turn();
    let scene = scene("cubes", [48, 40]);
    for opened in all("the negative control") {
        let picture = Picture::new(&scene, opened.bits());
        let method = method("ab-ll");
        let contract = method.contract();
        let record = crosscheck::record(contract);
        let band = picture.whole();
        let shape = Shape::new(method, band.config(contract, None)).expect("a method");
        let constants = constants(&shape, record, picture.background);
        let twin = twin("ab-ll");
        let program = Program::new(&opened.device, twin, shape, constants).expect("a program");
        let fragments = band.stream(contract, record, Some(1));
        program.run(|function| program.compute(function, &fragments)).expect("stored");
        let expected = band.expected(method, record, None);
        let got = resolve(&program, &picture.palette, expected.starts()).expect("resolved");
        assert!(compare(contract, None, &expected, &got).is_equal());
        let middle = got.keys.len() / 2;
        for bit in 0..64 {
            let mut flipped = got.clone();
            flipped.keys[middle] ^= 1 << bit;
            let found = compare(contract, None, &expected, &flipped);
            assert_eq!((found.list_differences, found.not_allowed), (1, 1), "bit {bit}: {found:?}");
            let depth = u64::from(bit >= 32);
            assert_eq!(
                (found.depth_differences, found.coverage_differences),
                (depth, 2 - 2 * depth)
            );
        }
        let pixel = (0..got.counts.len()).find(|&p| got.counts[p] > 1).expect("a covered pixel");
        let mut fewer = got.clone();
        fewer.counts[pixel] ^= 1;
        assert!(!compare(contract, None, &expected, &fewer).is_equal());
        let mut more = got.clone();
        more.counts[pixel] += 2;
        assert_eq!(compare(contract, None, &expected, &more).not_allowed, 1);
        let mut other = got;
        other.colors[pixel] ^= 1 << 8;
        assert_eq!(compare(contract, None, &expected, &other).pixel_differences, 1);
    }
}

/// Vertices that are not on the device's grid are moved onto it by the device, and then edges differ: sub-pixel
/// precision matters, and is measured right.
#[test]
fn a_finer_grid_than_the_device_has_is_seen() {
    let _turn = turn();
    let scene = scene("hairball:strands=60", [96, 96]);
    for opened in all("sub-pixel precision") {
        let bits = opened.bits();
        assert!(bits == 4 || bits == 8);
        if bits == 8 {
            continue;
        }
        let fine = Picture::new(&scene, 8);
        let options = Options { paths: vec![Path::Raster], ..methods(&["ab-ll"]) };
        let rows = crosscheck::run(&opened.device, &scene, &fine, 8, &options);
        let row = rows.first().expect("a row");
        assert_eq!(row.status, Status::Different, "{row:?}");
        assert!(row.is_finding && row.differences.coverage_differences > 0, "{row:?}");
    }
}

/// A device that does not come back is reported, and later calls do not wait for it. Some drivers end any loop after
/// 65,535 iterations, and come back.
#[test]
fn a_hang_is_survived() {
    let _turn = alone();
    let slow =
        "for (var i = 0u; i < 1000000000u; i++) { atomicAdd(&nodes.taken, i); }\n    let node";
    let twin = mutant("ab-ll", "let node", slow);
    let method = method("ab-ll");
    let contract = method.contract();
    let record = crosscheck::record(contract);
    let picture = Picture::new(&scene("layers:count=1", [8, 8]), 8);
    let band = picture.whole();
    let fragments = band.stream(contract, record, None);
    let (mut swiftshader, mut hung) = (false, false);
    for adapter in adapters() {
        let mut device = Device::open(&adapter).expect("a device");
        device.patience = 1;
        swiftshader |= device.name.name.contains("SwiftShader");
        let shape = Shape::new(method, band.config(contract, None)).expect("a method");
        let constants = constants(&shape, record, [0; 3]);
        let program = Program::new(&device, twin, shape, constants).expect("a program");
        match program.compute("store", &fragments[..1]) {
            Ok(()) => println!("{} ends the loop by itself", device.name.name),
            found => {
                hung = true;
                assert_eq!(found, Err(Failure::TimedOut(1)));
                assert!(device.is_lost());
                assert_eq!(program.clear(), Err(Failure::TimedOut(1)), "and stays so");
            }
        }
    }
    assert!(hung || !swiftshader, "it runs any loop to its end");
}

#[test]
fn what_has_no_room_is_refused() {
    let _turn = turn();
    for opened in all("limits") {
        let most = opened.device.largest();
        let usage = wgpu::BufferUsages::STORAGE;
        let found = opened.device.buffer("too large", most + 1, usage);
        assert!(matches!(found, Err(Failure::TooLarge(_))), "{found:?}");
        let found = opened.device.module("wrong", "fn main( {");
        assert!(matches!(found, Err(Failure::Invalid(_))), "{found:?}");
        assert_eq!(opened.device.check(), Ok(()), "and the device goes on");
    }
}
