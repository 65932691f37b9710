//! `fragloom bench`: its options, and what its rows have. No test looks at how long anything took. With devices:
//! `cli_gpu.rs`.

#[path = "support/command.rs"]
mod support;

use serde_json::Value;
use support::{Dir, Run};

fn number(value: &Value, field: &str) -> f64 {
    value[field].as_f64().unwrap_or_else(|| panic!("{field} in {value}"))
}

fn list<'a>(value: &'a Value, field: &str) -> &'a Vec<Value> {
    value[field].as_array().unwrap_or_else(|| panic!("{field} in {value}"))
}

fn document(run: &Run) -> Value {
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    run.json()
}

/// The cells of each line.
fn csv(run: &Run) -> Vec<Vec<String>> {
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    run.stdout.lines().map(cells).collect()
}

/// One line's cells, with quotes taken off.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("a cell").push(c),
        }
    }
    cells
}

/// A fuller table makes fragments look at more cells.
#[test]
fn a_load_is_that_of_hash_tables() {
    let dir = Dir::new();
    let looked = |load: &str| {
        let line = format!(
            "bench cubes --size 64x64 -m ha64 --exec threads --threads 1 --repeats 1 --json {load}"
        );
        let document = document(&dir.run(&line));
        number(&list(&document, "rows")[0], "atomics_per_fragment")
    };
    assert_eq!(looked(""), looked("--load 50"));
    assert!(looked("--load 100") > 1.1 * looked("--load 50"));
}

#[test]
fn wrong_options_are_one_line() {
    let dir = Dir::new();
    for (line, words) in [
        ("bench --repeats 1001", &["--repeats:", "1 to 1000"][..]),
        ("bench --exec gpu", &["--exec", "tile, threads, sim"]),
        ("bench --exec tile,", &["--exec"]),
        ("bench --threads 2000", &["--threads:", "1024"]),
        ("bench --threads many", &["--threads"]),
        ("bench --suite=0", &["--suite:", "1 to 300"]),
        ("bench --suite=301", &["--suite:", "1 to 300"]),
        ("bench --suite=all", &["--suite"]),
        ("bench --scaling up", &["--scaling", "threads, fragments, triangles, pixels"]),
        ("bench --load 0", &["--load:", "1 to 100"]),
        ("bench --scaling pixels --steps 1", &["--steps:", "2 to 12"]),
        ("bench --scaling pixels --steps 12 --size 4096x4096", &["--steps:", "16384"]),
        ("bench missing.obj --scaling pixels", &["missing.obj"]),
        ("bench missing.obj --scaling fragments", &["missing.obj"]),
        ("bench layers:count=40000 --scaling fragments", &["layers: count:", "65536"]),
        ("bench --scaling threads --cull occupancy", &["--scaling", "--cull"]),
        ("bench --csv --json", &["--csv", "--json"]),
        ("bench --wanted all", &["--wanted", "lists, hash, picture"]),
        ("bench --max-memory lots", &["--max-memory:", "512M"]),
        ("bench cubes --size 64x64 --max-memory 1K", &["--max-memory:", "1024"]),
        ("bench --explore nonsense", &["--explore:", "nonsense"]),
        ("bench --explore exact", &["exact"]),
        ("bench --explore ab-ll -n 9", &["-n:", "1 to 8"]),
        ("bench --explore kb -k 65", &["-k:", "kb", "1 to"]),
        ("bench --explore ab-ll cubes", &["--explore"]),
        ("bench --explore ab-ll --scaling threads", &["--explore", "--scaling"]),
        ("bench -n 3", &["--explore"]),
        ("bench synthetic:area=8,tessellation=2", &["synthetic: area:", "tessellation"]),
    ] {
        dir.run(line).is_error(words);
    }
    assert!(dir.names().is_empty());
}

#[test]
fn rows_have_their_fields() {
    let dir = Dir::new();
    let line =
        "bench layers:count=3 --size 70x40 --repeats 2 --threads 1,2 -m ab-ll,z-buffer --json -q";
    let found = document(&dir.run(line));
    let constants = list(&found["machine"], "constants");
    assert_eq!(
        constants.iter().map(|c| c["threads"].as_u64()).collect::<Vec<_>>(),
        [1, 2].map(Some)
    );
    assert!(number(&found["machine"], "cores") >= 1.0);
    for field in [
        "exchange_ns",
        "locked_pair_ns",
        "compare_exchange_max_ns",
        "add_ns",
        "cache_gb_per_s",
        "read_gb_per_s",
        "write_gb_per_s",
    ] {
        assert!(constants.iter().all(|c| number(c, field) > 0.0), "{field}: {constants:?}");
    }
    let rows = list(&found, "rows");
    let names = |row: &Value| {
        let word = |field: &str| row[field].as_str().unwrap().to_owned();
        (word("method"), word("exec"), row["threads"].as_u64().unwrap())
    };
    let order: Vec<_> = rows.iter().map(names).collect();
    let right = ["ab-ll", "z-buffer"].into_iter().flat_map(|method| {
        [("tile", 1), ("tile", 2), ("threads", 1), ("threads", 2)]
            .map(|(exec, threads)| (method.to_owned(), exec.to_owned(), threads))
    });
    assert_eq!(order, right.collect::<Vec<_>>());
    for row in rows {
        assert_eq!(
            (row["scene"].as_str(), row["asked"].as_str()),
            (Some("layers"), Some("layers:count=3"))
        );
        assert_eq!((number(row, "fragments"), number(row, "triangles")), (3.0 * 70.0 * 40.0, 6.0));
        for phase in ["load", "setup", "count", "coverage", "emit", "draw", "assemble", "hash"] {
            assert!(number(&row["seconds"], phase) >= 0.0, "{phase}: {row}");
        }
        let tile = row["exec"] == "tile";
        assert_eq!(row["seconds"]["store_resolve"].is_number(), tile, "{row}");
        assert_eq!(row["seconds"]["draw.store"].is_number(), !tile, "{row}");
        for field in
            ["mfrag_per_s", "setup_mtri_per_s", "coverage_gfrag_per_s", "bytes_per_fragment"]
        {
            assert!(number(row, field) > 0.0, "{field}: {row}");
        }
        // The limit counts the fastest emission, and seconds are medians.
        assert!(number(row, "limit_seconds") > 0.0 && number(row, "limit_ratio") > 0.0, "{row}");
        assert!(
            ["emit", "atomics", "cache", "memory"].map(Some).contains(&row["limit_by"].as_str())
        );
        assert_eq!(row["ratio"], Value::Null);
        #[cfg(target_os = "linux")]
        assert!(row["peak_mib"].as_f64().is_none_or(|mib| mib > 1.0), "{row}");
    }
    // An exchange a fragment, and what clears; a worker's own words are not atomic.
    let of = |exec: &str| rows.iter().find(|row| row["exec"] == exec && row["method"] == "ab-ll");
    assert_eq!(of("tile").unwrap()["atomics_per_fragment"], 0.0);
    let atomics = number(of("threads").unwrap(), "atomics_per_fragment");
    assert!((1.0..1.1).contains(&atomics), "{atomics}");
    assert!(list(&found, "means").is_empty());
}

#[test]
fn csv_opens_with_as_many_fields_in_every_line() {
    let dir = Dir::new();
    let line =
        "bench layers:count=2,alpha=0.5 cubes --size 32x24 --repeats 1 -m ab-ll,s-buffer --csv -q";
    let lines = csv(&dir.run(line));
    assert_eq!(lines.len(), 1 + 2 * 2 * 2);
    let names = &lines[0];
    assert_eq!(names[..4], ["method", "scene", "asked", "exec"]);
    assert!(lines.iter().all(|cells| cells.len() == names.len()), "{lines:?}");
    let mut unique = names.clone();
    unique.sort();
    unique.dedup();
    assert_eq!(unique.len(), names.len());
    assert_eq!(lines[1][..4], ["ab-ll", "layers", "layers:count=2,alpha=0.5", "tile"]);
    for run in [
        "bench cubes --size 32x24 --repeats 1 --scaling pixels --steps 2 --csv -q",
        "bench --explore kb -n 2 --csv",
    ] {
        let lines = csv(&dir.run(run));
        assert!(
            lines.len() > 2 && lines.iter().all(|cells| cells.len() == lines[0].len()),
            "{lines:?}"
        );
    }
}

#[test]
fn a_file_is_timed_as_it_was_named() {
    let dir = Dir::new();
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(dir.path("a,b.obj"), mesh).unwrap();
    let lines =
        csv(&dir.run("bench a,b.obj --size 32x24 --repeats 1 -m ab-ll --exec tile --csv -q"));
    assert_eq!(lines[1][..4], ["ab-ll", "a,b.obj", "a,b.obj", "tile"]);
    assert!(lines[1].len() == lines[0].len() && lines.len() == 2, "{lines:?}");
    dir.run("bench a,b.obj --scaling fragments").is_error(&["--scaling:", "a,b.obj", "built-in"]);
    assert_eq!((dir.names(), dir.read("a,b.obj")), (vec!["a,b.obj".to_owned()], mesh.into()));
}

#[test]
fn tables_are_for_people() {
    let dir = Dir::new();
    let run = dir.run("bench layers:count=2 --size 32x24 --repeats 1 --exec tile -m ab-ll -q");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    for word in [
        "method",
        "layers:count=2",
        "Mfrag/s",
        "limit",
        "Gfrag/s/core",
        "Mtri/s/core",
        "exchange ns",
    ] {
        assert!(run.stdout.contains(word), "{word}: {run:?}");
    }
    for word in ["adapter", "culling", "parts"] {
        assert!(!run.stdout.contains(word), "{word}: {run:?}");
    }
    for wanted in ["hash", "picture"] {
        let line = "bench layers:count=2 --size 32x24 --repeats 1 -m ab-ll -q --wanted";
        assert_eq!(dir.run(&format!("{line} {wanted}")).code, 0, "{wanted}");
    }
    let culled = dir.run(
        "bench layers:count=9 --size 32x24 --repeats 1 -m kplus-array -k 2 --cull occupancy -q",
    );
    assert!(culled.stdout.contains("1024 intervals"), "{culled:?}");
}

#[test]
fn scalings_have_a_step_for_each_size() {
    let dir = Dir::new();
    let steps = |what: &str| {
        let line = format!("bench --scaling {what} --repeats 1 -m ab-ll,kb --exec tile --json -q");
        let found = document(&dir.run(&line));
        assert_eq!(found["means"], Value::Null);
        list(&found, "rows").clone()
    };
    let sizes = |steps: &[Value], method: &str| {
        let own = steps.iter().filter(|step| step["method"] == method);
        own.map(|step| step["size"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    for (what, right) in [
        ("fragments layers:count=2 --size 20x10 --steps 3", [400, 800, 1_600]),
        ("triangles synthetic:n=1,density=100,area=8 --size 20x12 --steps 3", [30, 60, 120]),
        ("pixels layers:count=2 --size 20x10 --steps 3", [200, 400, 800]),
        ("threads layers:count=2 --size 20x10 --threads 1,2,3", [1, 2, 3]),
    ] {
        let found = steps(what);
        assert_eq!(
            [sizes(&found, "ab-ll"), sizes(&found, "kb")],
            [right; 2].map(Vec::from),
            "{what}"
        );
        let word = what.split(' ').next();
        for (i, step) in found.iter().enumerate() {
            assert_eq!(step["unit"].as_str(), word, "{step}");
            let threads = word == Some("threads");
            assert_eq!(step["draw_efficiency"].is_number(), threads, "{step}");
            assert_eq!(step["draw_change"].is_number(), !threads && i % 3 > 0, "{step}");
            assert!(number(step, "frame_seconds") >= number(step, "draw_seconds"), "{step}");
        }
    }
    let text = dir
        .run("bench layers:count=1 --size 16x16 --scaling fragments --steps 2 --repeats 1 -q")
        .stdout;
    assert!(text.contains("ns/unit") && text.contains("fragments"), "{text}");
}

#[test]
fn the_simulated_device_and_the_explorer_have_rates() {
    let dir = Dir::new();
    let line = "bench layers:count=2 --size 16x16 --exec sim -m kplus-array --repeats 1 --json -q";
    let found = document(&dir.run(line));
    let rows = list(&found, "rows");
    assert_eq!(rows.len(), 1);
    assert_eq!((rows[0]["exec"].as_str(), rows[0]["threads"].as_u64()), (Some("sim"), Some(1)));
    assert!(number(&rows[0], "mops_per_s") > 0.0);
    assert_eq!(rows[0]["limit_ratio"], Value::Null);

    let found = document(
        &dir.run("bench --explore kplus-array,ab-ll -n 3 -k 2 --threads 1 --repeats 1 --json"),
    );
    let rows = list(&found, "rows");
    let names: Vec<_> =
        rows.iter().map(|row| (row["method"].as_str(), row["k"].as_u64())).collect();
    let right =
        [("kplus-array", Some(2)), ("kplus-array", Some(2)), ("ab-ll", None), ("ab-ll", None)];
    assert_eq!(names, right.map(|(name, k)| (Some(name), k)));
    assert_ne!(rows[0]["memory"], rows[1]["memory"]);
    for row in rows {
        assert_eq!(row["threads"].as_u64(), Some(1));
        assert_eq!((row["n"].as_u64(), row["complete"].as_bool()), (Some(3), Some(true)));
        for field in ["states", "moves", "mstates_per_s", "mmoves_per_s"] {
            assert!(number(row, field) > 0.0, "{field}: {row}");
        }
        // A state has at least a word an invocation, and a move to it.
        assert!(number(row, "bytes_per_state") > 16.0, "{row}");
    }

    // Large enough to be shared, which changes nothing but the time.
    let line = "bench --explore ab-ll -n 4 --threads 1,3 --repeats 1 --json";
    let found = document(&dir.run(line));
    let rows = list(&found, "rows");
    for (one, several) in [(&rows[0], &rows[1]), (&rows[2], &rows[3])] {
        assert_eq!((one["threads"].as_u64(), several["threads"].as_u64()), (Some(1), Some(3)));
        for field in ["memory", "states", "moves", "complete", "bytes_per_state"] {
            assert_eq!(one[field], several[field], "{field}");
        }
    }
}
