//! Methods that approximate: a device gives a pixel's words, and the simulator's own resolve makes the colour of them.

use fragloom::gpu::check::compare::{Differences, compare};
use fragloom::gpu::check::crosscheck::{self, Options, Path, Status};
use fragloom::gpu::twin::picture::Picture;
use fragloom::gpu::twin::program::Program;
use fragloom::gpu::twin::resolve::{Downloaded, resolve};
use fragloom::gpu::twin::shape::{Shape, constants};
use fragloom::gpu::twin::source::Twin;
use fragloom::scene::{Projection, Scene};
use fragloom::scheme::approximate::Approximation;
use fragloom::scheme::approximate::wboit::Weight;

use super::drivers::{all, alone, methods, turn, twin};
use super::mutants::mutant;
use super::support::{scene, small_scenes};

const METHODS: [&str; 4] = ["wboit", "mbt", "mlab", "stochastic"];

/// Opaque layers: nothing passes.
fn opaque() -> Scene {
    scene("layers:count=20,alpha=1", [24, 16])
}

/// Rays are parallel.
fn parallel() -> Scene {
    let mut scene = scene("gears", [40, 32]);
    scene.camera.projection = Projection::Orthographic { height: 2.0 };
    scene
}

/// Every weight, number of moments, and few and many samples with seeds of one and of two words.
fn approximations() -> Vec<Approximation> {
    let of = |(weight, (moments, samples, seed))| Approximation { weight, moments, samples, seed };
    let others = [(4, 8, 0), (6, 1, 7), (8, 64, u64::MAX), (4, 13, 1 << 40)];
    Weight::ALL.into_iter().zip(others).map(of).collect()
}

/// A twin with one change to a part of it.
pub(super) fn mutant_part(method: &str, part: &str, from: &str, to: &str) -> Twin {
    let text = match part {
        "ray" => include_str!("../../src/gpu/wgsl/approximate/ray.wgsl"),
        "random" => include_str!("../../src/gpu/wgsl/approximate/random.wgsl"),
        "sums" => include_str!("../../src/gpu/wgsl/approximate/sums.wgsl"),
        _ => include_str!("../../src/gpu/wgsl/approximate/table.wgsl"),
    };
    let changed = text.replace(from, to);
    assert_ne!(text, changed, "{from}");
    mutant(method, &format!("//# include approximate/{part}\n"), &changed)
}

#[test]
fn words_and_colors_are_equal() {
    let _turn = turn();
    for opened in all("approximations") {
        let mut sums = METHODS.map(|_| Differences::default());
        for scene in small_scenes().into_iter().chain([opaque(), parallel()]) {
            for approximation in approximations() {
                let picture = Picture::new(&scene, opened.bits()).approximate(approximation);
                for k in [None, Some(1), Some(30)] {
                    let names: &[_] = if k.is_none() { &METHODS } else { &["mlab"] };
                    if k.is_some() && approximation != approximations()[0] {
                        continue;
                    }
                    let options = opened.paths(&Options { k, ..methods(names) });
                    let bits = opened.bits();
                    for row in crosscheck::run(&opened.device, &scene, &picture, bits, &options) {
                        if row.path == Path::Raster {
                            assert_eq!(row.status, Status::Unsupported, "{row:?}");
                            assert!(row.reason.contains("compute path"), "{row:?}");
                            continue;
                        }
                        if row.method == "stochastic" && !opened.device.atomics64 {
                            assert_eq!(row.status, Status::Unsupported, "{row:?}");
                            assert!(row.reason.contains("64 bits"), "{row:?}");
                            continue;
                        }
                        assert_eq!(row.status, Status::Equal, "{k:?} {approximation:?} {row:?}");
                        let open = row.differences.unsettled;
                        assert!(open == 0 || (row.method == "mlab" && k != Some(30)), "{row:?}");
                        let float = ["wboit", "mbt"].contains(&row.method.as_str());
                        assert_eq!(row.reason.contains("within a bound"), float, "{row:?}");
                        let place = METHODS.iter().position(|&name| name == row.method);
                        sums[place.expect("asked for")].add(&row.differences);
                    }
                }
            }
        }
        for (name, sum) in METHODS.iter().zip(sums) {
            let Differences { fragments, unsettled, .. } = sum;
            let device = &opened.device.name.name;
            println!("{device}: {name}: {fragments} fragments, {unsettled} pixels unsettled");
            let supported = *name != "stochastic" || opened.device.atomics64;
            assert!(!supported || fragments > 50_000, "{name}: {sum:?}");
            assert!(*name != "mlab" || unsettled > 100, "{sum:?}");
        }
    }
}

#[test]
fn scenes_find_changed_twins() {
    let _turn = alone();
    let scenes = [scene("synthetic:n=14,tessellation=3", [40, 28]), opaque(), parallel()];
    let mutants = [
        mutant("mlab", "   last = carried;", "   last = node;"),
        mutant("mlab", "merged(last, carried)", "merged(carried, last)"),
        mutant("mlab", "through(over(node.behind, next.key.x), next.behind)", "node.behind"),
        mutant("mlab", "if acquire_lock(pixel)", "if acquire_lock(pixel) || true"),
        mutant("mlab", "pixels[pixel].count = 0u", "pixels[pixel].count = 1u"),
        mutant_part("mlab", "ray", "32512u", "65024u"),
        mutant_part("mlab", "ray", "(255u - alpha)", "(254u - alpha)"),
        mutant("wboit", "POINT: u32 = 34u", "POINT: u32 = 33u"),
        mutant("wboit", "z / 5.0) * (z / 5.0)", "z / 5.0) * (z / 5.0001)"),
        mutant("wboit", "NEAR_TIMES_FAR / (NEAR +", "NEAR_TIMES_FAR / (1.00001 * NEAR +"),
        mutant("wboit", "NEAR + f32(depth)", "f32(depth)"),
        mutant("wboit", "= alpha * vec3", "= vec3"),
        mutant("wboit", "alpha == 255u", "alpha == 256u"),
        mutant("wboit", "f32(alpha) / 255.0", "f32(alpha) / 256.0"),
        mutant_part("wboit", "sums", "u32(old + term.x < old)", "0u"),
        mutant_part("wboit", "table", "alpha % 2u == 0u", "alpha % 2u == 1u"),
        mutant("mbt", "power *= u", "power *= abs(u)"),
        mutant("mbt", "negative(term)", "term"),
        mutant("mbt", "POINT: u32 = 40u", "POINT: u32 = 41u"),
        mutant("mbt", "atomicMin", "atomicMax"),
        mutant("mbt", "i <= MOMENTS", "i < MOMENTS"),
        mutant("mbt", "TWICE_PER_LOG, -1.0", "TWICE_PER_LOG * 1.0001, -1.0"),
        mutant("mbt", "TWICE_PER_DEPTH - 1.0", "TWICE_PER_DEPTH - 1.00002"),
        mutant("mbt", "f32(absorbance.x) * 0x1p-40f", "0.0"),
        mutant("stochastic", "left -= 1u", "left -= 0u"),
        mutant("stochastic", "SAMPLES - i)", "SAMPLES)"),
        mutant("stochastic", "u32(old + term.x < old)", "0u"),
        mutant("stochastic", "atomicOr", "atomicAdd"),
        mutant("stochastic", "Wide(fragment.extra, 0u)", "Wide(0u)"),
        mutant("stochastic", "Wide(place.x, place.y)", "Wide(place.y, place.x)"),
        mutant_part("stochastic", "random", "wide_fold(x, 31u)", "wide_fold(x, 30u)"),
        mutant_part("stochastic", "random", "wide_product(bits.y, n)", "wide_product(bits.x, n)"),
    ];
    for opened in all("mutants that approximate") {
        let mut unfound = Vec::new();
        for (number, mutant) in mutants.iter().copied().enumerate() {
            if mutant.needs_atomics64() && !opened.device.atomics64 {
                continue;
            }
            // With k = 13, the last two of 14 fragments become one, and arrival decides nothing.
            let ks: &[_] = if mutant.method.name() == "mlab" { &[None, Some(13)] } else { &[None] };
            let tried = scenes.iter().flat_map(|scene| ks.iter().map(move |&k| (scene, k)));
            let found = tried.into_iter().any(|(scene, k)| {
                let picture = Picture::new(scene, opened.bits());
                let paths = vec![Path::Compute];
                let options = Options { twins: vec![mutant], k, paths, ..Options::default() };
                let bits = opened.bits();
                crosscheck::run(&opened.device, scene, &picture, bits, &options)
                    .iter()
                    .any(|row| row.is_finding && !row.differences.is_equal())
            });
            if !found {
                unfound.push((number, mutant.method.name()));
            }
        }
        assert_eq!(unfound, [], "on {}", opened.device.name.name);
    }
}

/// The negative control: any bit that no bound covers is seen, and so is a word more or one less.
#[test]
fn a_flipped_bit_of_a_word_is_seen() {
    let _turn = turn();
    let scene = scene("synthetic:n=14,tessellation=3", [40, 28]);
    for opened in all("the negative control of approximations") {
        for name in METHODS {
            let twin = twin(name);
            if twin.needs_atomics64() && !opened.device.atomics64 {
                continue;
            }
            let picture = Picture::new(&scene, opened.bits());
            let contract = twin.method.contract();
            let record = crosscheck::record(contract);
            let band = picture.whole();
            let k = contract.default_k.map(|_| 30);
            let shape = Shape::new(twin.method, band.config(contract, k)).expect("a method");
            let constants = constants(&shape, record, picture.background);
            let program = Program::new(&opened.device, twin, shape, constants).expect("a program");
            let fragments = band.stream(contract, record, Some(1));
            program.run(|function| program.compute(function, &fragments)).expect("stored");
            let expected = band.expected(twin.method, record, k);
            let got = resolve(&program, &picture.palette, expected.starts()).expect("resolved");
            let differences = |got: &Downloaded| compare(contract, k, &expected, got);
            assert!(differences(&got).is_equal());
            let count = |pixel: usize| expected.generated.pixel(pixel).len();
            let pixel = (0..got.counts.len()).max_by_key(|&pixel| count(pixel)).expect("a pixel");
            let (first, room) = got.rooms[pixel];
            for bit in 0..64 * room as usize {
                let mut flipped = got.clone();
                flipped.keys[first as usize + bit / 64] ^= 1 << (bit % 64);
                let found = differences(&flipped);
                let (word, bit) = (bit / 64, bit % 64);
                let within = match (name, word) {
                    ("wboit", 0..4) => bit < 40,
                    ("mbt", 1..5) => bit < 45,
                    // The second pass.
                    ("mbt", 5..10) => true,
                    _ => false,
                };
                if !within {
                    assert_eq!(found.not_allowed, 1, "{name} word {word} bit {bit}: {found:?}");
                }
            }
            for count in [0, room - 1, room + 1] {
                let mut other = got.clone();
                other.counts[pixel] = count;
                assert_eq!(differences(&other).not_allowed, 1, "{name} {count}");
            }
        }
    }
}

/// Where no bound holds, the twin says so.
#[test]
fn what_has_no_bound_is_unsupported() {
    let _turn = turn();
    for opened in all("bounds") {
        let mut steep = scene("cubes", [16, 16]);
        steep.camera.far = steep.camera.near * 1.0005;
        let mut behind = parallel();
        behind.camera.near = -0.25;
        for (scene, name, why) in [(steep, "mbt", "far plane"), (behind, "wboit", "behind the eye")]
        {
            let options = Options { paths: vec![Path::Compute], ..methods(&[name]) };
            let row = super::drivers::crosscheck(&opened, &scene, &options).remove(0);
            assert_eq!(row.status, Status::Unsupported, "{row:?}");
            assert!(row.reason.contains(why), "{row:?}");
        }
    }
}
