//! Well-known models through every executor, where they lie beside the checkout (skipped with a line where not).
//! `battery.rs` and `same_bytes.rs` check the same on procedural scenes, and are never skipped.

mod support;

use std::path::{Path, PathBuf};

use fragloom::num::depth::Format;
use fragloom::render::{Exec, Options, Policy, Report, Sim};
use fragloom::scene::Scene;
use support::{draw, options, scene};

/// The model at 256x256, or `None` and a line that says so.
fn model(name: &str) -> Option<Scene> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("FRAGLOOM_MODELS").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        println!("skipped: there is no {}", path.display());
        return None;
    }
    Some(scene(path.to_str().expect("a path in UTF-8"), [256, 256]))
}

/// A method, and the reference that keeps as much.
const PAIRS: [(&str, Option<u32>, Option<u32>); 3] =
    [("ab-ll", None, None), ("kplus-array", Some(8), Some(8)), ("z-buffer", None, Some(1))];

fn executors() -> [Exec; 3] {
    let sim = Sim { policy: Policy::Random, seed: 2, resident: 1_024, record: false, watch: None };
    [Exec::Tile, Exec::Threads, Exec::Sim(sim)]
}

fn report(scene: &Scene, method: &str, k: Option<u32>, exec: Exec) -> Report {
    let depth_format = Some(Format::D32);
    draw(scene, &Options { exec, depth_format, counters: false, ..options(method, k) }).report
}

fn balances(report: &Report) -> bool {
    let dropped: u64 = report.dropped.values().sum();
    report.generated + report.duplicated + report.torn
        == report.kept + report.merged + report.culled + report.evicted + dropped
}

/// Every method on every executor gives what the oracle gives.
fn check(name: &str) {
    let Some(scene) = model(name) else { return };
    let generated = report(&scene, "exact", None, Exec::Tile).generated;
    // The ribbons are much thinner than a pixel here.
    assert!(generated > 5_000, "{name}: {generated}");
    for (method, k, reference_k) in PAIRS {
        let exact = report(&scene, "exact", reference_k, Exec::Tile);
        for exec in executors() {
            let found = report(&scene, method, k, exec);
            let what = format!("{name} {method} {}", found.exec);
            assert_eq!(found.generated, generated, "{what}");
            assert!(balances(&found) && found.violations.is_empty(), "{what}: {found:?}");
            assert_eq!(found.fragments_hash, exact.fragments_hash, "{what}");
            assert_eq!(found.image_hash, exact.image_hash, "{what}");
        }
    }
}

#[test]
fn dragon() {
    check("dragon.obj");
}

#[test]
fn sponza() {
    check("sponza/Sponza.gltf");
}

#[test]
fn hair_ribbons() {
    check("hair_ribbons.obj");
}

#[test]
fn spot() {
    check("spot.obj");
}

#[test]
fn teapot() {
    check("teapot.obj");
}

#[test]
fn bunny() {
    check("bunny.obj");
}
