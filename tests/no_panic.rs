//! No command panics: every method in every way of asking, on tiny scenes; and random commands, drawn from the command
//! line's own definition.
//!
//! What a command may do is end with 0, 1 or 2. `FRAGLOOM_RANDOM_COMMANDS=3000` draws more, and `FRAGLOOM_ALL_WAYS=1`
//! asks in every way about faults, too, of which the suite takes a quarter each.

#[path = "support/command.rs"]
#[allow(dead_code, reason = "its other users use the rest")]
mod command;

use std::process::Command;
use std::time::Duration;

use clap::{Arg, ArgAction};
use fragloom::catalogue::Catalogue;
use fragloom::cli;
use fragloom::exec::Method;
use fragloom::num::random::Random;
use rayon::prelude::*;

use command::Dir;

/// What is wrong with how a command ended, if anything is.
fn wrong(code: Option<i32>, stderr: &str) -> Option<String> {
    let panicked = stderr.contains("panicked") || stderr.contains("RUST_BACKTRACE");
    (panicked || !matches!(code, Some(0..=2))).then(|| format!("{code:?}: {stderr}"))
}

/// Run a line; what is wrong with how it ended.
fn run(dir: &Dir, line: &str) -> Option<String> {
    let run = dir.run(line);
    wrong(Some(run.code), &run.stderr).map(|how| format!("fragloom {line}\n    {how}"))
}

/// Every way of asking about a method, but for its name.
fn ways() -> Vec<String> {
    let (layers, cubes) = ("layers:count=3 --size 16x16", "cubes --size 16x16");
    let models =
        ["sc", "relaxed --profile vulkan", "relaxed --profile glsl", "relaxed --profile wgsl"];
    let mut ways = Vec::new();
    for model in models {
        // A pixel, with a bound that is hit, so that random runs follow.
        ways.push(format!(
            "check METHOD --scene {layers} --pixel 4,4 --memory-model {model} --executions 2 --max-states 20"
        ));
        ways.push(format!(
            "check METHOD -n 2 -k 1 --memory-model {model} --max-states 100 --runs 3"
        ));
    }
    ways.push(format!("check METHOD --scene {cubes} --pixel 9,8 --executions 2 --max-states 20"));
    ways.push(format!("check METHOD --scene {cubes} --executions 2 --json"));
    ways.push(format!("check METHOD --scene {layers} --executions 2 --schedule warp:4"));
    ways.push("check METHOD -n 1 -k 2 --helpers 1 --outcomes --max-states 100".to_owned());
    for progress in ["unfair", "hsa", "obe", "hsa+obe", "lobe", "fair", "simt"] {
        ways.push(format!(
            "check METHOD -n 2 -k 1 --progress {progress} --memory-model sc --max-states 100 --runs 3"
        ));
    }
    let draw = "render layers:count=3 -m METHOD --size 9x7 -q";
    for exec in ["tile", "threads", "sim"] {
        ways.push(format!("{draw} -k 2 --exec {exec}"));
    }
    for policy in ["order", "reverse", "round-robin", "random", "pct:2", "warp:4"] {
        ways.push(format!(
            "{draw} -k 8 --exec sim --schedule {policy} --resident 16 --check-steps"
        ));
    }
    for effect in ["oit", "media", "ldi", "csg=a"] {
        ways.push(format!("{draw} --effect {effect} --json"));
    }
    ways.push(format!("{draw} --data primitive --depth-format d24 --shadows"));
    ways.push(format!("{draw} --memory-budget 2000"));
    ways.push(format!("{draw} --frames 2 --tile 16 --sub-pixel-bits 4"));
    ways.push("compare layers:count=3 -m METHOD --size 9x7 -k 1".to_owned());
    ways
}

#[test]
fn every_method_in_every_way_of_asking() {
    let catalogue = Catalogue::built_in();
    let methods: Vec<&str> = catalogue.methods().iter().map(Method::name).collect();
    let ways = ways();
    let all = std::env::var_os("FRAGLOOM_ALL_WAYS").is_some();
    let mut lines = Vec::new();
    for (i, method) in methods.iter().enumerate() {
        // Published forms and faults are the same code but for their fault: together, they are asked in every way.
        let step = if all || !method.contains('@') { 1 } else { 4 };
        let asked = ways.iter().enumerate().filter(|(j, _)| (i + j) % step == 0);
        lines.extend(asked.map(|(_, way)| way.replace("METHOD", method)));
    }
    let dir = Dir::new();
    let found: Vec<String> = lines.par_iter().filter_map(|line| run(&dir, line)).collect();
    println!("{} methods, {} ways, {} commands", methods.len(), ways.len(), lines.len());
    assert!(methods.len() >= 100 && ways.len() >= 35);
    assert!(found.is_empty(), "{} of {}:\n{}", found.len(), lines.len(), found.join("\n"));
}

/// Words for an argument: mostly what it takes, sometimes what it does not.
fn value(arg: &Arg, random: &mut Random, methods: &[&str]) -> String {
    let pick = |random: &mut Random, from: &[&str]| {
        from[random.below(from.len() as u64) as usize].to_owned()
    };
    let possible = arg.get_possible_values();
    if !possible.is_empty() {
        let names: Vec<&str> =
            possible.iter().map(clap::builder::PossibleValue::get_name).collect();
        return pick(random, &names);
    }
    let names = arg.get_value_names().unwrap_or_default();
    let name = names.first().map_or("", |name| name.as_str());
    let own: &[&str] = match name {
        "METHOD" | "METHOD,..." => methods,
        "SCENE" => &[
            "layers:count=3",
            "cubes",
            "no-such-scene",
            "layers:count=0",
            "synthetic:n=5",
            "x.obj",
        ],
        "WxH" | "WxH,..." => &["9x7", "16x16", "1x1", "0x4", "4"],
        "X,Y" => &["4,4", "0,0", "99,99", "4"],
        "ID" => &["M1", "M17", "C1", "one-test", "nothing"],
        "POLICY" => &[
            "order",
            "reverse",
            "round-robin",
            "random",
            "pct:2",
            "warp:4",
            "warp:0",
            "recorded:none",
        ],
        "MODEL" => &["fair", "obe", "hsa", "simt", "unfair", "nobody"],
        "EFFECT" => &["oit", "media", "ldi", "csg=a", "csg=(a|b)-c", "csg=(", "none"],
        "TOKEN" => &["fl2-", "fl1-AAAA", "x", "fl2-AAAAAAAAAAAAAAAAAAAAAAAA"],
        "EXPERIMENT" => &["ha-table1", "none"],
        "BYTES" => &["100", "4K", "1G", "0", "x"],
        "DIR" => &[".", "no/such/folder"],
        name if name.contains("FILE") => &["a.png", "b.npz", "no/such/folder/c", ""],
        _ => &["0", "1", "2", "3", "8", "64", "-1", "0.5", "NaN", "1e9", "4294967296", "x", ""],
    };
    pick(random, own)
}

/// A random line of a command, bounded where the command can be.
fn line(random: &mut Random, methods: &[&str]) -> Vec<String> {
    let definition = cli::command();
    // It computes for minutes, whatever its options are.
    let commands: Vec<_> =
        definition.get_subcommands().filter(|c| c.get_name() != "reproduce").collect();
    let command = commands[random.below(commands.len() as u64) as usize];
    let mut words = vec![command.get_name().to_owned()];
    let mut names: Vec<&str> = Vec::new();
    for arg in command.get_arguments().filter(|arg| !arg.is_global_set()) {
        let positional = arg.is_positional();
        let chance = if positional || arg.is_required_set() { 90 } else { 12 };
        if random.below(100) >= chance {
            continue;
        }
        names.push(arg.get_id().as_str());
        if let Some(long) = arg.get_long() {
            words.push(format!("--{long}"));
        } else if let Some(short) = arg.get_short() {
            words.push(format!("-{short}"));
        }
        if positional || matches!(arg.get_action(), ArgAction::Set | ArgAction::Append) {
            words.push(value(arg, random, methods));
        }
    }
    let has_value = |arg: &Arg, option: &str| {
        let short = arg.get_short().map(|c| format!("-{c}"));
        let long = arg.get_long().map(|name| format!("--{name}"));
        [short, long].into_iter().flatten().any(|own| own == option)
    };
    for (id, bound) in [
        ("size", ["--size", "9x7"]),
        ("sizes", ["--size", "9x7"]),
        ("max_states", ["--max-states", "50"]),
        ("executions", ["--executions", "2"]),
        ("fragments", ["-n", "2"]),
        ("repeats", ["--repeats", "1"]),
    ] {
        let takes =
            command.get_arguments().any(|arg| arg.get_id() == id && has_value(arg, bound[0]));
        if takes && !names.contains(&id) {
            words.extend(bound.map(str::to_owned));
        }
    }
    words
}

/// How long to wait between two looks at a command.
const LOOK: Duration = Duration::from_millis(2);

/// After so many looks, 6 seconds, a command is stopped, and counted.
const MOST_LOOKS: u32 = 3_000;

/// Run words; what is wrong with how they ended, or that they were stopped.
fn bounded(dir: &Dir, words: &[String]) -> Result<Option<String>, String> {
    let log = tempfile::NamedTempFile::new().expect("a file");
    let mut command: Command = dir.command();
    let out = log.reopen().expect("the same file");
    command.args(words).stdout(std::process::Stdio::null()).stderr(out);
    let mut child = command.spawn().expect("the binary");
    let mut looks = 0;
    let code = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status.code();
        }
        looks += 1;
        if looks > MOST_LOOKS {
            child.kill().and_then(|()| child.wait()).expect("a child");
            return Err(words.join(" "));
        }
        std::thread::sleep(LOOK);
    };
    let stderr = std::fs::read_to_string(log.path()).expect("text");
    Ok(wrong(code, &stderr).map(|how| format!("fragloom {words:?}\n    {how}")))
}

#[test]
fn random_commands() {
    let number = std::env::var("FRAGLOOM_RANDOM_COMMANDS").ok();
    let number: u64 = number.map_or(160, |n| n.parse().expect("a number"));
    let catalogue = Catalogue::built_in();
    let mut methods: Vec<&str> = catalogue.methods().iter().map(Method::name).collect();
    methods.extend(["nothing", "kb,ab-ll", ""]);
    let dir = Dir::new();
    let ends: Vec<_> = (0..number)
        .into_par_iter()
        .map(|i| bounded(&dir, &line(&mut Random::new(0xF4A6, i), &methods)))
        .collect();
    let stopped: Vec<&String> = ends.iter().filter_map(|end| end.as_ref().err()).collect();
    let found: Vec<&String> = ends.iter().filter_map(|end| end.as_ref().ok()?.as_ref()).collect();
    println!("{number} random commands, {} stopped for taking long", stopped.len());
    assert!(found.is_empty(), "{} of {number}: {found:#?}", found.len());
    assert!(stopped.len() as u64 <= 1 + number / 10, "{stopped:#?}");
}

/// Negative controls.
#[test]
fn a_panic_and_a_signal_are_found() {
    let panic = "thread 'main' panicked at src/x.rs:1:1:\nindex out of bounds";
    assert!(wrong(Some(101), panic).is_some() && wrong(Some(2), panic).is_some());
    assert!(wrong(None, "").is_some() && wrong(Some(3), "").is_some());
    assert!((0..=2).all(|code| wrong(Some(code), "error: --size: wrong").is_none()));
    let drawn: Vec<Vec<String>> = (0..300).map(|i| line(&mut Random::new(1, i), &["kb"])).collect();
    for command in cli::command().get_subcommands().filter(|c| c.get_name() != "reproduce") {
        assert!(drawn.iter().any(|words| words[0] == command.get_name()), "{}", command.get_name());
    }
}
