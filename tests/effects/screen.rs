//! Ambient occlusion and depth of field: what must change nothing, and a step and an edge in closed form.

use std::f64::consts::PI;

use fragloom::effect::screen::occlusion::BIAS;
use fragloom::image::Image;
use fragloom::num::depth::Format;
use fragloom::render::{Data, Effect, Focus, Occlusion, Options, Screen, render};
use fragloom::scene::{Scene, Thickness};

use super::support::{draw, method, options, small_scenes};
use super::toml;

const PARALLEL: &str = "ortho_height = 4.0";
const PERSPECTIVE: &str = "fov_y = 40.0";

/// Looking along -z from z = 5.
fn head(size: [u32; 2], projection: &str) -> String {
    format!(
        "size = {size:?}\nbackground = [0.0, 0.0, 0.0]\n[camera]\neye = [0.0, 0.0, 5.0]\n\
         target = [0.0, 0.0, 0.0]\n{projection}\nnear = 0.5\nfar = 20.0\n"
    )
}

/// A white pane of half a side across the line of sight; `more` turns or thickens it.
fn pane(at: [f64; 3], half: f64, alpha: f64, more: &str) -> String {
    let name = format!("{at:?} {half} {alpha}");
    let more = if more.contains("rotate") {
        more.to_owned()
    } else {
        format!("rotate = [1.0, 0.0, 0.0, 90.0]\n{more}")
    };
    format!(
        "[[material]]\nname = \"{name}\"\ncolor = [1.0, 1.0, 1.0]\nalpha = {alpha}\nshading = \"flat\"\n\
         [[object]]\nfile = \"pane.obj\"\nmaterial = \"{name}\"\nscale = {half}\ntranslate = {at:?}\n{more}\n"
    )
}

fn scene(size: [u32; 2], projection: &str, parts: &[String]) -> Scene {
    toml(&(head(size, projection) + &parts.concat()))
}

fn with(screen: Screen, name: &str) -> Options {
    Options { method: method(name), effect: Effect::Screen(screen), ..options("exact", None) }
}

fn ao(radius: f64) -> Screen {
    let occlusion = Occlusion { radius: Some(radius), ..Occlusion::default() };
    Screen { occlusion: Some(occlusion), focus: None }
}

fn dof(aperture: f64, distance: f64) -> Screen {
    let (aperture, distance) = (Some(aperture), Some(distance));
    Screen { occlusion: None, focus: Some(Focus { aperture, distance, samples: 16 }) }
}

/// The picture without an effect.
fn plain(scene: &Scene, options: &Options) -> Image {
    draw(scene, &Options { effect: Effect::Transparency, ..options.clone() }).image
}

fn linear(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

const METHODS: [&str; 5] = ["exact", "ab-ll", "dfb+sfm", "dfb+ofm", "skb+ofm"];

#[test]
fn no_radius_and_no_aperture_change_no_bit() {
    let focus = dof(0.0, 3.0).focus;
    let both = Screen { focus, ..ao(0.0) };
    for scene in small_scenes() {
        for name in METHODS {
            for screen in [ao(0.0), dof(0.0, 3.0), both] {
                let options = with(screen, name);
                assert_eq!(draw(&scene, &options).image, plain(&scene, &options), "{name}");
            }
        }
        let options = Options { data: Data::Primitive, ..with(both, "ab-ll") };
        assert_eq!(draw(&scene, &options).image, plain(&scene, &options), "primitives");
    }
}

#[test]
fn a_plane_does_not_occlude_itself() {
    for turn in ["1.0, 0.0, 0.0, 90.0", "1.0, 0.3, 0.1, 55.0", "1.0, 0.0, 0.2, 20.0"] {
        let plane = pane([0.0; 3], 30.0, 1.0, &format!("rotate = [{turn}]"));
        for projection in [PARALLEL, PERSPECTIVE] {
            let scene = scene([40, 30], projection, std::slice::from_ref(&plane));
            for format in Format::ALL {
                let depth_format = Some(format);
                let options = Options { depth_format, ..with(ao(0.7), "exact") };
                let drawn = draw(&scene, &options).image;
                assert_eq!(drawn, plain(&scene, &options), "{turn} {projection} {format:?}");
            }
        }
        // A thick plane is a front over a back, which the front does not see.
        let scene = scene([40, 30], PERSPECTIVE, &[plane]);
        let thickness = Thickness::World(0.25);
        let options = Options { thickness, ..with(ao(0.7), "dfb+sfm") };
        assert_eq!(draw(&scene, &options).image, plain(&scene, &options), "{turn}, thick");
    }
}

/// What a step of height h takes from a floor at distance a from its edge, by the definition for endless directions and
/// steps, in integrals.
fn step(a: f64, h: f64, radius: f64) -> f64 {
    const PARTS: u32 = 20_000;
    let part = |i: u32| {
        let angle = PI * ((f64::from(i) + 0.5) / f64::from(PARTS) - 0.5);
        let far = a / libm::cos(angle);
        let squared = far * far + h * h;
        let falloff = (1.0 - squared / (radius * radius)).max(0.0);
        falloff * (h / squared.sqrt() - BIAS).max(0.0)
    };
    (0..PARTS).map(part).sum::<f64>() / f64::from(PARTS) / 2.0
}

/// Values of the floor along the middle row, from the edge at x = 0 to the left, against the closed form.
#[track_caller]
fn is_a_step(scene: &Scene, options: &Options, h: f64, radius: f64) {
    let image = draw(scene, options).image;
    for x in [20, 40, 60, 70, 76] {
        let a = (80.0 - (f64::from(x) + 0.5)) * 4.0 / 160.0;
        let found = 1.0 - linear(image.pixel(x, 80)[0]);
        let expected = step(a, h, radius);
        assert!((found - expected).abs() < 0.02, "{x}: {found} {expected}");
    }
    let far = image.pixel(2, 80)[0];
    assert_eq!(far, 255, "out of reach");
}

fn fine(radius: f64) -> Screen {
    let (directions, steps) = (64, 64);
    let occlusion = Occlusion { radius: Some(radius), directions, steps, seed: 7 };
    Screen { occlusion: Some(occlusion), focus: None }
}

#[test]
fn a_step_occludes_the_floor_below_it() {
    let floor = pane([-50.0, 0.0, 0.0], 50.0, 1.0, "");
    let block = pane([50.0, 0.0, 0.5], 50.0, 1.0, "");
    let step = scene([160, 160], PARALLEL, &[floor.clone(), block.clone()]);
    is_a_step(&step, &with(fine(1.2), "exact"), 0.5, 1.2);
    // Behind a layer that cannot be seen and is out of reach, it is the same: all layers count.
    let veil = pane([0.0, 0.0, 3.0], 50.0, 0.0, "");
    let veiled = scene([160, 160], PARALLEL, &[floor, block, veil]);
    is_a_step(&veiled, &with(fine(1.2), "ab-ll"), 0.5, 1.2);
}

/// The front of a thick record occludes like a surface there.
#[test]
fn a_thick_record_occludes_with_its_front() {
    let floor = pane([-50.0, 0.0, 0.0], 50.0, 1.0, "thickness = 0.0");
    let thick = pane([50.0, 0.0, 0.0], 50.0, 1.0, "thickness = 0.5");
    let scene = scene([160, 160], PARALLEL, &[floor, thick]);
    is_a_step(&scene, &with(fine(1.2), "dfb+sfm"), 0.5, 1.2);
}

#[test]
fn a_plane_in_focus_is_sharp() {
    let tile = |i: i32| {
        let at = [f64::from(i % 5) * 0.7 - 1.4, f64::from(i / 5) * 0.7 - 1.0, 0.0];
        pane(at, 0.3, 0.2 + 0.05 * f64::from(i), "")
    };
    let tiles: Vec<String> = (0..15).map(tile).collect();
    for projection in [PARALLEL, PERSPECTIVE] {
        let scene = scene([60, 50], projection, &tiles);
        for name in METHODS {
            // A pixel is a layer of its own distance, so the plane is in focus to the bit only up to its thickness.
            let thickness = Thickness::World(0.0);
            let options = Options { thickness, ..with(dof(1.5, 5.0), name) };
            let sharp = plain(&scene, &options);
            assert_eq!(draw(&scene, &options).image, sharp, "{name} {projection}");
            let options = with(dof(1.5, 3.0), name);
            assert_ne!(draw(&scene, &options).image, sharp, "{name} {projection}: out of focus");
        }
    }
}

#[test]
fn a_picture_that_is_the_same_everywhere_stays() {
    let panes =
        [(2.0, 0.5), (0.0, 0.3), (-4.0, 0.7)].map(|(z, a)| pane([0.0, 0.0, z], 40.0, a, ""));
    for projection in [PARALLEL, PERSPECTIVE] {
        let scene = scene([30, 20], projection, &panes);
        for name in METHODS {
            let options = with(dof(2.0, 4.0), name);
            assert_eq!(draw(&scene, &options).image, plain(&scene, &options), "{name}");
        }
    }
}

/// A half-plane out of focus: each pixel shows the share of the lens that sees it, a segment of the disc.
#[test]
fn an_edge_is_blurred_by_the_disc() {
    let edge = pane([20.0, 0.0, 0.0], 20.0, 1.0, "");
    for (projection, blur) in [
        // Half the lens, times (1 - z/f) or (1/z - 1/f), at z = 5 and f = 4, in pixels.
        (PARALLEL, 0.6 * (5.0 / 4.0 - 1.0) * 120.0 / 4.0),
        (PERSPECTIVE, 0.6 * (1.0 / 4.0 - 1.0 / 5.0) * 120.0 / 2.0 / libm::tan(PI / 9.0)),
    ] {
        let mut screen = dof(1.2, 4.0);
        screen.focus.as_mut().expect("a lens").samples = 1_024;
        let image = draw(
            &scene([120, 120], projection, std::slice::from_ref(&edge)),
            &with(screen, "exact"),
        )
        .image;
        for x in 45..75 {
            let off = ((f64::from(x) + 0.5 - 60.0) / blur).clamp(-1.0, 1.0);
            let segment = (libm::acos(-off) + off * (1.0 - off * off).sqrt()) / PI;
            let found = linear(image.pixel(x, 60)[0]);
            // A pixel is as wide as a tenth of the disc.
            let slack = 0.5 / blur * 2.0 / PI + 0.02;
            assert!((found - segment).abs() < slack, "{projection} {x}: {found} {segment}");
        }
    }
}

#[test]
fn threads_and_seeds() {
    let scene = &small_scenes()[1];
    let screen = Screen { focus: dof(0.4, 3.0).focus, ..ao(0.5) };
    let drawn =
        |threads, screen| draw(scene, &Options { threads, ..with(screen, "dfb+sfm") }).image;
    assert_eq!(drawn(1, screen), drawn(3, screen));
    let mut other = screen;
    other.occlusion.as_mut().expect("an occlusion").seed = 1;
    assert_ne!(drawn(1, screen), drawn(1, other), "the seed turns directions");
}

#[test]
fn wrong_numbers_are_named() {
    let scene = &small_scenes()[1];
    let occlusion = Occlusion::default();
    let focus = Focus::default();
    let ao = |occlusion| Screen { occlusion: Some(occlusion), focus: None };
    let dof = |focus| Screen { occlusion: None, focus: Some(focus) };
    for (screen, place) in [
        (ao(Occlusion { radius: Some(-1.0), ..occlusion }), "--effect: ao=-1"),
        (ao(Occlusion { radius: Some(f64::NAN), ..occlusion }), "--effect: ao=NaN"),
        (ao(Occlusion { directions: 0, ..occlusion }), "--ao-directions"),
        (ao(Occlusion { steps: 257, ..occlusion }), "--ao-steps"),
        (dof(Focus { aperture: Some(-1.0), ..focus }), "--aperture"),
        (dof(Focus { distance: Some(0.0), ..focus }), "--focus"),
        (dof(Focus { samples: 5_000, ..focus }), "--dof-samples"),
    ] {
        let error = render(scene, &with(screen, "exact")).unwrap_err().to_string();
        assert!(error.starts_with(place), "{error}");
    }
}

/// Volumes are not drawn with depth of field, which is said.
#[test]
fn volumes_are_left_out_with_a_warning() {
    let volume = "[[volume]]\nprocedural = \"constant\"\ndensity = 3.0\n".to_owned();
    let scene = scene([9, 9], PARALLEL, &[pane([0.0; 3], 1.0, 0.5, ""), volume]);
    let warnings = |screen| draw(&scene, &with(screen, "exact")).report.warnings;
    assert!(warnings(dof(0.1, 5.0))[0].starts_with("dof: the scene's volumes are not drawn"));
    assert!(warnings(ao(0.1)).is_empty());
}
