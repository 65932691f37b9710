//! Media of known thickness.

use fragloom::num::depth::Format;
use fragloom::render::{Effect, Options};
use fragloom::scene::Scene;

use super::support::draw;
use super::{effect, runs, srgb, toml};

const COLOR: [f64; 3] = [0.2, 0.6, 0.95];
const ALPHA: f64 = 0.4;
const BACKGROUND: [f64; 3] = [0.9, 0.8, 0.7];

const MEDIA: Effect = Effect::Media { density: 1.0 };

/// Seen straight on, with parallel rays.
const STRAIGHT: &str =
    "eye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\northo_height = 3.0\nnear = 1.0\nfar = 9.0\n";

/// As above, with a camera and boxes: depth and place on the line of sight.
fn slabs(camera: &str, slabs: &[[f64; 2]], more: &str) -> Scene {
    let mut text = format!(
        "size = [24, 24]\nbackground = {BACKGROUND:?}\n[camera]\n{camera}\
         [[material]]\nname = \"m\"\ncolor = {COLOR:?}\nalpha = {ALPHA}\n\
         [[material]]\nname = \"wall\"\ncolor = [0.5, 0.25, 1.0]\nalpha = 1.0\nshading = \"flat\"\n"
    );
    for [depth, place] in slabs {
        text += &format!(
            "[[object]]\nprocedural = \"box\"\nx = 20.0\ny = 20.0\nz = {depth}\nmaterial = \"m\"\n\
             translate = [0.0, 0.0, {place}]\n"
        );
    }
    toml(&(text + more))
}

/// What a thickness leaves of light, as the documentation has it: (1 - a) (1 - a (1 - c)) per world unit.
fn expected(thickness: f64, light: [f64; 3]) -> [u8; 4] {
    let channel = |i: usize| {
        let a = f64::from(ALPHA as f32);
        let c = f64::from(COLOR[i] as f32);
        let transmitted = libm::pow((1.0 - a) * (1.0 - a * (1.0 - c)), thickness);
        let light = (f64::from(light[i] as f32) * 65_535.0).round() as u64;
        srgb(((transmitted * 65_535.0).round() as u64 * light + 32_767) / 65_535)
    };
    [channel(0), channel(1), channel(2), 255]
}

#[track_caller]
fn is_everywhere(scene: &Scene, options: &Options, expected: [u8; 4]) {
    let image = draw(scene, options).image;
    assert!(
        image.pixels.iter().all(|&pixel| pixel == expected),
        "{:?} {expected:?}",
        image.pixel(9, 9)
    );
}

#[test]
fn a_slab_seen_straight_on() {
    for (thickness, density) in [(0.25, 1.0), (1.0, 1.0), (2.5, 1.0), (0.5, 3.0), (2.0, 0.0)] {
        let scene = slabs(STRAIGHT, &[[thickness, 0.0]], "");
        let right = expected(thickness * density, BACKGROUND);
        for format in Format::ALL {
            let options = effect("exact", Effect::Media { density });
            is_everywhere(&scene, &Options { depth_format: Some(format), ..options }, right);
        }
    }
}

#[test]
fn every_method_and_executor_sees_the_same_media() {
    let scene = slabs(STRAIGHT, &[[1.0, 0.0], [0.5, 2.0]], "");
    for (method, exec) in runs() {
        is_everywhere(
            &scene,
            &Options { exec, ..effect(method, MEDIA) },
            expected(1.5, BACKGROUND),
        );
    }
}

#[test]
fn media_in_each_other_multiply() {
    is_everywhere(
        &slabs(STRAIGHT, &[[3.0, 0.0], [1.0, 0.0], [1.0, 1.25]], ""),
        &effect("ab-ll", MEDIA),
        expected(5.0, BACKGROUND),
    );
}

#[test]
fn an_opaque_surface_ends_the_ray() {
    let wall = "[[object]]\nprocedural = \"box\"\nx = 9.0\ny = 9.0\nz = 0.5\nmaterial = \"wall\"\n\
                translate = [0.0, 0.0, 0.25]\n";
    // Its front is at 0.5, within the first slab, which reaches from 1 to -1; the second is behind it.
    let scene = slabs(STRAIGHT, &[[2.0, 0.0], [1.0, -2.0]], wall);
    let light = [128.0 / 255.0, 64.0 / 255.0, 1.0];
    is_everywhere(&scene, &effect("ab-ll", MEDIA), expected(0.5, light));
}

/// Rays of a perspective are longer the more oblique they are.
#[test]
fn a_slab_in_perspective() {
    let camera =
        "eye = [0.0, 0.0, 5.0]\ntarget = [0.0, 0.0, 0.0]\nfov_y = 60.0\nnear = 1.0\nfar = 9.0\n";
    let image = draw(&slabs(camera, &[[1.5, 0.0]], ""), &effect("ab-ll", MEDIA)).image;
    let half = libm::tan(std::f64::consts::PI / 6.0);
    for (x, y) in (0..24).flat_map(|y| (0..24).map(move |x| (x, y))) {
        let [u, v] = [x, y].map(|p| ((f64::from(p) + 0.5) / 12.0 - 1.0) * half);
        let long = 1.5 * libm::sqrt(1.0 + u * u + v * v);
        assert_eq!(image.pixel(x, y), expected(long, BACKGROUND), "{x} {y}");
    }
}

#[test]
fn open_objects_are_counted_and_the_rest_is_drawn() {
    let mut scene = slabs(STRAIGHT, &[[1.0, 0.0], [0.5, 2.0]], "");
    let closed = draw(&scene, &effect("ab-ll", MEDIA)).report;
    assert!(closed.open_pixels.is_empty() && closed.warnings.is_empty(), "{:?}", closed.warnings);
    // Without its face towards the viewer, triangles 2 and 3, the first is left without being entered.
    let mesh = std::sync::Arc::make_mut(&mut scene.objects[0].mesh);
    mesh.triangles.drain(2..4);
    let drawn = draw(&scene, &effect("ab-ll", MEDIA));
    assert_eq!(drawn.report.open_pixels, [("a".to_owned(), 576)].into());
    assert!(drawn.report.warnings[0].starts_with("object 'a' is not closed: 576 pixels"));
    assert!(drawn.image.pixels.iter().all(|&pixel| pixel == expected(0.5, BACKGROUND)));
}
