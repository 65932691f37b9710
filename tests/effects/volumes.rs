//! Volumes against closed forms: the law of Beer and Lambert, alone, around surfaces and over each other.

use fragloom::effect::volume::UNTIL;
use fragloom::image::Image;
use fragloom::render::{Marching, Options, render};
use fragloom::scene::{Scene, Thickness};

use super::support::{draw, method, options};
use super::{srgb, toml};

/// Parallel rays along -z, a box of `depth` in the middle, and what else there is.
const STRAIGHT: &str = "[camera]\neye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\northo_height = 2.0\nnear = 1.0\n\
                        far = 9.0\n";

const PERSPECTIVE: &str = "[camera]\neye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\nfov_y = 20.0\nnear = 1.0\n\
                           far = 9.0\n";

/// Linear, as the background and volumes have it.
const BACKGROUND: [f64; 3] = [0.75, 0.25, 0.5];
const COLOR: [f64; 3] = [0.25, 0.5, 1.0];
/// Per world unit.
const ALPHA: f64 = 0.75;

/// The pane of the tests, upright across the line of sight at z, linear and flat.
fn pane(z: f64, alpha: f64) -> String {
    format!(
        "[[material]]\nname = \"{z}\"\ncolor = [0.8, 0.6, 0.2]\nalpha = {alpha}\nshading = \"flat\"\n\
         [[object]]\nfile = \"pane.obj\"\nmaterial = \"{z}\"\nscale = 9.0\nrotate = [1.0, 0.0, 0.0, 90.0]\n\
         translate = [0.0, 0.0, {z}]\n"
    )
}

/// An even medium, whose box is so wide that rays enter at the front and leave at the back.
fn medium(depth: f64, z: f64, more: &str) -> String {
    let [r, g, b] = COLOR;
    format!(
        "[[volume]]\nprocedural = \"constant\"\nextent = [50.0, 50.0, {depth}]\ntranslate = [0.0, 0.0, {z}]\n\
         transfer = [[0.0, {r}, {g}, {b}, {ALPHA}]]\nstep = 0.125\n{more}"
    )
}

fn scene(camera: &str, parts: &[String]) -> Scene {
    let head = format!("size = [12, 8]\nbackground = {BACKGROUND:?}\n{camera}");
    toml(&(head + &parts.concat()))
}

/// What is in front of the background, front to back: colour and opacity, then in 16 bits and sRGB.
fn expected(layers: &[([f64; 3], f64)]) -> [u8; 4] {
    let (mut color, mut through) = ([0.0; 3], 1.0);
    for (c, alpha) in layers {
        (0..3).for_each(|i| color[i] += through * alpha * c[i]);
        through *= 1.0 - alpha;
    }
    let channel = |i: usize| {
        let background = (BACKGROUND[i] * 65_535.0).round();
        srgb((color[i] * 65_535.0 + through * background).round() as u64)
    };
    [channel(0), channel(1), channel(2), 255]
}

fn fog(length: f64) -> ([f64; 3], f64) {
    (COLOR, 1.0 - libm::pow(1.0 - ALPHA, length))
}

/// The bytes of the pane's colour and opacity, as a layer.
fn glass(alpha: f64) -> ([f64; 3], f64) {
    let byte = |c: f64| (c * 255.0).round() / 255.0;
    ([0.8, 0.6, 0.2].map(byte), byte(alpha))
}

fn exact() -> Options {
    Options { beta: 0.0, ..options("exact", None) }
}

/// Two roundings to 16 bits may fall on both sides of a step of sRGB.
const BYTES: i32 = 1;

#[track_caller]
fn is_everywhere(image: &Image, expected: [u8; 4]) {
    for (i, pixel) in image.pixels.iter().enumerate() {
        let apart = pixel.iter().zip(expected).map(|(a, b)| (i32::from(*a) - i32::from(b)).abs());
        assert!(apart.max().expect("channels") <= BYTES, "{i}: {pixel:?} {expected:?}");
    }
}

fn with(marching: Marching, options: &Options) -> Options {
    Options { volumes: marching, ..options.clone() }
}

#[test]
fn nothing_in_a_volume_changes_no_bit() {
    for (name, k) in [("exact", None), ("ab-ll", None), ("dfb+sfm", None), ("skb+ofm", None)] {
        for thickness in [Thickness::World(0.5), Thickness::default()] {
            let options = Options { method: method(name), k, thickness, ..exact() };
            let panes = [pane(0.25, 0.5), pane(0.0, 0.3), pane(-3.0, 0.9)];
            for camera in [STRAIGHT, PERSPECTIVE] {
                let without = draw(&scene(camera, &panes), &options).image;
                for empty in ["density = 0.0\n", "scale = 1e-3\n"] {
                    // The small one is between all rays.
                    let mut parts = panes.to_vec();
                    parts.push(medium(1.0, 0.0, empty));
                    assert_eq!(draw(&scene(camera, &parts), &options).image, without, "{name}");
                }
            }
        }
    }
}

#[test]
fn an_even_medium_is_closed_form_whatever_the_step() {
    for (length, step) in [(1.0, 0.125), (2.0, 0.3), (0.5, 9.0), (2.5, 1e-3)] {
        let step = Some(step);
        let options = with(Marching { step, ..Marching::default() }, &exact());
        let drawn = draw(&scene(STRAIGHT, &[medium(length, 0.5, "")]), &options);
        is_everywhere(&drawn.image, expected(&[fog(length)]));
    }
}

/// In a perspective, a slanted ray is longer by the distance to its pixel at distance 1.
#[test]
fn slanted_rays_are_longer() {
    let wide = PERSPECTIVE.replace("20.0", "60.0");
    let drawn = draw(&scene(&wide, &[medium(1.0, 0.0, "")]), &exact());
    let half = libm::tan(std::f64::consts::PI / 6.0);
    for (x, y) in (0..8).flat_map(|y| (0..12).map(move |x| (x, y))) {
        let [u, v] = [(f64::from(x) + 0.5) / 4.0 - 1.5, (f64::from(y) + 0.5) / 4.0 - 1.0];
        let longer = (1.0 + half * half * (u * u + v * v)).sqrt();
        let found = drawn.image.pixel(x, y);
        let expected = expected(&[fog(longer)]);
        assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "{x} {y}");
    }
}

#[test]
fn in_front_of_behind_and_inside() {
    for name in ["exact", "dfb+sfm"] {
        // Slabs as thin as depths allow: nothing to see of their thickness.
        let options =
            Options { method: method(name), thickness: Thickness::Precision(1.0), ..exact() };
        let behind = scene(STRAIGHT, &[medium(1.0, 0.0, ""), pane(-2.0, 0.5)]);
        is_everywhere(&draw(&behind, &options).image, expected(&[fog(1.0), glass(0.5)]));
        let front = scene(STRAIGHT, &[medium(1.0, 0.0, ""), pane(2.0, 0.5)]);
        is_everywhere(&draw(&front, &options).image, expected(&[glass(0.5), fog(1.0)]));
        let opaque = scene(STRAIGHT, &[medium(1.0, 0.0, ""), pane(2.0, 1.0)]);
        is_everywhere(&draw(&opaque, &options).image, expected(&[glass(1.0)]));
        // Not between two steps.
        let inside = scene(STRAIGHT, &[medium(2.0, 0.0, ""), pane(0.3, 0.5)]);
        let layers = [fog(0.7), glass(0.5), fog(1.3)];
        is_everywhere(&draw(&inside, &options).image, expected(&layers));
    }
}

#[test]
fn extinctions_of_volumes_add_up() {
    let parts = [medium(2.0, 0.0, ""), medium(1.0, 0.75, "density = 2.0\n"), medium(0.5, -3.0, "")];
    let drawn = draw(&scene(STRAIGHT, &parts), &exact());
    is_everywhere(&drawn.image, expected(&[fog(2.0 + 2.0 * 1.0 + 0.5)]));
}

#[test]
fn the_eye_may_be_inside() {
    let drawn = draw(&scene(STRAIGHT, &[medium(20.0, 0.0, "density = 0.125\n")]), &exact());
    is_everywhere(&drawn.image, expected(&[fog(1.0)]));
    // Near plane at z = 4, box from there on back to -1.
    let drawn = draw(&scene(STRAIGHT, &[medium(8.0, 3.0, "density = 0.5\n")]), &exact());
    is_everywhere(&drawn.image, expected(&[fog(2.5)]));
}

/// The largest difference of two pictures, linear.
fn apart(a: &Image, b: &Image) -> f64 {
    let linear = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.040_45 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
    };
    let channels = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    channels.map(|(a, b)| (linear(*a) - linear(*b)).abs()).fold(0.0, f64::max)
}

fn ball() -> Scene {
    let volume = "[[volume]]\nprocedural = \"sphere\"\nn = 24\nextent = [2.0, 2.0, 2.0]\ntransfer = \"fire\"\n\
                  density = 4.0\n";
    let head = "size = [48, 48]\n[camera]\neye = [1.0, 0.7, 3.0]\ntarget = [0.0, 0.0, 0.0]\n";
    let tilted = pane(0.0, 0.5).replace("[1.0, 0.0, 0.0, 90.0]", "[1.0, 0.2, 0.0, 50.0]");
    toml(&format!("{head}{volume}{tilted}"))
}

fn at_step(step: f64, merge: bool) -> Image {
    let marching = Marching { step: Some(step), merge, ..Marching::default() };
    draw(&ball(), &with(marching, &exact())).image
}

/// Halving the step halves the distance to the limit at least, down to what a byte resolves.
#[test]
fn finer_steps_converge() {
    let limit = at_step(0.002, true);
    let errors = [0.4, 0.2, 0.1, 0.05].map(|step| apart(&at_step(step, true), &limit));
    assert!(errors.is_sorted_by(|a, b| *b <= *a * 0.6 + 0.004), "{errors:?}");
    assert!(errors[0] > 0.05 && errors[3] < 0.02, "{errors:?}");
}

/// The banding of a surface that is not merged with coarse samples.
#[test]
fn merging_is_nearer_to_the_limit() {
    let limit = at_step(0.002, true);
    assert!(apart(&at_step(0.002, false), &limit) < 0.02, "in the limit, both are the same");
    let [merged, plain] = [true, false].map(|merge| apart(&at_step(0.1, merge), &limit));
    assert!(merged * 3.0 < plain, "{merged} {plain}");
}

/// What is left out beyond the bound is less than the bound.
#[test]
fn ending_early_keeps_its_bound() {
    let scene = scene(STRAIGHT, &[medium(4.0, 0.0, "density = 3.0\n"), pane(-3.0, 1.0)]);
    let drawn = |until| draw(&scene, &with(Marching { until, ..Marching::default() }, &exact()));
    let never = drawn(0.0).image;
    assert_eq!(drawn(UNTIL).image, never);
    for until in [0.01, 0.1] {
        let early = drawn(until).image;
        assert!(apart(&early, &never) <= until + 0.005, "{until}");
        assert_ne!(early, never, "{until}");
    }
}

#[test]
fn every_number_of_threads_draws_the_same() {
    let images = [1, 2, 5].map(|threads| draw(&ball(), &Options { threads, ..exact() }).image);
    assert!(images.iter().all(|image| *image == images[0]));
}

#[test]
fn a_scene_of_volumes_alone_frames_itself() {
    let scene =
        toml("size = [9, 9]\n[[volume]]\nprocedural = \"ellipsoid\"\nn = 8\ndensity = 9.0\n");
    let drawn = draw(&scene, &exact());
    assert_eq!(drawn.report.generated, 0);
    assert_ne!(drawn.image.pixel(4, 4), drawn.image.pixel(0, 0));
}

#[test]
fn wrong_options_are_named() {
    let scene = scene(STRAIGHT, &[medium(1.0, 0.0, "")]);
    let error = |marching| render(&scene, &with(marching, &exact())).unwrap_err().to_string();
    for until in [-0.1, 1.5, f64::NAN] {
        let found = error(Marching { until, ..Marching::default() });
        assert!(found.starts_with("--volume-until"), "{found}");
    }
    for step in [0.0, -1.0, f64::INFINITY, 1e-9] {
        let found = error(Marching { step: Some(step), ..Marching::default() });
        assert!(found.starts_with("--volume-step"), "{found}");
    }
}
