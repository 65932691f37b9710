//! Whole frames: ten million fragments at 1024x1024 on the `tile` and `threads` executors. Prints, per scene and method,
//! the median seconds of raster, store and resolve together (`draw`), of what surrounds them, and nanoseconds per
//! fragment; and the ratio to the `z-buffer` on the same scene, which is free of the machine's speed.

mod support;

use fragloom::render::{Exec, Options, render};
use fragloom::scene::{self, Overrides};
use support::median;

const SCENES: [&str; 3] = ["layers:count=10", "synthetic:n=20", "synthetic:n=20,tessellation=64"];
const METHODS: [&str; 4] = ["z-buffer", "ab-ll", "ab-array", "kplus-array"];
const RUNS: usize = 7;

fn main() {
    println!(
        "{:<32} {:<8} {:<12} {:>6} {:>7} {:>7} {:>7} {:>7}",
        "scene", "exec", "method", "Mfrag", "setup", "draw", "ns/frag", "ratio"
    );
    for source in SCENES {
        let scene = scene::load(source, &Overrides::default()).expect("a built-in scene");
        for exec in [Exec::Tile, Exec::Threads] {
            let mut base = None;
            for method in METHODS {
                let options = Options {
                    method: method.to_owned(),
                    exec: exec.clone(),
                    counters: false,
                    ..Options::default()
                };
                let reports: Vec<_> =
                    (0..RUNS).map(|_| render(&scene, &options).expect("a frame").report).collect();
                let phase = |name: &str| median(reports.iter().map(|r| r.seconds[name]).collect());
                let draw = phase("draw") + phase("count");
                let generated = reports[0].generated as f64;
                let base = *base.get_or_insert(draw);
                println!(
                    "{source:<32} {:<8} {method:<12} {:>6.1} {:>7.3} {draw:>7.3} {:>7.1} {:>7.2}",
                    exec.name(),
                    generated * 1e-6,
                    phase("setup"),
                    draw * 1e9 / generated,
                    draw / base
                );
            }
        }
    }
}
