//! Whole frames: ten million fragments at 1024x1024 on the `tile` and `threads` executors. The methods take turns, so
//! that a machine whose speed drifts cannot decide. Prints, per scene and method, median seconds of set-up and of
//! raster, store and resolve together (`draw`, with the counting pass of methods that need one), nanoseconds per
//! fragment, and the median ratio to the `z-buffer` of the same turn.

mod support;

use fragloom::catalogue;
use fragloom::render::{Exec, Options, Report, render};
use fragloom::scene::{self, Overrides, Scene};
use support::median;

const SCENES: [&str; 3] = ["layers:count=10", "synthetic:n=20", "synthetic:n=20,tessellation=64"];
const METHODS: [&str; 4] = ["z-buffer", "ab-ll", "ab-array", "kplus-array"];
const TURNS: usize = 9;

fn main() {
    println!(
        "{:<32} {:<8} {:<12} {:>6} {:>7} {:>7} {:>7} {:>7}",
        "scene", "exec", "method", "Mfrag", "setup", "draw", "ns/frag", "ratio"
    );
    for source in SCENES {
        let scene = scene::load(source, &Overrides::default()).expect("a built-in scene");
        for exec in [Exec::Tile, Exec::Threads] {
            let turn = || METHODS.map(|method| frame(&scene, method, &exec));
            turn();
            let turns: Vec<[Report; METHODS.len()]> = (0..TURNS).map(|_| turn()).collect();
            for (i, method) in METHODS.into_iter().enumerate() {
                row(source, &exec, method, &turns, i);
            }
        }
    }
}

fn frame(scene: &Scene, method: &str, exec: &Exec) -> Report {
    let method = catalogue::method(method).expect("a built-in method");
    let options = Options { method, exec: exec.clone(), counters: false, ..Options::default() };
    render(scene, &options).expect("a frame").report
}

fn draw(report: &Report) -> f64 {
    report.seconds["draw"] + report.seconds["count"]
}

fn row(source: &str, exec: &Exec, method: &str, turns: &[[Report; METHODS.len()]], i: usize) {
    let over =
        |value: &dyn Fn(&[Report; METHODS.len()]) -> f64| median(turns.iter().map(value).collect());
    let generated = turns[0][i].generated as f64;
    let seconds = over(&|turn| draw(&turn[i]));
    println!(
        "{source:<32} {:<8} {method:<12} {:>6.1} {:>7.3} {seconds:>7.3} {:>7.1} {:>7.2}",
        exec.name(),
        generated * 1e-6,
        over(&|turn| turn[i].seconds["setup"]),
        seconds * 1e9 / generated,
        over(&|turn| draw(&turn[i]) / draw(&turn[0]))
    );
}
