//! Parity and voxels.

use fragloom::num::depth::Format;
use fragloom::render::{Effect, Options};
use fragloom::scene::Scene;

use super::support::model;
use super::support::{draw, options, scene};
use super::{effect, runs, toml};

const LDI: Effect = Effect::Ldi { voxels: None };

#[track_caller]
fn is_closed(scene: &Scene) {
    let drawn = draw(scene, &effect("ab-ll", LDI));
    assert!(drawn.report.generated > 2_000, "{}", scene.name);
    assert!(
        drawn.lists().expect("lists").offsets.windows(2).all(|ends| (ends[1] - ends[0]) % 2 == 0),
        "{}",
        scene.name
    );
    assert!(
        drawn.report.open_pixels.is_empty() && drawn.report.warnings.is_empty(),
        "{}",
        scene.name
    );
    let (black, white) = ([0, 0, 0, 255], [255; 4]);
    assert!(drawn.image.pixels.contains(&black) && drawn.image.pixels.contains(&white));
}

#[test]
fn closed_meshes_have_even_parity() {
    for source in
        ["cubes", "sphere", "box", "gears:count=4", "bottles:columns=4,rows=3,levels=2,sides=14"]
    {
        is_closed(&scene(source, [96, 80]));
    }
}

#[test]
fn closed_models_have_even_parity() {
    for name in ["spot.obj", "dragon.obj"] {
        model(name, [160, 160]).iter().for_each(is_closed);
    }
}

#[test]
fn odd_parity_is_counted_and_red() {
    let mut open = scene("cubes", [96, 80]);
    std::sync::Arc::make_mut(&mut open.objects[0].mesh).triangles.pop();
    let drawn = draw(&open, &effect("ab-ll", LDI));
    let red = drawn.image.pixels.iter().filter(|&&pixel| pixel == [255, 0, 0, 255]).count() as u64;
    assert!(red > 20);
    assert_eq!(drawn.report.open_pixels, [("scene".to_owned(), red)].into());
    let warning = format!("the scene is not closed: {red} pixels have odd parity");
    assert_eq!(drawn.report.warnings, [warning]);
}

/// A box of 2 x 2 x 2 in a view of 4 x 4 x 4: the inner half in each direction.
#[test]
fn voxels_of_a_box() {
    let scene = toml(
        "size = [16, 16]\n[camera]\neye = [0.0, 0.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\northo_height = 4.0\n\
         near = 1.0\nfar = 5.0\n[[object]]\nprocedural = \"box\"\nx = 2.0\ny = 2.0\nz = 2.0\n",
    );
    for (method, exec) in runs() {
        let options = Options { exec, ..effect(method, Effect::Ldi { voxels: Some(8) }) };
        let drawn = draw(&scene, &options);
        let voxels = drawn.voxels.as_ref().expect("asked for");
        assert_eq!((voxels.width, voxels.height, voxels.slices), (16, 16, 8));
        assert_eq!(drawn.report.solid_voxels, Some(8 * 8 * 4), "{method}");
        for (i, &inside) in voxels.inside.iter().enumerate() {
            let [x, y, slice] = [i % 16, i / 16 % 16, i / 256];
            let within = (4..12).contains(&x) && (4..12).contains(&y) && (2..6).contains(&slice);
            assert_eq!(inside, u8::from(within), "{x} {y} {slice}");
        }
    }
}

/// One by one, from the exact lists, in every depth format.
#[test]
fn voxels_follow_the_parity_rule() {
    for format in Format::ALL {
        let options = Options { depth_format: Some(format), ..options("exact", None) };
        let cubes = scene("cubes", [40, 32]);
        let effect = Effect::Ldi { voxels: Some(21) };
        let drawn = draw(&cubes, &Options { effect, ..options });
        let voxels = drawn.voxels.as_ref().expect("asked for");
        assert!(voxels.solid() > 500);
        for (i, &inside) in voxels.inside.iter().enumerate() {
            let [x, y, slice] = [i % 40, i / 40 % 32, i / 1_280];
            let before = |word: u64| match format {
                // In units of 1 / (2^32 - 1) and 42.
                Format::D32 => 42 * word < (2 * slice as u64 + 1) * u64::from(u32::MAX),
                _ => format.decode(word as u32) < (slice as f64 + 0.5) / 21.0,
            };
            let keys = drawn.lists().expect("lists").pixel(x as u32, y as u32);
            let count = keys.iter().filter(|&&key| before(key >> 32)).count();
            assert_eq!(usize::from(inside), count % 2, "{x} {y} {slice}");
        }
    }
}
