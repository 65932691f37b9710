//! Well-known models through every executor, where they lie beside the checkout (skipped with a line where not).
//! `battery.rs` and `same_bytes.rs` check the same on procedural scenes, and are never skipped.

mod support;

use fragloom::num::depth::Format;
use fragloom::render::{Data, Exec, Options, Policy, Rendering, Report, Sim};
use fragloom::scene::Scene;
use fragloom::scheme::catalogue::contract;
use fragloom::scheme::contract::Keeps;
use fragloom::scheme::{Contract, Form, contracts};
use support::{draw, model, options};

fn executors() -> [Exec; 3] {
    let sim = Sim {
        policy: Policy::Random,
        seed: 2,
        resident: 1_024,
        record: false,
        watch: None,
        check: false,
    };
    [Exec::Tile, Exec::Threads, Exec::Sim(sim)]
}

fn drawn(
    scene: &Scene,
    method: &str,
    k: Option<u32>,
    exec: Exec,
    (depth, data): (Format, Data),
) -> Rendering {
    let depth_format = Some(depth);
    draw(scene, &Options { exec, depth_format, data, counters: false, ..options(method, k) })
}

fn balances(report: &Report) -> bool {
    let dropped: u64 = report.dropped.values().sum();
    report.generated + report.duplicated + report.torn
        == report.kept + report.merged + report.culled + report.evicted + dropped
}

/// These methods on every executor balance, and give what the oracle gives if their contract says so.
fn check(name: &str, methods: &[&'static Contract]) {
    let Some(scene) = model(name, [256, 256]) else { return };
    let words = (Format::D32, Data::Color);
    let generated = drawn(&scene, "exact", None, Exec::Tile, words).report.generated;
    // The ribbons are much thinner than a pixel here.
    assert!(generated > 5_000, "{name}: {generated}");
    for contract in methods {
        let k = contract.default_k;
        let data = contract.data.unwrap_or_default();
        let words = (contract.depth_format.unwrap_or_default(), data);
        let exact = drawn(&scene, "exact", contract.reference_k(k), Exec::Tile, words);
        let expected = exact.lists.cut(|keys| contract.keep(keys, k));
        for exec in executors() {
            let found = drawn(&scene, contract.name, k, exec, words);
            let (lists, found) = (found.lists, found.report);
            let what = format!("{name} {} {}", contract.name, found.exec);
            assert_eq!(found.generated, generated, "{what}");
            assert!(balances(&found) && found.violations.is_empty(), "{what}: {found:?}");
            // Published forms that keep one of every depth, or lose some, say so.
            let partly = matches!(contract.keeps, Keeps::Layers | Keeps::Some);
            if !contract.order_independent() || partly {
                continue;
            }
            assert!(lists == expected, "{what}");
            // Of fragments that are alike, one is kept by contract.
            if contract.identical {
                assert_eq!(found.image_hash, exact.report.image_hash, "{what}");
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
