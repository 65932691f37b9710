//! What several test files share.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::path::{Path, PathBuf};

use fragloom::catalogue;
use fragloom::exec::Method;
use fragloom::render::{Exec, Lists, Options, Policy, Rendering, Sim, render};
use fragloom::scene::{self, Overrides, Scene};
use fragloom::scheme::Contract;

/// A built-in or bundled scene at a size.
pub(crate) fn scene(source: &str, size: [u32; 2]) -> Scene {
    let overrides = Overrides { size: Some(size), ..Overrides::default() };
    scene::load(source, &overrides).expect("a scene")
}

/// A model that is not part of the repository, if it is there: in `FRAGLOOM_MODELS`, or beside the checkout.
pub(crate) fn model(name: &str, size: [u32; 2]) -> Option<Scene> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("FRAGLOOM_MODELS").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if !path.exists() {
        println!("skipped: there is no {}", path.display());
        return None;
    }
    Some(scene(path.to_str().expect("a path in UTF-8"), size))
}

/// A built-in method.
pub(crate) fn method(name: &str) -> Method {
    catalogue::method(name).expect("a built-in method")
}

/// What it promises.
pub(crate) fn contract(name: &str) -> &'static Contract {
    method(name).contract()
}

/// Options for a method.
pub(crate) fn options(method: &str, k: Option<u32>) -> Options {
    Options { method: self::method(method), k, threads: 2, ..Options::default() }
}

/// Draw, which must succeed.
pub(crate) fn draw(scene: &Scene, options: &Options) -> Rendering {
    render(scene, options).unwrap_or_else(|e| panic!("{}: {e}", options.method))
}

/// What pixels hold after a draw, of a method that keeps lists of fragments.
pub(crate) fn lists(scene: &Scene, options: &Options) -> Lists {
    let drawn = draw(scene, options);
    drawn.lists().unwrap_or_else(|e| panic!("{}: {e}", options.method)).clone()
}

/// The simulated device with a policy; few resident invocations, so that small scenes overlap in many ways.
pub(crate) fn sim(policy: Policy, seed: u64) -> Exec {
    Exec::Sim(Sim { policy, seed, resident: 96, record: false, watch: None, check: false })
}

/// The policies that are not recordings.
pub(crate) fn policies() -> [Policy; 6] {
    let [order, reverse, turns] = [Policy::Order, Policy::Reverse, Policy::RoundRobin];
    [order, reverse, turns, Policy::Random, Policy::Warp(8), Policy::Pct(3)]
}

/// Small scenes of different character: many layers in random order, intersecting and coplanar boxes, thin tubes,
/// hand-written triangles with equal depths, equal layers.
pub(crate) fn small_scenes() -> Vec<Scene> {
    vec![
        scene("synthetic:n=14,tessellation=3", [40, 28]),
        scene("cubes", [48, 40]),
        scene("hairball:strands=40", [48, 48]),
        scene(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/screen.toml"), [45, 33]),
        scene("layers:count=6", [17, 9]),
    ]
}
