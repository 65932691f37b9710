//! Effects against answers that do not come from them: closed forms, and sets of intervals.
//!
//! * Media: the law of Beer and Lambert on slabs whose thickness is known.
//! * CSG: intervals of every object along every ray, from the exact fragments, and algebra on sets of intervals.
//! * Layered depth images: even parity of closed meshes; voxels one by one.
//! * Shadows: the colour words of a floor below panes of glass.
//! * Volumes: the law of Beer and Lambert, around surfaces.
//! * Ambient occlusion and depth of field: what changes nothing, and a corner and a blur in closed form.
//! * What a user meets: warnings and errors.

mod csg;
mod faults;
mod ldi;
mod media;
mod screen;
mod shadows;
#[path = "../support/mod.rs"]
mod support;
mod volumes;

use fragloom::render::{Effect, Exec, Options, Policy};
use fragloom::scene::{self, Overrides, Scene};
use support::{options, sim};

/// A pane of 2 x 2 around the origin, facing up.
const PANE: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";

/// The scene of a scene file's text, beside which `pane.obj` lies.
fn toml(text: &str) -> Scene {
    let dir = tempfile::tempdir().expect("a folder");
    std::fs::write(dir.path().join("pane.obj"), PANE).expect("written");
    let path = dir.path().join("scene.toml");
    std::fs::write(&path, text).expect("written");
    scene::load(path.to_str().expect("UTF-8"), &Overrides::default()).expect("a scene")
}

/// Options for a method and an effect.
fn effect(method: &str, effect: Effect) -> Options {
    let needs = effect.needs_primitives();
    let data = if needs { fragloom::render::Data::Primitive } else { Default::default() };
    Options { effect, data, ..options(method, None) }
}

/// Methods that keep everything here, on each executor.
fn runs() -> Vec<(&'static str, Exec)> {
    let executors = [Exec::Tile, Exec::Threads, sim(Policy::Random, 3)];
    let methods = ["exact", "ab-ll", "ab-array", "s-buffer", "kplus-array"];
    methods.iter().flat_map(|&m| executors.iter().map(move |e| (m, e.clone()))).collect()
}

/// The sRGB byte of a linear 16-bit value, by decoding the limits between bytes (IEC 61966-2-1).
fn srgb(value: u64) -> u8 {
    let linear = |encoded: f64| {
        if encoded <= 0.040_45 {
            encoded / 12.92
        } else {
            libm::pow((encoded + 0.055) / 1.055, 2.4)
        }
    };
    let value = value as f64 / 65_535.0;
    (0..255).find(|&byte| value < linear((f64::from(byte) + 0.5) / 255.0)).unwrap_or(255)
}
