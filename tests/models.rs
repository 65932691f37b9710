//! Well-known models through every executor, where they lie beside the checkout (skipped with a line where not).
//! `battery.rs` and `same_bytes.rs` check the same on procedural scenes, and are never skipped.

mod support;

use std::path::{Path, PathBuf};

use fragloom::num::depth::Format;
use fragloom::render::{Exec, Options, Policy, Report, Sim};
use fragloom::scene::Scene;
use fragloom::scheme::catalogue::contract;
use fragloom::scheme::contract::Keeps;
use fragloom::scheme::{Contract, Form, contracts};
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

fn executors() -> [Exec; 3] {
    let sim = Sim { policy: Policy::Random, seed: 2, resident: 1_024, record: false, watch: None };
    [Exec::Tile, Exec::Threads, Exec::Sim(sim)]
}

fn report(scene: &Scene, method: &str, k: Option<u32>, exec: Exec, depth: Format) -> Report {
    let depth_format = Some(depth);
    draw(scene, &Options { exec, depth_format, counters: false, ..options(method, k) }).report
}

fn balances(report: &Report) -> bool {
    let dropped: u64 = report.dropped.values().sum();
    report.generated + report.duplicated + report.torn
        == report.kept + report.merged + report.culled + report.evicted + dropped
}

/// These methods on every executor balance, and give what the oracle gives if their contract says so.
fn check(name: &str, methods: &[&'static Contract]) {
    let Some(scene) = model(name) else { return };
    let generated = report(&scene, "exact", None, Exec::Tile, Format::D32).generated;
    // The ribbons are much thinner than a pixel here.
    assert!(generated > 5_000, "{name}: {generated}");
    for contract in methods {
        let k = contract.default_k;
        let depth = contract.depth_format.unwrap_or_default();
        let exact = report(&scene, "exact", contract.reference_k(k), Exec::Tile, depth);
        for exec in executors() {
            let found = report(&scene, contract.name, k, exec, depth);
            let what = format!("{name} {} {}", contract.name, found.exec);
            assert_eq!(found.generated, generated, "{what}");
            assert!(balances(&found) && found.violations.is_empty(), "{what}: {found:?}");
            // Of equal depths, one is kept by contract.
            if contract.order_independent() && contract.keeps != Keeps::Layers {
                assert_eq!(found.fragments_hash, exact.fragments_hash, "{what}");
                assert_eq!(found.image_hash, exact.image_hash, "{what}");
            }
        }
    }
}

/// One method of each kind.
fn check_some(name: &str) {
    let some = ["ab-ll", "kplus-array", "z-buffer"].map(|name| contract(name).expect("known"));
    check(name, &some);
}

/// All of them.
fn check_all(name: &str) {
    let all = contracts().into_iter().filter(|c| c.form != Form::Mutation && c.name != "exact");
    check(name, &all.collect::<Vec<_>>());
}

#[test]
fn dragon() {
    check_all("dragon.obj");
}

#[test]
fn sponza() {
    check_all("sponza/Sponza.gltf");
}

#[test]
fn hair_ribbons() {
    check_all("hair_ribbons.obj");
}

#[test]
fn spot() {
    check_some("spot.obj");
}

#[test]
fn teapot() {
    check_some("teapot.obj");
}

#[test]
fn bunny() {
    check_some("bunny.obj");
}
