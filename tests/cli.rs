//! The binary's manners: help, errors, exit codes, and never a file half written. What it draws is in
//! `cli_render.rs`.

#[path = "support/command.rs"]
mod support;

use std::fs;
use std::process::Stdio;

use support::Dir;

#[test]
fn help_exists_for_the_program_and_every_command() {
    let dir = Dir::new();
    let help = dir.run("--help");
    assert_eq!((help.code, help.stderr.as_str()), (0, ""));
    for command in [
        "render",
        "info",
        "compare",
        "inspect",
        "export",
        "check",
        "replay",
        "claims",
        "methods",
        "mutations",
        "scenes",
        "reproduce",
    ] {
        assert!(help.stdout.contains(command), "{command}");
        let help = dir.run(&format!("{command} --help"));
        assert_eq!((help.code, help.stderr.as_str()), (0, ""), "{command}");
        assert!(help.stdout.contains("--json"), "{command}");
    }
    assert!(dir.run("--version").stdout.starts_with("fragloom "));
}

/// `help COMMAND` and `COMMAND --help` are the same.
#[test]
fn help_is_a_command_too() {
    let dir = Dir::new();
    assert_eq!(dir.run("help").stdout, dir.run("--help").stdout);
    for command in fragloom::cli::command().get_subcommands().map(clap::Command::get_name) {
        let help = dir.run(&format!("help {command}"));
        assert_eq!((help.code, help.stderr.as_str()), (0, ""), "{command}");
        assert_eq!(help.stdout, dir.run(&format!("{command} --help")).stdout, "{command}");
    }
}

#[test]
fn shells_and_manuals_are_served() {
    let dir = Dir::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = dir.run(&format!("completions {shell}"));
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{shell}");
        assert!(run.stdout.contains("fragloom") && run.stdout.contains("reproduce"), "{shell}");
    }
    let page = dir.run("man");
    assert_eq!((page.code, page.stderr.as_str()), (0, ""));
    assert!(dir.names().is_empty());
    assert_eq!(dir.run("man pages").code, 0, "the folder is made");
    assert_eq!(dir.read("pages/fragloom.1"), page.stdout.as_bytes());
    for command in fragloom::cli::command().get_subcommands().map(clap::Command::get_name) {
        assert!(dir.path(&format!("pages/fragloom-{command}.1")).is_file(), "{command}");
    }
    fs::write(dir.path("file"), "kept").unwrap();
    dir.run("man file").is_error(&["DIR:", "file"]);
    dir.run("man file/below").is_error(&["DIR:", "file"]);
    assert_eq!(dir.run("man a/b").code, 0, "folders within folders");
    assert_eq!(dir.names(), ["a", "file", "pages"]);
    assert_eq!(dir.read("file"), b"kept");
}

#[test]
fn options_have_a_default_or_say_that_they_have_none() {
    let definition = fragloom::cli::command();
    let all = definition.get_subcommands();
    for sub in all.flat_map(|sub| std::iter::once(sub).chain(sub.get_subcommands())) {
        for argument in sub.get_arguments().filter(|a| a.get_long().is_some()) {
            let help = argument.get_help().unwrap().to_string();
            let takes_value = argument.get_action().takes_values();
            let told = help.contains("[default:") || !argument.get_default_values().is_empty();
            let free = !takes_value || argument.is_required_set();
            assert!(told || free, "{} {:?}: {help}", sub.get_name(), argument.get_long());
        }
    }
}

#[test]
fn wrong_values_are_one_line_that_names_the_option() {
    let dir = Dir::new();
    for (line, words) in [
        ("render x -k 0", &["-k:", "at least 1"][..]),
        ("render x -k -1", &["-k"]),
        ("render x --size 0x4", &["--size:", "16384"]),
        ("render x --size 16385x4", &["--size:", "16384"]),
        ("render x --size 64y", &["--size:", "640x480"]),
        ("render x --alpha 1.01", &["--alpha:", "0 to 1"]),
        ("render x --alpha -1", &["--alpha:"]),
        ("render x --alpha nan", &["--alpha:"]),
        ("render x --tile 8", &["--tile:", "16, 32, 64"]),
        ("render x --sub-pixel-bits 6", &["--sub-pixel-bits:", "8, 4"]),
        ("render x --max-memory lots", &["--max-memory:", "512M"]),
        ("render x --memory-budget much", &["--memory-budget:", "512M"]),
        ("render cubes --memory-budget 1K", &["--memory-budget:", "needs", "k = 1"]),
        ("render cubes -k 4 --memory-budget 1G", &["--memory-budget:", "-k", "one of them"]),
        ("render x --sort bubble", &["--sort", "published"]),
        ("render x --exec gpu", &["--exec", "tile, threads, sim"]),
        ("render x --shading phong", &["--shading", "gooch"]),
        ("render x --depth-format d16", &["--depth-format", "d24"]),
        ("render x --data depth", &["--data", "primitive"]),
        ("render x --cull-face both", &["--cull-face", "back"]),
        ("render x --threads -1", &["--threads"]),
        ("render x --threads many", &["--threads"]),
        ("render x --schedule random", &["--schedule:", "--exec sim"]),
        ("render x --exec sim --schedule fifo", &["--schedule:", "round-robin"]),
        ("render x --exec sim --schedule warp:0", &["--schedule:", "warp:N"]),
        ("render x --exec sim --schedule recorded:none", &["--schedule:", "none"]),
        ("render x --exec sim --resident 0", &["--resident:", "at least 1"]),
        ("render x --record s", &["--record:", "--exec sim"]),
        ("render x -m kplus-aray", &["-m:", "did you mean kplus-array?", "exact"]),
        ("render cubes -m ha64 --load 0", &["--load:", "1 to 100"]),
        ("render cubes -m ha64 --load 50 --table 9x9", &["--load:", "--table"]),
        ("render cubes -m ha64 --table 9by9", &["--table:", "WIDTHxHEIGHT"]),
        ("render cubes -m ha64 --size 64x48 --table 64x47", &["--table:", "64x48"]),
        (
            "render layers:count=1 -m hash-coherent --size 8192x2049",
            &["--size:", "16777216", "hash-coherent"],
        ),
        ("render cubes -m ha64 --age-limit 256", &["--age-limit:", "1 to 255"]),
        ("render cubes -m ha64-cull --cull-threshold 1.5", &["--cull-threshold:", "0 to 1"]),
        ("render cubes -m ha64 --depth-format d32", &["--depth-format:", "24 bits"]),
        ("render cubes -m ha64 --memory-budget 9M --load 9", &["--memory-budget:", "--load"]),
        ("render cubes -m ha64 --offsets far", &["--offsets", "farthest-point"]),
        ("render cubes -m ha32 --effect csg=a", &["--effect:", "ha32"]),
        ("render cubes -m ha32 --shadows", &["--shadows:", "ha32"]),
        ("render cubes --check-steps", &["--check-steps:", "--exec sim"]),
        ("render cubes --frames 0", &["--frames:", "1 to 100000"]),
        ("render cubes --resize at-once", &["--resize:", "--frames"]),
        ("render cubes --frames 2 --fragments f.npz", &["--fragments:", "--frames"]),
        ("reproduce ha-fig6", &["EXPERIMENT:", "ha-fig8"]),
        ("render cubes --cull depth", &["--cull:", "occupancy"]),
        ("render cubes -m ab-ll --cull occupancy", &["--cull:", "ab-ll"]),
        ("render cubes -m k-variable --gaze 9", &["--gaze:", "X,Y"]),
        ("render cubes -m k-variable --gaze 9,9000", &["--gaze:", "1024x1024"]),
        ("render cubes -m k-variable --importance-map no.png", &["no.png:", "opened"]),
        ("render cubes -m k-variable --importance map", &["--importance:", "--importance-map"]),
        ("render cubes -m k-variable --importance glory", &["--importance", "periphery"]),
        (
            "render cubes -m k-variable --k-average 2 --memory-budget 9M",
            &["--k-average:", "give one"],
        ),
        ("reproduce --edge 1", &["--edge:", "16 to"]),
        ("reproduce --repeats 0", &["--repeats:", "1 to"]),
        ("compare x -m exact,nonsense", &["-m:", "nonsense"]),
        ("compare x --reference exakt", &["--reference:", "did you mean exact?"]),
        ("render", &["SCENE"]),
        ("render x --sise 4x4", &["--sise", "--size"]),
        ("rendr x", &["\"rendr\"", "did you mean render?"]),
        ("help rendr", &["\"rendr\"", "did you mean render?"]),
        ("completions", &["SHELL"]),
        ("completions csh", &["SHELL", "zsh"]),
        ("", &["subcommand"]),
    ] {
        dir.run(line).is_error(words);
    }
    assert!(dir.names().is_empty());
}

#[test]
fn a_scene_that_is_not_there_is_an_error() {
    let dir = Dir::new();
    dir.run("render missing.obj -o out.png --json").is_error(&["missing.obj"]);
    dir.run("compare missing.obj -o .").is_error(&["missing.obj"]);
    assert!(dir.names().is_empty());
}

#[test]
fn outputs_are_checked_before_anything_runs() {
    let dir = Dir::new();
    for option in ["-o", "--fragments", "--stats"] {
        // The scene is missing as well: the output is complained of first.
        let run = dir.run(&format!("render missing.obj {option} no/such/folder/file"));
        run.is_error(&[&format!("{option}:"), "no/such/folder"]);
    }
    let run = dir.run("render missing.obj --exec sim --record no/schedule");
    run.is_error(&["--record:", "no/schedule"]);
    dir.run("render missing.obj -o .").is_error(&["-o:"]);
    dir.run("render missing.obj -o a.png --stats ./a.png").is_error(&["--stats:", "-o"]);
    dir.run("render missing.obj -o a.jpg").is_error(&["-o:", "a.jpg", ".png, .ppm, .pfm or .exr"]);
    dir.run("render missing.obj -o - --json").is_error(&["--json:", "stdout"]);
    fs::write(dir.path("file"), "kept").unwrap();
    dir.run("compare missing.obj -o file/below").is_error(&["-o:", "file"]);
    dir.run("compare missing.obj -o file").is_error(&["-o:", "file"]);
    assert_eq!(dir.names(), ["file"]);
    assert_eq!(dir.read("file"), b"kept");
}

#[test]
fn methods_come_from_the_contracts() {
    let dir = Dir::new();
    let document = dir.run("methods --json").json();
    let methods = document.as_array().unwrap();
    let keys = [
        "name",
        "title",
        "paper",
        "section",
        "form",
        "program",
        "words",
        "exact_when",
        "arrival_dependent",
        "ties",
        "overflow",
        "wgsl",
        "default_k",
    ];
    assert!(methods.iter().all(|method| keys.iter().all(|key| method.get(key).is_some())));
    let all = dir.run("methods --all");
    assert_eq!(all.stdout.lines().count(), methods.len() + 1);
    let table = dir.run("methods");
    let faults = methods.iter().filter(|method| method["form"] == "mutation").count();
    assert_eq!(table.stdout.lines().count(), methods.len() - faults + 1);
    assert!(all.stdout.contains("@M1 ") && !table.stdout.contains("@M1 "));
    for name in ["exact", "kplus-array"] {
        assert!(methods.iter().any(|method| method["name"] == name), "{name}");
        assert!(table.stdout.lines().any(|line| line.starts_with(name)), "{name}");
    }
}

#[test]
fn mutations_are_listed_with_their_methods() {
    let dir = Dir::new();
    let document = dir.run("mutations --json").json();
    let mutations = document.as_array().unwrap();
    let find = |id: &str| mutations.iter().find(|mutation| mutation["id"] == id).unwrap();
    assert_eq!(find("M19")["variants"], serde_json::json!(["kplus-array@M19"]));
    assert_eq!(find("M19")["absent"], serde_json::Value::Null);
    assert!(find("M12")["absent"].as_str().is_some_and(|why| why.contains("ordered")));
    let table = dir.run("mutations").stdout;
    assert!(table.contains("-m kplus-array@M1-relaxed\n") && table.contains("none: "));
    assert!(mutations.iter().all(|m| table.contains(m["text"].as_str().unwrap())));
}

#[test]
fn scenes_are_listed_with_their_keys() {
    let dir = Dir::new();
    let document = dir.run("scenes --json").json();
    let scenes = document.as_array().unwrap();
    let layers = scenes.iter().find(|scene| scene["name"] == "layers").unwrap();
    assert!(layers["description"].as_str().is_some_and(|text| !text.is_empty()));
    assert!(layers["keys"].as_array().unwrap().iter().any(|key| key["name"] == "count"));
    assert!(dir.run("scenes").stdout.contains("layers"));
}

#[test]
fn a_reader_that_goes_away_is_no_fault() {
    let dir = Dir::new();
    for line in ["methods --json", "--help"] {
        let mut command = dir.command();
        command.args(line.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]), "{line}");
    }
}

/// A picture on stdout is all that is there; methods by pattern and with blanks; sizes by one number; a folder is made.
#[test]
fn habits_from_elsewhere_work() {
    let dir = Dir::new();
    let output =
        dir.command().args(["render", "cubes", "--size", "24", "-o", "-"]).output().unwrap();
    assert!(output.status.success() && output.stdout.starts_with(b"\x89PNG"), "{output:?}");
    let run = dir.run("render cubes --size 24 -o cubes.ppm --json -q");
    assert_eq!((run.json()["width"].as_u64(), run.json()["height"].as_u64()), (Some(24), Some(24)));
    assert!(dir.read("cubes.ppm").starts_with(b"P6\n24 24\n255\n"));
    let words = [
        "compare",
        "cubes",
        "--size",
        "24x16",
        "-m",
        "ab-ll, depth-peel*",
        "-o",
        "sheets",
        "--json",
    ];
    let output = dir.command().args(words).output().unwrap();
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let names: Vec<&str> =
        rows.as_array().unwrap().iter().map(|r| r["method"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["ab-ll", "depth-peel", "depth-peel@published", "depth-peel-dual", "depth-peel-bucket"]
    );
    assert!(dir.path("sheets/compare-ab-ll.png").is_file());
}

/// What is read is never written: by its name, by another spelling, through a link.
#[test]
fn inputs_are_kept() {
    let dir = Dir::new();
    let mesh = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(dir.path("a.obj"), mesh).unwrap();
    let scene = "[[object]]\nfile = \"a.obj\"\n";
    fs::write(dir.path("s.toml"), scene).unwrap();
    for line in [
        "render a.obj --stats a.obj",
        "render s.toml --stats s.toml",
        "render s.toml --stats a.obj",
        "render s.toml --stats ./a.obj",
        "render s.toml --fragments s.toml",
    ] {
        dir.run(&format!("{line} --size 8 -q")).is_error(&["is an input"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a.obj", dir.path("link.png")).unwrap();
        dir.run("render s.toml -o link.png --size 8 -q").is_error(&["-o:", "link.png"]);
    }
    assert_eq!((dir.read("a.obj"), dir.read("s.toml")), (mesh.into(), scene.into()));
}
