//! `fragloom check`, `replay` and `claims`: verdicts, tokens, exit codes, and bad input.

#[path = "support/command.rs"]
mod support;

use std::fs;

use serde_json::Value;
use support::Dir;

fn rows(dir: &Dir, line: &str) -> (i32, Vec<Value>) {
    let run = dir.run(&format!("{line} --json"));
    let Value::Array(rows) = run.json() else { panic!("a list: {run:?}") };
    (run.code, rows)
}

#[test]
fn a_correct_method_is_verified_with_its_bound() {
    let dir = Dir::new();
    let (code, rows) = rows(&dir, "check kplus-array -n 3");
    assert_eq!(code, 0, "{rows:?}");
    assert!(rows.len() > 12);
    let (sampled, rows) = rows.split_last().unwrap();
    assert_eq!((&sampled["verdict"], &sampled["executions"]), (&"sampled".into(), &400.into()));
    assert_eq!(
        (&sampled["exhaustive"], &sampled["scope"]["random_runs"]),
        (&false.into(), &400.into())
    );
    for row in rows {
        assert_eq!(
            (&row["verdict"], &row["exhaustive"]),
            (&"verified".into(), &true.into()),
            "{row}"
        );
        assert!(row["bound"].as_str().unwrap().contains("n <= 3"), "{row}");
        let scope = &row["scope"];
        assert_eq!((&scope["interleavings"], &scope["fragments"]), (&"all".into(), &3.into()));
        assert_eq!((&scope["pixels"], &scope["initial"]), (&3.into(), &3.into()));
        assert_eq!(scope["ks"], serde_json::json!([1, 2, 3]));
        for field in ["method", "property", "memory", "instance", "initial", "states", "message"] {
            assert!(!row[field].is_null(), "{field} of {row}");
        }
        for field in ["profile", "progress", "executions", "token", "steps"] {
            assert!(row.get(field).is_some(), "{field} of {row}");
        }
    }
    let properties: Vec<&str> = rows.iter().map(|r| r["property"].as_str().unwrap()).collect();
    for asked in ["keeps", "one-outcome", "mutual-exclusion", "race-free", "termination"] {
        assert!(properties.contains(&asked), "{asked}");
    }
    let table = dir.run("check kplus-array -n 2 -k 1 --memory-model sc --progress none");
    assert!(table.stdout.contains("states") && table.stdout.contains("explored:"), "{table:?}");
}

#[test]
fn a_violation_comes_with_a_token_that_shows_it_again() {
    let dir = Dir::new();
    let (code, found) = rows(&dir, "check kplus-array@published -n 2 --memory-model sc");
    assert_eq!(code, 1);
    let keeps = found.iter().find(|row| row["property"] == "keeps").unwrap();
    assert_eq!(keeps["verdict"], "violated");
    let token = keeps["token"].as_str().unwrap();

    let trace = dir.run(&format!("replay {token} --trace"));
    assert_eq!(trace.code, 1, "{trace:?}");
    for told in ["step", "A 0/20", "B fffffffe/10", "every continuation is wrong", "instead of"] {
        assert!(trace.stdout.contains(told), "{told}: {}", trace.stdout);
    }
    let replayed = dir.run(&format!("replay {token} --json")).json();
    assert_eq!(replayed["method"], "kplus-array@published");
    assert_eq!(replayed["violations"][0]["property"], "keeps");
    assert_eq!(replayed["steps"], keeps["steps"]);
    let doomed = replayed["doomed_after"].as_u64().unwrap();
    assert!((1..=replayed["steps"].as_u64().unwrap()).contains(&doomed));

    assert_eq!(dir.run(&format!("replay {token} -o .")).code, 1);
    assert_eq!(dir.names(), ["trace.txt"]);
    assert!(String::from_utf8(dir.read("trace.txt")).unwrap().contains("exchange"));
}

/// Two executions of a racy method, down to a few steps on one pixel.
#[test]
fn a_scene_is_sampled_and_cut_down() {
    let dir = Dir::new();
    let (code, found) = rows(&dir, "check kb -k 2 --scene cubes --size 48x40 --executions 3");
    assert_eq!(code, 1);
    let verdicts: Vec<&Value> = found.iter().map(|row| &row["verdict"]).collect();
    assert_eq!(verdicts, ["violated", "violated"]);
    let token = found[0]["token"].as_str().unwrap();
    let again = dir.run(&format!("replay {token}"));
    assert!(again.code == 1 && again.stdout.contains("lost"), "{again:?}");
    dir.run(&format!("replay {token} --trace")).is_error(&["--trace", "--minimise"]);
    let smaller = dir.run(&format!("replay {token} --minimise --json")).json();
    assert!(smaller["steps"].as_u64().unwrap() <= 40, "{smaller}");
    let own = smaller["token"].as_str().unwrap();
    assert_eq!(dir.run(&format!("replay {own} --trace")).code, 1);

    let (code, fine) = rows(&dir, "check kplus-array --scene cubes --size 48x40 --executions 4");
    assert_eq!(code, 0);
    for row in &fine {
        assert_eq!(row["verdict"], "unknown", "a sample is no proof: {row}");
        assert_eq!(row["executions"], 4);
    }
    assert!(fine[1]["message"].as_str().unwrap().starts_with("one image in 4 executions"));
}

#[test]
fn one_pixel_of_a_scene_is_explored() {
    let dir = Dir::new();
    let line = "check kplus-array -k 2 --scene layers:count=4 --size 9x9 --pixel 4,4";
    let (code, found) = rows(&dir, line);
    assert_eq!(code, 0);
    assert!(found.iter().all(|row| row["verdict"] == "verified"), "{found:?}");
    assert!(found[0]["bound"].as_str().unwrap().starts_with("these 4 fragments, k = 2"));
    dir.run(&line.replace("4,4", "9,0")).is_error(&["--pixel", "9,0", "9x9"]);
    dir.run(&line.replace("4,4", "4")).is_error(&["--pixel", "320,240"]);
    dir.run(&line.replace("count=4", "count=60")).is_error(&["--pixel", "60 fragments", "28"]);
}

#[test]
fn expectations_turn_verdicts_into_exit_codes() {
    let dir = Dir::new();
    let check = |text: &str| {
        fs::write(dir.path("expect.toml"), text).unwrap();
        dir.run("check kb -n 2 -k 1 --memory-model sc --progress none --expect expect.toml")
    };
    let violated = |property| {
        format!("[[expect]]\nmethod = \"kb\"\nproperty = \"{property}\"\nverdict = \"violated\"\n")
    };
    let all = ["keeps", "intact", "accounting", "one-outcome"].map(violated).concat();
    let met = check(&all);
    assert_eq!(met.code, 0, "{met:?}");
    let surprised = check(&violated("keeps"));
    assert_eq!(surprised.code, 1);
    assert!(surprised.stderr.contains("nothing was expected of it"), "{surprised:?}");
    let wrong = check(&all.replacen("violated", "verified", 1));
    assert!(wrong.code == 1 && wrong.stderr.contains("but verified was expected"), "{wrong:?}");
    let idle = check(&(all + &violated("race-free")));
    assert!(idle.code == 1 && idle.stderr.contains("nothing was checked that fits"), "{idle:?}");
    check("[[expect]]\nverdict = \"fine\"\n").is_error(&["expect.toml", "line 2", "fine"]);
    check("expect = []\n").is_error(&["expect.toml", "no expectation"]);
    let missing = "check kb --expect missing.toml";
    dir.run(missing).is_error(&["missing.toml", "cannot be read"]);
}

#[test]
fn claims_are_listed_and_recomputed() {
    let dir = Dir::new();
    let claims = dir.run("claims --json").json();
    let ids: Vec<&str> =
        claims.as_array().unwrap().iter().map(|c| c["id"].as_str().unwrap()).collect();
    assert_eq!(ids, (1..=16).map(|i| format!("C{i}")).collect::<Vec<_>>());
    for claim in claims.as_array().unwrap() {
        assert!(claim.get("verdict").is_none(), "verdicts are computed, never written down");
    }
    assert!(dir.run("claims").stdout.contains("fragloom check --claim C1"));

    let (code, c1) = rows(&dir, "check --claim C1 -n 2 -k 1 --memory-model sc");
    assert_eq!(code, 1);
    let of = |method: &str| {
        c1.iter().find(|row| row["method"] == method).map(|row| row["verdict"].clone()).unwrap()
    };
    assert_eq!(of("kplus-array@published"), "violated");
    assert_ne!(of("kplus-array"), "violated");
    let (code, c14) = rows(&dir, "check --claim c14 dfb+ofm skb+ofm -n 3 -k 2 --memory-model sc");
    let verdicts: Vec<&Value> = c14.iter().map(|row| &row["verdict"]).collect();
    assert_eq!((code, verdicts), (1, vec![&"verified".into(), &"violated".into()]));
    assert!(c14[1]["message"].as_str().unwrap().contains("2 different results"));
    let (code, c11) = rows(&dir, "check --claim C11 -n 3 --memory-model sc");
    let verdicts: Vec<&Value> = c11.iter().map(|row| &row["verdict"]).collect();
    assert_eq!((code, verdicts), (1, vec![&"verified".into(), &"violated".into()]));
    dir.run("check --claim C18").is_error(&["--claim", "C18", "C17"]);
}

#[test]
fn one_fault_of_the_catalogue() {
    let dir = Dir::new();
    let (code, lines) = rows(&dir, "check --mutation M18");
    assert_eq!(code, 0);
    let methods: Vec<&str> = lines.iter().filter_map(|line| line["method"].as_str()).collect();
    assert_eq!(methods, ["z-buffer@M18", "kb-mdt64@M18"]);
    assert!(lines.iter().all(|line| line["fate"] == "killed"));
    assert!(dir.run("check --mutation M19").stdout.contains("termination"));
    dir.run("check --mutation M99").is_error(&["--mutation", "M99"]);
    dir.run("check --mutation M12").is_error(&["--mutation", "M12", "ordered"]);
}

#[test]
fn every_result_of_a_racy_method_is_listed() {
    let dir = Dir::new();
    let (code, found) = rows(&dir, "check kb -n 2 -k 1 --memory-model sc --outcomes");
    assert_eq!(code, 0);
    let outcomes = found[0]["outcomes"].as_array().unwrap();
    assert!(outcomes.contains(&"[0/20]".into()), "the right one: {outcomes:?}");
    assert!(outcomes.contains(&"[fffffffe/10]".into()), "a lossy one: {outcomes:?}");
}

#[test]
fn bad_input_is_one_line() {
    let dir = Dir::new();
    for (line, words) in [
        ("check", &["METHOD", "--all"][..]),
        ("check kbb", &["METHOD", "did you mean kb?"]),
        ("check exact", &["exact", "sequential"]),
        ("check kb -n 0", &["-n", "at least 1"]),
        ("check kb -n 99", &["-n", "above 12"]),
        ("check kb -k 0", &["-k", "at least 1"]),
        ("check kb -k 65", &["-k", "64"]),
        ("check kb --max-states 0", &["--max-states"]),
        ("check kb --helpers 13", &["--helpers"]),
        ("check kb --memory-model tso", &["--memory-model", "relaxed"]),
        ("check kb --profile hlsl", &["--profile", "vulkan"]),
        ("check kb --progress all-of-them", &["--progress", "hsa+obe"]),
        ("check kb --scene cubes --size 8x8 --executions 0", &["--executions", "at least 1"]),
        ("check kb --scene missing.obj", &["missing.obj"]),
        ("check kb --pixel 1,1", &["--scene"]),
        ("check kb --scene cubes --schedule fifo", &["--schedule", "pct:D"]),
        ("check kb --scene cubes --schedule pct:0", &["--schedule"]),
        ("replay", &["TOKEN"]),
        ("replay nonsense", &["TOKEN", "fl2-"]),
        ("replay fl1-AAAA", &["TOKEN", "version 1 ", "version 2"]),
        ("replay fl2-AAAA", &["TOKEN", "damaged"]),
        ("replay fl2-", &["TOKEN", "damaged"]),
    ] {
        dir.run(line).is_error(words);
    }
    assert_eq!(dir.names(), Vec::<String>::new());
}

#[test]
fn a_bound_that_is_hit_is_unknown() {
    let dir = Dir::new();
    let (code, found) =
        rows(&dir, "check kplus-array -n 4 --max-states 200 --progress obe --runs 0");
    assert_eq!(code, 0);
    assert!(found.iter().all(|row| row["verdict"] == "unknown" && row["exhaustive"] == false));
}

/// Ctrl-C: what was found so far, and nothing of it verified.
#[cfg(unix)]
#[test]
fn an_interrupted_check_says_unknown() {
    use std::process::{Command, Stdio};
    let dir = Dir::new();
    let line = "check kplus-array -n 9 -k 3 --memory-model sc --progress none --max-states 500000000 --json";
    let mut command = dir.command();
    let child = command.args(line.split(' ')).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = child.spawn().unwrap();
    // Long enough to begin; the whole takes many minutes.
    std::thread::sleep(std::time::Duration::from_millis(1_500));
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupted.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let rows: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    assert!(!rows.is_empty() && rows.iter().all(|row| row["verdict"] == "unknown"), "{rows:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted"));
}
