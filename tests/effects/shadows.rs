//! The colours of a floor below panes of glass.

use fragloom::effect::csg::Expression;
use fragloom::render::{CullFace, Data, Effect, Options, Shadows};
use fragloom::scene::{Scene, Shading};
use glam::DVec3;

use super::support::{draw, lists, method, options, scene};
use super::{runs, toml};

const WHITE: [f64; 3] = [0.8, 0.8, 0.8];
const AMBIENT: f64 = 0.25;

/// A pane: its material, and where its middle is; each reaches 1 to every side.
struct Pane {
    color: [f64; 3],
    alpha: f64,
    at: [f64; 3],
}

const RED: Pane = Pane { color: [0.9, 0.2, 0.1], alpha: 0.5, at: [0.0, 1.0, 0.0] };
const BLUE: Pane = Pane { color: [0.1, 0.3, 1.0], alpha: 0.3, at: [1.0, 2.0, 0.5] };
const BLACK: Pane = Pane { color: [0.5, 0.5, 0.5], alpha: 1.0, at: [0.0, 1.5, -0.5] };

/// A floor at y = 0 seen from straight above, with panes over it.
fn floor(towards: [f64; 3], panes: &[&Pane]) -> Scene {
    let mut text = format!(
        "size = [48, 48]\n[camera]\neye = [0.0, 6.0, 0.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, -1.0]\n\
         ortho_height = 8.0\n[light]\ntowards = {towards:?}\nambient = {AMBIENT}\n\
         [[material]]\nname = \"floor\"\ncolor = {WHITE:?}\nalpha = 1.0\n\
         [[object]]\nname = \"floor\"\nfile = \"pane.obj\"\nmaterial = \"floor\"\nscale = 5.0\n"
    );
    for (i, Pane { color, alpha, at }) in panes.iter().enumerate() {
        text += &format!(
            "[[material]]\nname = \"{i}\"\ncolor = {color:?}\nalpha = {alpha}\n\
             [[object]]\nfile = \"pane.obj\"\nmaterial = \"{i}\"\ntranslate = {at:?}\n"
        );
    }
    toml(&text)
}

fn byte(c: f64) -> f64 {
    (c * 255.0 + 0.5).floor()
}

/// What these panes leave of the light, by the documentation's real formula; each is rounded to 16 bits.
fn left(panes: &[&Pane]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let light = panes.iter().fold(65_535.0, |light, pane| {
            let [a, c] = [pane.alpha, pane.color[i]].map(|share| byte(share) / 255.0);
            (light * (1.0 - a) * (1.0 - a * (1.0 - c))).round()
        });
        light / 65_535.0
    })
}

/// The floor's word in light that these panes filter.
fn word(towards: [f64; 3], panes: &[&Pane]) -> u32 {
    let cosine = DVec3::from(towards).normalize().y;
    let left = left(panes);
    let channel = |i: usize| byte(WHITE[i] * (AMBIENT + (1.0 - AMBIENT) * cosine * left[i])) as u8;
    u32::from_le_bytes([channel(0), channel(1), channel(2), 255])
}

/// Whether the floor's point is in a pane's shadow: inside by a margin, outside by one, or `None`.
fn shadowed(towards: [f64; 3], pane: &Pane, x: f64, z: f64) -> Option<bool> {
    const MARGIN: f64 = 0.1;
    let up = pane.at[1] / towards[1];
    let [dx, dz] = [x + towards[0] * up - pane.at[0], z + towards[2] * up - pane.at[2]];
    let reach = dx.abs().max(dz.abs());
    ((reach - 1.0).abs() > MARGIN).then_some(reach < 1.0)
}

/// Check every pixel's floor word; how many are in no shadow, and in that of one pane, two, ...
#[track_caller]
fn check(towards: [f64; 3], panes: &[&Pane], options: &Options) -> Vec<usize> {
    let scene = floor(towards, panes);
    let lists = lists(&scene, options);
    let mut found = vec![0; panes.len() + 1];
    for (x, y) in (0..48).flat_map(|y| (0..48).map(move |x| (x, y))) {
        let [px, pz] = [x, y].map(|p| (f64::from(p) + 0.5) / 6.0 - 4.0);
        let over: Option<Vec<bool>> =
            panes.iter().map(|pane| shadowed(towards, pane, px, pz)).collect();
        let Some(over) = over else { continue };
        // The light meets the highest pane first.
        let mut above: Vec<&Pane> =
            panes.iter().zip(&over).filter(|(_, over)| **over).map(|(pane, _)| *pane).collect();
        above.sort_by(|a, b| b.at[1].total_cmp(&a.at[1]));
        found[above.len()] += 1;
        let last = *lists.pixel(x, y).last().expect("the floor");
        assert_eq!(last as u32, word(towards, &above), "{x} {y}: {:08x}", last as u32);
    }
    found
}

fn shadows() -> Options {
    let shadows = Some(Shadows { size: Some(256), bias: None });
    Options { shadows, ..options("ab-ll", None) }
}

const STRAIGHT: [f64; 3] = [0.0, 1.0, 0.0];
const OBLIQUE: [f64; 3] = [0.5, 1.0, 0.25];

#[test]
fn a_pane_throws_its_colour() {
    for towards in [STRAIGHT, OBLIQUE] {
        let found = check(towards, &[&RED], &shadows());
        assert!(found[0] > 1_500 && found[1] > 80, "{found:?}");
    }
}

#[test]
fn two_panes_multiply_and_an_opaque_one_ends_the_light() {
    for towards in [STRAIGHT, OBLIQUE] {
        let found = check(towards, &[&RED, &BLUE], &shadows());
        assert!(found.iter().all(|&pixels| pixels > 20), "{found:?}");
        let found = check(towards, &[&RED, &BLUE, &BLACK], &shadows());
        assert!(found.iter().all(|&pixels| pixels > 5), "{found:?}");
        let dark = word(towards, &[&BLACK]).to_le_bytes();
        assert_eq!(f64::from(dark[0]), byte(WHITE[0] * AMBIENT), "only ambient light is left");
    }
}

/// Negative control: without shadows, the check fails.
#[test]
#[should_panic(expected = "assertion `left == right` failed")]
fn without_shadows_it_is_seen() {
    check(OBLIQUE, &[&RED], &Options { shadows: None, ..shadows() });
}

#[test]
fn every_method_and_executor_draws_the_same_picture() {
    let scene = floor(OBLIQUE, &[&RED, &BLUE]);
    let first = draw(&scene, &shadows());
    for (method, exec) in runs() {
        for data in [Data::Color, Data::Primitive] {
            let options =
                Options { method: self::method(method), exec: exec.clone(), data, ..shadows() };
            let drawn = draw(&scene, &options);
            assert_eq!(drawn.image, first.image, "{method} {data:?}");
            let [map, expected] = [&drawn, &first].map(|drawn| drawn.report.shadows.clone());
            assert_eq!(map.expect("a map"), expected.expect("a map"), "{method}");
            if data == Data::Color {
                assert_eq!(
                    *drawn.lists().expect("lists"),
                    *first.lists().expect("lists"),
                    "{method}"
                );
            }
        }
    }
}

/// Where nothing stands in the light, shading is the same to the bit: by face normals, by those of vertices, in every
/// way of shading.
#[test]
fn light_that_is_not_attenuated_is_the_same_light() {
    for source in ["sphere:sides=24", "box"] {
        for shading in [Shading::Flat, Shading::Lambert, Shading::Gooch] {
            let mut convex = scene(source, [48, 40]);
            convex.materials[0].shading = shading;
            let plain = Options { cull_face: CullFace::Back, ..options("ab-ll", None) };
            let without = lists(&convex, &plain);
            // A bias as large as the object leaves nothing in front.
            let far = Some(Shadows { size: None, bias: Some(1e3) });
            let with = lists(&convex, &Options { shadows: far, ..plain.clone() });
            assert_eq!(without, with, "{source} {shading:?}");
            let near = Some(Shadows { size: None, bias: Some(0.0) });
            let attenuated = lists(&convex, &Options { shadows: near, ..plain });
            assert_eq!(attenuated == without, shading == Shading::Flat, "{source} {shading:?}");
        }
    }
}

/// The default bias keeps the lit side of convex bodies free of their own shadow: where the light is not grazing.
#[test]
fn surfaces_do_not_shadow_themselves() {
    let mut ball = scene("sphere:sides=64", [64, 64]);
    ball.light.towards = (ball.camera.eye - ball.camera.target).normalize();
    let plain = Options { cull_face: CullFace::Back, ..options("ab-ll", None) };
    let without = lists(&ball, &plain);
    let with = lists(&ball, &Options { shadows: Some(Shadows::default()), ..plain });
    let apart = without.entries.iter().zip(&with.entries).filter(|(a, b)| a != b).count();
    // The outer tenth of the radius is met at more than 64 degrees.
    assert!(apart * 10 < without.entries.len(), "{apart} of {}", without.entries.len());
}

/// A box over the floor throws a shadow, unless another box cuts it away.
#[test]
fn what_is_cut_away_throws_no_shadow() {
    let mut scene = floor(STRAIGHT, &[]);
    // Straight light, seen obliquely.
    scene.camera.eye = DVec3::new(0.0, 5.0, 4.0);
    for (name, place, [edge, height]) in
        [("table", -0.5, [8.0, 0.9]), ("block", 1.0, [1.0, 0.9]), ("knife", 1.0, [1.5, 1.2])]
    {
        let source = format!("box:x={edge},y={height},z={edge}");
        let mut object = self::scene(&source, [8, 8]).objects.remove(0);
        object.name = name.to_owned();
        object.transform = glam::DMat4::from_translation(DVec3::new(0.0, place, 0.0));
        scene.objects.push(object);
    }
    (scene.camera.near, scene.camera.far) = (-10.0, 20.0);
    let image = |text: &str, shadows| {
        let effect = Effect::Csg(Expression::parse(text).expect("right"));
        draw(&scene, &Options { shadows, ..super::effect("ab-ll", effect) }).image
    };
    let shadows = Some(Shadows::default());
    assert_eq!(image("table | block - knife", shadows), image("table", None));
    assert_ne!(image("table | block", shadows), image("table | block", None));
}
