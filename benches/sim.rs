//! The simulated device: millions of memory operations a second on whole scenes, by method and policy, with 1,024
//! resident invocations and nothing counted. Operations are counted exactly, in a run of its own; seconds are those of
//! the frame's three passes, rasterizing and compositing included, on one thread, and of the fastest turn: whatever
//! else a machine does only adds to them.
//!
//! The goal is 40 under every policy. What stands in its way under `random` is `docs/performance.md`'s to say; `order`,
//! which is predicted, shows what a step costs without that.

use fragloom::catalogue;
use fragloom::render::{Exec, Options, Policy, Report, Sim, render};
use fragloom::scene::{self, Overrides, Scene};

const SCENES: [&str; 2] = ["synthetic:n=20", "scenes/glass.toml"];
const SIZE: [u32; 2] = [640, 480];
const METHODS: [&str; 3] = ["kplus-array", "ab-ll", "kb"];
const POLICIES: [(&str, Policy); 3] =
    [("random", Policy::Random), ("round-robin", Policy::RoundRobin), ("order", Policy::Order)];
const TURNS: usize = 5;

fn main() {
    println!(
        "{:<18} {:<12} {:<12} {:>6} {:>7} {:>8} {:>7}",
        "scene", "method", "policy", "Mfrag", "Mops", "seconds", "Mops/s"
    );
    for source in SCENES {
        let overrides = Overrides { size: Some(SIZE), ..Overrides::default() };
        let scene = scene::load(source, &overrides).expect("a scene of the project");
        for method in METHODS {
            for (name, policy) in &POLICIES {
                let counted = frame(&scene, method, policy, true);
                let turns = (0..TURNS).map(|_| passes(&frame(&scene, method, policy, false)));
                let seconds = turns.fold(f64::INFINITY, f64::min);
                let million = operations(&counted) as f64 * 1e-6;
                println!(
                    "{source:<18} {method:<12} {name:<12} {:>6.2} {million:>7.1} {seconds:>8.3} {:>7.1}",
                    counted.generated as f64 * 1e-6,
                    million / seconds
                );
            }
        }
    }
}

fn frame(scene: &Scene, method: &str, policy: &Policy, counters: bool) -> Report {
    let sim = Sim { policy: policy.clone(), seed: 1, resident: 1_024, ..Sim::default() };
    let method = catalogue::method(method).expect("a built-in method");
    let exec = Exec::Sim(sim);
    let options = Options { method, k: None, exec, threads: 1, counters, ..Options::default() };
    render(scene, &options).expect("a frame").report
}

/// Seconds of clear, store and resolve.
fn passes(report: &Report) -> f64 {
    report.seconds.iter().filter(|(name, _)| name.starts_with("draw.")).map(|(_, s)| s).sum()
}

/// Every kind of operation has a counter; the other counters are not operations.
fn operations(report: &Report) -> u64 {
    let others = ["failed_exchanges", "spins", "bytes"];
    report
        .counters
        .iter()
        .filter(|(name, _)| !others.contains(&name.as_str()))
        .map(|(_, n)| n)
        .sum()
}
