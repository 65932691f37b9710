//! Methods that merge: their records are whole numbers on a device, and those of the simulator once they are home.

use fragloom::gpu::check::compare::compare;
use fragloom::gpu::check::crosscheck::{self, Options, Path, Status};
use fragloom::gpu::twin::picture::Picture;
use fragloom::gpu::twin::program::Program;
use fragloom::gpu::twin::resolve::{Downloaded, resolve};
use fragloom::gpu::twin::shape::{Shape, constants};
use fragloom::gpu::twin::source::Twin;
use fragloom::scene::{Scene, Thickness};

use super::drivers::{all, alone, methods, turn, twin};
use super::mutants::mutant;
use super::support::{scene, small_scenes};

/// From surfaces to slabs that reach through the scene.
const THICK: [Thickness; 4] = [
    Thickness::Precision(0.0),
    Thickness::Precision(2.0),
    Thickness::World(0.05),
    Thickness::World(1.0),
];

/// Every other part is made of surfaces, whatever the others are.
fn gears() -> Scene {
    let mut scene = scene("gears", [56, 44]);
    for object in scene.objects.iter_mut().step_by(2) {
        object.thickness = Some(Thickness::World(0.0));
    }
    scene
}

/// Opaque layers: the sum of their logarithms stops at its largest value.
fn opaque() -> Scene {
    scene("layers:count=20,alpha=1", [24, 16])
}

/// A twin with one change to the part that both have.
pub(super) fn mutant_part(method: &str, from: &str, to: &str) -> Twin {
    let part = include_str!("../../src/gpu/wgsl/parts/merged.wgsl");
    let changed = part.replace(from, to);
    assert_ne!(part, changed, "{from}");
    mutant(method, "//# include parts/merged\n", &changed)
}

#[test]
fn records_are_equal() {
    let _turn = turn();
    for opened in all("merging") {
        let (mut compared, mut unsettled) = (0, 0);
        for scene in small_scenes().into_iter().chain([gears(), opaque()]) {
            for thickness in THICK {
                let picture = Picture::new(&scene, opened.bits()).thick(&scene, thickness);
                for k in [None, Some(1), Some(3)] {
                    let options = Options { k, ..methods(&["skb+ofm", "dfb+ofm"]) };
                    let options = opened.paths(&options);
                    let bits = opened.bits();
                    for row in crosscheck::run(&opened.device, &scene, &picture, bits, &options) {
                        if row.path == Path::Raster {
                            assert_eq!(row.status, Status::Unsupported, "{row:?}");
                            assert!(row.reason.contains("compute path"), "{row:?}");
                            continue;
                        }
                        assert_eq!(row.status, Status::Equal, "{thickness} {k:?} {row:?}");
                        assert!(row.reason.contains("without colours"), "{row:?}");
                        let open = row.differences.unsettled;
                        assert!(open == 0 || (row.method == "skb+ofm" && k != Some(1)), "{row:?}");
                        compared += row.differences.fragments;
                        unsettled += open;
                    }
                }
            }
        }
        println!(
            "{}: {compared} fragments, {unsettled} pixels by their sum alone",
            opened.device.name.name
        );
        assert!(compared > 100_000 && unsettled > 100, "{compared} {unsettled}");
    }
}

#[test]
fn scenes_find_changed_twins() {
    let _turn = alone();
    let scenes = [scene("synthetic:n=14,tessellation=3", [40, 28]), gears(), opaque()];
    let mutants = [
        mutant("dfb+ofm", "memory.near[behind] <", "memory.near[thick] <"),
        mutant("dfb+ofm", "a.near < b.near", "a.near > b.near"),
        mutant("dfb+ofm", "is_nearer(alone_at(surface), next)", "true"),
        mutant("dfb+ofm", "emitted < K - 1u", "emitted < K"),
        mutant("dfb+ofm", "tail = joined(tail, next)", "tail = next"),
        mutant(
            "skb+ofm",
            "i < count {\n                    put",
            "i > count {\n                    put",
        ),
        mutant("skb+ofm", "into_tail(pixel, last)", "into_tail(pixel, own)"),
        mutant("skb+ofm", "!is_nearer(own, last)", "is_nearer(own, last)"),
        mutant("skb+ofm", "own.near >= bound", "own.near >= 0u"),
        mutant("skb+ofm", "if acquire_lock(pixel)", "if acquire_lock(pixel) || true"),
        mutant_part("dfb+ofm", "select(sum, vec2<u32>(0xFFFFFFFFu), sum < a)", "sum"),
        mutant_part("dfb+ofm", "[a % 4u]", "[a % 3u]"),
        mutant_part("skb+ofm", "emit(record.ba)", "emit(record.rg)"),
    ];
    for opened in all("mutants that merge") {
        for (number, mutant) in mutants.iter().copied().enumerate() {
            // What arrival decides may hide a change: then another order is tried.
            let tried = (0..4).flat_map(|seed| {
                let each = move |scene| THICK.map(move |thickness| (scene, thickness, Some(seed)));
                scenes.iter().flat_map(each)
            });
            let found = tried.into_iter().any(|(scene, thickness, shuffle)| {
                let picture = Picture::new(scene, opened.bits()).thick(scene, thickness);
                let (k, paths) = (Some(5), vec![Path::Compute]);
                let options = Options { twins: vec![mutant], k, paths, shuffle };
                let bits = opened.bits();
                crosscheck::run(&opened.device, scene, &picture, bits, &options)
                    .iter()
                    .any(|row| row.is_finding && row.differences.list_differences > 0)
            });
            assert!(found, "mutant {number} of {}", mutant.method);
        }
    }
}

/// The negative control: any bit of a record is seen, and so is one more or one less.
#[test]
fn a_flipped_bit_of_a_record_is_seen() {
    let _turn = turn();
    let scene = scene("cubes", [48, 40]);
    for opened in all("the negative control of merging") {
        let picture =
            Picture::new(&scene, opened.bits()).thick(&scene, Thickness::Precision(100.0));
        let Twin { method, .. } = twin("dfb+ofm");
        let contract = method.contract();
        let record = crosscheck::record(contract);
        let band = picture.whole();
        let shape = Shape::new(method, band.config(contract, None)).expect("a method");
        let constants = constants(&shape, record, picture.background);
        let program =
            Program::new(&opened.device, twin("dfb+ofm"), shape, constants).expect("a program");
        let fragments = band.stream(contract, record, Some(1));
        program.run(|function| program.compute(function, &fragments)).expect("stored");
        let expected = band.expected(method, record, None);
        let got = resolve(&program, &picture.palette, expected.starts()).expect("resolved");
        let differences = |got: &Downloaded| compare(contract, None, &expected, got);
        assert!(differences(&got).is_equal());
        let pixel = (0..got.counts.len()).find(|&p| got.counts[p] == 8).expect("two records");
        let first = got.rooms[pixel].0 as usize;
        for bit in 0..256 {
            let mut flipped = got.clone();
            flipped.keys[first + bit / 64] ^= 1 << (bit % 64);
            let found = differences(&flipped);
            assert_eq!((found.list_differences, found.not_allowed), (1, 1), "bit {bit}: {found:?}");
        }
        for count in [0, 4, 7, 9, 1_000] {
            let mut other = got.clone();
            other.counts[pixel] = count;
            assert_eq!(differences(&other).not_allowed, 1, "{count}");
        }
    }
}
