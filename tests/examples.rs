//! The examples are the whole tool with methods of their own in it. `cargo test` builds them.

#[path = "support/command.rs"]
#[allow(dead_code, reason = "its other users use the rest")]
mod command;

use std::path::PathBuf;
use std::process::Command;

use command::{Dir, Run};

/// An example, run in a folder.
fn example(dir: &Dir, name: &str, line: &str) -> Run {
    let mut path: PathBuf = std::env::current_exe().expect("this test");
    path.pop();
    path.pop();
    path.push("examples");
    path.push(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(path.exists(), "{} is not built: run cargo build --examples first", path.display());
    let mut command = Command::new(path);
    command.current_dir(dir.path("")).args(line.split_whitespace());
    let output = command.output().expect("it runs");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    let code = output.status.code().expect("no signal");
    Run { code, stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn your_own_scheme_is_in_every_command() {
    let dir = Dir::new();
    let run = |line: &str| example(&dir, "user_scheme", line);
    let drawn = run("render cubes -m cas-list --size 48x40 -o a.png --json");
    assert_eq!((drawn.code, dir.read("a.png").starts_with(b"\x89PNG")), (0, true), "{drawn:?}");
    let same = run("render cubes -m ab-ll --size 48x40 --json");
    let hash = |run: &Run| run.json()["fragments_hash"].as_str().map(str::to_owned);
    assert!(hash(&drawn).is_some() && hash(&drawn) == hash(&same));
    for exec in ["tile", "threads", "sim --seed 4", "sim --schedule round-robin --check-steps"] {
        let run = run(&format!("render cubes -m cas-list --size 48x40 --json --exec {exec}"));
        assert_eq!((run.code, hash(&run)), (0, hash(&drawn)), "{exec}");
    }
    assert_eq!(run("compare cubes -m cas-list,ab-ll --size 24x20").code, 0);
    assert_eq!(run("check cas-list -n 2 -q").code, 0);
    assert_eq!(run("check cas-list --scene layers:count=2 --size 8x8 --pixel 4,4 -q").code, 0);
    assert_eq!(run("check cas-list --scene cubes --size 16x16 --executions 3 -q").code, 0);
    assert_eq!(run("bench layers:count=3 -m cas-list --size 16x16 --repeats 1 -q").code, 0);
    assert!(run("methods").stdout.contains("cas-list"));
    assert!(run("methods --stability").stdout.contains("cas-list"));
    assert!(run("render cubes -m cas-lst").stderr.contains("did you mean cas-list?"));
}

#[test]
fn its_broken_twin_is_refuted_and_replayed() {
    let dir = Dir::new();
    let run = |line: &str| example(&dir, "user_scheme", line);
    let checked = run("check cas-list@broken -n 2 --memory-model sc --json -q");
    assert_eq!(checked.code, 1, "{checked:?}");
    let rows = checked.json();
    let rows = rows["rows"].as_array().or(rows.as_array()).expect("rows").clone();
    let token = rows.iter().find_map(|row| row["token"].as_str()).expect("a token");
    let replayed = run(&format!("replay {token} --trace"));
    assert_eq!(replayed.code, 1, "{replayed:?}");
    assert!(replayed.stdout.contains("cas-list@broken"));
    // A scene's token, too.
    let line = "check cas-list@broken --scene synthetic:n=9 --size 16x16 --executions 3 --resident 64 --json -q";
    let sampled = run(line);
    assert_eq!(sampled.code, 1, "{sampled:?}");
    let rows = sampled.json();
    let rows = rows["rows"].as_array().or(rows.as_array()).expect("rows").clone();
    let token = rows.iter().find_map(|row| row["token"].as_str()).expect("a token");
    assert_eq!(run(&format!("replay {token}")).code, 1);
    // The built-in catalogue does not know it.
    let unknown = dir.run(&format!("replay {token}"));
    unknown.is_error(&["TOKEN", "cas-list@broken"]);
}

#[test]
fn a_merging_method_is_in_every_command() {
    let dir = Dir::new();
    let run = |line: &str| example(&dir, "merge_two", line);
    let line = "render cubes -m merge-two --size 48x40 -o m.png --fragments m.npz --json";
    let drawn = run(line);
    assert_eq!(drawn.code, 0, "{drawn:?}");
    assert!(drawn.json()["merged"].as_u64().is_some_and(|merged| merged > 0));
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(dir.read("m.npz"))).expect("a zip");
    for name in ["offsets", "depth", "data", "thickness", "rgba", "weight", "width", "height"] {
        assert!(archive.by_name(&format!("{name}.npy")).is_ok(), "{name}");
    }
    for exec in ["threads", "sim --schedule warp:8"] {
        let other = run(&format!("render cubes -m merge-two --size 48x40 --json --exec {exec}"));
        assert_eq!(other.json()["fragments_hash"], drawn.json()["fragments_hash"], "{exec}");
    }
    assert_eq!(run("compare cubes -m merge-two --size 24x20").code, 0);
    assert_eq!(run("check merge-two -n 2 -q").code, 0);
    assert_eq!(run("check merge-two --scene cubes --size 16x16 --executions 3 -q").code, 0);
    run("render cubes -m merge-two --size 24x20 --effect media")
        .is_error(&["--effect", "merged records"]);
}
