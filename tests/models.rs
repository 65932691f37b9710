//! Well-known models through every executor, where they lie beside the checkout (skipped with a line where not).
//! `battery.rs` and `same_bytes.rs` check the same on procedural scenes, and are never skipped.

mod support;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::render::{Exec, Options, Policy, Report, Sim, reference};
use fragloom::scheme::contract::Keeps;
use support::{draw, method, model};

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

fn balances(report: &Report) -> bool {
    let dropped: u64 = report.dropped.values().sum();
    report.generated + report.duplicated + report.torn
        == report.kept + report.merged + report.culled + report.evicted + dropped
}

/// These methods on every executor balance, and give what the oracle gives if their contract says so.
fn check(name: &str, methods: &[Method]) {
    let Some(scene) = model(name, [256, 256]) else { return };
    let plain = Options { counters: false, threads: 2, ..Options::default() };
    let generated = draw(&scene, &plain.exact(None)).report.generated;
    // The ribbons are much thinner than a pixel here.
    assert!(generated > 5_000, "{name}: {generated}");
    for &method in methods {
        let contract = method.contract();
        let options = Options { method, k: contract.default_k, ..plain.clone() };
        let expected = reference(&scene, &options).expect("a reference").kept;
        let exact = draw(&scene, &options.exact(contract.reference_k(options.k)));
        for exec in executors() {
            let found = draw(&scene, &Options { exec, ..options.clone() });
            let (kept, found) = (found.kept, found.report);
            let what = format!("{name} {method} {}", found.exec);
            assert_eq!(found.generated, generated, "{what}");
            assert!(balances(&found) && found.violations.is_empty(), "{what}: {found:?}");
            // Published forms that keep one of every depth, or lose some, say so.
            let partly = matches!(contract.keeps, Keeps::Layers | Keeps::Some);
            if !contract.order_independent() || partly {
                continue;
            }
            assert!(Some(&kept) == expected.as_ref(), "{what}");
            // Of fragments that are alike, one is kept by contract; and no single k gives the picture of a k per pixel, of
            // a depth, of merged records, or of an approximation.
            let single =
                !matches!(contract.keeps, Keeps::NearestChosen | Keeps::Bound | Keeps::Merged);
            if contract.keeps_alike() && single && !contract.keeps.is_approximate() {
                assert_eq!(found.image_hash, exact.report.image_hash, "{what}");
            }
        }
    }
}

/// One method of each kind.
fn check_some(name: &str) {
    let some = ["ab-ll", "kplus-array", "z-buffer"].map(method);
    check(name, &some);
}

/// All of them.
fn check_all(name: &str) {
    let catalogue = Catalogue::built_in();
    check(name, &catalogue.promised().collect::<Vec<_>>());
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
